"""Evidence in an FMU: an experiment with reference results, and what the communication step costs in accuracy.

Written and read as the layered standard FMI-LS-REF has it (1.0.0-beta.1, July 2026, whose text still prints the version before;
github.com/modelica/fmi-ls-ref): a manifest names related files with their roles. The experiment is a file of the draft
MA-HS-Experiments (github.com/modelica/ma-hs-experiments, schema of 2026; that of the examples before, with times at the experiment,
is read, too). Neither says how near a result has to be: tolerances are an annotation of the reference results, as both allow.
"""

from __future__ import annotations

import csv
import html
import io
import posixpath
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree as ET

import numpy as np

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
NAMESPACE, EXPERIMENTS = "http://fmi-standard.org/fmi-ls-manifest", "application/x-ma-hs-experiments"
OLDER = "application/x-ma-ls-experiments"  # in an example of the standard
CSV, KNOWN = "text/csv", ("TransientSimulation", "Parameters", "Stimuli", "References", "Annotations")
TOLERANCES = "cosimo.tolerances"  # type of the annotation
STANDARD = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-beta.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}


@dataclass(frozen=True)
class Step:
    """One length of the step.

    error: the largest of the quantities, as a share, and `of` which it is; seconds: CPU time of a second of simulated time.
    """

    length: float
    error: float
    seconds: float
    outcome: str = "done"
    of: str = ""


@dataclass(frozen=True)
class Evidence:
    """What was measured before an FMU was built.

    step: s, of the default experiment.  stop: s.  time: (n,) s.  outputs, inputs: name -> (n,).  tolerances: of the outputs, in
    their units.  source: where the numbers come from.  steps: from the longest on.  meaning: which step is varied, and what an
    error is.  stable: on the longest stable step.
    """

    step: float
    stop: float
    time: np.ndarray
    outputs: Mapping[str, np.ndarray]
    tolerances: Mapping[str, float]
    source: str
    steps: Sequence[Step]
    meaning: str
    stable: str
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def summary(self) -> str:
        """One sentence for the description of the FMU."""
        of_step = next((s for s in self.steps if s.length == self.step), None)
        name = "" if of_step is None or not of_step.of else f" ({of_step.of})"
        error = "" if of_step is None else f" Error at a step of {self.step:g} s: {100.0 * of_step.error:.2g} %{name}."
        return f"{error} {self.stable}".strip()

    def section(self) -> str:
        """HTML for the documentation of the FMU."""
        rows = "\n".join(
            f"<tr><td>{s.length:g}</td><td>{100.0 * s.error:.3g}</td><td>{html.escape(s.of)}</td>"
            f"<td>{s.seconds:.3g}</td><td>{html.escape(s.outcome)}</td></tr>"
            for s in self.steps
        )
        return f"""<h2>Evidence</h2>
<p>{html.escape(self.meaning)} {html.escape(self.stable)}</p>
<table><tr><th>step, s</th><th>error, %</th><th>of</th><th>CPU time of 1 s, s</th><th>outcome</th></tr>
{rows}
</table>
<p>An experiment with reference results: <code>{FOLDER}</code>. {html.escape(self.source)}</p>
"""

    def described(self, description: bytes) -> bytes:
        """A model description with the step of the default experiment, and a sentence on it."""
        root = _parsed(description)
        root.set("description", f"{root.get('description')}. {self.summary}")
        for experiment in root.iter("DefaultExperiment"):
            experiment.set("stepSize", repr(self.step))
        return _finished(root)

    def members(self, arrays: bool) -> dict[str, bytes]:
        """Path in the FMU -> content; arrays: elements of an array are one variable, as in FMI 3."""
        files = {
            "reference.csv": self._table(self.outputs, arrays),
            "steps.csv": self._steps(),
            "default.exp": self._experiments(),
        }
        related = [
            (EXPERIMENTS, "default.exp", "experiment/validation", "The default experiment, with its results"),
            ("text/csv", "reference.csv", "result", "Outputs of the default experiment. " + self.source),
            ("text/csv", "steps.csv", "report", self.meaning),
            ("text/html", "../../documentation/index.html", "document", "Equations, variables, and what accuracy costs"),
        ]
        if self.inputs:
            files["stimuli.csv"] = self._table(self.inputs, arrays)
            related.append(("text/csv", "stimuli.csv", "other", "Inputs of the default experiment"))
        ET.register_namespace("fmi-ls", NAMESPACE)
        root = ET.Element("fmiReferences", {f"{{{NAMESPACE}}}{name}": value for name, value in STANDARD.items()})
        for kind, source, role, text in related:
            ET.SubElement(root, "Related", {"type": kind, "source": source, "role": role, "description": text})
        return {MANIFEST: _finished(root)} | {f"{FOLDER}/{name}": content for name, content in files.items()}

    def _experiments(self) -> bytes:
        root = ET.Element("Experiments", {"name": "Evidence", "description": self.source})
        experiment = ET.SubElement(root, "Experiment", {"name": "default", "description": "The default experiment"})
        times = {"startTime": "0", "stopTime": repr(self.stop), "stepSize": repr(float(self.time[1]))}
        ET.SubElement(experiment, "TransientSimulation", times)
        if self.inputs:
            ET.SubElement(experiment, "Stimuli", {"source": "stimuli.csv"})
        references = ET.SubElement(experiment, "References", {"source": "reference.csv"})
        annotation = ET.SubElement(ET.SubElement(references, "Annotations"), "Annotation", {"type": TOLERANCES})
        for name, value in self.tolerances.items():
            ET.SubElement(annotation, "Tolerance", {"signal": name, "absolute": repr(float(value))})
        return _finished(root)

    def _table(self, columns: Mapping[str, np.ndarray], arrays: bool) -> bytes:
        whole = {name: np.asarray(values)[:, None] for name, values in columns.items()}
        if arrays:
            groups: dict[str, list[np.ndarray]] = {}
            for name, values in columns.items():
                groups.setdefault(name.partition("[")[0] if name.endswith("]") else name, []).append(values)
            whole = {name: np.stack(values, axis=1) for name, values in groups.items()}
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", *whole])
        for k, t in enumerate(self.time.tolist()):
            writer.writerow([repr(t), *(" ".join(map(repr, values[k].tolist())) for values in whole.values())])
        return file.getvalue().encode()

    def _steps(self) -> bytes:
        rows = "\n".join(f'{s.length!r},{s.error!r},"{s.of}",{s.seconds:.4g},{s.outcome}' for s in self.steps)
        return f"step (s),error (1),of,CPU time of a second (s),outcome\n{rows}\n".encode()


def _finished(root: ET.Element) -> bytes:
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


@dataclass(frozen=True)
class Experiment:
    """An experiment that an FMU brings along; files by their paths in it, "" for none. tolerances: by signal, absolute."""

    name: str
    reference: str
    start: float | None = None
    stop: float | None = None
    step: float | None = None
    stimuli: str = ""
    parameters: str = ""
    tolerances: Mapping[str, float] = field(default_factory=dict)


def experiments(files: Mapping[str, bytes]) -> tuple[list[Experiment], list[str]]:
    """Experiments that can be replayed, and what of the evidence cannot; `files`: path in the FMU -> content.

    A result that no experiment refers to is that of the default experiment.
    """
    replayable: list[Experiment] = []
    left: list[str] = []
    results: list[str] = []
    for related in _parsed(files[MANIFEST]).iter("Related"):
        role, source, kind = (related.get(name, "") for name in ("role", "source", "type"))
        place = _place(source, MANIFEST)
        if role.partition("/")[0] not in ("experiment", "result"):
            continue
        if place not in files:
            left.append(f"{source or 'a source without a name'} ({role}) is not in the FMU")
        elif role == "result" and kind == CSV:
            results.append(place)
        elif role != "result" and kind in (EXPERIMENTS, OLDER):
            replayable += _experiments_of(place, files, left)
        else:
            left.append(f"{source} ({role}) is of the type {kind!r}, which is not read")
    referred = {e.reference for e in replayable}
    replayable += [Experiment(posixpath.basename(place), place) for place in results if place not in referred]
    return replayable, left


def _experiments_of(place: str, files: Mapping[str, bytes], left: list[str]) -> Iterable[Experiment]:
    for element in _parsed(files[place]).iter("Experiment"):
        name = element.get("name", "without a name")
        transient = element.find("TransientSimulation")
        times: Any = element if transient is None else transient
        sources = {child.tag: child.get("source", "") for child in element}
        places = {tag: _place(sources[tag], place) if tag in sources else "" for tag in ("Parameters", "Stimuli", "References")}
        missing = [sources[tag] for tag, at in places.items() if at and at not in files]
        other = [child.tag for child in element if child.tag not in KNOWN]
        other += [
            kind for tag in ("Stimuli", "References") for child in element.iter(tag) if (kind := child.get("type", CSV)) != CSV
        ]
        if other:
            left.append(f"experiment {name!r} has {other[0]}, which is not replayed")
            continue
        if not places["References"] or missing:
            left.append(f"experiment {name!r} has " + (f"no file {missing[0]}" if missing else "no reference results"))
            continue
        tolerances = {
            t.get("signal", ""): float(t.get("absolute", "nan"))
            for annotation in element.iter("Annotation")
            if annotation.get("type") == TOLERANCES
            for t in annotation.iter("Tolerance")
        }
        start, stop, step = (
            None if (text := times.get(key)) is None else float(text) for key in ("startTime", "stopTime", "stepSize")
        )
        yield Experiment(name, places["References"], start, stop, step, places["Stimuli"], places["Parameters"], tolerances)


def _parsed(content: bytes) -> ET.Element:
    return ET.fromstring(content)


def _place(source: str, file: str) -> str:
    """Path in the FMU of a source, relative to the file that names it; "" for what is elsewhere."""
    parts = urlsplit(source)
    if parts.scheme or parts.netloc or not parts.path:
        return ""
    return posixpath.normpath(posixpath.join(posixpath.dirname(file), unquote(parts.path)))


def read_table(content: bytes) -> tuple[dict[str, np.ndarray], list[str]]:
    """Columns of numbers, (n, elements), and the names of the other columns."""
    rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"))))
    columns: dict[str, np.ndarray] = {}
    others: list[str] = []
    for name, *values in zip(*(row for row in rows if row), strict=True):
        try:
            columns[name.strip()] = np.array([[_number(v) for v in value.split()] for value in values], dtype=float)
        except ValueError:
            others.append(name.strip())
    return columns, others


def _number(text: str) -> float:
    return float(text == "true") if text in ("true", "false") else float(text)
