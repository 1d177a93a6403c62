"""Linear units that are coupled by velocity and force alone, so that a power bond has all that goes between them."""

from __future__ import annotations

import numpy as np
from cosimo.components.core.variables import input_, output, parameter
from cosimo.tests.support import Linear
from scipy.linalg import expm


class Body(Linear):
    """A mass on a spring and a damper to the ground, and an oscillating load: it gets a force and gives its velocity."""

    m = parameter(1.0, "kg", "mass", low=1e-9)
    k = parameter(0.0, "N/m", "spring to the ground")
    c = parameter(0.0, "N.s/m", "damper to the ground")
    v0 = parameter(1.0, "m/s", "velocity at the start")
    load = parameter(0.0, "N", "amplitude of the load")
    frequency = parameter(1.0, "rad/s", "of the load, a sine")
    bias = parameter(0.0, "N", "constant part of the load")
    force = input_(0.0, "N", "force")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")

    def matrices(self):
        p = self.parameters
        w = p["frequency"]
        A = np.zeros((5, 5))  # x, v, load, its other phase, constant load
        A[:2] = [0.0, 1.0, 0.0, 0.0, 0.0], [-p["k"] / p["m"], -p["c"] / p["m"], 1.0 / p["m"], 0.0, 1.0 / p["m"]]
        A[2, 3], A[3, 2] = w, -w
        B = np.array([[0.0], [1.0 / p["m"]], [0.0], [0.0], [0.0]])
        return A, B, np.eye(2, 5), np.zeros((2, 1)), [0.0, p["v0"], 0.0, p["load"], p["bias"]]


class Link(Linear):
    """Spring and damper that integrate the velocity of their end themselves: the force on what moves it."""

    k = parameter(1.0, "N/m", "stiffness")
    c = parameter(0.0, "N.s/m", "damping")
    velocity = input_(0.0, "m/s", "velocity of the end")
    x_out = output("m", "length")
    force = output("N", "force on the end", feedthrough=("velocity",))

    def matrices(self):
        p = self.parameters
        return np.zeros((1, 1)), np.ones((1, 1)), np.array([[1.0], [-p["k"]]]), np.array([[0.0], [-p["c"]]]), [0.0]


class Tethered(Linear):
    """A mass on a spring to a moving end, whose velocity it gets and which it gives the spring's force."""

    m = parameter(1.0, "kg", "mass", low=1e-9)
    k = parameter(1.0, "N/m", "spring to the moving end")
    c = parameter(0.0, "N.s/m", "damper to the moving end")
    kg = parameter(0.0, "N/m", "spring to the ground")
    cg = parameter(0.0, "N.s/m", "damper to the ground")
    v0 = parameter(0.0, "m/s", "velocity at the start")
    velocity = input_(0.0, "m/s", "velocity of the end")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")
    stretch = output("m", "stretch of the spring")
    force = output("N", "force on the end", feedthrough=("velocity",))

    def matrices(self):
        p = self.parameters
        m, k, c = p["m"], p["k"], p["c"]
        A = np.array([[0.0, 1.0, 0.0], [-p["kg"] / m, -(c + p["cg"]) / m, -k / m], [0.0, 1.0, 0.0]])  # x, v, stretch
        C = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, c, k]])
        return A, np.array([[0.0], [c / m], [-1.0]]), C, np.array([[0.0], [0.0], [0.0], [-c]]), [0.0, p["v0"], 0.0]


HERE = "cosimo.tests.engine.algorithms.bonded"
BOND = "a.v_out * b.force"


def bonded(
    second: str,
    algorithm: str,
    step: float,
    degree: int,
    *,
    stop: float = 10.0,
    a: dict | None = None,
    b: dict | None = None,
    **master,
) -> dict:
    """A body `a` and a `Link` or `Tethered` mass `b` as scene data, with their bond."""
    return {
        "stop_time": stop,
        "connections": ["b.force -> a.force", "a.v_out -> b.velocity"],
        "units": {
            "a": {"component": f"{HERE}:Body", "parameters": a or {}},
            "b": {"component": f"{HERE}:{second}", "parameters": b or {}},
        },
        "master": {"algorithm": algorithm, "step": step, "extrapolation": degree, "bonds": [BOND], **master},
    }


def oscillation(t: float, m: float = 1.0, k: float = 1.0, c: float = 0.0, v0: float = 1.0) -> np.ndarray:
    """(x, v) of a mass on a spring and damper at t."""
    return expm(np.array([[0.0, 1.0], [-k / m, -c / m]]) * t) @ np.array([0.0, v0])
