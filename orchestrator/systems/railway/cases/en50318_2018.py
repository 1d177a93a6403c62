"""EN 50318:2018, its three catenaries: against ranges that are only quoted from memory, and statics that an independent solver computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .....components.railway.contact import contact_compliance, wire_height
from .....components.railway.statics import Statics, elasticity
from ....harness.validation import Evidence, Runs
from ....harness.validation.reference import compare, load_table
from ....run.results import Result
from ....units.component import make
from ... import load_scene
from ..records import statistics
from ..runs import numbers, set_mean_run, target_mean
from .catenary_statics import resting_catenary
from .en50318_2018_data import model_data

AT_REST = "at rest, strings"
MESH = {"element": 0.04}  # m: right at a node a mesh is softer by the mean of what it misses, a sixth of an element over T
CONTACT = 50e3  # N/m, of a contact with a wire in the sharing of a force


def measure(runs: Runs, name: str, speeds: Sequence[float], mean_at_rest: float, statics: str = "") -> Evidence:
    """Every speed with the mean force set by the static force; then statics, where the table has them.

    name: of the scene.  speeds: km/h.  mean_at_rest: mean force at 0 km/h, N.  statics: a key of `STATICS`.
    """
    results: dict[str, Result] = {}
    measured: dict[str, dict[str, float]] = {}
    notes: list[str] = []
    for v in speeds:
        speed, target = f"{v:g} km/h", target_mean(v, mean_at_rest)
        results[speed], static_force, trial = set_mean_run(name, v, target, runs.options)
        of_speed = numbers(results[speed])
        measured[speed] = {**of_speed, "std_over_mean": of_speed["std"] / of_speed["mean"]}
        notes.append(
            f"At {speed} the static force was set to {static_force:.1f} N, from one trial run whose mean was {trial:.1f} N, to "
            f"bring the mean to {target:.1f} N (0.00097 v² + {mean_at_rest:g}); the run's own mean is "
            f"{of_speed['mean']:.1f} N. That row is set, not found."
        )
    if statics:
        measured[AT_REST] = STATICS[statics](resting_catenary(name, MESH, bending=False))
    rows = compare(load_table(name).rows, measured)
    outside = [
        f"{r.reference.quantity} at {r.reference.condition}"
        for r in rows
        if r.reference.standing == "unconfirmed" and not r.inside
    ]
    notes.append("Outside the unconfirmed ranges: " + ("; ".join(outside) if outside else "none") + ".")
    settings = {speed: statistics(result).settings for speed, result in results.items()}
    data = model_data(name, make("catenary", load_scene(name).units["catenary"]))
    return Evidence(measured, shown=results, notes=tuple(notes), settings=settings, data={"model": data})


def stitched_statics(catenary: Any) -> dict[str, float]:
    """Elasticity, preloads, lengths and reaction of the middle span; mm/N at 100 N, N, m."""
    form = catenary.form()
    start = form.layout.supports[5]
    places = {"e_support": 0.0, "e_first": 5.0, "e_clamp": 9.0, "e_greatest": 28.5, "e_midspan": 32.5}
    e = 1e3 * elasticity(catenary.mesh, start + np.array(list(places.values())), 100.0)
    first = int(np.searchsorted(form.layout.droppers.position, start))
    return dict(zip(places, e.tolist(), strict=True)) | {
        "preload_stitch": form.preload[first],
        "preload": form.preload[first + 1],
        "reaction": form.reaction[4],
        **{f"length_{k + 1}": form.length[first + k] for k in range(4)},
    }


def two_wire_statics(catenary: Any) -> dict[str, float]:
    """Elasticity of the first wire, how both share 100 N, preloads, lengths and reaction of the middle span; mm/N, 1, N, m."""
    form = catenary.form()
    start = float(form.layout.supports[5])
    places = (0.0, 4.0, 8.0, 22.0, 32.0)
    e = 1e3 * elasticity(catenary.mesh, start + np.array(places), 100.0)
    d = form.layout.droppers
    mine = np.flatnonzero((d.position > start) & (d.lower == 0))[:4]
    return {
        **{f"e_{x:g}": v for x, v in zip(places, e.tolist(), strict=True)},
        "e_4_at_200": 1e3 * float(elasticity(catenary.mesh, [start + 4.0], 200.0)[0]),
        **{f"share_{x:g}": first_share(catenary.mesh, start + x, 100.0) for x in places[1:4]},
        **{f"preload_{k + 1}": form.preload[i] for k, i in enumerate(mine[:3])},
        **{f"length_{k + 1}": form.length[i] for k, i in enumerate(mine)},
        "reaction": form.reaction[4],
    }


def first_share(mesh: Any, position: float, force: float) -> float:
    """Share of the first of two contact wires in a force on a head at rest that touches both through a spring each, 1."""
    statics, rest = Statics(mesh), np.zeros(mesh.mass.size)
    soft = [1.0 / CONTACT + contact_compliance(0.0, position, wire, mesh) for wire in (0, 1)]

    def apart(first: float) -> float:
        """Height of the head under the first wire less that under the second, m."""
        q, _, _ = statics.under([(position, first, 0), (position, force - first, 1)], True)
        return (wire_height(position, q, 0, mesh) + soft[0] * first) - (
            wire_height(position, q, 1, mesh) + soft[1] * (force - first)
        )

    if wire_height(position, rest, 1, mesh) - wire_height(position, rest, 0, mesh) > 1.0:
        return 1.0
    low, high = 0.0, force
    for _ in range(25):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if apart(middle) < 0.0 else (low, middle)
    return low / force


STATICS = {"stitched": stitched_statics, "two wires": two_wire_statics}
