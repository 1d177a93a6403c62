"""Replays the experiments that an FMU of any maker brings along, and says which of its reference results hold."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from fmpy import read_model_description, simulate_fmu

from .evidence import MANIFEST, Experiment, experiments, read_table

SHARE = 0.01  # of the range of a signal, or of its size where it is constant: taken where no tolerance is given
SHOWN = 3  # names in a message
NOT_OFFERED = "not offered"


def replayed(path: str) -> tuple[bool, str]:
    """Whether all reference results hold, and what was seen; that an FMU has no evidence is no fault of it."""
    with zipfile.ZipFile(path) as file:
        if MANIFEST not in file.namelist():
            return True, NOT_OFFERED
        files = {name: file.read(name) for name in file.namelist() if name.startswith("extra/")}
    replayable, left = experiments(files)
    answers = [_replayed(path, experiment, files) for experiment in replayable]
    texts = [text for _, text in answers] + left
    return all(ok for ok, _ in answers), "; ".join(texts) or "a manifest without experiments and results"


def _replayed(path: str, experiment: Experiment, files: Mapping[str, bytes]) -> tuple[bool, str]:
    description = read_model_description(path, validate=False)
    columns, others = read_table(files[experiment.reference])
    if "time" not in columns or not columns["time"].size:
        return False, f"{experiment.name}: reference results without a column time"
    time = columns.pop("time")[:, 0]
    known = {v.name for v in description.modelVariables}
    missing = [name for name in columns if name not in known]
    names = [name for name in columns if name in known]
    if not names:
        return False, f"{experiment.name}: no variable of the FMU among {', '.join(columns) or 'no numbers'}"
    default = description.defaultExperiment
    step = experiment.step or (
        float(default.stepSize) if default is not None and default.stepSize else float(np.diff(time).max())
    )
    result = simulate_fmu(
        path,
        validate=False,
        start_time=time[0] if experiment.start is None else experiment.start,
        stop_time=time[-1] if experiment.stop is None else experiment.stop,
        output_interval=step,
        output=names,
        fmi_type=None if description.coSimulation is None else "CoSimulation",
        input=_stimuli(files[experiment.stimuli]) if experiment.stimuli else None,
        start_values=_parameters(files[experiment.parameters]) if experiment.parameters else {},
    )
    return _compared(experiment, time, {name: columns[name] for name in names}, result, missing, others)


def _compared(
    experiment: Experiment,
    time: np.ndarray,
    columns: Mapping[str, np.ndarray],
    result: Any,
    missing: list[str],
    others: list[str],
) -> tuple[bool, str]:
    """The answer: the largest difference of each signal beside its tolerance, at the instants of the reference."""
    worst: list[tuple[float, str, float]] = []
    for name, expected in columns.items():
        there = np.asarray(result[name], dtype=float).reshape(len(result), -1)
        at_instants = np.stack([np.interp(time, result["time"], column) for column in there.T], axis=1)
        if at_instants.shape != expected.shape:
            worst.append((np.inf, name, np.inf))
            continue
        differences = np.abs(at_instants - expected).max(axis=0)
        scales = [float(np.ptp(column) or np.abs(column).max() or 1.0) for column in expected.T]
        names = [name] if name in experiment.tolerances else [f"{name}[{k + 1}]" for k in range(len(scales))]
        limits = [experiment.tolerances.get(n, SHARE * scale) for n, scale in zip(names, scales, strict=False)]
        shares = [
            d / limit if limit > 0.0 else np.inf if d else 0.0 for d, limit in zip(differences.tolist(), limits, strict=False)
        ]
        worst.append((max(shares), name, float(differences.max())))
    worst.sort(reverse=True)
    beyond = [f"{name} by {difference:.3g}" for share, name, difference in worst if not share <= 1.0]
    within = "their tolerances" if experiment.tolerances else f"{100.0 * SHARE:g} % of their ranges (no tolerance is given)"
    text = f"{experiment.name}: {len(columns) - len(beyond)} of {len(columns)} signals at {time.size} instants within {within}"
    text += f", largest difference {worst[0][2]:.3g} ({worst[0][1]})" if not beyond else f"; beyond: {_some(beyond)}"
    ended = result["time"][-1] < time[-1] * (1.0 - 1e-9)
    text += f"; it ended at {result['time'][-1]:g} s of {time[-1]:g} s" if ended else ""
    text += f"; not in the FMU: {_some(missing)}" if missing else ""
    text += f"; no numbers: {_some(others)}" if others else ""
    return not beyond and not ended, text


def _some(names: list[str]) -> str:
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def _stimuli(content: bytes) -> np.ndarray:
    """Inputs as FMPy takes them."""
    columns, _ = read_table(content)
    kinds = [(name, float) if values.shape[1] == 1 else (name, float, (values.shape[1],)) for name, values in columns.items()]
    table = np.empty(len(columns["time"]), dtype=kinds)
    for name, values in columns.items():
        table[name] = values[:, 0] if values.shape[1] == 1 else values
    return table


def _parameters(content: bytes) -> dict[str, str]:
    """Start values of a parameter set (SSV)."""
    parameters = (e for e in ET.fromstring(content).iter() if e.tag.rpartition("}")[2] == "Parameter")
    return {p.get("name", ""): p[0].get("value", "") for p in parameters if len(p)}
