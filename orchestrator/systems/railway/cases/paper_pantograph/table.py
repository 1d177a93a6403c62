"""The lumped catenary through the table of EN 50318:2002: with the stiffness of statics, and with coefficients that are chosen."""

from __future__ import annotations

import numpy as np

from .....harness.analysis.signals import ButterworthFilter, uniform, window
from .....harness.validation import Evidence, Runs
from .....harness.validation.reference import compare, load_table
from .....run.results import Result
from ...records import analysis_window, passages
from ...runs import numbers, reference_run
from .lumped import FRAME_SPRING, MASSLESS, SPAN, lumped_run

SPEEDS = (250.0, 300.0)  # km/h
ROWS = ("mean", "std", "statistical_max", "statistical_min", "max", "min", "uplift_mm", "loss_raw")
DROPPER = 9  # harmonic
FIT = (0.30, *[0.0] * (DROPPER - 2), 0.15)
VARIANTS = {  # name -> stiffness in N/m, swings, mass in kg and damping in N.s/m
    "statics: 2870 N/m, 0.38": (2870.0, (0.38,), MASSLESS),
    "softer: 2500 N/m, 0.30": (2500.0, (0.30,), MASSLESS),
    "softer, dropper term 0.15": (2500.0, FIT, MASSLESS),
    "softer, mass of 100 kg, 300 N.s/m": (2500.0, (0.30,), (100.0, 300.0)),
}


def measure(runs: Runs) -> Evidence:
    """Both speeds, beside the distributed catenary; then other stiffnesses, a dropper term, a mass."""
    results = {v: lumped_run(v) for v in SPEEDS}
    of_speed = {v: cells(results[v]) for v in SPEEDS}
    measured = {f"{name}.{v:g}": of_speed[v][name] for v in SPEEDS for name in ROWS}
    for v, n in of_speed.items():
        frame = float(np.mean(results[v]["pantograph.frame_height"][in_window(results[v])]))
        measured |= {
            f"crest.{v:g}": (n["max"] - n["mean"]) / n["std"],
            f"fast.{v:g}": n["std_5_20"],
            f"lift.{v:g}": n["mean"] + FRAME_SPRING * frame,
            f"peak.{v:g}": peak(results[v]),
            f"lumped.uplift.{v:g}": n["uplift_mm"],
        }
    measured["growth"] = of_speed[300.0]["std"] / of_speed[250.0]["std"]
    distributed = reference_run(250.0, runs.options)
    measured["peak.distributed"] = peak(distributed)
    of_variants, variants = _variants()
    forces = {"lumped": filtered(results[250.0]), "distributed": filtered(distributed)}
    return Evidence(measured | of_variants, data={"forces": forces, "rows": _rows(of_speed), "variants": variants})


def cells(result: Result) -> dict[str, float]:
    """The run's statistics by the table's names; as uplift that at the supports of the window, where the wire has a height."""
    start, end = analysis_window(result)
    x, height = result["pantograph.contact_position"], result["catenary.wire_height"]
    supports = np.arange(start, end + 1e-6, SPAN)
    return numbers(result) | {"uplift_mm": 1e3 * float(np.interp(supports, x, height).max())}


def in_window(result: Result) -> slice:
    """Samples in the window of analysis."""
    return window(result["pantograph.contact_position"], *analysis_window(result))


def peak(result: Result) -> float:
    """Position in the span of the mean force's maximum, m, filtered, folded over the window."""
    x, force = filtered(result)
    bins = np.floor(x % SPAN).astype(int)
    return float(np.argmax([force[bins == k].mean() for k in range(int(SPAN))])) + 0.5


def filtered(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Position in m and force below 20 Hz in N, in the window of analysis."""
    record = passages(result)[0].record
    rate, _, (x, force) = uniform(record.time, record.position, record.force)
    cut = window(x, *analysis_window(result))
    return x[cut], ButterworthFilter().apply(force, rate)[cut]


def _rows(of_speed: dict[float, dict[str, float]]) -> list[tuple[str | float, ...]]:
    """Every row of the table beside what the lumped model gives."""
    rows: list[tuple[str | float, ...]] = []
    for v, values in of_speed.items():
        for row in compare(load_table("en50318-2002").under(f"{v:g} km/h"), values):
            r = row.reference
            ends = " to ".join(f"{e:g}" for e in (r.low, r.high) if e is not None)
            rows.append((f"{v:g}", r.quantity, r.unit, round(row.simulated, 1), ends, "holds" if row.inside else "fails"))
    return rows


def _variants() -> tuple[dict[str, float], list[tuple[str | float, ...]]]:
    """Measures and rows of the variants at both speeds."""
    results = {name: {v: cells(lumped_run(v, *variant)) for v in SPEEDS} for name, variant in VARIANTS.items()}
    names = list(VARIANTS)
    measured = {f"soft.std.{v:g}": results[names[1]][v]["std"] for v in SPEEDS}
    measured |= {f"fit.fast.{v:g}": results[names[2]][v]["std_5_20"] for v in SPEEDS}
    measured |= {f"mass.std.{v:g}": results[names[3]][v]["std"] for v in SPEEDS}
    columns = ("std", "std_5_20", "max", "min")
    return measured, [(n, *(round(of[v][m], 1) for v in SPEEDS for m in columns), inside(of)) for n, of in results.items()]


def inside(of_speed: dict[float, dict[str, float]]) -> str:
    """How many cells of the table hold."""
    rows = [r for v in SPEEDS for r in compare(load_table("en50318-2002").under(f"{v:g} km/h"), of_speed[v])]
    return f"{sum(r.inside for r in rows)} of {len(rows)}"
