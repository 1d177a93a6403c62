"""A small system as somebody would add it: a pendulum on a spring, with scene, case, table, figure, facts and a test."""

from __future__ import annotations

FILES = {
    "components/spring_pendulum/__init__.py": '"""Pendulum on a spring."""\n',
    "components/spring_pendulum/pendulum.py": '''"""A mass on a spring that swings in a plane."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.variables import input_, output, parameter


class AirDrag(Effect):
    """Drag in proportion to the velocity."""

    coefficient = parameter(0.1, "N.s/m", "force per velocity", low=0.0)


class SpringPendulum(OdeComponent):
    """A mass on a massless spring from a fixed point; r its length, th the angle from below.

        m (r'' - r th'^2) = m g cos th - k (r - l) + F_r - c r'
        m (r th'' + 2 r' th') = - m g sin th - c r th'

    Source: Lagrange's equations, any textbook of mechanics.
    """

    title = "Pendulum on a spring"
    system = "spring_pendulum"
    default_stop = 10.0
    start_inputs = ()

    air_drag = AirDrag

    mass = parameter(1.0, "kg", "mass", low=1e-9)
    stiffness = parameter(100.0, "N/m", "stiffness of the spring", low=1e-9)
    length = parameter(1.0, "m", "length of the spring without force", low=1e-3)
    gravity = parameter(9.80665, "m/s2", "acceleration of gravity", low=0.0)
    start_stretch = parameter(0.0, "m", "stretch beyond the rest under gravity at the start")
    start_angle = parameter(0.0, "rad", "angle at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    pull = input_(0.0, "N", "force along the spring, outwards", nominal=1.0)

    stretch = output("m", "stretch beyond the length without force")
    angle = output("rad", "angle from below")
    mechanical_energy = output("J", "kinetic energy, of the spring and of the height", nominal=10.0)

    def states(self) -> int:
        """Length, angle, their rates."""
        return 4

    def energy(self) -> float:
        """Kinetic energy, of the spring and of the height, J."""
        return float(pendulum_energy(self.x, self.arguments[1]))


@kernel
def pendulum_start(t, s, p, e):
    """Stretched and turned from the rest under gravity."""
    s.x[0] = p.length + p.mass * p.gravity / p.stiffness + p.start_stretch
    s.x[1] = p.start_angle
    return DONE


@kernel
def pendulum_stable(t, s, p, e):
    """RK4's limit for the spring's own frequency, s."""
    return RK4_STABILITY_RADIUS * math.sqrt(p.mass / p.stiffness)


@kernel
def pendulum_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (length, angle, their rates)."""
    dx[0], dx[1] = x[2], x[3]
    dx[2] = x[0] * x[3] * x[3] + p.gravity * math.cos(x[1]) - (p.stiffness * (x[0] - p.length) - u[0]) / p.mass
    dx[3] = -(p.gravity * math.sin(x[1]) + 2.0 * x[2] * x[3]) / x[0]
    if e.air_drag is not None:
        dx[2] -= e.air_drag.coefficient * x[2] / p.mass
        dx[3] -= e.air_drag.coefficient * x[3] / p.mass


@kernel
def pendulum_energy(x, p):
    """Kinetic energy, of the spring and of the height, J."""
    kinetic = 0.5 * p.mass * (x[2] * x[2] + x[0] * x[0] * x[3] * x[3])
    return kinetic + 0.5 * p.stiffness * (x[0] - p.length) ** 2 - p.mass * p.gravity * x[0] * math.cos(x[1])


@kernel
def pendulum_outputs(t, s, p, e):
    """Stretch, angle, energy."""
    s.y[0], s.y[1], s.y[2] = s.x[0] - p.length, s.x[1], pendulum_energy(s.x, p)
    return DONE


SpringPendulum.kernels = ode_kernels(__name__, start=pendulum_start, derivatives=pendulum_derivatives, outputs=pendulum_outputs,
                                     stable=pendulum_stable)
''',
    "components/spring_pendulum/hard_cases.py": '''"""Hard cases of the pendulum on a spring."""

from __future__ import annotations

from ..core.hard_cases import AtMost, HardCase, Refused

HARD_CASES = {
    "SpringPendulum": (
        HardCase("at rest", "Hangs still.", (AtMost("angle", 0.0),)),
        HardCase("a very stiff spring", "Beyond the substep.", Refused("the limit of RK4", accepted={"substep": 1e-6}), (),
                 {"stiffness": 1e9}),
    ),
}
''',
    "orchestrator/systems/spring_pendulum/__init__.py": '''"""Pendulum on a spring: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System

SYSTEM = System("spring_pendulum", "Pendulum on a spring", __name__)
''',
    "orchestrator/systems/spring_pendulum/scenes/bounce.toml": """title = "A pendulum on a spring bounces"
stop_time = 10.0

[units.pendulum]
component = "SpringPendulum"
parameters = { start_stretch = 0.01 }

[master]
algorithm = "jacobi"
step = 1e-2

[analysis]
system = "spring_pendulum"
""",
    "orchestrator/systems/spring_pendulum/cases/__init__.py": '''"""Validation cases of the system."""

from __future__ import annotations

from . import bounce

CASES = (bounce.CASE,)
''',
    "orchestrator/systems/spring_pendulum/cases/bounce.py": '''"""The frequency of the bounce."""

from __future__ import annotations

import numpy as np

from ....harness.validation import Case, Evidence, Question, Runs
from ....scene.scene import Scene
from ... import load_scene


def scenes() -> dict[str, Scene]:
    """The scene as shipped."""
    return {"bounce": load_scene("bounce")}


def measure(runs: Runs) -> Evidence:
    """Mean period between upward passages of the rest."""
    result = runs["bounce"]
    stretch = result["pendulum.stretch"] - 9.80665 / 100.0
    up = np.flatnonzero((stretch[:-1] < 0.0) & (stretch[1:] >= 0.0))
    passed = result.time[up] - stretch[up] * np.diff(result.time)[up] / np.diff(stretch)[up]
    measured = {"frequency": 2.0 * np.pi / float(np.diff(passed).mean())}
    return Evidence(measured, shown=runs)


CASE = Case("bounce", "Bounce of a pendulum on a spring", "The closed form of the frequency.", (Question(measure, scenes),))
''',
    "orchestrator/systems/spring_pendulum/cases/bounce.toml": """title = "Bounce of a pendulum on a spring"
text = "A mass of 1 kg on 100 N/m."

[sources]
closed = "sqrt(k/m)"
""",
    "orchestrator/systems/spring_pendulum/cases/bounce.csv": """quantity,measure,condition,unit,low,high,standing,source
angular frequency,frequency,bounce,rad/s,9.999,10.001,computed,closed
""",
    "orchestrator/systems/spring_pendulum/figures.py": '''"""Figures of the pendulum on a spring."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...harness.charts.blocks import Block
from ...harness.charts.chart import Chart, Panel, Series
from ...harness.charts.charts import draw_chart

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """The stretch of every pendulum over the time."""
    series = tuple(Series(n, result.time, c) for n, c in result.columns.items() if n.endswith(".stretch"))
    return [draw_chart(Chart("Stretch of the spring", "time, s", (Panel("stretch, m", series),), "Bounce."))] if series else []
''',
    "tests/systems/spring_pendulum/facts.py": '''"""Pendulum on a spring."""

from __future__ import annotations

from cosimo.tests.contract.facts import Facts

FACTS: dict[str, Facts] = {
    "SpringPendulum": Facts(plain=(("air_drag",), {"start_angle": 0.3}, 20), disturbance={"pull": 1.0},
                            strengths={"air_drag.coefficient": ({}, 1e-4)}),
}
''',
    "tests/systems/spring_pendulum/known_answers.py": '''"""Known answers."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import in_file

KNOWN: dict[str, dict[str, str]] = {
    "SpringPendulum": in_file("spring_pendulum/test_spring_pendulum.py", air_drag="air_drag_takes_energy"),
}
''',
    "tests/systems/spring_pendulum/test_spring_pendulum.py": """import pytest

from cosimo.components.spring_pendulum.pendulum import SpringPendulum


def energy_after(effects, seconds=1.0):
    pendulum = SpringPendulum(effects, {"start_angle": 0.4})
    pendulum.initialize(0.0)
    start = pendulum.energy()
    for k in range(round(seconds / 1e-2)):
        pendulum.step(k * 1e-2, 1e-2)
    return start, pendulum.energy()


def test_energy_is_kept():
    start, end = energy_after(())
    assert end == pytest.approx(start, rel=1e-9)


def test_air_drag_takes_energy():
    start, end = energy_after(("air_drag",))
    assert end < start - 1e-3
""",
}
# file -> (before, after): the shared files that know of a system
LISTS = {
    "components/catalogue.py": (
        '    "Pantograph": "railway.pantograph",\n',
        '    "Pantograph": "railway.pantograph",\n    "SpringPendulum": "spring_pendulum.pendulum",\n',
    ),
    "orchestrator/systems/__init__.py": ('"pipe_robot", "wrist")', '"pipe_robot", "wrist", "spring_pendulum")'),
}
