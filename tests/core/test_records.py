"""Records of a component: named numbers in `s`, in machine code and in plain Python."""

import pytest
from cosimo import DONE, OWN, BadInput, KernelComponent, Kernels, Refusal, kernel, output, parameter
from cosimo.components.core.kernels import in_python

TOO_SOFT = OWN + 1


class Derived:
    """The record `s.derived`."""

    stiffness: float
    steps: int
    least: float


@kernel
def start(t, s, p, e):
    """What follows from the parameters."""
    s.derived.stiffness, s.derived.least = p.mass * p.frequency**2, 1.0
    s.limits[0] = s.derived.stiffness
    if s.derived.stiffness < s.derived.least:
        return TOO_SOFT
    return DONE


@kernel
def step(t, h, s, p, e):
    """Counts, in the record."""
    s.derived.steps += 1
    return outputs(t + h, s, p, e)


@kernel
def outputs(t, s, p, e):
    """The force of a spring, with a record that another kernel is handed."""
    s.y[0] = force(t, s.derived)
    return DONE


@kernel
def force(t, derived):
    """Of a spring that is as long as the time; derived: `Derived`."""
    return derived.stiffness * t + derived.steps


class Spring(KernelComponent):
    """A spring that is as long as the time."""

    system = "core"
    mass = parameter(2.0, "kg", "mass")
    frequency = parameter(3.0, "rad/s", "frequency")
    force = output("N", "force")
    kernels = Kernels(start, step, outputs)
    refusals = {TOO_SOFT: Refusal("a stiffness of {derived.stiffness} N/m", "at least {derived.least} N/m")}

    def shapes(self):
        """`derived`: see `Derived`."""
        return super().shapes() | {"derived": Derived, "limits": 1}


def test_fields_are_numbers_of_the_block_by_their_names():
    spring, other = Spring(), Spring(parameters={"mass": 5.0})
    for each in (spring, other):
        each.initialize(0.0)
        each.step(0.0, 0.25)
        each.step(0.25, 0.25)
    derived = spring.arguments[0].derived
    assert (derived.stiffness, derived.steps, spring["force"]) == (18.0, 2, 18.0 * 0.5 + 2)
    assert other.arguments[0].derived.stiffness == 45.0
    cell = spring.block.cell("s", "derived")
    assert spring.block.memory[cell] == 18.0
    assert spring.block.ranges("derived") == [(cell, cell + 3)]
    spring.initialize(0.0)
    assert spring.arguments[0].derived.steps == 0  # as all that is no parameter


def test_a_parameter_is_what_stands_in_its_cell_whoever_has_asked_before():
    spring, other = Spring(), Spring(parameters={"mass": 5.0})
    spring.set("mass", 5.0)
    assert spring.of_initialization("limits", 0) == 45.0
    spring.initialize(0.0)
    assert spring.arguments[0].derived.stiffness == 45.0
    other.initialize(0.0)
    for mass in (2.0, 5.0):  # of a block that stands where another one does, also back to what it had before
        other.set("mass", mass)
        other.initialize(0.0)
        spring.stand(other.block.memory.copy())
        assert spring["mass"] == spring.arguments[1].mass == spring.block.memory[spring.cell_of("mass")] == mass
        spring.initialize(0.0)
        assert spring.arguments[0].derived.stiffness == 9.0 * mass


def test_python_writes_what_machine_code_reads():
    spring = Spring()
    spring.initialize(0.0)
    spring.arguments[0].derived.stiffness = 7.0
    spring.step(0.0, 1.0)
    assert spring["force"] == 8.0
    in_python(step)(1.0, 1.0, *spring.arguments)
    assert spring.arguments[0].derived.steps == 2


def test_a_refusal_has_the_values_of_fields():
    with pytest.raises(BadInput, match=r"a stiffness of 0.5 N/m, expected at least 1 N/m"):
        Spring(parameters={"mass": 0.5, "frequency": 1.0}).initialize(0.0)
