"""Operating points against closed forms: linear sets, the inverted pendulum, the centrifugal governor, the wind pump."""

import math

import numpy as np
import pytest
from cosimo import BadInput, Scene, read_scene
from cosimo.orchestrator.harness.analysis.operating_point import SceneRates, linearised, operating_line, operating_point
from cosimo.orchestrator.settings import UnitSettings

K1 = 2.0 / math.pi * 0.05 * 20.0 * 2.0 * 0.05  # of the default inertial converter, kg m²
K2 = 2.0 / math.pi * 0.05**2 * 20.25
LOAD = 13.2435  # N.m
START = (2.5, 2.0)  # rad/s of turbine and driven shaft


def wind_pump(wind: float):
    """Rates of turbine and driven shaft: farm windmill, averaged converter, a load that does not pulsate."""

    def rates(x: np.ndarray) -> np.ndarray:
        turbine, pump = x
        crank = 6.0 * turbine
        drive = 0.5 * 1.225 * math.pi * 1.5**3 * wind**2 * 0.5 * (1.0 - turbine * 1.5 / wind / 2.4)
        passed = K1 * crank**2 - K2 * crank * pump
        return np.array([(drive - 6.0 * passed * pump / crank) / 15.0, passed - LOAD])

    return rates


def wind_pump_scene(wind: float, **converter: float) -> Scene:
    """The same as units."""
    return read_scene({
        "stop_time": 1.0,
        "connections": ["turbine.speed -> converter.turbine_speed", "converter.turbine_torque -> turbine.torque"],
        "units": {
            "turbine": {"component": "WindTurbine", "parameters": {"curve": "farm", "wind": wind, "start_speed": START[0]}},
            "converter": {"component": "AveragedConverter",
                          "parameters": {"load_torque": LOAD, "start_speed": START[1], **converter}},
        },
        "master": {"step": 1e-2},
    })  # fmt: skip


def test_a_linear_set_has_the_eigenvalues_of_its_matrix():
    rng = np.random.default_rng(2)
    matrix, shift = rng.normal(size=(5, 5)), rng.normal(size=5)
    point = operating_point(lambda x: matrix @ (x - shift), np.zeros(5))
    np.testing.assert_allclose(point.state, shift, rtol=1e-9)
    np.testing.assert_allclose(point.matrix, matrix, atol=1e-9)
    expected = np.linalg.eigvals(matrix)
    np.testing.assert_allclose(np.sort_complex(point.eigenvalues), np.sort_complex(expected), atol=1e-8)
    assert point.eigenvalues.real.tolist() == sorted(point.eigenvalues.real, reverse=True)
    assert point.stable == (expected.real.max() < 0.0)
    assert point.time_constant == pytest.approx(1.0 / abs(expected.real.max()))


@pytest.mark.parametrize(("start", "state", "stable"), [(0.3, 0.0, True), (3.0, math.pi, False)])
def test_a_pendulum_hangs_stably_and_stands_unstably(start, state, stable):
    """Damped: -d/2 ± sqrt(d²/4 ∓ g/l)."""
    point = operating_point(lambda x: np.array([x[1], -9.81 * math.sin(x[0]) - 0.2 * x[1]]), (start, 0.1))
    assert point.state == pytest.approx([state, 0.0], abs=1e-9)
    assert point.stable == stable
    root = np.sqrt(complex(0.01 - 9.81 if stable else 0.01 + 9.81))
    np.testing.assert_allclose(point.eigenvalues, [-0.1 + root, -0.1 - root], atol=1e-8)


def test_the_governor_loses_its_lower_position_at_the_critical_speed():
    """theta'' = sin theta (W² cos theta - g/l) - d theta': 0 is stable up to W² = g/l, acos(g / (l W²)) beyond."""

    def governor(speed):
        return lambda x: np.array([x[1], math.sin(x[0]) * (speed**2 * math.cos(x[0]) - 9.81) - 0.5 * x[1]])

    speeds = np.linspace(2.0, 5.0, 13)
    critical = math.sqrt(9.81)
    low = operating_line(governor, speeds, (0.0, 0.0))
    assert low.exists.all()
    assert low.stable.tolist() == (speeds < critical).tolist()
    above = speeds[speeds > critical]
    high = operating_line(governor, above, (1.0, 0.0))
    assert high.stable.all()
    np.testing.assert_allclose(high.states[:, 0], np.arccos(9.81 / above**2), rtol=1e-9)


def test_the_wind_pump_of_the_printed_example():
    """Farm windmill of 1.5 m with a gear of 6 on the default converter: printed speeds and ratios over the wind."""
    line = operating_line(wind_pump, (2.0, 2.5, 3.0, 6.0), START)
    np.testing.assert_allclose(line.states[:, 0], [2.428, 2.466, 2.518, 3.349], atol=5e-4)
    np.testing.assert_allclose(line.states[:, 0] / line.states[:, 1], [4.228, 1.701, 0.953, 0.174], atol=5e-4)
    assert line.stable.all()


@pytest.mark.full
@pytest.mark.parametrize("wind", [2.0, 3.0, 6.0])
def test_units_of_a_scene_give_the_rates_of_the_equations(wind):
    rates = SceneRates(wind_pump_scene(wind), {"turbine": [0], "converter": [0]})
    assert rates.start.tolist() == list(START)
    state = np.array([2.7, 3.1])
    np.testing.assert_allclose(rates(state), wind_pump(wind)(state), rtol=1e-6)  # step² times the square of the fastest rate
    point, expected = operating_point(rates, rates.start), operating_point(wind_pump(wind), START)
    np.testing.assert_allclose(point.state, expected.state, rtol=1e-10)
    np.testing.assert_allclose(point.eigenvalues, expected.eigenvalues, rtol=1e-5)
    outputs = rates.outputs(point.state)
    assert outputs["converter.driving_torque"] == pytest.approx(LOAD, rel=1e-10)
    assert outputs["turbine.power"] == pytest.approx(LOAD * point.state[1], rel=1e-10)


@pytest.mark.interpreted
def test_states_that_a_component_refuses_have_no_rates():
    """Beyond the largest turbine speed of the averaged converter; the rates elsewhere are the same afterwards."""
    rates = SceneRates(wind_pump_scene(3.0), {"turbine": [0], "converter": [0]})
    before = rates(np.array(START))
    assert np.isnan(rates(np.array([60.0, 2.0]))).all()
    assert rates(np.array(START)).tolist() == before.tolist()
    with pytest.raises(BadInput, match="vanish"):
        operating_point(rates, (60.0, 2.0))


def test_the_matrix_of_the_wind_pump_in_closed_form():
    """d(T - T1)/dw and so on, by hand."""
    point = operating_point(wind_pump(3.0), START)
    turbine, pump = point.state
    slope = -0.5 * 1.225 * math.pi * 1.5**4 * 3.0 * 0.5 / 2.4
    expected = np.array(
        [
            [(slope - 36.0 * K1 * pump) / 15.0, -6.0 * (6.0 * K1 * turbine - 2.0 * K2 * pump) / 15.0],
            [72.0 * K1 * turbine - 6.0 * K2 * pump, -6.0 * K2 * turbine],
        ]
    )
    np.testing.assert_allclose(point.matrix, expected, rtol=1e-7)
    np.testing.assert_allclose(linearised(wind_pump(3.0), point.state), expected, rtol=1e-7)


def test_where_there_is_no_equilibrium_there_is_a_gap():
    """x' = r - x²: none for negative r. The line goes on behind it."""
    with pytest.raises(BadInput, match="there may be none"):
        operating_point(lambda x: -1.0 - x**2, (2.0,))
    line = operating_line(lambda r: lambda x: r - x**2, (4.0, 1.0, -1.0, 9.0), (1.5,))
    assert line.exists.tolist() == line.stable.tolist() == [True, True, False, True]
    np.testing.assert_allclose(line.states[line.exists, 0], [2.0, 1.0, 3.0], rtol=1e-9)
    np.testing.assert_allclose(line.eigenvalues[line.exists, 0], [-4.0, -2.0, -6.0], rtol=1e-9)


def test_what_cannot_be_set_is_refused():
    scene = wind_pump_scene(3.0)
    with pytest.raises(BadInput, match="units of the scene"):
        SceneRates(scene, {"pump": [0]})
    with pytest.raises(BadInput, match="state of 2 numbers"):
        SceneRates(scene, {"turbine": [2]})
    units = {**scene.units, "turbine": UnitSettings.model_construct(fmu="turbine.fmu")}
    with pytest.raises(BadInput, match="a component"):
        SceneRates(scene.model_copy(update={"units": units}), {"turbine": [0]})
