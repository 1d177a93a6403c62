"""What a page that computes a wrist shows: how far the hand moves, what ligaments bear, the swing of linkages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.explore.figures import LiveFigure
from .records import HAND, bundles, linkages, wrists

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every wrist, ligament bundle and four-bar linkage of the scene that was recorded, after the transient."""
    rows, units, begin = [], result.scene.units, result.scene.analysis.transient

    def add(unit: str, name: str, text: str, measure: str, signals: list[str], kind: str) -> None:
        rows.append(LiveFigure(f"{unit}.{name}", text, measure, tuple(signals), kind, transient=begin))

    for wrist in wrists(result):
        for name in HAND:
            for word, kind in (("max", "maximum"), ("min", "minimum")):
                if name in wrist.signals and wrist.unit in units:
                    add(wrist.unit, f"{name}_{word}", f"{word} of the hand's {name}", "rad", [f"{wrist.unit}.{name}"], kind)
    for bundle in bundles(result):
        for what, measure in (("tension", "N"), ("strain", "1")):
            signals = [n for n in result.columns if n.startswith(f"{bundle.unit}.{what}[")]
            if signals and bundle.unit in units:
                add(bundle.unit, f"{what}_max", f"largest {what} of a ligament", measure, signals, "maximum")
    for linkage in linkages(result):
        if linkage.unit in units:
            add(linkage.unit, "swing", "swing of the output link", "rad", [f"{linkage.unit}.output_angle"], "peak to peak")
    return tuple(rows)
