"""Small linear units with exact steps, so that what a test measures is the coupling alone; a bearing as tests start it.

The units are the halves of two masses between springs and dampers,

    m1 x1'' = -k1 x1 - c1 x1' + f      m2 x2'' = -k2 x2 - c2 x2' - f      f = kc (x2 - x1) + cc (x2' - x1'),

cut so that the first gets the force f and the second, which owns the coupling spring, the motion of the first.
"""

import math
import signal
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

import numpy as np
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE, NOT_FINITE, hold_inputs
from cosimo.components.core.variables import input_, output, parameter
from pydantic import PlainSerializer, TypeAdapter
from scipy.linalg import expm


class OfTime(Component):
    """Gives functions of time; a subclass declares its outputs, and gives `_outputs`."""

    def _initialize(self, t: float) -> int:
        return DONE

    def _step(self, t: float, h: float) -> int:
        self._outputs(t + h)
        return DONE


class Integrals(Component):
    """Integrates its inputs exactly, whatever polynomials they are; a subclass declares inputs, and outputs as many or more."""

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(len(self.inputs))
        return DONE

    def _step(self, t: float, h: float) -> int:
        u = self.u
        self.x += h * (u[0] + h * (u[1] / 2.0 + h * u[2] / 3.0))
        hold_inputs(u, h)
        self._outputs(t + h)
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[: self.x.size] = self.x


class Linear(Component):
    """x' = A x + B u, y = C x + D u; a step is exact for inputs that are polynomials of degree 2.

    A subclass gives `matrices()` -> A (n, n), B (n, m), C (k, n), D (k, m), x0 (n,).
    """

    def _initialize(self, t: float) -> int:
        self.A, self.B, self.C, self.D, x0 = map(np.atleast_1d, self.matrices())
        self.x = np.array(x0, dtype=float)
        self._steps: dict[float, np.ndarray] = {}
        return DONE

    def _exact(self, h: float) -> np.ndarray:
        """From (x, u[0], u[1], u[2]) to the next x, (n, n + 3 m): the exponential of A extended by the input's Taylor terms."""
        if h not in self._steps:
            n, m = self.B.shape
            M = np.zeros((n + 3 * m, n + 3 * m))
            M[:n, :n], M[:n, n : n + m] = self.A, self.B
            M[n : n + 2 * m, n + m :] = np.eye(2 * m)
            E = expm(M * h)[:n]
            E[:, n + 2 * m :] *= 2.0  # u[2] is half of the second derivative
            self._steps[h] = E
        return self._steps[h]

    def _step(self, t: float, h: float) -> int:
        self.x = self._exact(h) @ np.concatenate((self.x, self.u.ravel()))
        hold_inputs(self.u, h)
        self.y[:] = self.C @ self.x + self.D @ self.u[0]
        self.counts[0] += 1
        return DONE if np.isfinite(self.x).all() else NOT_FINITE

    def _outputs(self, t: float) -> None:
        self.y[:] = self.C @ self.x + self.D @ self.u[0]


class Mass(Linear):
    """A mass on spring and damper that gets a force."""

    title = "mass with force input"
    m = parameter(1.0, "kg", "mass", low=1e-9)
    k = parameter(0.0, "N/m", "spring to the ground")
    c = parameter(0.0, "N.s/m", "damper to the ground")
    x0 = parameter(0.0, "m", "position at the start")
    v0 = parameter(1.0, "m/s", "velocity at the start")
    force = input_(0.0, "N", "force")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")

    def matrices(self):
        p = self.parameters
        A = np.array([[0.0, 1.0], [-p["k"] / p["m"], -p["c"] / p["m"]]])
        return A, np.array([[0.0], [1.0 / p["m"]]]), np.eye(2), np.zeros((2, 1)), [p["x0"], p["v0"]]


class SpringDamper(Linear):
    """Spring and damper without a state of their own: the force on what moves their end."""

    k = parameter(100.0, "N/m", "stiffness")
    d = parameter(1.0, "N.s/m", "damping")
    position = input_(0.0, "m", "position of the end")
    velocity = input_(0.0, "m/s", "velocity of the end")
    force = output("N", "force on the end", feedthrough=("position", "velocity"))

    def matrices(self):
        p = self.parameters
        return np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), np.array([[-p["k"], -p["d"]]]), np.zeros(0)


class Oscillator(Linear):
    """The second mass with its own spring and damper, and with the coupling spring and damper to a moving end."""

    m = parameter(1.0, "kg", "mass", low=1e-9)
    k = parameter(1000.0, "N/m", "spring to the ground")
    c = parameter(0.01, "N.s/m", "damper to the ground")
    kc = parameter(100.0, "N/m", "coupling spring")
    cc = parameter(0.01, "N.s/m", "coupling damper")
    x0 = parameter(0.0, "m", "position at the start")
    v0 = parameter(-100.0, "m/s", "velocity at the start")
    position = input_(0.0, "m", "position of the coupling's end")
    velocity = input_(0.0, "m/s", "velocity of the coupling's end")
    force = output("N", "force on the coupling's end", feedthrough=("position", "velocity"))
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")

    def matrices(self):
        p = self.parameters
        m, k, c = p["m"], p["k"] + p["kc"], p["c"] + p["cc"]
        A, B = np.array([[0.0, 1.0], [-k / m, -c / m]]), np.array([[0.0, 0.0], [p["kc"] / m, p["cc"] / m]])
        C, D = np.array([[p["kc"], p["cc"]], [1.0, 0.0], [0.0, 1.0]]), np.array([[-p["kc"], -p["cc"]], [0.0, 0.0], [0.0, 0.0]])
        return A, B, C, D, [p["x0"], p["v0"]]


class Probe(Linear):
    """Gives the time, hands on its input scaled to other units of measure, and fails when told to."""

    fail_at = parameter(1e9, "s", "time of the step that fails")
    length = input_(0.5, "mm", "a length in millimetres")
    time = output("s", "time")
    profile = output("mm", "multiples of the length", size=3, feedthrough=("length",))

    def matrices(self):
        D = np.array([[0.0], [1.0], [2.0], [3.0]])
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((4, 0)), D, np.zeros(0)

    def _step(self, t: float, h: float) -> int:
        super()._step(t, h)
        self.y[0] = t + h
        return DONE if t + h < self.parameters["fail_at"] else NOT_FINITE

    def _outputs(self, t: float) -> None:
        super()._outputs(t)
        self.y[0] = t


def two_masses(algorithm: str = "jacobi", step: float = 1e-2, degree: int = 0, feedthrough: str = "immediate") -> dict:
    """The two masses as scene data, with the numbers of case 1 of the LIM benchmark (github fgonzalezLIM/cosim-benchmarks)."""
    return {
        "stop_time": 1.0,
        "connections": ["b.force -> a.force", "a.x_out -> b.position", "a.v_out -> b.velocity"],
        "units": {
            "a": {"component": "cosimo.tests.support:Mass", "parameters": {"k": 10.0, "c": 0.01, "v0": 100.0}},
            "b": {"component": "cosimo.tests.support:Oscillator"},
        },
        "master": {"algorithm": algorithm, "step": step, "extrapolation": degree, "feedthrough": feedthrough},
    }


def exact_two_masses(t: float) -> np.ndarray:
    """(x1, v1, x2, v2) of `two_masses` at t, from the matrix exponential of the whole."""
    k1, kc, k2, c = 10.0, 100.0, 1000.0, 0.01
    A = np.array([[0, 1, 0, 0], [-k1 - kc, -2 * c, kc, c], [0, 0, 0, 1], [kc, c, -k2 - kc, -2 * c]])
    return expm(A * t) @ np.array([0.0, 100.0, 0.0, -100.0])


def signal_inside_a_library(number: int) -> None:
    """A signal while code of a library is under way that makes an exception of its own of any other."""
    TypeAdapter(Annotated[int, PlainSerializer(signal.raise_signal)]).dump_python(number)


AComponent = TypeVar("AComponent", bound=Component)
RPM = 2.0 * math.pi / 60.0


def initialized(component: AComponent, inputs: Mapping[str, Any] | None = None) -> AComponent:
    """The component with values of inputs, initialized at 0 s."""
    for name, value in (inputs or {}).items():
        component.set(name, value)
    component.initialize(0.0)
    return component


def ball_bearing(effects=(), parameters=None, rpm=1000.0, **inputs) -> BallBearing:
    """The bearing with two degrees of freedom at a speed, with values of inputs, initialized."""
    return initialized(BallBearing(effects, parameters), {"speed": rpm * RPM, **inputs})
