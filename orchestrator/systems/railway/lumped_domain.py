"""The lumped catenary of a line, and up to which speed it may stand for the line: both run under the same pantograph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ....components.railway.catenary import Catenary
from ....components.railway.contact import wire_height
from ....components.railway.lumped import SpanFit, fit_span
from ...harness.analysis.signals import ButterworthFilter, uniform, window
from ...harness.charts.chart import Chart, Grid, Panel, Series
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from ...harness.report.generic import grid_table
from ...harness.report.page import Page, Section, write_page
from ...output import ensure_directory, write_table
from ...run.results import Result
from ...run.run import run
from ...scene.scene import Scene, write_scene
from ...settings.names import connection
from ...units.component import make
from .. import read_scene
from .records import analysis_window, measured, passages, statistics
from .runs import WITHOUT_PICTURES, at_speed

ERRORS = {  # column -> what it says
    "mean": "mean force",
    "std": "σ of the force",
    "std_0_5": "σ, 0-5 Hz",
    "std_5_20": "σ, 5-20 Hz",
    "history": "time history of the force below 20 Hz, rms over σ",
    "uplift": "uplift of the contact point, rms over its mean",
}
PORTS = ("wire_height", "contact_force", "contact_position")


@dataclass(frozen=True)
class LumpedDomain:
    """Errors of a lumped catenary against the line it was fitted to.

    speeds: (n,) km/h, rising.  errors: by the columns of `ERRORS`, (n,) each, shares: of the line's own value, `history` of its
    standard deviation, `uplift` of its mean uplift.  lumped: the scene with the lumped catenary.
    """

    name: str
    force: float  # N, at which the elasticity was taken
    fit: SpanFit
    inerter: bool
    lumped: Scene
    speeds: np.ndarray
    errors: Mapping[str, np.ndarray]

    def up_to(self, quantity: str, tolerance: float) -> float:
        """The highest speed up to which an error stays within the tolerance at every speed that was run, km/h; NaN for none."""
        within = list(takewhile(lambda pair: pair[1] <= tolerance, zip(self.speeds, np.abs(self.errors[quantity]), strict=True)))
        return float(within[-1][0]) if within else float("nan")

    def save(self, directory: str | Path) -> list[Path]:
        """`lumped.toml`, the scene, and `lumped.csv`, a row for each speed."""
        folder = ensure_directory(directory)
        remarks = [
            f"Lumped catenary of the scene {self.name}: static elasticity under {self.force:g} N; its stiffness is off by",
            f"{100.0 * self.fit.rms:.2g} % (rms), {100.0 * self.fit.worst:.2g} % at worst.",
        ]
        header = ["speed [km/h]", *(f"error of {name} [1]" for name in ERRORS)]
        rows = [(float(v), *(float(self.errors[q][i]) for q in ERRORS)) for i, v in enumerate(self.speeds)]
        return [write_scene(self.lumped, folder / "lumped.toml", remarks), write_table(folder, "lumped.csv", header, rows)]


def lumped_domain(
    scene: Scene, speeds: Sequence[float], force: float | None = None, span: int | None = None, inerter: bool = False
) -> LumpedDomain:
    """Derive a lumped catenary from the line of a scene with one pantograph, and run both at each speed (km/h).

    force: N, at which the static elasticity is taken; without it the line's own mean force at the lowest speed.
    span: counted from 1; without it the middle one.

    Raises `BadInput` for a scene without a distributed catenary or with several pantographs.
    """
    order = np.unique(np.asarray(speeds, dtype=float))
    if not order.size or not (np.isfinite(order).all() and order[0] > 0.0):
        raise BadInput("speeds", str(list(speeds)), "positive speeds in km/h")
    pantograph, catenary = _pair(scene)
    plain = scene.with_changes({k: v for k, v in WITHOUT_PICTURES.items() if scene.record.snapshots})
    distributed = {v: _done(at_speed(plain, v, unit=pantograph)) for v in order}
    mean = statistics(distributed[order[0]]).mean if force is None else force
    line: Any = make(catenary, scene.units[catenary])
    line.set("contact_position", make(pantograph, scene.units[pantograph]).parameters["start_position"])
    line.initialize(0.0)
    _equal_spans(line, catenary)
    fit = fit_span(line, mean, span)
    lumped = _with_lumped(plain, catenary, fit, mean if inerter else None, analysis_window(distributed[order[0]]))
    errors: dict[str, list[float]] = {name: [] for name in ERRORS}
    for v in order:
        for name, value in _errors(distributed[v], _done(at_speed(lumped, v, unit=pantograph)), line).items():
            errors[name].append(value)
    return LumpedDomain(scene.name, mean, fit, inerter, lumped, order, {k: np.array(v) for k, v in errors.items()})


def _pair(scene: Scene) -> tuple[str, str]:
    """(pantograph, catenary) of a scene with one of each."""
    pairs = []
    for source, target in scene.ends:
        unit, _, name = source.partition(".")
        if target.endswith(".wire_height") and issubclass(scene.component_classes.get(unit, object), Catenary):
            pairs.append((target.partition(".")[0], unit, name))
    if len(pairs) != 1 or pairs[0][2] != "wire_height":
        raise BadInput(
            scene.name,
            f"{len(pairs)} pantographs under a distributed catenary",
            "a scene with one",
            "A lumped catenary has no waves, and so no other pantograph's wake.",
        )
    return pairs[0][0], pairs[0][1]


def _equal_spans(line: Catenary, name: str) -> None:
    lengths = np.diff(line.mesh.position[line.mesh.support])
    if np.ptp(lengths) > 1e-6:
        raise BadInput(
            f"units.{name}",
            f"spans of {lengths.min():g} to {lengths.max():g} m",
            "spans of one length",
            "The lumped catenary repeats one span; fit a span of this line alone with LumpedCatenary.from_line.",
        )


def _done(scene: Scene) -> Result:
    result = run(scene, in_process=True).unless_stopped()
    if result.outcome != "done":
        raise BadInput(scene.name, f"a run with the outcome {result.outcome}: {result.message}", "runs that reach their end")
    return result


def _with_lumped(scene: Scene, catenary: str, fit: SpanFit, reference: float | None, place: tuple[float, float]) -> Scene:
    """The scene with the lumped catenary in the place of its line."""
    data: dict[str, Any] = scene.settings()
    values: dict[str, Any] = {k: v for k, v in fit.parameters.items() if not k.startswith("harmonic[")}
    values["harmonic"] = [v for k, v in fit.parameters.items() if k.startswith("harmonic[")]
    if reference is not None:
        values["inerter.reference_force"] = reference
    data["units"][catenary] = {
        "component": "LumpedCatenary",
        "effects": [] if reference is None else ["inerter"],
        "parameters": values,
    }
    kept = {f"{catenary}.{port}" for port in PORTS}

    def known(name: str) -> bool:
        return not name.startswith(f"{catenary}.") or name in kept

    data["connections"] = [connection(*ends, scene.units) for ends in scene.ends if all(map(known, ends))]
    if data["record"].get("signals"):
        data["record"]["signals"] = [s for s in data["record"]["signals"] if known(s)]
    data["analysis"] = {k: v for k, v in data["analysis"].items() if k != "spans"} | {"window": list(place)}
    data.pop("study", None)
    data["title"] = f"{scene.name} with a lumped catenary in the place of its line"
    return read_scene(data, f"{scene.name}-lumped")


def _errors(distributed: Result, lumped: Result, line: Catenary) -> dict[str, float]:
    ours, theirs = (measured(statistics(r)) for r in (lumped, distributed))
    errors = {name: ours[name] / theirs[name] - 1.0 for name in ERRORS if name not in ("history", "uplift")}
    place = analysis_window(distributed)
    grid = np.linspace(*place, 2001)
    forces, heights = [], []
    for result in (distributed, lumped):
        record = passages(result)[0].record
        rate, _, (x, force, height) = uniform(record.time, record.position, record.force, record.height)
        cut = window(x, place[0] - 1.0, place[1] + 1.0)
        forces.append(np.interp(grid, x[cut], ButterworthFilter().apply(force, rate)[cut]))
        heights.append(np.interp(grid, x[cut], height[cut]))
    unloaded = np.zeros(line.mesh.mass.size)
    uplift = heights[0] - [wire_height(x, unloaded, 0, line.mesh) for x in grid]
    return errors | {
        "history": float(np.sqrt(np.mean((forces[1] - forces[0]) ** 2)) / theirs["std"]),
        "uplift": float(np.sqrt(np.mean((heights[1] - uplift) ** 2)) / uplift.mean()),
    }


def report(domain: LumpedDomain, tolerance: float, directory: str | Path) -> Path:
    """`report.html`: errors over the speed, how far each stays within the tolerance, the parameters."""
    series = tuple(
        Series(text, domain.speeds, 100.0 * np.abs(domain.errors[name]), "line+points") for name, text in ERRORS.items()
    )
    chart = Chart(
        "Error of the lumped catenary over the speed",
        "speed, km/h",
        (Panel("error, %", series, logarithmic=True),),
        "Against the line itself under the same pantograph; the force below 20 Hz in the window of analysis.",
    )
    rows = tuple(
        (text, *(f"{100.0 * e:+.2g}" for e in domain.errors[name]), domain_text(domain, name, tolerance))
        for name, text in ERRORS.items()
    )
    header = ("quantity", *(f"{v:g} km/h, %" for v in domain.speeds), f"within {100.0 * tolerance:g} % up to")
    grid = Grid("Errors", header, rows)
    values = Grid(
        "Parameters",
        ("parameter", "value"),
        tuple((k, number(v)) for k, v in domain.fit.parameters.items()),
        f"Static elasticity of one span under {domain.force:.4g} N. The series leaves {100.0 * domain.fit.rms:.2g} % "
        f"(rms) of the stiffness out; {100.0 * domain.fit.asymmetry:.2g} % of its swing is odd about midspan.",
    )
    lead = (
        f"A mass on a spring that varies along the span, fitted to the line of {domain.name}. It has no waves and not the "
        "line's shape at rest: it may stand for the line only where the errors below are small enough for the purpose."
    )
    return write_page(
        Page(
            f"Lumped catenary of {domain.name}",
            lead,
            [Section("Where it may be used", [draw_chart(chart), grid_table(grid)]), Section("The fit", [grid_table(values)])],
        ),
        Path(directory) / "report.html",
    )


def domain_text(domain: LumpedDomain, quantity: str, tolerance: float) -> str:
    """How far an error stays within the tolerance, in words."""
    speed = domain.up_to(quantity, tolerance)
    if not speed > 0.0:
        return f"not at {domain.speeds[0]:g} km/h"
    return f"{speed:g} km/h" + (", the highest that was run" if speed == domain.speeds[-1] else "")
