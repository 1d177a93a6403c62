"""Sizes of a converter by the sizing command, beside the equations that the paper's case has of its own."""

import numpy as np
import pytest
from cosimo import BadInput, load_scene
from cosimo.orchestrator.systems.wind_pump.cases.paper_wind_pump.sizes import gain
from cosimo.orchestrator.systems.wind_pump.sizing import main, site_of, wins

SCENE = load_scene("wind-pump-record")


def test_water_and_the_gears_that_win_are_those_of_the_papers_case():
    """Its equations take the farm windmill's line and a pump of constant torque in closed form, and find equilibria by roots."""
    site = site_of(SCENE, 4.0)
    _, fixed = site.best_fixed()
    for gear, lever in ((2.8, 20.0), (9.0, 40.0)):
        assert site.by_converter(gear, lever) / fixed == pytest.approx(gain(gear, lever, 4.0), rel=1e-3)
    assert wins(site, 20.0, fixed) == pytest.approx((2.95, 8.49), rel=3e-3)  # as runs of the components say


def test_a_fixed_ratio_under_a_constant_torque_is_its_closed_form():
    """C_p / C_p max = 4 u (1 - u), u = (v0 / v)², in each wind, so that the flow follows."""
    site = site_of(SCENE, 4.0)
    torque, ratio = np.interp(1.0, *site.pump[:2]), 2.0
    v0 = np.sqrt(ratio * torque / (0.5 * 1.225 * np.pi * 1.5**3 * 0.5))
    u = np.minimum(v0 / site.winds, 1.0) ** 2
    power = 0.5 * 1.225 * np.pi * 1.5**2 * site.winds**3 * 0.3 * 4.0 * u * (1.0 - u)
    flow = power / torque * np.interp(1.0, site.pump[0], site.pump[2])
    assert site.by_fixed(ratio) == pytest.approx(float(site.weights @ flow), rel=3e-3)


def test_a_pump_with_a_curve_delivers_against_the_losses_of_its_pipe():
    changes = {"units.pump": {"component": "CentrifugalPump"}, "pipe.effects.friction": True, "connections": []}
    speeds, _, flows = site_of(SCENE.with_changes(changes), 4.0).pump
    k = int(np.searchsorted(speeds, 200.0))
    n, q = speeds[k] / 150.0, flows[k]
    assert n**2 * 30.0 - n * 2e3 * q - 5.3e6 * q**2 == pytest.approx(20.0 + 1e6 * q**2)


def test_winds_in_which_a_pump_leaves_its_table_are_told():
    """Its last row is 9.2 m at 150 rad/s, and so 20 m at 150 sqrt(20 / 9.2): 221.2 rad/s, between two places of the curve."""
    changes = {"units.pump": {"component": "CentrifugalPump", "effects": ["curve_table"]}, "connections": []}
    site, last = site_of(SCENE.with_changes(changes), 4.0), 150.0 * np.sqrt(20.0 / 9.2)
    assert 0.97 * last < site.last <= last
    notes = [site.beyond("x", shown) for shown in (0.97 * site.last + 0.0 * site.winds, last / 5.0 * site.winds)]  # at 5 m/s
    assert (notes[0], notes[1][0].split(" m/s")[0]) == ([], "x: in winds from 5")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pump.effects.averaged": False}, "a piston pump in its strokes"),
        ({"turbine.effects.pitch": True, "turbine.curve": "heier"}, "a rotor whose pitch changes"),
        ({"units.converter": {"component": "FixedTransmission"}}, "0 units AveragedConverter"),
    ],
)
def test_what_cannot_be_sized_is_refused(changes, message):
    with pytest.raises(BadInput, match=message):
        site_of(SCENE.with_changes(changes), 4.0)


@pytest.mark.parametrize(
    "arguments",
    [
        *(["--mean", mean] for mean in ("x", "0", "1e400", "0.2")),
        *(["--mean", "4", "--levers", levers] for levers in ("a", "10,nan", "10,inf", "1e-12")),
        ["--mean", "4", "--shape", "inf"],
    ],
)
def test_a_site_without_sense_is_one_message(arguments, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        main(["wind-pump-record", *arguments, "-o", str(tmp_path)])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("cosimo: ")
