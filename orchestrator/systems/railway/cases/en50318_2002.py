"""EN 50318:2002: the reference model at two speeds against the published table, and what moves its numbers."""

from __future__ import annotations

import math
from itertools import chain
from typing import Any

from ....harness.analysis.signals import ButterworthFilter
from ....harness.validation import Evidence, Runs
from ....harness.validation.questions import done
from ....harness.validation.reference import Table, compare, load_table
from ....opened.compile_ahead import compile_ahead, wanted_by
from ....run.run import run
from ....scene.scene import Scene
from ....units.component import make
from ... import load_scene
from ..records import statistics
from ..runs import WITHOUT_PICTURES, at_speed, numbers, reference_run, with_stable_substep

SPEEDS = (250.0, 300.0)  # km/h
BETAS = (0.0, 2.5e-4, 5e-4, 1e-3, 1.5e-3, 2e-3, 3e-3)  # s
BETA, ALPHA = "catenary.damping.beta", "catenary.damping.alpha"
STUDIED = ("std", "max", "min", "uplift_mm")
RAYLEIGH = "Rayleigh, α = 0.0125 1/s, β = 0.1 ms"


def condition(speed: float) -> str:
    """The table's name of a speed in km/h."""
    return f"{speed:g} km/h"


def measure(runs: Runs) -> Evidence:
    """The 16 cells through the scene as shipped."""
    results = {condition(v): reference_run(v, runs.options) for v in SPEEDS}
    measured = {c: numbers(r) for c, r in results.items()}
    settings = {c: statistics(r).settings for c, r in results.items()}
    rows = (r for r in compare(load_table("en50318-2002").rows, measured) if r.reference.low != r.reference.high)
    tight = [
        f"{r.reference.quantity} at {r.reference.condition}, margin {r.margin:.2g} {r.reference.unit}"
        for r in sorted(rows, key=lambda r: r.margin)[:4]
    ]
    return Evidence(measured, shown=results, settings=settings, data={"tight": "; ".join(tight)})


def study(runs: Runs) -> Evidence:
    """What moves the cells: variants of the model in process, and filters."""
    table = load_table("en50318-2002")
    results = {condition(v): reference_run(v, runs.options) for v in SPEEDS}
    scene = load_scene("en50318-2002")
    variants = _variants(scene)
    effects = [changes for changes in variants.values() if "units.catenary.effects" in changes]
    compile_ahead(chain(*(wanted_by(scene.with_changes(changes), {}) for changes in ({}, *effects))), runs.options.progress)
    measured = {name: {v: _variant(changes, v) for v in SPEEDS} for name, changes in variants.items()}
    measured = {"as shipped": {v: numbers(results[condition(v)]) for v in SPEEDS}, **measured}
    damped = {name: m for name, m in measured.items() if name.startswith("β")}
    drawn: dict[str, Any] = {
        "shipped": [1e3 * _parameter(load_scene("en50318-2002"), "damping.beta")],
        "betas": [1e3 * b for b in BETAS],
    }
    for measure in STUDIED:
        for v in SPEEDS:
            drawn[f"{measure}.{v:g}"] = [m[v].get(measure, math.nan) for m in damped.values()]
            drawn[f"{measure}.{v:g}.rayleigh"] = [measured[RAYLEIGH][v].get(measure, math.nan)]
            drawn[f"{measure}.{v:g}.shipped"] = [measured["as shipped"][v].get(measure, math.nan)]
    columns = ("std", "max", "min", "uplift_mm", "loss_raw")
    drawn["variants"] = [(name, *_line(m, columns), _inside(table, m)) for name, m in measured.items()]
    return Evidence(data={**drawn, "filters": _filtered(results, table)})


def _variants(scene: Scene) -> dict[str, dict[str, Any]]:
    """Name -> changes of the scene; each changes one thing."""
    catenary = scene.units["catenary"]
    element, substep = _parameter(scene, "element"), _parameter(scene, "substep")
    half_step = {"master.step": 0.5 * scene.master.step, "catenary.substep": 0.5 * substep}
    half_element = {"catenary.element": 0.5 * element}
    with_effect = {
        e: {"units.catenary.effects": [*catenary.effects, e]} for e in ("steady_arm", "level_support", "bending_stiffness")
    }
    return {
        **{f"β = {1e3 * b:g} ms": {ALPHA: 0.0, BETA: b} for b in BETAS},
        RAYLEIGH: {ALPHA: 0.0125, BETA: 1e-4},
        "steps halved": half_step,
        "elements halved": half_element,
        "steps and elements halved": half_step | half_element,
        "steady arm of 300 N/m": with_effect["steady_arm"],
        "wire held level at the supports": with_effect["level_support"],
        "wires with bending stiffness": with_effect["bending_stiffness"],
    }


def _parameter(scene: Scene, name: str) -> float:
    catenary: Any = make("catenary", scene.units["catenary"])
    return catenary.parameters[name]


def _variant(changes: dict[str, Any], speed: float) -> dict[str, float]:
    scene = at_speed(load_scene("en50318-2002"), speed, WITHOUT_PICTURES | changes)
    return numbers(done(run(with_stable_substep(scene), in_process=True)))


def _inside(table: Table, of_speed: dict[float, dict[str, float]]) -> str:
    rows = [row for v in SPEEDS for row in compare(table.under(condition(v)), of_speed[v])]
    return f"{sum(r.inside for r in rows)} of {len(rows)}"


def _line(of_speed: dict[float, dict[str, float]], measures: tuple[str, ...]) -> tuple[str | float, ...]:
    return tuple(of_speed[v].get(m, math.nan) for v in SPEEDS for m in measures)


def _filtered(results: dict[str, Any], table: Table) -> list[tuple[str | float, ...]]:
    """The numbers of the same runs by other filters."""
    rows: list[tuple[str | float, ...]] = []
    for zero_phase in (True, False):
        for order in (2, 4, 6, 8):
            low_pass = ButterworthFilter(20.0, order, zero_phase)
            of_speed = {v: numbers(results[condition(v)], low_pass) for v in SPEEDS}
            name = str(low_pass).partition(" low pass, ")[2].partition(", -3")[0]
            rows.append((name, *_line(of_speed, ("std", "max", "min")), _inside(table, of_speed)))
    return rows
