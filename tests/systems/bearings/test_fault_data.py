"""The data set of bearing faults: what is planned, the sensor path against closed forms, and faults that show where they must."""

import csv

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.systems.bearings.fault_check import features
from cosimo.orchestrator.systems.bearings.fault_data import (
    CLASSES,
    SHORTEST,
    Sensor,
    base_scene,
    bearing_of,
    fault_data,
    planned,
    point,
)

QUIET = 200.0  # dB: no noise to speak of


def test_no_individual_is_in_two_parts_and_every_part_has_all_classes():
    records = planned(5, 3, run_up=True)
    parts = {}
    for r in records:
        parts.setdefault(r.individual, set()).add(r.part)
    assert {len(p) for p in parts.values()} == {1}
    for part in ("train", "validation", "test"):
        assert {r.label for r in records if r.part == part} == set(CLASSES)
    assert records == planned(5, 3, run_up=True)
    assert records != planned(5, 4, run_up=True)
    with pytest.raises(BadInput, match="3 or more"):
        planned(2, 1, run_up=False)


def test_every_planned_record_is_a_scene():
    scene = base_scene(0.1)
    component = bearing_of(scene)
    for record in planned(3, 1, run_up=True)[::5]:
        one = scene.with_changes(point(record, component))
        assert set(CLASSES[record.label]) <= set(one.units["bearing"].effects)
        assert ("speed_ramp" in one.units["bearing"].effects) == record.run_up


@pytest.mark.parametrize("frequency", [50.0, 1500.0, 3000.0, 4500.0])
def test_the_sensor_has_its_resonance(frequency):
    """Amplitude of the oscillator, 1 / sqrt((1 - r²)² + (2 ζ r)²), with r as the bilinear transform bends it: exact at the
    resonance, 1.5 % off at 4500 Hz."""
    rate = 50_000.0
    t = np.arange(0.0, 2.0, 1.0 / rate)
    sensor = Sensor(snr=QUIET)
    volts = sensor.record(3.0 * np.sin(2.0 * np.pi * frequency * t), rate, np.random.default_rng(0))[6000:-600]
    r = np.tan(np.pi * frequency / rate) / np.tan(np.pi * sensor.resonance / rate)
    exact = 3.0 * sensor.sensitivity / np.sqrt((1.0 - r * r) ** 2 + (2.0 * sensor.damping_ratio * r) ** 2)
    assert np.sqrt(2.0) * volts.std() == pytest.approx(exact, rel=0.01)  # ripple of the anti-aliasing filter


def test_what_is_above_half_the_sampling_rate_is_filtered_away_and_noise_has_its_ratio():
    rate = 50_000.0
    t = np.arange(0.0, 2.0, 1.0 / rate)
    sensor = Sensor(resonance=15_000.0, snr=QUIET)
    low, high = (sensor.record(np.sin(2.0 * np.pi * f * t), rate, np.random.default_rng(0))[600:-600].std() for f in (1e3, 8e3))
    assert high < 0.01 * low
    x = np.sin(2.0 * np.pi * 100.0 * t)
    clean, noisy = (Sensor(snr=snr).record(x, rate, np.random.default_rng(0)) for snr in (QUIET, 10.0))
    ratio = clean.std() / (noisy - clean).std()
    assert 20.0 * np.log10(ratio) == pytest.approx(10.0, abs=0.3)  # five standard errors of 24 000 samples


@pytest.mark.parametrize("duration", [0.24, 601.0, float("nan")])
def test_records_without_lines_to_look_for_are_refused_before_anything_runs(duration, tmp_path):
    with pytest.raises(BadInput, match=r"--duration.*0\.25 to 600 s"):
        fault_data(tmp_path, individuals=3, duration=duration)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("rpm", [1730.0, 1797.0])
def test_the_shortest_record_has_every_feature(rpm):
    component = bearing_of(base_scene(1.0))
    frequencies = component.geometry.defect_frequencies(rpm / 60.0)
    x = np.random.default_rng(3).standard_normal(round(SHORTEST * Sensor().rate))
    assert all(np.isfinite(v) for v in features(x, Sensor(), frequencies).values())


def test_features_of_known_signals():
    """Kurtosis 3 of Gaussian noise, 1.5 of a sine; a line where impulses come."""
    rng, rate = np.random.default_rng(2), 12_000.0
    frequencies = {"outer": 107.3, "inner": 162.2, "ball": 70.6, "cage": 11.9}
    assert features(rng.standard_normal(48_000), Sensor(), frequencies)["kurtosis"] == pytest.approx(3.0, abs=0.12)
    t = np.arange(48_000) / rate
    assert features(np.sin(2.0 * np.pi * 50.0 * t), Sensor(), frequencies)["kurtosis"] == pytest.approx(1.5, abs=1e-3)
    pulses = np.zeros(t.size)
    pulses[(np.arange(1, 400) / 107.3 * rate).astype(int)] = 1.0
    ringing = np.convolve(pulses, np.exp(-t[:200] * 900.0) * np.sin(2.0 * np.pi * 3000.0 * t[:200]))[: t.size]
    shown = features(ringing + 0.02 * rng.standard_normal(t.size), Sensor(), frequencies)
    assert shown["outer line"] > 10.0 * max(shown["inner line"], shown["ball line"])


@pytest.mark.full
def test_faults_show_in_the_records(tmp_path):
    """One condition: the pits' records have impulses, and their own lines are the highest over what is around them."""
    pytest.importorskip("sklearn")
    records, runs = fault_data(tmp_path, individuals=3, duration=0.5, conditions=1)
    assert set(runs.outcomes) == {"done"}
    with open(tmp_path / "labels.csv", newline="") as file:
        assert [row["label"] for row in csv.DictReader(file)] == [r.label for r in records]
    from cosimo.orchestrator.systems.bearings.fault_check import check

    by_label = check(tmp_path, Sensor()).by_label
    assert by_label["outer"]["outer line"] > 5.0 * by_label["healthy"]["outer line"]
    assert by_label["inner"]["inner line"] > 5.0 * by_label["healthy"]["inner line"]
    assert by_label["ball"]["ball line"] > 2.0 * by_label["healthy"]["ball line"]
    sidebands = {label: row["cage sidebands"] for label, row in by_label.items()}
    assert all(sidebands["cage"] > 2.0 * sidebands[label] for label in sidebands if label != "cage")
    assert all(
        by_label[label]["kurtosis"] > 1.5 * by_label["healthy"]["kurtosis"]
        for label in by_label
        if label not in ("healthy", "cage")
    )
