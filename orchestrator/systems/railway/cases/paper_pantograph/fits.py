"""What a free choice of coefficients buys: other stiffnesses, a dropper term, a mass."""

from __future__ import annotations

from .....harness.charts.chart import Grid
from .....harness.validation import Evidence, Question, Runs
from .....harness.validation.reference import compare, load_table
from .lumped import MASSLESS, lumped_run
from .table import SPEEDS, cells

DROPPER = 9  # harmonic
FIT = (0.30, *[0.0] * (DROPPER - 2), 0.15)
VARIANTS = {  # name -> stiffness in N/m, swings, mass in kg and damping in N.s/m
    "statics: 2870 N/m, 0.38": (2870.0, (0.38,), MASSLESS),
    "softer: 2500 N/m, 0.30": (2500.0, (0.30,), MASSLESS),
    "softer, dropper term 0.15": (2500.0, FIT, MASSLESS),
    "softer, mass of 100 kg, 300 N.s/m": (2500.0, (0.30,), (100.0, 300.0)),
}


def measure(runs: Runs) -> Evidence:
    """The variants at both speeds."""
    results = {name: {v: cells(lumped_run(v, *variant)) for v in SPEEDS} for name, variant in VARIANTS.items()}
    names = list(VARIANTS)
    measured = {f"soft.std.{v:g}": results[names[1]][v]["std"] for v in SPEEDS}
    measured |= {f"fit.fast.{v:g}": results[names[2]][v]["std_5_20"] for v in SPEEDS}
    measured |= {f"mass.std.{v:g}": results[names[3]][v]["std"] for v in SPEEDS}
    header = ("k(x)", *(f"{n} ({v:g})" for v in SPEEDS for n in ("σ, N", "σ 5-20 Hz, N", "max, N", "min, N")), "cells inside")
    rows: list[tuple[str | float, ...]] = [
        (name, *(round(of[v][m], 1) for v in SPEEDS for m in ("std", "std_5_20", "max", "min")), inside(of))
        for name, of in results.items()
    ]
    text = (
        "(250), (300): km/h. Statics gives a dropper term of 0.03: five times that is a fit. A mass whose frequency on its "
        "spring is below the span-passing one takes the pantograph off the line."
    )
    grid = Grid("What coefficients buy", header, tuple(rows), text)
    return Evidence(measured, (grid,))


def inside(of_speed: dict[float, dict[str, float]]) -> str:
    """How many cells of the table hold."""
    rows = [r for v in SPEEDS for r in compare(load_table("en50318-2002").under(f"{v:g} km/h"), of_speed[v])]
    return f"{sum(r.inside for r in rows)} of {len(rows)}"


QUESTION = Question(measure)
