"""The page of `cosimo effects`: predicted beside actual size and what each effect costs, then the table with the reasons."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...charts.style import BLUE, GREEN, INK, RAW, SKY, VERMILION, axis, drawn, label, layout, vertical
from ...studies.chosen import reason
from ...studies.quantities import percent
from ..page import Block, Cells, Facts, Figure, Page, Section, Text, write_page

if TYPE_CHECKING:
    from ...studies.effects import Effects, Finding

ROW = 44  # px of an effect
DECADES = 4  # below the tolerance, of the axis of errors
LARGEST = 3.0  # error at the end of the axis: runs that fail reach it


def for_effects(found: Effects, directory: str | Path) -> Path:
    """`report.html` of the effects a scene calls for."""
    measured = [f for f in found.findings if f.standing == "measured"]
    shown = sorted(measured, key=lambda f: f.actual)  # the largest at the top
    blocks: list[Block] = [Text(_advice(found))]
    blocks += [Text(list(found.remarks), "note")] if found.remarks else []
    blocks += [_sizes(found, shown), _costs(found, shown)] if shown else []
    sections = [Section("Which effects matter", blocks), Section("Effects", [_table(found), *_others(found)]),
                Section("Study", [Facts("What was compared", [
                    ("tolerance", percent(found.tolerance)), ("quantities", "; ".join(found.quantities)),
                    ("models that were run", str(found.runs))])])]
    return write_page(Page(found.scene.title or found.scene.name, _lead(found), sections), Path(directory) / "report.html")


def _lead(found: Effects) -> str:
    chosen = sum(f.chosen for f in found.findings)
    return (f"{chosen} of {sum(f.standing in ('measured', 'required') for f in found.findings)} effects are enough for an error "
            f"within {percent(found.tolerance)}, against the scene with all of them; without any one of these it is larger.")


def _advice(found: Effects) -> list[str]:
    rows = (("With all effects", found.full), ("As it is", found.given), ("With the smallest set", found.least))
    said = [f"{name}: error {percent(c.error)}, {c.calls} calls, {c.seconds:.3g} s." for name, c in rows]
    return [" ".join(said), *(["The smallest set: " + ", ".join(f.name for f in found.findings if f.chosen) + "."]
                              if any(f.chosen for f in found.findings) else ["No effect is called for."])]


def _bars(values: Sequence[float], rows: Sequence[int], name: str, colour: str, shift: float, texts: Sequence[str],
          **more: Any) -> dict[str, Any]:
    return {"type": "bar", "orientation": "h", "x": drawn(values, 4), "y": [r + shift for r in rows], "width": 0.34, "name": name,
            "marker": {"color": colour}, "text": list(texts), "textposition": "none",
            "hovertemplate": "%{text}<extra></extra>"} | more


def _sizes(found: Effects, shown: Sequence[Finding]) -> Figure:
    rows, least = list(range(len(shown))), found.tolerance * 10.0**-DECADES

    def length(error: float) -> float:
        return LARGEST if error == float("inf") else max(error, least) if error == error else error

    data = [
        *(_bars([length(f.actual) for f in some], [r for r, f in enumerate(shown) if f.chosen == chosen], name, colour, 0.19,
                [f"{f.name}<br>actual: {_size(f.actual)}" + (f", in {f.worst}" if f.worst else "") for f in some])
          for chosen, name, colour in ((True, "actual, chosen", BLUE), (False, "actual, left out", SKY))
          if (some := [f for f in shown if f.chosen == chosen])),
        _bars([length(f.predicted) for f in shown], rows, "predicted", VERMILION, -0.19,
              [f"{f.name}<br>predicted: {_size(f.predicted)}" for f in shown]),
    ]
    made = _layout("error without it", shown, barmode="overlay", shapes=[vertical(found.tolerance, colour=INK, dash="dash")],
                   annotations=[label(percent(found.tolerance), log10(found.tolerance), 1.0, xref="x", yanchor="bottom")])
    made["xaxis"] |= {"type": "log", "range": [log10(least), log10(LARGEST)], "dtick": 1}
    return Figure("Size of each effect", {"data": data, "layout": made}, (
        "Error of the scene with all effects but this one and those that need it: measured, and predicted from short ways along "
        "the solution. Left out is what stays within the tolerance, the dashed line, together with all else that is. Bars that "
        "end at the left are smaller than the axis shows; those that reach the right end are of runs that fail."))


def _costs(found: Effects, shown: Sequence[Finding]) -> Figure:
    rows, full = list(range(len(shown))), found.full
    texts = [f"{f.name}<br>{f.calls} calls, {f.seconds:.3g} s, {f.states} states" for f in shown]
    data = [_bars([100.0 * f.calls / max(full.calls, 1) for f in shown], rows, "counted work", GREEN, 0.19, texts),
            _bars([100.0 * f.seconds / full.seconds for f in shown], rows, "time", RAW, -0.19, texts)]
    made = _layout("more with it, % of a run with all effects", shown, barmode="overlay", shapes=[vertical(0.0, colour=INK)])
    return Figure("What each effect adds", {"data": data, "layout": made}, (
        "Counted work, the same on every machine: evaluations of equations and hand-overs; what only lengthens an equation adds "
        "none. Time is that of the shortest of several runs, and scatters. To the left: a run has less of it with the effect."))


def _layout(title: str, shown: Sequence[Finding], **more: Any) -> dict[str, Any]:
    rows = list(range(len(shown)))
    y = axis("", tickvals=rows, ticktext=[f.name for f in shown], range=[-0.6, len(rows) - 0.4])
    return layout(110 + ROW * len(rows), xaxis=axis(title, grid=True), yaxis=y) | more


def _size(error: float) -> str:
    return "the run fails" if error == float("inf") else percent(error)


def _table(found: Effects) -> Cells:
    order = sorted((f for f in found.findings if f.standing in ("measured", "required")), key=lambda f: (not f.chosen, -f.actual))
    rows = [(f.name, "yes" if f.given else "no", "yes" if f.chosen else "no", percent(f.predicted), _size(f.actual), f.worst,
             percent(f.breaking), str(f.states), str(f.calls), f"{f.seconds:.3g}" if isfinite(f.seconds) else "–",
             reason(f, found.tolerance)) for f in order]
    return Cells("Effects of the full model", (
        "effect", "in the scene", "chosen", "predicted", "actual", "largest in", "error of the set without it", "states", "calls",
        "seconds", "why"), rows, "States, calls and seconds: what a run has more with it.", frozenset({3, 4, 6, 7, 8, 9}))


def _others(found: Effects) -> list[Block]:
    rows = [(f.name, reason(f, found.tolerance)) for f in found.findings if f.standing in ("left out", "unable")]
    return [Facts("Not in the full model", rows, folded=len(rows) > 20)] if rows else []
