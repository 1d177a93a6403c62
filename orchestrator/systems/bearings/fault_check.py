"""Whether a data set of bearing faults shows its faults: features of the records, and a small classifier as a sanity check."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...harness.analysis.spectra import amplitude_spectrum, envelope_spectrum, peak
from .fault_data import CLASSES, RPM, Sensor, base_scene, bearing_of

WITHIN = 2.0  # Hz, around the place of a line
BAND = 0.5  # of the resonance: the envelope is of the band resonance ± this share
AROUND = 20.0  # Hz on either side of a line, of which the median is the background
LOW = (20.0, 1000.0)  # Hz, below the resonance: the background of the plain spectrum
TREES = 100


@dataclass(frozen=True)
class FaultCheck:
    """accuracy: share of the test records whose label is right.  chance: of the largest class.  by_label: medians of features."""

    accuracy: float
    chance: float
    records: int
    by_label: Mapping[str, Mapping[str, float]]


def features(x: np.ndarray, sensor: Sensor, frequencies: Mapping[str, float]) -> dict[str, float]:
    """Of a record (n,): rms, kurtosis (3 for Gaussian noise), crest factor, the envelope's lines at the defect frequencies of
    pits over what is around them, and the plain spectrum's about that of the outer race at the distance of the cage's, over its
    background: a ball out of its place strikes nothing, so that the envelope does not show it."""
    x = x - x.mean()
    rms = float(np.sqrt(np.mean(x**2)))
    low, high = (1.0 - BAND) * sensor.resonance, min((1.0 + BAND) * sensor.resonance, 0.49 * sensor.rate)
    f, a = envelope_spectrum(x, sensor.rate, low, high)
    lines = {"outer": frequencies["outer"], "inner": frequencies["inner"], "ball": 2.0 * frequencies["ball"]}
    values = {"rms": rms, "kurtosis": float(np.mean(x**4) / rms**4), "crest": float(np.abs(x).max() / rms)}
    for name, at in lines.items():
        near = (np.abs(f - at) < AROUND) & (np.abs(f - at) > WITHIN)
        values[f"{name} line"] = peak(f, a, at, WITHIN)[1] / max(float(np.median(a[near])), 1e-300)
    f, a = amplitude_spectrum(x, sensor.rate)
    beside = [peak(f, a, frequencies["outer"] + k * frequencies["cage"], WITHIN)[1] for k in (-2, -1, 1, 2)]
    values["cage sidebands"] = float(np.mean(beside) / max(np.median(a[(f > LOW[0]) & (f < LOW[1])]), 1e-300))
    return values


def read_records(directory: str | Path) -> list[tuple[dict[str, str], np.ndarray]]:
    """(labels, record) of every file that labels.csv names, in the layout of CWRU."""
    from scipy.io import loadmat

    folder = Path(directory)
    try:
        with open(folder / "labels.csv", newline="", encoding="utf-8") as file:
            rows = [{k.partition(",")[0]: v for k, v in row.items()} for row in csv.DictReader(file)]
        records = []
        for row in rows:
            number = int(row["number"])
            content: dict[str, Any] = loadmat(folder / row["part"] / f"{number:03d}.mat")
            records.append((row, content[f"X{number:03d}_DE_time"][:, 0]))
    except (OSError, KeyError, ValueError) as error:
        raise BadInput("dataset", repr(str(directory)), "a data set in the layout of CWRU", f"{error}.") from None
    return records


def check(directory: str | Path, sensor: Sensor, seed: int = 0) -> FaultCheck:
    """Train on the part train, judge by the part test; raises `BadInput` without scikit-learn or without records."""
    if find_spec("sklearn") is None:
        raise BadInput("dataset", "no scikit-learn", "an installed scikit-learn for the check", "pip install scikit-learn")
    from sklearn.ensemble import RandomForestClassifier

    component = bearing_of(base_scene(1.0))
    rows, labels, parts = [], [], []
    for row, x in read_records(directory):
        if row["run_up"] == "no":
            turns = float(row["rpm"]) * RPM / (2.0 * np.pi)
            rows.append(features(x, sensor, component.geometry.defect_frequencies(turns)))
            labels.append(row["label"])
            parts.append(row["part"])
    table = np.array([list(r.values()) for r in rows])
    train, test = (np.array([p == part for p in parts]) for part in ("train", "test"))
    if not (train.any() and test.any()):
        raise BadInput("dataset", "no records to train and to test", "records in both parts")
    model = RandomForestClassifier(TREES, random_state=seed).fit(table[train], np.array(labels)[train])
    right = model.predict(table[test]) == np.array(labels)[test]
    names = list(rows[0])
    by_label = {
        label: {n: float(np.median(table[np.array(labels) == label, k])) for k, n in enumerate(names)}
        for label in CLASSES
        if label in labels
    }
    counts = np.unique(np.array(labels)[test], return_counts=True)[1]
    return FaultCheck(float(right.mean()), float(counts.max() / counts.sum()), int(test.sum()), by_label)
