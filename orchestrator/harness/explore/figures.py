"""Figures that a page computes from a run's signals, as data: the page has one small interpreter of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from ...run.key_results import STATISTICS
from ...scene.scene import Scene
from ..analysis.signals import ButterworthFilter, sections
from ..preferred_units import choices
from ..studies.quantities import EDGE, quantities_of

MOST = 12  # figures of a scene without a system that knows better
OF_THE_SIGNAL = (
    *STATISTICS,
    "end",
    "mean + 3 σ",
    "mean - 3 σ",
    "amplitude",
    "largest size",
    "peak to peak",
    "at the largest",
    "overshoot",
)
LIVE_KINDS = (  # those with the signal's unit of measure, and the others
    *OF_THE_SIGNAL, "kurtosis", "integral", "change", "rate of change", "largest drift", "share not above zero", "share of zeros",
    "share of time at 1", "settling time", "starts", "distinct points",
)  # fmt: skip


@dataclass(frozen=True)
class LiveFigure:
    """One number of a run.

    signals: "unit.output"; of several, the largest number, unless they are combined row by row.
    combine: "size" (Euclidean norm), "product", "difference" of two, "largest size"; "" for none.
    kind: one of `LIVE_KINDS`; a share is in percent.  factor: of the number shown over that of the signals.
    powers: "unit.parameter" -> exponent with which the present value of the parameter multiplies the number.
    over: a figure by which this one is divided; without a number where that one is not positive.
    cutoff: Hz, of the `ButterworthFilter` that the whole signal goes through first; 0 without.
    window: (signal, from, to), where the signal never decreases: rows with from <= signal < to; without one the rows from
    `transient` s on, without `edge` s at either end.  frequency: Hz, of an amplitude.
    moves: of overshoot and settling time: (begin, change done, begin of the next one, s; sign of the change; band).
    section: of distinct points: (signal of an angle, spacing in rad): groups of points 2 % of the range apart, among the
    combinations of all signals at the multiples of the spacing; the first half of the signals has one range, and so has the
    other. Over a parameter the page draws the first signal there.
    limits: of starts: speed above which a shaft runs, and the longest standstill, s, that is no stop.
    measure: its name in reference tables.
    """

    name: str
    text: str
    unit: str
    signals: tuple[str, ...]
    kind: str
    factor: float = 1.0
    combine: str = ""
    powers: tuple[tuple[str, float], ...] = ()
    over: LiveFigure | None = None
    cutoff: float = 0.0
    window: tuple[str, float, float] | None = None
    transient: float = 0.0
    edge: float = 0.0
    frequency: float = 0.0
    moves: tuple[tuple[float, float, float, float, float], ...] = ()
    section: tuple[str, float] | None = None
    limits: tuple[float, float] | None = None
    measure: str = ""

    @property
    def whole(self) -> tuple[LiveFigure, ...]:
        """Itself and the figure by which it is divided."""
        return (self, self.over) if self.over else (self,)

    def to_json(self) -> dict[str, Any]:
        """For the page."""
        return asdict(self) | {
            "choices": choices(self.unit, self.name),
            "filter": f"{self.cutoff:g}" if self.cutoff else "",
            "over": self.over.to_json() if self.over else None,
            "of_the_signal": self.kind in OF_THE_SIGNAL and not self.over and self.combine != "product",
        }


def figures_of_study(scene: Scene) -> tuple[LiveFigure, ...]:
    """The quantities of interest of a scene; of a time history, its extremes."""
    figures = []
    for q in quantities_of(scene):
        kinds = ("minimum", "maximum") if q.kind == "time history" else (q.kind,)
        for kind in kinds:
            live = "amplitude" if kind.startswith("amplitude") else kind
            text = (
                q.name.partition(", ")[2] if q.kind != "time history" else kind + (f" below {q.cutoff:g} Hz" if q.cutoff else "")
            )
            edge = EDGE / q.cutoff if q.cutoff else 0.0
            figures.append(
                LiveFigure(
                    f"{q.signal}, {text}",
                    f"{q.signal}, {text}",
                    q.unit,
                    (q.signal,),
                    live,
                    cutoff=q.cutoff,
                    transient=max(q.transient, edge),
                    edge=edge,
                    frequency=q.frequency,
                )
            )
    return tuple({f.name: f for f in figures}.values())[:MOST]


def filters(figures: Iterable[LiveFigure], step: float) -> dict[str, dict[str, Any]]:
    """What the page filters with at a macro step in s, by cut-off: second-order sections, their state at rest, samples at the ends."""
    from scipy.signal import sosfilt_zi

    rate, needed = 1.0 / step, {}
    for cutoff in {f.cutoff for figure in figures for f in figure.whole if 0.0 < f.cutoff < 0.5 * rate}:
        coefficients = sections(ButterworthFilter(cutoff), rate)
        needed[f"{cutoff:g}"] = {
            "sections": coefficients.tolist(),
            "rest": sosfilt_zi(coefficients).tolist(),
            "ends": int(3 * rate / cutoff),
        }
    return needed
