"""Measured files by one vocabulary, of cases, fits and estimates; files of 0.7 are read under their own."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.scene.measured import read_columns, read_curve
from cosimo.orchestrator.settings.answers import FitSettings, FittedCurve, SpectrumSettings
from cosimo.orchestrator.settings.estimate import MeasuredSettings
from cosimo.orchestrator.settings.messages import validated

TIME = np.arange(10.0)
NAMES = {"signal": "m.x", "file": "m.csv"}
UNITS = {"m.x": "m", "m.s": "m"}


@pytest.fixture
def folder(tmp_path):
    lines = [f"{1e3 * t:g},{2.0 * t:g},{t:g}" for t in TIME]
    (tmp_path / "m.csv").write_text("time [ms],m.x [mm],way\n" + "\n".join(lines) + "\n2e4,,11\n")
    return tmp_path


@pytest.mark.parametrize("plan", [FittedCurve, MeasuredSettings])
def test_plans_read_a_column_alike(plan, folder):
    """Named by the signal, in its header's units, by clock, lateness and calibration of the sensor; an empty cell is a gap."""
    settings = plan(**NAMES, noise="5 mm", shift=100.0, delay="500 ms", offset=3.0)
    found = read_columns(settings, folder, (settings.time, "s"), "m", "here")
    np.testing.assert_allclose(found.x, TIME + 99.5, rtol=1e-12)
    np.testing.assert_allclose(found.y, 2e-3 * TIME + 3.0, rtol=1e-12)
    assert found.empty == 1


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, 293.15),
        ({"offset": 0.5}, 293.65),
        ({"scale": 1.0, "offset": 273.15}, 293.15),
        ({"scale": 1.0}, 0),
        ({"offset": 273.15}, 0),
    ],
)
def test_a_temperature_is_converted_once(given, expected, tmp_path):
    """Of 20 degrees Celsius; 0: refused, for the header leads to 293.15 K, and half of one's own conversion somewhere else."""
    (tmp_path / "m.csv").write_text("time [s],m.x [degC]\n" + "".join(f"{t:g},20\n" for t in TIME))
    curve = FittedCurve(**NAMES, **given)
    if expected:
        assert read_curve(curve, tmp_path, {"m.x": "K"}).y == pytest.approx(expected)
    else:
        with pytest.raises(BadInput, match=r"expected scale = 1 and offset = 273\.15, which lead from degC to K, or neither"):
            read_curve(curve, tmp_path, {"m.x": "K"})


@pytest.mark.parametrize(("noise", "expected"), [("5 mm", 5e-3), (5e-3, 5e-3), (None, None)])
def test_a_fit_has_its_noise_in_the_unit_of_the_signal(noise, expected, folder):
    assert read_curve(FittedCurve(**NAMES, noise=noise), folder, UNITS).noise == expected


@pytest.mark.parametrize(("noise", "named"), [("5 N", "'5 N'"), (0.0, "a positive number"), ("loud", "a number in m")])
def test_noise_that_is_none_is_refused(noise, named, folder):
    with pytest.raises(BadInput, match=named):
        read_curve(FittedCurve(**NAMES, noise=noise), folder, UNITS)


def test_files_of_earlier_versions_are_read():
    old, new = {"abscissa": "t", "ordinate": "x", "deviation": 0.1}, {"time": "t", "column": "x", "noise": 0.1}
    assert FittedCurve(**NAMES, **old) == FittedCurve(**NAMES, **new)
    over = {"over": "m.s", "shift": 2.0}
    assert FittedCurve(**NAMES, **over, **old) == FittedCurve(**NAMES, **over, over_column="t", column="x", noise=0.1)
    old, new = {"frequency": "f", "ordinate": "S", "deviation": 0.1}, {"frequency": "f", "column": "S", "noise": 0.1}
    assert SpectrumSettings(**NAMES, **old) == SpectrumSettings(**NAMES, **new)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"ordinate": "x", "column": "x"}, r"curves\[1\].column: got also as 'ordinate', expected each key once"),
        ({"over": "m.s", "time": "t"}, r"time: got 't' with over = 'm.s', expected over_column"),
        ({"over": "m.s", "delay": 1.0}, "delay: got 1.0 with over"),
        ({"over_column": "way"}, "over_column: got 'way', expected over = "),
        ({"ordinatte": "x"}, "unknown key 'ordinatte'"),
    ],
)
def test_keys_that_contradict_one_another_are_one_message(change, named):
    plan = {"vary": {"m.k": {"low": 1.0, "high": 2.0}}, "curves": [NAMES | change]}
    with pytest.raises(BadInput, match=named):
        validated(FitSettings, plan, "fit")


def test_a_curve_over_a_position_has_a_column_of_it(folder):
    curve = FittedCurve(**NAMES, over="m.s", over_column="way", shift=-2.0)
    np.testing.assert_allclose(read_curve(curve, folder, UNITS).x, TIME - 2.0)
