"""The linear model with viscous friction: where its modes decouple, and that they mix elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .....harness.studies.modes import modes as modes_of_scene
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene

NAME = "paper-two-links"
GRAVITY, SECOND = 9.81, 0.1  # m/s²; N.m.s/rad, damper of the second joint
# name -> masses, lengths, centres, inertias of both links, kg, m, m, kg m²
CHAINS: dict[str, tuple[float, ...]] = {
    "point masses": (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0),
    "equal rods": (1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 1.0 / 12.0, 1.0 / 12.0),
    "rods 2 : 1": (2.0, 1.0, 1.0, 1.0, 0.5, 0.5, 2.0 / 12.0, 1.0 / 12.0),
    "unequal": (1.3, 0.6, 0.8, 0.7, 0.5, 0.4, 0.04, 0.03),
}
OTHER = (0.5, 0.8, 0.9, 1.1, 1.25, 2.0)  # times the ratio at which the modes decouple
SMALL, LARGE = 1e-5, (0.05, 0.1, 0.2, 0.4)  # rad
SPAN, STEP = 6.0, 0.01  # s
COAST, SLOWEST = 700.0, 1e-4  # s; rad/s for one of the starts that friction alone ends


def scenes() -> dict[str, Scene]:
    """Every chain in its first mode, with each damper; the large swings; coasting without gravity."""
    mixed = {}
    for name in CHAINS:
        shape = modes(name)[1][:, 0]
        start = SMALL * shape / np.abs(shape).max()
        mixed[name] = scene(name, {n: (damper, start) for n, damper in _dampers(name).items()})
    shape = modes("point masses")[1][:, 0]
    swing = shape / np.abs(shape).max()
    large = {f"{a:g} rad": scene("point masses", {"d0": (SECOND, a * swing)}, 2.0) for a in LARGE}
    starts = {f"s{k}": (0.1, SLOWEST * np.eye(2)[k]) for k in range(2)}
    return {**mixed, **large, "coasting": scene("equal rods", starts, COAST, gravity=False)}


def measure(runs: Runs) -> Evidence:
    """Decoupled motion against its closed form, mixing at other dampers, the nonlinear model, coasting without gravity."""
    measured: dict[str, float] = {}
    mixed: dict[str, list[float]] = {}
    for name in CHAINS:
        measured[f"ratio.{name}"] = decoupling(*matrices(name))
        dampers, result = _dampers(name), runs[name]
        closed = modal(name, dampers["d0"], SMALL, result.time)
        measured[f"error.{name}"] = float(np.abs(_angles(result, "d0") - closed).max()) / SMALL
        shares = [_leaked(name, result, n) for n in dampers]
        mixed[name] = shares
        measured |= {f"mixed.{name}.exact": shares[0], f"mixed.{name}.other": min(shares[1:])}
    errors = [_nonlinear(runs[f"{a:g} rad"], a) for a in LARGE]
    measured["order"] = float(np.polyfit(np.log(LARGE), np.log(errors), 1)[0])
    measured |= _eigenvalues() | _coasting(runs["coasting"])
    at = np.argsort((1.0, *OTHER))
    result = runs["point masses"]
    errors = (_angles(result, "d0") - modal("point masses", SECOND, SMALL, result.time))[:, 0] / SMALL
    drawn = {"ratios": np.array((1.0, *OTHER))[at], "mixed": {name: np.array(shares)[at] for name, shares in mixed.items()}}
    return Evidence(measured, data={**drawn, "t": result.time, "errors": errors})


def matrices(name: str) -> tuple[np.ndarray, np.ndarray]:
    """(M, K) of a chain's small motion in the absolute angles, kg m² and N m."""
    m1, m2, l1, _, a1, a2, i1, i2 = CHAINS[name]
    coupling = m2 * l1 * a2
    mass = np.array([[i1 + m1 * a1**2 + m2 * l1**2, coupling], [coupling, i2 + m2 * a2**2]])
    return mass, GRAVITY * np.diag([m1 * a1 + m2 * l1, m2 * a2])


def decoupling(mass: np.ndarray, stiffness: np.ndarray) -> float:
    """d1 / d2 at which D M^-1 K is symmetric: [K1 (B + C) - K2 (A + B)] / (K2 B), A, B, C of the mass matrix."""
    (a, b), (_, c) = mass
    k1, k2 = stiffness[0, 0], stiffness[1, 1]
    return float((k1 * (b + c) - k2 * (a + b)) / (k2 * b))


def modes(name: str) -> tuple[np.ndarray, np.ndarray]:
    """(frequencies of the undamped chain, slowest first, (2,), rad/s; modes as columns, M-orthonormal, (2, 2))."""
    mass, stiffness = matrices(name)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
    return np.sqrt(squares), root.T @ vectors


def _dampers(name: str) -> dict[str, float]:
    """Dampers of the first joint, N.m.s/rad, by unit: that at which the modes decouple, then the others."""
    ratio = decoupling(*matrices(name))
    return {f"d{k}": r * ratio * SECOND for k, r in enumerate((1.0, *OTHER))}


def modal(name: str, first: float, amplitude: float, time: np.ndarray) -> np.ndarray:
    """Angles (n, 2) after a start at rest in the first mode: exp(-s t) (cos w_d t + s / w_d sin w_d t) of it."""
    frequencies, shapes = modes(name)
    shape = shapes[:, 0]
    damping = np.array([[first + SECOND, -SECOND], [-SECOND, SECOND]])
    decay = 0.5 * float(shape @ damping @ shape)
    damped = math.sqrt(float(frequencies[0]) ** 2 - decay**2)
    course = np.exp(-decay * time) * (np.cos(damped * time) + decay / damped * np.sin(damped * time))
    return amplitude * course[:, None] * shape / np.abs(shape).max()


def scene(name: str, starts: Mapping[str, tuple[float, np.ndarray]], span: float = SPAN, gravity: bool = True) -> Scene:
    """Chains side by side. starts: unit -> (damper of the first joint, angles with gravity or rates without)."""
    values = dict(zip(("first_mass", "second_mass", "first_length", "second_length", "first_centre", "second_centre",
                       "first_inertia", "second_inertia"), CHAINS[name], strict=True))  # fmt: skip
    what = "angle" if gravity else "rate"
    units = {}
    for chain, (first, x) in starts.items():
        given: dict[str, Any] = {**values, "viscous.first": first, "viscous.second": SECOND if gravity else 0.05}
        given |= {f"start_{link}_{what}": float(value) for link, value in zip(("first", "second"), x, strict=True)}
        units[chain] = unit("TwoLinkChain", effects=["gravity", "viscous"] if gravity else ["viscous"], **given)
    signals = [f"{chain}.{s}" for chain in units for s in ("first_angle", "second_angle", "first_rate", "second_rate")]
    record = {"signals": signals, "interval": None if gravity else 10.0}
    return build_scene(units, stop_time=span, step=STEP, name=NAME, title=f"Small motion: {name}", record=record)


def _angles(result: Result, unit: str) -> np.ndarray:
    return np.column_stack([result[f"{unit}.{which}_angle"] for which in ("first", "second")])


def _leaked(name: str, result: Result, unit: str) -> float:
    """Largest energy in the second mode over that at the start, which is all in the first."""
    mass, _ = matrices(name)
    frequencies, shapes = modes(name)
    rates = np.column_stack([result[f"{unit}.{which}_rate"] for which in ("first", "second")])
    q, v = _angles(result, unit) @ mass @ shapes, rates @ mass @ shapes
    energies = 0.5 * (v**2 + (frequencies * q) ** 2)
    return float(energies[:, 1].max() / energies[0, 0])


def _nonlinear(result: Result, amplitude: float) -> float:
    """Largest difference of a swing of the point masses from the linear model's, over its amplitude, in the first two seconds."""
    return float(np.abs(_angles(result, "d0") - modal("point masses", SECOND, amplitude, result.time)).max()) / amplitude


def _eigenvalues() -> dict[str, float]:
    """Decay rates and frequencies of the component at rest, for equal point masses with equal dampers."""
    of_scene = modes_of_scene(scene("point masses", {"chain": (SECOND, np.zeros(2))})).rows()
    upper = sorted((mode.rate for _, mode in of_scene if mode.frequency), key=lambda x: float(x.imag))
    measured = {f"decay.{k}": -float(x.real) for k, x in enumerate(upper, 1)}
    return measured | {f"frequency.{k}": float(x.imag) for k, x in enumerate(upper, 1)}


def _coasting(result: Result) -> dict[str, float]:
    """Angles at which rods without gravity come to rest, over the rate of the start, s."""
    return {f"coast.{k}.{which}": float(result[f"s{k}.{which}_angle"][-1]) / SLOWEST
            for k in range(2) for which in ("first", "second")}  # fmt: skip
