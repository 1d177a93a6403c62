"""Figures that a page computes from a run's signals, as data: the page has one small interpreter of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from ...scene.scene import Scene
from ..analysis.records import KINDS
from ..analysis.signals import Filter, sections
from ..studies.quantities import EDGE, quantities_of

MOST = 12  # figures of a scene without a system that knows better
LIVE_KINDS = (*KINDS, "end", "mean + 3 σ", "mean - 3 σ", "share not above zero", "amplitude")


@dataclass(frozen=True)
class LiveFigure:
    """One number of a run.

    signals: "unit.output"; of several, the largest number.  kind: one of `LIVE_KINDS`; a share is in percent.  factor: of the
    number shown over that of the signals.  cutoff: Hz, of the `Filter` that the whole signal goes through first; 0 without.
    window: (signal, from, to), where the signal never decreases: rows with from <= signal < to; without one the rows from
    `transient` s on, without `edge` s at either end.  frequency: Hz, of an amplitude.
    measure: its name in reference tables.
    """

    name: str
    text: str
    unit: str
    signals: tuple[str, ...]
    kind: str
    factor: float = 1.0
    cutoff: float = 0.0
    window: tuple[str, float, float] | None = None
    transient: float = 0.0
    edge: float = 0.0
    frequency: float = 0.0
    measure: str = ""

    def to_json(self) -> dict[str, Any]:
        """For the page."""
        return asdict(self) | {"filter": f"{self.cutoff:g}" if self.cutoff else ""}


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
    for cutoff in {f.cutoff for f in figures if 0.0 < f.cutoff < 0.5 * rate}:
        coefficients = sections(Filter(cutoff), rate)
        needed[f"{cutoff:g}"] = {
            "sections": coefficients.tolist(),
            "rest": sosfilt_zi(coefficients).tolist(),
            "ends": int(3 * rate / cutoff),
        }
    return needed
