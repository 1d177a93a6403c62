"""`cosimo new`: files to start from, which run, keep the contract of components, and are there to be changed."""

from __future__ import annotations

import keyword
import re
from pathlib import Path
from string import Template
from typing import Annotated

from typer import Argument, Option

from ...components.core.errors import BadInput
from ..output import ensure_directory
from .asked import Asking
from .common import group, print_written

new = group(
    "new",
    "Create a scene, vehicle, component, line, case or limit table from a template. On a terminal, cosimo new asks for what it needs.",
    Asking,
)

COMPONENT = '''"""$title: a mass on a spring and a damper, to start from.

Give equations and their source here and in the docstring of the class; one line declares a variable, and what the FMU, the scenes
and the documentation say of it follows from that line.
"""

from __future__ import annotations

import math

from cosimo import DONE, Effect, OdeComponent, input_, kernel, ode_kernels, output, parameter
from cosimo.components.core.integrators import RK4_STABILITY_RADIUS


class CubicSpring(Effect):
    """The spring stiffens: a force k3 x³ beside the linear one. Off, nothing of it is in the machine code."""

    stiffness = parameter(1e4, "N/m3", "stiffness of the cubic part", low=0.0)


class $name(OdeComponent):
    """$title.

        m x'' = F - k x - c x' - k3 x³

    x: displacement, k3: of `cubic_spring`.
    Source: any textbook of vibrations; the default values are choices.
    """

    title = "$title"
    default_stop = 5.0
    default_step = 1e-2

    cubic_spring = CubicSpring

    mass = parameter(1.0, "kg", "mass", low=1e-6)
    stiffness = parameter(100.0, "N/m", "stiffness of the spring", low=0.0)
    damping = parameter(0.2, "N.s/m", "damping", low=0.0)
    start = parameter(0.01, "m", "displacement at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    force = input_(0.0, "N", "force on the mass", nominal=1.0)

    displacement = output("m", "displacement of the mass", nominal=0.01)
    velocity = output("m/s", "velocity of the mass", nominal=0.1)

    def states(self) -> int:
        """Displacement, velocity."""
        return 2

    def energy(self) -> float:
        """Kinetic energy plus that of the springs, J."""
        _, p, e = self.arguments
        cubic = e.cubic_spring.stiffness if e.cubic_spring is not None else 0.0
        x, v = self.x
        return 0.5 * (p.mass * v**2 + p.stiffness * x**2 + 0.5 * cubic * x**4)


@kernel
def start(t, s, p, e):
    """At rest, displaced."""
    s.x[0] = p.start
    return DONE


@kernel
def stable(t, s, p, e):
    """RK4's limit at the start, radius / max |eigenvalue|, s."""
    stiffness = p.stiffness
    if e.cubic_spring is not None:
        stiffness += 3.0 * e.cubic_spring.stiffness * p.start**2
    a, b = 0.5 * p.damping / p.mass, stiffness / p.mass  # z² + 2 a z + b = 0
    fastest = a + math.sqrt(a * a - b) if a * a > b else math.sqrt(b)
    return RK4_STABILITY_RADIUS / fastest if fastest > 0.0 else math.inf


@kernel
def derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (displacement, velocity)."""
    force = u[0] - p.stiffness * x[0] - p.damping * x[1]
    if e.cubic_spring is not None:
        force -= e.cubic_spring.stiffness * x[0] ** 3
    dx[0] = x[1]
    dx[1] = force / p.mass


@kernel
def outputs(t, s, p, e):
    """y = (displacement, velocity)."""
    s.y[0], s.y[1] = s.x[0], s.x[1]
    return DONE


$name.kernels = ode_kernels(__name__, start=start, derivatives=derivatives, outputs=outputs, stable=stable)
'''
TEST = '''"""What $name promises: a closed form, exact states, effects that are absent when off, an FMU that passes its checks."""

from __future__ import annotations

import math

import cosimo
import pytest
from $module import $name


def run(component, steps=100, h=1e-2):
    """The component after some macro steps."""
    component.initialize(0.0)
    for k in range(steps):
        component.step(k * h, h)
    return component


def test_free_vibration_is_the_closed_form():
    """x = x0 exp(-d t) (cos w t + d / w sin w t), d = c / 2 m, w² = k / m - d²."""
    m, k, c, x0, t = 1.0, 100.0, 0.2, 0.01, 1.0
    d = c / (2.0 * m)
    w = math.sqrt(k / m - d**2)
    exact = x0 * math.exp(-d * t) * (math.cos(w * t) + d / w * math.sin(w * t))
    assert run($name())["displacement"] == pytest.approx(exact, abs=1e-9)


def test_order_of_the_integrator():
    exact = run($name(parameters={"substep": 1e-4}))["displacement"]
    coarse, fine = (abs(run($name(parameters={"substep": h}))["displacement"] - exact) for h in (1e-2, 5e-3))
    assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.2)


def test_energy_stays_without_damping():
    component = $name(["cubic_spring"], {"damping": 0.0})
    component.initialize(0.0)
    before = component.energy()
    assert run(component, 500).energy() == pytest.approx(before, rel=1e-6)


def test_a_repeated_step_is_bit_identical():
    component = run($name(["cubic_spring"]), 3)
    state = component.save()
    component.step(0.03, 1e-2)
    first = component.save()
    component.restore(state)
    component.step(0.03, 1e-2)
    assert component.save() == first


def test_an_effect_that_is_off_is_absent():
    off, on = $name(), $name(["cubic_spring"])
    assert "cubic_spring.stiffness" not in off.parameters
    assert run(on)["displacement"] != run(off)["displacement"]
    assert run($name(["cubic_spring"], {"cubic_spring.stiffness": 0.0}))["displacement"] == off["displacement"]


def test_a_substep_beyond_the_stable_one_is_refused():
    with pytest.raises(cosimo.BadInput, match="substep"):
        $name(parameters={"substep": 0.5}).initialize(0.0)


def test_the_scene_runs():
    result = cosimo.run(cosimo.load_scene("$module.toml"), in_process=True)
    assert result.outcome == "done"
    assert abs(result["$unit.displacement"]).max() <= 0.01 + 1e-12


def test_the_fmu_passes_its_checks(tmp_path):
    findings = cosimo.check(cosimo.build($name, tmp_path))
    assert [f"{f.name}: {f.detail}" for f in findings if not f.ok] == []
'''
SCENE = """#:schema scene.schema.json
title = "$title, let go"
stop_time = 5.0                                   # s

[units.$unit]
component = "$module:$name"
effects = ["cubic_spring"]
parameters = { damping = 0.5 }                    # SI units

[master]
algorithm = "gauss-seidel"
step = 1e-2                                       # s
"""
README = """# $title

`$name` in `$module.py` is a component of cosimo: `m x'' = F - k x - c x' - k3 x³`. Change it, and `test_$module.py` with it.

In the folder of `$module.py`:

    pytest                                       # what the component promises
    cosimo show $module:$name                    # variables, effects, presets
    cosimo run $module.toml -o out               # out/report.html
    cosimo build $module:$name                   # $name.fmu
    cosimo check $name.fmu --execute
    cosimo stability component:$module:$name
    cosimo schema $module.toml                   # with it, editors complete and check the scene
"""


@new.command()
def component(
    name: Annotated[str, Argument(help="Name of the class, for example MassOnSpring.")],
    output: Annotated[Path, Option("-o", "--output", help="Directory for the files. Default: the working directory.")] = Path(),
) -> None:
    """Write a component with its test, a scene and a page. Example: cosimo new component MassOnSpring -o mine"""
    from ...components.catalogue import CATALOGUE
    from ..scene.build import snake_case

    if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name) or keyword.iskeyword(name):
        raise BadInput(
            "new component",
            repr(name),
            "a class name of letters and digits that starts with a capital letter",
            "As in MassOnSpring.",
        )
    if name in CATALOGUE:
        raise BadInput(
            "new component", repr(name), "a name that no component of the catalogue has", "Its FMU would have the same name."
        )
    module = snake_case(name)
    title = module.replace("_", " ").capitalize()
    files = {f"{module}.py": COMPONENT, f"test_{module}.py": TEST, f"{module}.toml": SCENE, "README.md": README}
    directory = ensure_directory(output)
    if there := [file for file in files if (directory / file).exists()]:
        raise BadInput(
            "new component",
            f"{directory / there[0]}, which is there already",
            "files that do not exist yet",
            "Give another directory by -o, or another name.",
        )
    for file, text in files.items():
        filled = Template(text).substitute(name=name, module=module, unit=module, title=title)
        (directory / file).write_text(filled, encoding="utf-8")
        print_written([directory / file])
    print("README.md says how to test, run and build it.")
