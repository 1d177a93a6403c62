"""Lumped pantograph from a measured frequency response at its head, on a fixed base.

    1 / H(w) = Z_1,    Z_j = -w² m_j + D_j Z_{j+1} / (D_j + Z_{j+1}),    D_j = k_j + i w c_j,    Z = D below the last mass

H: the head's displacement per force on it, m/N; the masses count from the head to the base.

Parameters are positive; their logarithms are fitted to ln H, so that resonances and their flanks count alike:

    minimise sum |ln H_model - ln H_measured|² / s²

The static force, the lift and the contact spring are no part of the response.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....components.core.columns import Columns, read_table
from ....components.core.errors import BadInput, counted, nearest
from ....components.core.measure import parse
from ....components.core.store import replaced
from ...harness.analysis.least_squares import Fit, fit
from ...harness.charts.blocks import Block, Text
from ...harness.charts.chart import Chart, Grid, Panel, Series
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from ...harness.report.generic import grid_table
from ...harness.report.page import Page, Section, write_page
from ...output import ensure_directory, write_table

MASSES = {2: ("head", "frame"), 3: ("head", "frame", "lower_frame")}
UNITS = {"mass": "kg", "stiffness": "N/m", "damping": "N.s/m"}
NOISE = 3.84  # growth of the sum of squares over the residuals' variance: 95 % of one parameter (chi squared)
BOUNDS = {"mass": (0.1, 200.0), "stiffness": (1e-2, 1e6), "damping": (1e-3, 1e4)}  # kg, N/m, N.s/m
STARTS = {"mass": (7.0, 10.0, 10.0), "stiffness": (7e3, 1e4, 1e2), "damping": (2e1, 2e1, 8e1)}  # from the head to the base
KINDS = {"frequency": "Hz", "real": "", "imaginary": "", "magnitude": "", "phase": "rad", "deviation": "1"}  # column -> unit
FEWEST = 5  # rows of a response
SEARCHES = 10  # starts of the search, the first at `STARTS`, the others around it
SPREAD = {"mass": 0.4, "stiffness": 1.2, "damping": 1.2}  # of the logarithms of the other starts
SAME = 1e-3  # relative difference of the residual up to which two searches have the same end
IDENTIFIED = 0.25  # relative standard deviation up to which a parameter is a number
POWERS = {"m/N": 0, "m/s/N": 1, "m/s2/N": 2, "N/m": 0, "N.s/m": 1, "kg": 2}  # unit -> power of i w beside the displacement


@dataclass(frozen=True)
class FrequencyResponse:
    """A measured response. frequency: (n,) Hz, rising.  receptance: (n,) complex, m/N.  deviation: (n,) relative, or None."""

    name: str
    frequency: np.ndarray
    receptance: np.ndarray
    deviation: np.ndarray | None


@dataclass(frozen=True)
class PantographFit:
    """Lumped parameters of `Pantograph` by name; `fit`: of their logarithms, so that its deviations are relative.

    identified: names whose relative standard deviation is at most `IDENTIFIED`.  ranges: of the other names, from where to where
    the misfit stays within its noise while the others are as fitted.  agreeing: of the searches, those with this end.
    magnitude, phase: rms misfit, relative and in rad.
    """

    response: FrequencyResponse
    values: dict[str, float]
    fixed: dict[str, float]
    fit: Fit
    identified: tuple[str, ...]
    ranges: dict[str, tuple[float, float]]
    agreeing: int
    magnitude: float
    phase: float

    @property
    def messages(self) -> list[str]:
        """What a user should know of the fit."""
        texts = [m for m in self.fit.messages if not any(m.startswith(f"{name} has stopped") for name in self.ranges)]
        for name, (low, high) in self.ranges.items():
            texts.append(
                f"{name} is not identified: {low:.3g} to {high:.3g} {UNITS[name.rpartition('_')[2]]} explain the data "
                "as well. Fix it from another measurement"
            )
        if self.agreeing < 3:
            texts.append(f"{self.agreeing} of {SEARCHES} searches end here: there may be a better fit")
        return texts


def read_response(path: str | Path) -> FrequencyResponse:
    """Read a CSV file whose header names the columns with their units.

    `frequency [Hz]`, then `real [unit]` and `imaginary [unit]`, or `magnitude [unit]` and `phase [deg]` (or `[rad]`); if known
    `deviation [1]`, the relative standard deviation. unit: as m/N, m/s/N or m/s2/N of motion per force, or as N/m, N.s/m or kg of
    force per motion (dynamic stiffness, impedance, apparent mass); mm/N is one as well. Raises `BadInput` with line and column.
    """
    path = Path(path)
    table = read_table(path, "frequency response")
    table.only(KINDS, "frequency, real and imaginary, or magnitude and phase; deviation")
    columns = {name: table.numbers(name, unit, asked=True) for name, unit in KINDS.items() if table.place(name) is not None}
    pair = next((pair for pair in (("real", "imaginary"), ("magnitude", "phase")) if {*pair} <= columns.keys()), None)
    if pair is None:
        raise BadInput(str(path), f"columns {', '.join(table.header)}", "real and imaginary, or magnitude and phase")
    unit = _kind_of(table, pair[0])
    first = table.numbers(pair[0], unit)
    response = (
        first + 1j * table.numbers("imaginary", unit, asked=True) if pair[0] == "real" else first * np.exp(1j * columns["phase"])
    )
    f, deviation = table.numbers("frequency", "Hz", asked=True), columns.get("deviation")
    whole = np.isfinite(np.abs(response) + sum(columns.values()))
    if not whole.all():
        raise BadInput(
            f"{path}, line {table.rows[int(whole.argmin())][0]}", "a cell without a number", "numbers", "Leave the row out."
        )
    if f.size < FEWEST:
        raise BadInput(str(path), f"{counted(f.size, 'row')}", f"at least {FEWEST} rows of numbers")
    if f[0] <= 0.0 or np.any(np.diff(f) <= 0.0):
        raise BadInput(f"{path}: frequency", "values that are not positive and rising", "a column frequency [Hz] that rises")
    if pair[0] == "magnitude" and (first <= 0.0).any():
        raise BadInput(f"{path}: magnitude", f"{first.min():g} {unit}", "magnitudes above 0", "Are they levels in dB?")
    if not np.abs(response).all():
        raise BadInput(str(path), "a response of 0", "a response that has a logarithm", "Leave those rows out.")
    if unit in ("N/m", "N.s/m", "kg"):
        response = 1.0 / response
    receptance = response / (2j * np.pi * f) ** POWERS[unit]
    if deviation is not None and not np.all((deviation > 0.0) & (deviation <= 1.0)):
        raise BadInput(
            f"{path}: deviation",
            f"from {deviation.min():g} to {deviation.max():g}",
            "relative standard deviations, such as 0.05 or 5 %",
        )
    return FrequencyResponse(path.name, f, receptance, deviation)


def _kind_of(table: Columns, name: str) -> str:
    """Which of the kinds of responses a column is, by the dimension of its unit: one of `POWERS`."""
    written, where = table.unit(name), f"{table.where}, column {name!r}"
    if not written:
        raise BadInput(where, "no unit", f"one of the dimension of {', '.join(POWERS)}", f"Write '{name} [m/N]'.")
    exponents = parse(written, where).exponents
    if (unit := next((unit for unit in POWERS if parse(unit).exponents == exponents), None)) is None:
        raise BadInput(where, f"unit {written!r}", f"one of the dimension of {', '.join(POWERS)}")
    return unit


def parameter_names(masses: int) -> tuple[str, ...]:
    """Names of `Pantograph`'s parameters, those of the third mass without their effect's name."""
    if masses not in MASSES:
        raise BadInput("masses", str(masses), "2 or 3")
    return tuple(f"{part}_{kind}" for part in MASSES[masses] for kind in BOUNDS)


def receptance(frequency: np.ndarray, values: Mapping[str, float]) -> np.ndarray:
    """H for frequencies in Hz, (n,) complex m/N; values by `parameter_names`, of two or three masses."""
    w = 2.0 * np.pi * np.asarray(frequency)
    below: np.ndarray | None = None  # dynamic stiffness of all that is below
    for part in reversed(MASSES[len(values) // 3]):
        link = values[f"{part}_stiffness"] + 1j * w * values[f"{part}_damping"]
        below = (link if below is None else link * below / (link + below)) - w**2 * values[f"{part}_mass"]
    assert below is not None
    return 1.0 / below


def fit_pantograph(
    response: FrequencyResponse, masses: int = 3, fixed: Mapping[str, float] | None = None, seed: int = 1
) -> PantographFit:
    """Fit a pantograph of two or three masses; `fixed`: values of parameters that are known, such as the base's stiffness."""
    known = dict(fixed or {})
    names = parameter_names(masses)
    for name, value in known.items():
        if name not in names:
            raise BadInput(f"fixed: {name}", "no parameter of the fit", "one of " + ", ".join(names), nearest(name, names))
        if not (math.isfinite(value) and value >= 0.0):
            raise BadInput(f"fixed: {name}", f"{value:g}", "a number that is not negative")
    free = [n for n in names if n not in known]
    if not free:
        raise BadInput("fixed", "all parameters", "at least one that is left to fit")
    scale = 1.0 if response.deviation is None else response.deviation

    def values_of(p: np.ndarray) -> dict[str, float]:
        values = known | dict(zip(free, np.exp(p).tolist(), strict=True))
        return {n: values[n] for n in names}

    def residuals(p: np.ndarray) -> np.ndarray:
        ratio = np.log(receptance(response.frequency, values_of(p)) / response.receptance)  # phase within half a turn
        return np.concatenate((ratio.real / scale, ratio.imag / scale))

    kinds = {n: n.rpartition("_")[2] for n in free}
    first = {n: math.log(STARTS[kinds[n]][names.index(n) // 3]) for n in free}
    bounds = {n: (math.log(BOUNDS[kinds[n]][0]), math.log(BOUNDS[kinds[n]][1])) for n in free}
    draw = np.random.default_rng(seed)
    fits = []
    for k in range(SEARCHES):
        shift = {n: SPREAD[kinds[n]] * draw.standard_normal() if k else 0.0 for n in free}
        start = {n: min(max(first[n] + shift[n], bounds[n][0]), bounds[n][1]) for n in free}
        fits.append(fit(residuals, start, bounds, noise_known=response.deviation is not None, most=200))
    best = min(fits, key=lambda f: f.rms)
    agreeing = sum(f.rms <= best.rms * (1.0 + SAME) + 1e-12 for f in fits)
    n = response.frequency.size
    magnitude, phase = (best.residuals[part] * scale for part in (slice(n), slice(n, None)))
    identified = tuple(name for name, s in zip(free, best.deviations, strict=True) if s <= IDENTIFIED)
    allowed = NOISE * (1.0 if response.deviation is not None else float(best.residuals @ best.residuals) / (2 * n - len(free)))
    ranges = {}
    for i, name in enumerate(free):
        if name not in identified:
            low, high = (_edge(residuals, best, i, bound, allowed) for bound in bounds[name])
            ranges[name] = (math.exp(low), math.exp(high))
    return PantographFit(
        response,
        values_of(best.values),
        known,
        best,
        identified,
        ranges,
        agreeing,
        float(np.sqrt(np.mean(magnitude**2))),
        float(np.sqrt(np.mean(phase**2))),
    )


def _edge(residuals: Callable[[np.ndarray], np.ndarray], best: Fit, i: int, bound: float, allowed: float) -> float:
    """Where parameter i has raised the sum of squares by `allowed` on its way to a bound, or the bound; by bisection."""
    least = float(best.residuals @ best.residuals)

    def beyond(value: float) -> bool:
        r = residuals(np.where(np.arange(best.values.size) == i, value, best.values))
        return float(r @ r) - least > allowed

    if not beyond(bound):
        return bound
    inside, outside = float(best.values[i]), bound
    for _ in range(40):
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if beyond(middle) else (middle, outside)
    return inside


def scene_text(result: PantographFit) -> str:
    """The table of a unit for a scene, with the uncertainty of each number beside it."""
    deviations = dict(zip(result.fit.names, result.fit.deviations, strict=True))
    lower = "lower_frame_mass" in result.values
    lines = [
        f"# fitted to {result.response.name}: misfit {100.0 * result.magnitude:.2g} % of the magnitude, "
        f"{math.degrees(result.phase):.2g} deg of the phase (rms)",
        "[units.pantograph]",
        'component = "Pantograph"',
        f'effects = ["contact_loss"{", " + chr(34) + "lower_frame" + chr(34) if lower else ""}]',
        "",
        "[units.pantograph.parameters]",
    ]
    for name, value in result.values.items():
        if name in result.fixed:
            remark = "given"
        elif name in result.identified:
            remark = f"standard deviation {100.0 * deviations[name]:.2g} %"
        else:
            remark = "not identified: {:.3g} to {:.3g} explain the data as well".format(*result.ranges[name])
        unit = UNITS[name.rpartition("_")[2]]
        lines.append(f"{name.replace('lower_frame_', 'lower_frame.')} = {value:.6g}  # {unit}; {remark}")
    return "\n".join(lines) + "\n"


def report(result: PantographFit, directory: str | Path) -> Path:
    """`report.html`: measured and fitted response, what is left, the parameters with their uncertainty."""
    f, data = result.response.frequency, result.response.receptance
    model = receptance(f, result.values)
    panels = (
        Panel(
            "head's displacement per force, mm/N",
            (Series("measured", f, 1e3 * np.abs(data), "points"), Series("fitted", f, 1e3 * np.abs(model))),
            logarithmic=True,
        ),
        Panel(
            "phase, degrees",
            (Series("measured", f, np.degrees(np.angle(data)), "points"), Series("fitted", f, np.degrees(np.angle(model)))),
        ),
        Panel("fitted over measured, %", (Series("magnitude", f, 100.0 * (np.abs(model / data) - 1.0), "line+points"),)),
    )
    chart = Chart("Frequency response at the head, on a fixed base", "frequency, Hz", panels)
    deviations = dict(zip(result.fit.names, result.fit.deviations, strict=True))
    rows = []
    for name, value in result.values.items():
        known = "given" if name in result.fixed else f"{100.0 * deviations[name]:.2g} %" if name in result.identified else ""
        other = "{:.3g} to {:.3g}".format(*result.ranges[name]) if name in result.ranges else ""
        rows.append((name, UNITS[name.rpartition("_")[2]], "not identified" if other else number(value), known, other))
    grid = Grid(
        "Parameters",
        ("parameter", "unit", "value", "standard deviation", "explains the data as well"),
        tuple(rows),
        "Deviations are linearised at the fit; ranges are at 95 % with the other parameters as fitted.",
    )
    blocks: list[Block] = [draw_chart(chart), grid_table(grid), *([Text(result.messages, "warning")] if result.messages else [])]
    lead = (
        f"{len(result.values) // 3} masses fitted to {counted(f.size, 'line')} from {f[0]:g} to {f[-1]:g} Hz: misfit "
        f"{100.0 * result.magnitude:.2g} % of the magnitude, {math.degrees(result.phase):.2g} degrees of the phase (rms)."
    )
    return write_page(
        Page(f"Pantograph fitted to {result.response.name}", lead, [Section("Fit", blocks)]), Path(directory) / "report.html"
    )


def save(result: PantographFit, directory: str | Path) -> list[Path]:
    """`pantograph.toml`, for a scene, `fit.csv` with a row for each fitted parameter, and `report.html`."""
    folder = ensure_directory(directory)
    with replaced(folder / "pantograph.toml") as file:
        file.write(scene_text(result))
    deviations = zip(result.fit.names, result.fit.deviations, strict=True)
    rows = [
        (
            name,
            UNITS[name.rpartition("_")[2]],
            result.values[name],
            float(s),
            int(name in result.identified),
            *result.ranges.get(name, (result.values[name],) * 2),
        )
        for name, s in deviations
    ]
    header = ["parameter", "unit", "value", "relative standard deviation [1]", "identified", "from", "to"]
    return [folder / "pantograph.toml", write_table(folder, "fit.csv", header, rows), report(result, folder)]
