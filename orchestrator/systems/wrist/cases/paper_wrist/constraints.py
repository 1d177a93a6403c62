"""Lengths of the ligaments over all postures, ways there and back, and a person's wrist with two interventions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.wrist.kinematics import inverse
from ......components.wrist.ligament_springs import COUNT, LIGAMENTS, attachments, lengths
from ......components.wrist.ligaments import LigamentBundle
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .... import load_scene
from .postures import CALM, DEGREES, DEVIATIONS, FLEXIONS, STANDARD, axes, held_scene, wrist

EXTENTS = np.array([[0.0, 0.7], [1.0, 1.0], [1.0, 0.7], [0.7, 0.85], [0.0, 0.85]])  # of the component's defaults
OFF_AXIS = 3e-3  # m
ISOMETRIC, FARTHEST, HALVINGS = 0.05, 5e-3, 12  # strain; m, where the search for an end begins
LEVER, EXTENT = 12e-3, 0.7  # m, of the radius' end of the first ligament; of the lunate's angle over the row's
SEED, SIZE = 17, 0.012  # of the control's ends; m
MOMENT = 2.0  # N.m, of the range of motion
PROXIMAL = (1, 3, 4, 5)  # ligaments of the proximal row, which are redundant
PATTERN = (1, 3, 5)  # cut together: radius to lunate, scaphoid to lunate, radius to triquetrum
CUTS: dict[str, tuple[int, ...]] = {"none": (), **{f"cut {j}": (j,) for j in PROXIMAL}, "several": PATTERN}
DIRECTIONS = {"flexion": (1.0, 0.0), "extension": (-1.0, 0.0), "radial": (0.0, 1.0), "ulnar": (0.0, -1.0)}


def scenes() -> dict[str, Scene]:
    """Wrists with cut ligaments under moments in four directions, and the shipped scene of a person."""
    return {"cuts": _cut_scene(), "person": load_scene("wrist-person")}


def measure(runs: Runs) -> Evidence:
    """Strains over the postures with a control, the closed form of one pair, and both interventions."""
    named = _strains(attachments(np.full(COUNT, OFF_AXIS)))
    rng = np.random.default_rng(SEED)
    control = _strains(rng.uniform(-SIZE, SIZE, (COUNT, 6)))
    ends = control[[0, 0, -1, -1], [0, -1, 0, -1]]  # of flexion and deviation
    widest = _widest()
    measured = {f"strain.{name}": 100.0 * float(named[:, :, j].max()) for j, name in enumerate(LIGAMENTS)}
    measured |= {
        "slack": -100.0 * float(named.min()),
        "control": 100.0 * float(np.abs(ends).max(axis=0).max()),
        "control.mean": 100.0 * float(np.abs(ends).max(axis=0).mean()),
        "closed": _closed_form(),
        "widest": float(widest[0]) / widest_in_closed_form(),
        "back": _back(),
    }
    measured |= _interventions(runs["cuts"]) | _person(runs["person"])
    middle = int(np.argmin(np.abs(DEVIATIONS)))
    drawn = {
        "flexion": DEGREES * FLEXIONS,
        "isometric": {name.replace("_", "-"): 100.0 * named[:, middle, j] for j, name in enumerate(LIGAMENTS)},
        "control.strains": {f"pair {j + 1}": 100.0 * control[:, middle, j] for j in range(COUNT)},
        "cuts": list(CUTS),
        "widest.ends": ", ".join(f"{n.replace('_', '-')} {1e3 * r:.2f} mm" for n, r in zip(LIGAMENTS, widest, strict=True)),
        "ranges": {way: [measured[f"rom.{n}.{way}"] for n in CUTS] for way in DIRECTIONS},
        "ligaments": ", ".join(f"{j + 1} {n.replace('_', '-')}" for j, n in enumerate(LIGAMENTS)),
    }
    return Evidence(measured, data=drawn)


def _strains(ends: np.ndarray) -> np.ndarray:
    """Strain of five pairs of ends (5, 6) over the postures, (flexions, deviations, 5)."""
    at = axes(STANDARD)
    slack = np.linalg.norm(ends[:, 3:] - ends[:, :3], axis=1)
    ligaments = np.column_stack((ends, EXTENTS))  # of whose columns lengths know these
    return np.array([[lengths(*inverse(f, d, at)[:2], at, ligaments)[:, 0] / slack - 1.0 for d in DEVIATIONS.tolist()]
                     for f in FLEXIONS.tolist()])  # fmt: skip


def _widest() -> np.ndarray:
    """Largest distance of an end from the axis at which each ligament stays isometric over all postures, (5,) m, by bisection."""
    low, high = np.zeros(COUNT), np.full(COUNT, FARTHEST)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        within = _strains(attachments(middle)).max(axis=(0, 1)) <= ISOMETRIC
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return low


def widest_in_closed_form() -> float:
    """The same of lunate and radius, m: 2 r1 r (1 - cos a) = ((1 + strain)² - 1) (r1 - r)² at the largest angle a."""
    at = axes(STANDARD)
    most = max(abs(inverse(f, d, at)[0]) for f in FLEXIONS.tolist() for d in DEVIATIONS.tolist())
    grown, turn = (1.0 + ISOMETRIC) ** 2 - 1.0, 1.0 - math.cos(EXTENT * most)
    return float(np.roots([grown, -2.0 * LEVER * (grown + turn), grown * LEVER**2]).real.min())


def _closed_form() -> float:
    """Largest difference of the component's strain, lunate to radius, from sqrt(1 + 2 r1 r2 (1 - cos a) / L²) - 1."""
    bundle = LigamentBundle(parameters={f"off_axis[{j + 1}]": OFF_AXIS for j in range(COUNT)})
    bundle.initialize(0.0)
    r1, r2 = 12e-3, OFF_AXIS  # both ends on one side of the axis, in one plane across it
    rest = r1 - r2
    worst = 0.0
    for angle in np.linspace(-0.9, 0.9, 37).tolist():
        bundle.set("proximal_angle", angle)
        bundle.step(bundle.t, 1e-3)
        closed = math.sqrt(1.0 + 2.0 * r1 * r2 * (1.0 - math.cos(0.7 * angle)) / rest**2) - 1.0
        worst = max(worst, abs(float(bundle["strain[1]"]) - closed))
    return worst


def _back() -> float:
    """Largest difference of the component's strains on the way through the postures from those on the way back."""
    bundle = LigamentBundle()
    bundle.initialize(0.0)
    at = axes(STANDARD)
    across = np.linspace(DEVIATIONS[0], DEVIATIONS[-1], FLEXIONS.size)
    way = [inverse(f, d, at)[:2] for f, d in zip(FLEXIONS.tolist(), across.tolist(), strict=True)]
    seen = []
    for q1, q2 in [*way, *reversed(way)]:
        bundle.set("proximal_angle", q1)
        bundle.set("distal_angle", q2)
        bundle.step(bundle.t, 1e-3)
        seen.append([float(bundle[f"strain[{j + 1}]"]) for j in range(COUNT)])
    forth = np.array(seen[: len(way)])
    return float(np.abs(forth - np.array(seen[len(way) :])[::-1]).max())


def _cut_scene() -> Scene:
    """A wrist for each cut and each direction of a moment of 2 N.m."""
    units: dict[str, Any] = {}
    for k, cut in enumerate(CUTS.values()):
        stiffness = [0.0 if j + 1 in cut else 5e4 for j in range(COUNT)]
        for way, (flexion, deviation) in DIRECTIONS.items():
            given = {**CALM, "flexion_stiffness": 3.0, "deviation_stiffness": 3.0, "constraint.stiffness": stiffness}
            units[f"c{k}_{way}"] = wrist((MOMENT * flexion, MOMENT * deviation), given, ("morphology", "constraint"))
    return held_scene(units, ("flexion", "deviation"))


def _interventions(result: Result) -> dict[str, float]:
    """Range of motion under 2 N.m in four directions with no, one, or several ligaments cut, and its changes, degrees."""
    ranges = {}
    for k, name in enumerate(CUTS):
        ends = [[result[f"c{k}_{way}.{s}"][-1] for s in ("flexion", "deviation")] for way in DIRECTIONS]
        ranges[name] = np.array([DEGREES * math.hypot(*end) for end in ends])
    measured = {f"rom.{name}.{way}": float(v) for name, row in ranges.items() for way, v in zip(DIRECTIONS, row, strict=True)}
    changes = {name: float(np.abs(row - ranges["none"]).max()) for name, row in ranges.items()}
    measured["cut.one"] = max(changes[f"cut {j}"] for j in PROXIMAL)
    measured["cut.several"] = changes["several"]
    return measured


def _person(result: Result) -> dict[str, float]:
    """Shares of a person's rows before and after a fusion that moves the distal axis, of the shipped scene."""
    measured: dict[str, float] = {}
    for name in ("intact", "fused"):
        at = {s: float(result[f"{name}_flexion.{s}"][-1]) for s in ("proximal_flexion", "flexion")}
        to = {s: float(result[f"{name}_radial.{s}"][-1]) for s in ("proximal_flexion", "deviation")}
        measured |= {
            f"person.s.{name}": at["proximal_flexion"] / at["flexion"],
            f"person.p.{name}": to["proximal_flexion"] / to["deviation"],
        }
    return measured
