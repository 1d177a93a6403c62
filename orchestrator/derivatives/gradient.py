"""How figures of a run move with its parameters: derivatives and elasticities, each with its error, or the reason why there is none.

Signals have exact derivatives (`tangent_block`). A figure is a function of the signals: its derivative is that of the function along their
tangents, by central differences in the space of signals, at two lengths that agree to many digits since nothing but the function is
repeated. Where decisions stand at their very boundary, the runs on either side tell whether a derivative holds, for one side, or not;
where it holds for none, those close to the boundary are tried, each on its side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed, nearest
from ..opened.open_scene import OpenScene
from ..output import write_table
from ..run.comparison import SURE
from ..run.key_results import STATISTICS, KeyResults, after_transient, key_results
from ..run.results import Result
from ..run.run import run
from ..scene.names import numerical_of, place_of
from ..scene.scene import Scene
from ..scene.shorter_steps import refined
from ..scene.sums import parts_alone
from .along import AGREE, along, length
from .tangent_block import TangentBlock
from .tangent_run import TangentRows, beside, tangent_run

STATISTICS_AND_LAST: dict[str, Callable[[np.ndarray], Any]] = {**STATISTICS, "last": lambda values: values[-1]}
BESIDE = 1e-5  # of runs on either side of a boundary, relative to the parameter
CLOSE = 1e-9  # to a boundary, relative to the parameter: derivatives there are those of its side
SAID = 0.05  # of a derivative: runs that resolve no more say nothing of one that counts
ROUNDED = 1e-12  # of any signal: below stands what rounding leaves, such as the residual of a balance
COUNTS = 1e-6  # of a figure: what the whole parameter moves it by at least, where that counts
EXACT, LEFT, RIGHT, DIFFERENCES = "exact", "one-sided, below", "one-sided, above", "differences"
COLUMNS = ("figure", "unit", "value", "parameter", "at", "derivative", "elasticity", "error", "how")
Measure = Callable[[Result], KeyResults]
Own = Callable[[Result], Mapping[str, tuple[float, str]]]  # a function of a user's: value and unit by name


@dataclass(frozen=True)
class Slope:
    """The derivative of a figure by a parameter. at: the parameter's value. error: of the derivative; NaN where it is not known.

    how: "exact", "one-sided, above" or "below", "differences", or the reason for which there is none; the derivative is NaN then.
    """

    figure: str
    unit: str
    value: float
    parameter: str
    at: float
    derivative: float
    error: float
    how: str

    @property
    def elasticity(self) -> float:
        """So many percent the figure moves for one percent of the parameter; NaN where either is 0."""
        return self.derivative * self.at / self.value if self.value and self.at else nan


@dataclass(frozen=True)
class Gradient:
    """Derivatives of figures by parameters, those that matter most first within each figure; refused: parameter -> reason. remarks:
    which figures are of a part alone, such as one contact wire of two."""

    scene: Scene
    slopes: tuple[Slope, ...]
    refused: Mapping[str, str]
    remarks: tuple[str, ...] = ()

    def __getitem__(self, names: tuple[str, str]) -> Slope:
        """That of a figure by a parameter; raises `BadInput` with the near names."""
        known = {(s.figure, s.parameter): s for s in self.slopes}
        if names not in known:
            expected = nearest(", ".join(names), [", ".join(pair) for pair in known])
            raise BadInput(f"gradient of {self.scene.name}", repr(names), "a figure and a parameter of it", expected)
        return known[names]

    def __repr__(self) -> str:
        lines = [f"<Gradient of {self.scene.name}: {len(self.slopes)} derivatives>"]
        lines += [
            f"{s.figure} by {s.parameter}: {s.derivative:.6g}, elasticity {s.elasticity:.3g} ({s.how})" for s in self.slopes
        ]
        return "\n".join([*lines, *(f"{name}: {reason}" for name, reason in self.refused.items())])

    def save(self, directory: str | Path) -> Path:
        """Write gradient.csv; an empty cell is a number that is not known."""
        rows = [[getattr(s, column) for column in COLUMNS] for s in self.slopes]
        shown = [["" if isinstance(cell, float) and not isfinite(cell) else cell for cell in row] for row in rows]
        return write_table(directory, "gradient.csv", COLUMNS, shown)

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data; a number that is not finite is None."""
        cells = [{c: getattr(s, c) for c in COLUMNS} for s in self.slopes]
        plain = [{c: None if isinstance(v, float) and not isfinite(v) else v for c, v in row.items()} for row in cells]
        return {"scene": self.scene.name, "derivatives": plain, "refused": dict(self.refused), "remarks": list(self.remarks)}


def gradient(
    scene: Scene,
    of: str | Sequence[str] | Own | None = None,
    by: str | Sequence[str] | None = None,
    *,
    differences: float = 0.0,
    halved: bool = True,
) -> Gradient:
    """Derivatives of figures by parameters.

    of: figures of the summary, "unit.output, kind" with a kind of `STATISTICS_AND_LAST`, or a function of a `Result`; default: the summary.
    by: real parameters, and inputs that nothing drives; default: all.  differences: by runs with so large a relative change instead,
    for scenes that have no derivatives.  halved: errors by derivatives with half of all steps.  Raises `BadInput`, `StepFailed`.
    """
    of = [of] if isinstance(of, str) else of
    figures = _figures(of)
    if differences:
        return _by_differences(scene, of, [by] if isinstance(by, str) else by, differences)
    with ExitStack() as stack:
        block = TangentBlock(scene, stack)
        names = [by] if isinstance(by, str) else block.parameters() if by is None else list(by)
        refused = numerical_of(scene, names)
        names = [n for n in names if n not in refused]
        at = {n: block.value(n) for n in names}
        base = _run(scene)
        slopes = slopes_of(base, block, figures, names, at)
    if halved and names:
        finer = scene.with_changes({"master.step": 0.5 * scene.master.step, **refined(scene, 0.5)})
        with ExitStack() as stack:
            again = slopes_of(_run(finer), TangentBlock(finer, stack), figures, names, at)
        slopes = {key: replace(s, error=SURE * abs(s.derivative - again[key].derivative)) for key, s in slopes.items()}
    return Gradient(scene, _sorted(slopes.values()), refused, alone(base, of))


def alone(base: Result, of: Sequence[str] | Own | None) -> tuple[str, ...]:
    """A sentence for each signal of these figures that is a part of a sum, where the rest is not zero in the run."""
    names = () if of is None or callable(of) else [name.partition(",")[0].strip() for name in of]
    known = [name for name in names if name in base.columns]
    return tuple(parts_alone(base.scene, known, lambda name: base[name][after_transient(base)]))


def _sorted(slopes: Any) -> tuple[Slope, ...]:
    order = {figure: k for k, figure in enumerate(dict.fromkeys(s.figure for s in slopes))}
    size = {id(s): abs(s.elasticity) if isfinite(s.elasticity) else -1.0 for s in slopes}
    return tuple(sorted(slopes, key=lambda s: (order[s.figure], -size[id(s)])))


def _figures(of: Sequence[str] | Own | None) -> Measure:
    """The function that gives the wanted figures of a result."""
    if of is None:
        return key_results
    if callable(of):
        return lambda result: KeyResults.of((name, *number) for name, number in of(result).items())

    def figures(result: Result) -> KeyResults:
        statistics = all(name.rpartition(",")[2].strip() in STATISTICS_AND_LAST for name in of)
        summary = KeyResults() if statistics else key_results(result)
        chosen = KeyResults()
        for name in of:
            signal, _, kind = (part.strip() for part in name.partition(","))
            if name in summary:
                chosen.add([(name, summary[name], summary.units[name])])
            elif kind in STATISTICS_AND_LAST:
                chosen.add([(name, STATISTICS_AND_LAST[kind](result[signal][after_transient(result)]), result.measures[signal])])
            else:
                known = [*summary, *(f"{s}, {k}" for s in result.columns for k in STATISTICS_AND_LAST)]
                raise BadInput(f"gradient of {result.scene.name}", repr(name), "a figure", nearest(name, known))
        return chosen

    return figures


def _run(scene: Scene) -> Result:
    """A run in this process; raises `StepFailed` where it does not come to its end."""
    result = run(scene, in_process=True).unless_stopped()
    if result.outcome != "done":
        raise StepFailed(scene.name, result.end if result.rows else scene.start_time, result.message)
    return result


def slopes_of(
    base: Result, block: TangentBlock, figures: Measure, names: Sequence[str], at: Mapping[str, float]
) -> dict[tuple[str, str], Slope]:
    """Derivatives of figures of a run, (figure, parameter) -> `Slope`; at: values of the parameters.

    Raises `StepFailed`, and `BadInput` for figures that are not of signals alone.
    """
    base = _of_signals(base, figures)
    scene, rows = base.scene, tangent_run(block, names)
    recorded = _recorded(base, block, rows)
    values = figures(base)
    slopes: dict[tuple[str, str], Slope] = {}
    for k, name in enumerate(names):
        ways = [_along(base, {s: t[:, k] for s, t in recorded.items()}, figures, values, name, at[name])]
        sides = _beside(scene, figures, values, name, at[name]) if rows.at_tie[k] else None
        if sides is not None and not all(_fits(d, side, at[name], v).any() for d, side, v in _each(ways[0][0], sides, values)):
            ways += _close(base, block, figures, values, name, at[name])
        for i, (figure, value) in enumerate(values.items()):
            derivative, error, smooth = (of_all[i] for of_all in ways[0])
            how = EXACT if smooth else "the figure itself jumps or bends there"
            if sides is not None:
                chosen, how = _verdict([way[0][i] for way in ways], sides[:, :, i], at[name], value)
                derivative, error, _ = (of_all[i] for of_all in ways[chosen])
            if not isfinite(derivative):
                how = "infinite, or not a number"
            known = how in (EXACT, LEFT, RIGHT)
            slopes[figure, name] = Slope(
                figure, values.units[figure], value, name, at[name], float(derivative) if known else nan, float(error), how
            )
    return slopes


def _of_signals(base: Result, figures: Measure) -> Result:
    """The run without its snapshots, which have no tangents; raises `BadInput` where figures depend on them."""
    bare = replace(base, snapshots={})
    try:
        alone = not base.snapshots or repr(figures(bare)) == repr(figures(base))
    except (BadInput, KeyError):
        alone = False
    if not alone:
        where = f"gradient of {base.scene.name}"
        raise BadInput(where, "figures of snapshots", "figures of signals, which have derivatives", "Or differences = 1e-4.")
    return bare


def _recorded(base: Result, block: TangentBlock, rows: TangentRows) -> dict[str, np.ndarray]:
    """Tangents of the recorded columns at the recorded times, (n, d); raises `BadInput` where the runs are not one."""
    at = np.clip(np.searchsorted(rows.time, base.time - 1e-9 * base.scene.master.step), 0, rows.time.size - 1)
    places = {f"{unit}.{name}": k for k, (unit, name) in enumerate(block.signals)}
    where = f"gradient of {base.scene.name}"
    if not np.allclose(rows.time[at], base.time, rtol=0.0, atol=1e-6 * base.scene.master.step):
        raise BadInput(where, "rows between macro steps", "record.interval as a multiple of master.step")
    for name, column in base.columns.items():
        within = 1e-6 * np.max(np.abs(column), initial=0.0) + ROUNDED
        if not np.allclose(rows.values[at, places[name]], column, rtol=1e-6, atol=within, equal_nan=True):
            raise BadInput(where, f"{name} of the run with derivatives is another one", "the same run", "Report this scene.")
    return {name: rows.tangents[at, places[name]] for name in base.columns}


def _along(
    base: Result, tangents: Mapping[str, np.ndarray], figures: Measure, values: KeyResults, name: str, at: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the figures (m,) their derivatives along tangents of the signals, the errors of these, and whether both sides agree."""
    first = values.at(values)
    if not (step := length(base, tangents, at)):
        return np.full_like(first, nan), np.full_like(first, nan), np.zeros(first.size, dtype=bool)

    def numbers(result: Result) -> np.ndarray:
        return figures(result).at(values)

    whole, _ = along(base, tangents, numbers, first, name, at, step)
    half, bend = along(base, tangents, numbers, first, name, at, 0.5 * step)
    rounding = 1e-13 * np.abs(first) / step
    return half, np.abs(whole - half) + rounding, np.abs(bend) <= AGREE * np.abs(half) + 10.0 * rounding


def _beside(scene: Scene, figures: Measure, values: KeyResults, name: str, at: float) -> np.ndarray:
    """(2, 2, m), below and above: differences of runs, and what they do not resolve; NaN where a side cannot run."""
    step, first = BESIDE * (abs(at) or 1.0), values.at(values)
    sides = np.full((2, 2, first.size), nan)
    for side, way in zip(sides, (-step, step), strict=True):
        with suppress(BadInput, StepFailed):
            runs = [figures(_run(scene.with_changes({name: at + share * way}))).at(values) for share in (1.0, 0.5)]
            whole, near = ((run - first) / (share * way) for run, share in zip(runs, (1.0, 0.5), strict=True))
            side[:] = 2.0 * near - whole, np.abs(near - whole) + 1e-11 * np.abs(first) / step
    return sides


def _each(derivatives: np.ndarray, sides: np.ndarray, values: KeyResults) -> Iterator[tuple[float, np.ndarray, float]]:
    """Of each figure its derivative, what runs give on either side, (2, 2), and its value."""
    yield from zip(derivatives.tolist(), np.moveaxis(sides, 2, 0), values.values(), strict=True)


def _close(
    base: Result, block: TangentBlock, figures: Measure, values: KeyResults, name: str, at: float
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """As `_along`, of the derivatives close below and above a boundary; NaN where a side cannot run, or is another run at once."""
    none = np.full(len(values), nan)
    sides = [(none, none, none)] * 2
    for side, way in enumerate((-CLOSE, CLOSE)):
        with suppress(BadInput, StepFailed):
            rows = beside(block, name, way * (abs(at) or 1.0))
            recorded = _recorded(base, block, rows)
            sides[side] = _along(base, {s: t[:, 0] for s, t in recorded.items()}, figures, values, name, at)
    return sides


def _fits(derivative: float, sides: np.ndarray, at: float, value: float) -> np.ndarray:
    """Whether a derivative is what runs below, above say, (2,).  sides: (2, 2) differences, and what they do not resolve."""
    differences, unsure = sides.T
    size = np.maximum(abs(derivative), np.abs(differences))
    silent = (unsure > SAID * size) & (unsure * (abs(at) or 1.0) > COUNTS * abs(value))
    return ~silent & (np.abs(derivative - differences) <= AGREE * size + 2.0 * unsure)


def _verdict(derivatives: Sequence[float], sides: np.ndarray, at: float, value: float) -> tuple[int, str]:
    """What runs on either side of a boundary say of derivatives at it, and close below and above: which one holds, and how."""
    fits = [_fits(derivative, sides, at, value) for derivative in derivatives]
    if fits[0].all() or (len(fits) > 1 and fits[2].all()):
        return (0 if fits[0].all() else 2), EXACT
    for which, side, how in ((0, 1, RIGHT), (0, 0, LEFT), (2, 1, RIGHT), (1, 0, LEFT)):
        if which < len(fits) and fits[which][side]:
            return which, how
    below, above = sides[:, 0].tolist()
    if isnan(below) and isnan(above):
        return 0, "no other value comes to its end in this scene"
    return 0, f"a decision stands at its boundary; runs give {below:.4g} below and {above:.4g} above"


def _by_differences(scene: Scene, of: Sequence[str] | Own | None, by: Sequence[str] | None, share: float) -> Gradient:
    """By runs on either side, whatever the units of the scene are; the error by half the distance."""
    if not by:
        raise BadInput(f"gradient of {scene.name}", "no parameters", "their names, where differences of runs are asked for")
    steps = {name: share * (abs(_value(scene, name)) or 1.0) for name in by}
    base = _run(scene)
    return Gradient(scene, _sorted(by_differences(base, _figures(of), steps).values()), {}, alone(base, of))


def by_differences(
    base: Result, figures: Measure, steps: Mapping[str, float], *, halved: bool = True
) -> dict[tuple[str, str], Slope]:
    """As `slopes_of`, by runs with each parameter so far on either side; 0 where that is no way. Raises `BadInput`, `StepFailed`.

    halved: by half as far, with the error that the whole distance shows; else it is not known, and a parameter takes two runs.
    """
    scene, values = base.scene, figures(base)
    slopes: dict[tuple[str, str], Slope] = {}

    def quotients(name: str, at: float, step: float) -> np.ndarray:
        up, down = (figures(_run(scene.with_changes({name: at + way * step}))).at(values) for way in (1.0, -1.0))
        return (up - down) / (2.0 * step)

    for name, step in steps.items():
        at, derivatives, errors = _value(scene, name), np.zeros(len(values)), np.zeros(len(values))
        if step:
            whole = quotients(name, at, step)
            derivatives = quotients(name, at, 0.5 * step) if halved else whole
            errors = np.abs(derivatives - whole) if halved else np.full_like(whole, nan)
        for (f, value), d, e in zip(values.items(), derivatives.tolist(), errors.tolist(), strict=True):
            slopes[f, name] = Slope(f, values.units[f], value, name, at, d, e, DIFFERENCES)
    return slopes


def _value(scene: Scene, parameter: str) -> float:
    """Of a parameter as it stands; raises `BadInput` for one that is no number."""
    place = place_of(scene, parameter)
    with ExitStack() as stack:
        value = OpenScene(scene, stack, in_process=True).units[place.unit].parameters().get(place.parameter)
    if isinstance(value, bool) or not isinstance(value, float | int):
        raise BadInput(f"gradient of {scene.name}: {parameter}", repr(value), "a number")
    return float(value)
