"""Curves of one's own: a turbine's coefficients and a pump's data sheet from tables, against the formulas that they were made of."""

import math
import warnings

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.integrators import RK4_STABILITY_RADIUS
from cosimo.components.wind_pump.centrifugal_pump import CentrifugalPump
from cosimo.components.wind_pump.turbine import WindTurbine, wind_torque
from cosimo.tests.support import initialized
from scipy.interpolate import PchipInterpolator

pytestmark = pytest.mark.interpreted

RATIOS, POWERS = (0.4, 0.8, 1.2, 1.6, 2.0, 2.4), (0.03, 0.12, 0.26, 0.29, 0.21, 0.0)
AFFINE = "pitch [deg],tip_speed_ratio,torque_coefficient\n" + "".join(
    f"{p},{r},{(0.3 - 0.01 * p) * (1.0 - r / 3.0):.17g}\n" for p in (0, 10) for r in (0, 1, 2, 3)
)


def turbine(table: str, effects=(), wind=5.0, **parameters) -> WindTurbine:
    return initialized(
        WindTurbine(["performance_table", *effects], {"performance_table.table": table, **parameters}), {"wind": wind}
    )


def powers(ratios=RATIOS, values=POWERS) -> str:
    return "tip_speed_ratio;power_coefficient\n" + "".join(f"{r:g};{v:g}\n" for r, v in zip(ratios, values, strict=True))


@pytest.mark.known_answers(WindTurbine="performance_table")
def test_a_table_of_a_straight_line_is_the_farm_windmill():
    line = "tip_speed_ratio,torque_coefficient\n0,0.5\n0.7,0.35416666666666669\n2.4,0\n"
    own, farm = turbine(line), WindTurbine()
    farm.set("wind", 5.0)
    farm.initialize(0.0)
    for k in range(200):
        own.step(0.05 * k, 0.05)
        farm.step(0.05 * k, 0.05)
        assert own["speed"] == pytest.approx(farm["speed"], rel=1e-13)
    assert own["speed"] * 1.5 / 5.0 > 2.0


def test_between_its_rows_the_torque_coefficient_is_the_cubic_of_scipy():
    cubic = PchipInterpolator(RATIOS, np.array(POWERS) / RATIOS)
    for ratio in np.linspace(0.4, 2.4, 41):
        unit = turbine(powers(), start_speed=ratio * 5.0 / 1.5)
        assert unit["power_coefficient"] == pytest.approx(ratio * cubic(ratio), abs=1e-15)
    at_rest = turbine("tip_speed_ratio;power_coefficient\n0;0\n0,4;0,03\n2,4;0\n")  # says nothing of the torque at rest
    assert at_rest["aerodynamic_torque"] == pytest.approx(0.5 * 1.225 * math.pi * 1.5**3 * 25.0 * 0.075, rel=1e-14)


def test_between_two_pitches_it_is_straight_and_outside_it_stays():
    feathered = turbine(AFFINE, start_speed=4.0)  # without the effect
    assert feathered["power_coefficient"] == pytest.approx(1.2 * 0.3 * (1.0 - 1.2 / 3.0), rel=1e-13)
    for degrees, coefficient in ((0.0, 0.3), (5.0, 0.25), (10.0, 0.2), (-3.0, 0.3), (40.0, 0.2)):
        unit = turbine(AFFINE, ["pitch"], start_speed=4.0)
        unit.set("pitch.angle", math.radians(degrees))
        unit.refresh()
        expected = 0.5 * 1.225 * math.pi * 1.5**3 * 25.0 * coefficient * (1.0 - 1.2 / 3.0)
        assert unit["aerodynamic_torque"] == pytest.approx(expected, rel=1e-13)


STEEP = "pitch [deg],tip_speed_ratio,torque_coefficient\n" + "".join(
    f"{p},{r},{c}\n"
    for p, curve in ((0, (0.3, 0.15, 0.0)), (20, (0.3, -0.3, -0.9)))
    for r, c in zip((0, 1, 2), curve, strict=True)
)


def test_the_stable_step_is_that_of_the_steepest_pitch():
    """The radius of RK4 over the slope of the torque over the speed, in 60 m/s: 0.15 at pitch 0, 0.6 at 20 degrees."""
    most = 0.5 * 1.225 * math.pi * 1.5**4 * 60.0
    without, with_pitch = turbine(STEEP), turbine(STEEP, ["pitch"])
    assert without.stable_step() == pytest.approx(RK4_STABILITY_RADIUS * 15.0 / (most * 0.15), rel=1e-3)
    assert with_pitch.stable_step() == pytest.approx(RK4_STABILITY_RADIUS * 15.0 / (most * 0.6), rel=1e-3)


@pytest.mark.parametrize("curve", ["heier", "simple", "variant"])
def test_a_rotor_at_its_stable_step_is_stable_at_every_pitch(curve):
    """The fits are steeper when pitched, by 3 to 7 at 45 degrees: a disturbance of its speed must die out at each."""
    unit = WindTurbine(["pitch"], {"curve": curve, "radius": 20.0, "inertia": 5e6})
    unit.set("wind", 60.0)
    unit.initialize(0.0)
    limit = unit.stable_step()
    _, p, e = unit.arguments
    steepest = 0.0
    for degrees in np.arange(0.0, 90.0, 0.25):
        speeds = np.linspace(0.0, 20.0 * 60.0 / 20.0, 801)
        unit.set("pitch.angle", math.radians(degrees))
        torques = [wind_torque(w, unit.u[0], unit.arguments[0], p, e) for w in speeds[::20]]
        steepest = max(steepest, np.abs(np.diff(torques)).max() / (speeds[20] - speeds[0]))
    assert limit * steepest / 5e6 < RK4_STABILITY_RADIUS
    assert limit * steepest / 5e6 > 0.5


@pytest.mark.parametrize(
    ("table", "effects", "expected"),
    [
        ("a,b\n1,2\n2,3\n", (), "one column 'power_coefficient' or 'torque_coefficient'"),
        (powers((1, 2), (0.3, 0.2)), (), "ends at runaway"),
        (powers((1, 2), (0.7, 0.0)), (), "Betz"),
        (powers((1, 1), (0.3, 0.0)), (), "line 3: got tip_speed_ratio 1 behind 1"),
        (powers((-1, 1), (0.3, 0.0)), (), "ratios of 0 or more"),
        (powers((0, 1, 2), (0.1, 0.3, 0.0)), (), "at standstill"),
        ("tip_speed_ratio,power_coefficient\n1,0.3\n2,\n", (), "1 whole rows of 2"),
        (AFFINE.replace("0,", "5,", 1).replace("\n0,", "\n5,"), (), "Switch the effect 'pitch' on"),
        (powers(), ("pitch",), "Add a column 'pitch"),
        (AFFINE.replace("10,3,", "10,4,"), ("pitch",), "a row for each pair of them"),
        (AFFINE.replace("pitch [deg]", "pitch"), ("pitch",), "a name with its unit"),
    ],
)
def test_a_table_of_a_turbine_that_cannot_be_used_is_one_message(table, effects, expected):
    with pytest.raises(BadInput, match=expected):
        turbine(table, effects)


def test_a_pitch_beyond_those_of_the_table_is_told_once():
    unit = turbine(AFFINE, ("pitch",))
    unit.set("pitch.angle", np.deg2rad(10.0))  # the last one
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        unit.step(0.0, 0.01)
    unit.set("pitch.angle", 0.5)
    with pytest.warns(UserWarning, match=r"at t = 0.02 s the pitch of 28.65 deg lies beyond those of performance_table.table"):
        unit.step(0.01, 0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        unit.step(0.02, 0.01)


# -- the pump ------------------------------------------------------------------------------------------------------------
def sheet(last=2.0, efficiency=True) -> str:
    """The default pump's parabolas as rows, 0.05 l/s apart."""
    rows = []
    for litres in np.arange(0.0, last + 0.01, 0.05):
        q = 1e-3 * litres
        head, share = 30.0 - 2e3 * q - 5.3e6 * q * q, q / 1.2e-3
        power = 1000.0 * 9.81 * head * 1.2e-3 / (0.55 * (2.0 - share))
        rows.append(f"{litres:.2f};{head:.12g};{100.0 * 0.55 * (2.0 * share - share**2) if efficiency else power:.12g}\n")
    return f"flow [l/s];head [m];{'efficiency [%]' if efficiency else 'power [W]'}\n" + "".join(rows)


def pump(table: str, speed: float, head: float) -> CentrifugalPump:
    return initialized(CentrifugalPump(["curve_table"], {"curve_table.table": table}), {"speed": speed, "head": head})


@pytest.mark.known_answers(CentrifugalPump="curve_table")
@pytest.mark.parametrize("efficiency", [True, False])
def test_a_data_sheet_of_the_parabolas_is_the_pump_of_the_parabolas(efficiency):
    """At other speeds, too, by affinity; the cubics miss the parabolas by less than 1e-4 of rows that are 4 % apart."""
    for speed, head in ((150.0, 20.0), (150.0, 8.5), (120.0, 15.0), (200.0, 30.0), (150.0, 45.0), (0.0, 10.0)):
        own, formula = pump(sheet(efficiency=efficiency), speed, head), CentrifugalPump()
        formula.set("speed", speed)
        formula.set("head", head)
        formula.initialize(0.0)
        for name in ("flow", "torque", "hydraulic_power"):
            assert own[name] == pytest.approx(formula[name], rel=1e-3 if efficiency and own["flow"] == 0.0 else 1e-4)
        assert own["curve_table.beyond"] == 0.0


def test_behind_the_last_row_it_goes_on_straight_and_warns_once():
    unit = pump(sheet(last=1.0), 150.0, 15.0)
    slope = 1.0 / (2e3 + 2.0 * 5.3e6 * 1e-3)  # of the curve at 1 l/s, s/m2, inverted
    assert unit["flow"] == pytest.approx(1e-3 + slope * (22.7 - 15.0), rel=2e-3)
    assert unit["curve_table.beyond"] == 1.0
    with pytest.warns(UserWarning, match=r"at t = 0\.1 s, with 150 rad/s against 15 m, the flow lies behind the last row"):
        unit.step(0.0, 0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        unit.step(0.1, 0.1)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("flow [l/s],head [m]\n0,30\n1,20\n", "one of power and efficiency"),
        ("flow [l/s],head [m],power [W]\n0,30,100\n1,31,200\n", "line 3: got head 31 behind 30, expected a head that falls"),
        ("flow [l/s],head [m],power [W]\n0.1,30,100\n1,20,200\n", "a flow of 0 first"),
        ("flow [l/s],head [m],efficiency [%]\n0,30,0\n1,20,50\n", "three rows or more"),
        ("flow [l/s],head [m],efficiency\n0,30,0\n1,20,50\n2,9,40\n", "at most 1"),
        ("flow,head [m],power [W]\n0,30,100\n1,20,200\n", "a name with its unit"),
        ("flow [l/s],head [m],power [W]\n0,30,0.18\n0.6,27,0.315\n", "an efficiency of 504.*W or kW"),
        ("flow [l/s],head [m],power [W]\n0,30,100\n1,20,0\n", "an efficiency of inf"),
    ],
)
def test_a_data_sheet_that_cannot_be_used_is_one_message(table, expected):
    with pytest.raises(BadInput, match=expected):
        pump(table, 150.0, 10.0)
