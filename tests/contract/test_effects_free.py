"""An effect that is off costs nothing: no call, no state, no bit of the result, no instruction of the machine code."""

import math
import sys
from collections import Counter
from pathlib import Path

import pytest
from cosimo import components
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.component import Effect
from cosimo.components.core.contract import KernelComponent, Kernels
from cosimo.components.core.integrators import OdeComponent, rk4
from cosimo.components.core.kernels import COMPILED, kernel
from cosimo.components.core.variables import output, parameter
from cosimo.tests.contract.configurations import (
    SMALL,
    bits,
    compatible,
    excite,
    in_plain_python,
    slope_inputs,
    small,
    with_required,
)
from cosimo.tests.contract.never_written import never_written, python, stripped
from cosimo.tests.contract.test_effects_absent import SINGLE
from cosimo.tests.contract.test_effects_absent import stripped as undeclared
from cosimo.tests.short_run import full_but

ROOT = str(Path(components.__file__).parent)
CLASSIC = [
    c
    for c in CATALOGUE
    if issubclass(cls := component_class(c), OdeComponent)
    and cls.effects
    and python(cls.kernels.step).__code__ is python(rk4).__code__
]
MACHINE_CODE = ("Thruster", "PlanarLink")  # the compiler takes seconds over each


def calls_of(component) -> tuple[Counter, list[bytes]]:
    """Calls of every function of the components' package in two steps with moving inputs, and every bit behind each."""
    excite(component)
    component.initialize(0.0)
    counted: Counter = Counter()

    def count(frame, event, argument):
        if event == "call" and frame.f_code.co_filename.startswith(ROOT):
            counted[frame.f_code.co_filename[len(ROOT) :], frame.f_code.co_qualname] += 1

    rows = []
    before = sys.getprofile()
    sys.setprofile(count)
    try:
        for k in range(2):
            slope_inputs(component, rate=0.5 + 0.1 * k)
            component.step(k * 1e-3, 1e-3)
            rows.append(bits(component))
    finally:
        sys.setprofile(before)
    return counted, rows


@pytest.mark.parametrize(("component", "effect"), in_plain_python(full_but((), SINGLE)))
@pytest.mark.uncompiled
def test_an_effect_that_is_off_is_neither_called_nor_felt_by_the_others(component, effect):
    """All others on, this one off, against the component in which nobody has declared it."""
    cls = component_class(component)
    others = [e for e in compatible(cls) if effect not in with_required(cls, e)]
    given = small(component, others)
    here, bare = cls(others, given), undeclared(cls, effect)(others, given)
    calls, rows = calls_of(here)
    wanted, same = calls_of(bare)
    assert calls == wanted
    assert sum(calls.values()) > 0
    assert rows == same
    assert here.x.size == bare.x.size
    assert here.work == bare.work


@pytest.mark.parametrize("component", in_plain_python(full_but((), CLASSIC)))
@pytest.mark.uncompiled
def test_without_effects_it_is_the_component_without_their_source(component):
    """Kernels from whose source every branch of an effect has been cut out: the same calls, bit-identical."""
    cls = component_class(component)
    here, bare = cls((), SMALL[component]), never_written(cls)((), SMALL[component])
    calls, rows = calls_of(here)
    wanted, same = calls_of(bare)
    assert sum(calls.values()) == sum(wanted.values())
    assert rows == same


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
@pytest.mark.parametrize("component", MACHINE_CODE)
def test_no_instruction_of_an_effect_that_is_off_is_in_the_machine_code(component):
    import numba
    import numpy as np
    from cosimo.components.core.compiler import OPTIONS

    cls = component_class(component)
    made, full = cls((), SMALL[component]), cls(compatible(cls), small(component, compatible(cls)))
    for one in (made, full):
        one.initialize(0.0)
    source = cls.kernels.derivatives
    cut, branches = stripped(source)
    assert branches > 0

    def instructions(function, one) -> int:
        compiled = numba.njit(**OPTIONS)(python(function))
        compiled(0.0, one.x, one.u[0], np.zeros_like(one.x), *one.arguments)
        (code,) = compiled.inspect_asm().values()
        return sum(line.startswith("\t") and not line.startswith("\t.") for line in code.splitlines())

    off, never, on = instructions(source, made), instructions(cut, made), instructions(source, full)
    assert off == never
    assert on > off


class LogGamma(Effect):
    """Found on or off when the kernel runs; the function that it calls is one that nothing else calls."""

    read_by = either_in = ("initialize",)

    of = parameter(5.0, "1", "argument")
    weights = parameter((1.0, 2.0), "1", "factors", size=2)


class Started(KernelComponent):
    title, system = "Started", "test"
    log_gamma = LogGamma

    result = output("1", "what initialization computes")


@kernel
def started(t, s, p, e):
    s.y[0] = -1.0
    if e.log_gamma is not None:
        s.y[0] = math.lgamma(e.log_gamma.of) * e.log_gamma.weights[1]
    return 0


@kernel
def nothing(t, h, s, p, e):
    return 0


@kernel
def nothing_shown(t, s, p, e):
    return 0


Started.kernels = Kernels(started, nothing, nothing_shown)


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_one_machine_code_finds_effects_on_or_off_and_a_native_library_has_nothing_of_those_that_are_off():
    from cosimo.fmus.native.machine_code import compile_entries, source_of

    kernels, texts = set(), []
    for on, result in (((), -1.0), (("log_gamma",), 2.0 * math.lgamma(5.0))):
        made = Started(on)
        made.initialize(0.0)
        assert made.result == pytest.approx(result, rel=1e-15)
        kernels.add(Started.known_entries["initialize", made.layout_of_block].kernel)
        texts.append(compile_entries(source_of(made)))
    assert len(kernels) == 1
    assert ["lgamma" in text for text in texts] == [False, True]
