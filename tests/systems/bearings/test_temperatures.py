"""Temperatures of the network against matrix exponentials, steady states and balances; thermal expansion."""

import numpy as np
import pytest
from cosimo import StepFailed, read_scene
from cosimo.components.bearings.conductance import AngularContactConductance
from cosimo.components.bearings.radiation import STEFAN_BOLTZMANN, radiative_coefficient
from cosimo.components.bearings.temperatures import BearingTemperatures, network_derivatives, network_jacobian
from cosimo.orchestrator.run.run import run as run_scene
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from scipy.integrate import solve_ivp
from scipy.linalg import expm

pytestmark = pytest.mark.interpreted

ALL = ("housing", "oil_flow", "radiation", "shaft_heat")


def started(effects=(), parameters=None, **inputs):
    """An initialized instance."""
    return initialized(BearingTemperatures(effects, {**(parameters or {}), **inputs}))


def run(made, step, steps, t=0.0):
    """Advance by equal steps."""
    for k in range(steps):
        made.step(t + k * step, step)
    return made


def network(p, conductance):
    """(A, b per watt, b per kelvin of ambient): T' = A T + ..., written again with matrices instead of balances, (3, 3), (3,)."""
    incidence = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])
    outside = np.array([p["shaft_conductance"], 0.0, p["ambient_conductance"]])
    laplacian = incidence.T @ incidence * 2.0 * conductance + np.diag(outside)
    c = np.array([p["inner_capacity"], p["ball_capacity"], p["outer_capacity"]])
    share = np.array([p["inner_share"], 1.0 - p["inner_share"] - p["outer_share"], p["outer_share"]])
    return -laplacian / c[:, None], share / c, outside / c


@pytest.mark.parametrize("step", [10.0, 250.0])
def test_constant_inputs_against_the_matrix_exponential(step):
    made = started((), {"substep": 2.0}, friction_power=25.0, ambient=280.0, conductance=0.3)
    run(made, step, int(1000.0 / step))
    A, heated, cooled = network(made.parameters, 0.3)
    rest = np.linalg.solve(-A, 25.0 * heated + 280.0 * cooled)
    exact = rest + expm(1000.0 * A) @ (np.full(3, 293.15) - rest)
    # third order, substep over the shortest time constant 2/10: (0.2)^3/24 of the balls' first rise, mostly forgotten at the end
    np.testing.assert_allclose(made.x[:3], exact, rtol=0.0, atol=2e-5)


def test_order_three_in_the_substep():
    A, heated, cooled = network(started().parameters, 0.2)
    rest = np.linalg.solve(-A, 20.0 * heated + 293.15 * cooled)
    exact = rest + expm(64.0 * A) @ (np.full(3, 293.15) - rest)
    substeps = np.array([8.0, 4.0, 2.0, 1.0])
    errors = [np.abs(run(started((), {"substep": s}, friction_power=20.0), 64.0, 1).x[:3] - exact).max() for s in substeps]
    assert slope(substeps, errors) == pytest.approx(3.0, abs=0.15)


def test_everything_on_and_moving_inputs_against_scipy():
    made = started(ALL, {"substep": 5.0, "housing.heat_capacity": 300.0}, friction_power=20.0)
    names = ("conductance", "friction_power", "oil_flow.inlet_temperature", "shaft_heat.power")
    column = dict(zip(names, made.input_positions(names), strict=True))
    slopes = {"conductance": 5e-4, "friction_power": 0.05, "oil_flow.inlet_temperature": -0.01, "shaft_heat.power": 0.02}
    for name, rate in slopes.items():
        made.u[1, column[name]] = rate
    u0, rate, x0 = made.u[0].copy(), made.u[1].copy(), made.x.copy()

    def right(t, x):
        dx = np.zeros_like(x)
        network_derivatives(t, x, u0 + t * rate, dx, *made.arguments)
        return dx

    exact = solve_ivp(right, (0.0, 600.0), x0, method="Radau", rtol=1e-10, atol=1e-8).y[:, -1]
    made.step(0.0, 600.0)
    np.testing.assert_allclose(made.x[:4], exact[:4], rtol=0.0, atol=2e-3)  # K: substep 5 s, shortest time constant 10 s


@pytest.mark.known_answers(BearingTemperatures=("housing", "oil_flow"))
def test_steady_state_is_that_of_the_resistances():
    """All friction in the inner ring, no way out but the outer ring: three resistances in series."""
    made = started(
        (),
        {"shaft_conductance": 0.0, "inner_share": 1.0, "outer_share": 0.0, "substep": 500.0},
        friction_power=10.0,
        conductance=0.25,
    )
    run(made, 1e5, 10)
    assert made["outer_temperature"] - 293.15 == pytest.approx(10.0 / 1.0, rel=1e-9)  # 1e6 s are 1000 time constants
    assert made["inner_temperature"] - made["outer_temperature"] == pytest.approx(10.0 / 0.25, rel=1e-9)
    assert made["ball_temperature"] == pytest.approx(0.5 * (made["inner_temperature"] + made["outer_temperature"]), rel=1e-12)


@pytest.mark.known_answers(BearingTemperatures="shaft_heat")
@pytest.mark.first(2)
@pytest.mark.parametrize("effects", [(), ALL], ids=["none", "all"])
@pytest.mark.parametrize("substep", [1000.0, 50.0, 0.5])
def test_heat_supplied_is_stored_or_released(effects, substep):
    """A linear invariant of the method: to rounding, however rough the step; f_t by a difference leaves 1e-11 a step."""
    made = started(effects, {"substep": substep}, friction_power=30.0)
    for k in range(5):
        made.u[1] = 1e-3 * np.array([made.variables[n].nominal for n in made.inputs])
        made.step(k * 1000.0, 1000.0)
    assert made["heat_supplied"] > 1e5
    balance = made["heat_supplied"] - made["heat_stored"] - made["heat_released"]
    assert abs(balance) < 1e-9 * made["heat_supplied"]


def test_supplied_is_the_integral_of_the_power():
    made = started(("shaft_heat",), {}, friction_power=12.0)
    made.set("shaft_heat.power", 5.0)
    made.u[1, made.input_positions(["friction_power"])] = 0.5
    made.step(0.0, 40.0)
    assert made["heat_supplied"] == pytest.approx(17.0 * 40.0 + 0.25 * 40.0**2, rel=1e-12)  # roundings


def test_the_jacobian_is_the_derivative():
    rng = np.random.default_rng(5)
    made = started(ALL, {}, friction_power=10.0)
    n = made.x.size
    for _ in range(5):
        x = np.concatenate([rng.uniform(270.0, 400.0, n - 2), rng.normal(size=2)])

        def right(x):
            dx = np.zeros(n)
            network_derivatives(0.0, x, made.u[0], dx, *made.arguments)
            return dx

        band = np.zeros((n, 2 * n - 1))
        network_jacobian(0.0, x, made.u[0], band, *made.arguments)
        dense = np.array([[band[i, n - 1 + j - i] for j in range(n)] for i in range(n)])
        differences = np.array([(right(x + e) - right(x - e)) / 2e-3 for e in 1e-3 * np.eye(n)]).T
        np.testing.assert_allclose(dense, differences, rtol=0.0, atol=1e-8)  # rounding of W over 1e-3 K, T⁴'s third derivative


@pytest.mark.known_answers(BearingTemperatures="radiation")
def test_radiation_alone_cools_by_the_fourth_power():
    """A single mass (huge conductance inside) in an ambient of 0 K: T^-3 grows linearly in time."""
    parameters = {"shaft_conductance": 0.0, "ambient_conductance": 0.0, "start_temperature": 600.0, "substep": 5.0}
    made = started(("radiation",), parameters, conductance=1e6, ambient=0.0)
    made.step(0.0, 1000.0)
    p = made.parameters
    c = p["inner_capacity"] + p["ball_capacity"] + p["outer_capacity"]
    rate = 3.0 * p["radiation.emissivity"] * p["radiation.area"] * STEFAN_BOLTZMANN / c
    assert made["outer_temperature"] == pytest.approx((600.0**-3 + rate * 1000.0) ** (-1.0 / 3.0), abs=1e-3)  # not quite rigid


@pytest.mark.parametrize("power", [1e3, 1e4, 1e5])
def test_radiation_in_substeps_of_any_length_is_right_or_fails(power):
    """All heat leaves by radiation; a substep of 1000 s once went to 1e20 K silently."""
    parameters = {"shaft_conductance": 0.0, "ambient_conductance": 0.0}
    rest = (293.15**4 + power / (0.8 * 0.05 * STEFAN_BOLTZMANN)) ** 0.25
    fine = run(started(("radiation",), {**parameters, "substep": 10.0}, friction_power=power), 1000.0, 20)
    assert fine["outer_temperature"] == pytest.approx(rest, rel=1e-3)  # 20000 s, against 565 J/K / (4 eps A sigma T³) <= 150 s
    with pytest.raises(StepFailed, match="substep"):
        run(started(("radiation",), {**parameters, "substep": 1000.0}, friction_power=power), 1000.0, 20)


def test_a_linear_network_may_be_as_hot_as_it_likes():
    """Radiation of no area limits nothing: balls without a way out keep what is theirs, 5e4 W of 1e5 W over 15 J/K."""
    made = run(started(("radiation",), {"radiation.area": 0.0, "substep": 1000.0}, friction_power=1e5, conductance=0.0), 1e3, 5)
    assert made["ball_temperature"] - 293.15 == pytest.approx(5e4 * 5e3 / 15.0, rel=1e-9)


def test_radiation_at_absolute_zero_and_under_hot_surroundings_does_not_fail():
    for start, ambient, inlet in ((0.0, 0.0, 0.0), (300.0, 1500.0, 300.0), (1500.0, 300.0, 300.0), (300.0, 300.0, 1500.0)):
        inputs = {"ambient": ambient, "oil_flow.inlet_temperature": inlet}
        made = run(started(ALL, {"start_temperature": start, "substep": 20.0}, friction_power=0.0, **inputs), 20.0, 200)
        low, high = min(start, ambient, inlet), max(start, ambient, inlet)
        assert low - 1e-6 <= made["housing_temperature"] <= high + 1e-6  # what flows only levels: rounding


def test_radiative_coefficient():
    assert radiative_coefficient(400.0, 300.0) * 100.0 == pytest.approx(STEFAN_BOLTZMANN * (400.0**4 - 300.0**4), rel=1e-14)
    assert radiative_coefficient(300.0, 300.0) == pytest.approx(4.0 * STEFAN_BOLTZMANN * 300.0**3, rel=1e-14)
    assert radiative_coefficient(-50.0, 0.0) == 0.0


# -- clearance ---------------------------------------------------------------------------------------------------------
def test_all_parts_equally_warm_leave_the_clearance():
    made = started((), {"start_temperature": 353.15})
    assert abs(made["clearance_change"]) < 1e-18  # m: rounding of 60 mm * 1.2e-5 * 60, thrice


def test_clearance_from_the_diameters_of_the_parts():
    """Race diameters and balls each grown on their own: the change of D_o - D_i - 2 d."""
    made = started((), {"inner_share": 0.6, "outer_share": 0.1}, friction_power=40.0)
    made.step(0.0, 900.0)
    p, alpha = made.parameters, made["expansion"]
    d, dm = p["ball_diameter"], p["pitch_diameter"]
    warm = [alpha * (made[f"{part}_temperature"] - 293.15) for part in ("inner", "ball", "outer")]
    inner, ball, outer = (dm - d) * (1 + warm[0]), d * (1 + warm[1]), (dm + d) * (1 + warm[2])
    assert made["clearance_change"] == pytest.approx(outer - inner - 2.0 * ball, abs=1e-16)  # cancellation of 60 mm
    assert made["clearance_change"] < -1e-6  # a warm shaft in a cool housing takes clearance away


def test_a_warm_outer_ring_opens_the_bearing():
    made = started((), {"inner_share": 0.0, "outer_share": 1.0}, friction_power=40.0, conductance=0.0)
    made.step(0.0, 900.0)
    assert made["clearance_change"] > 1e-6


@pytest.mark.full
def test_balls_unload_one_after_the_other():
    made = AngularContactConductance((), {"axial_force": 500.0}, preset="7210B")
    made.initialize(0.0)
    counts, values = [], []
    for radial in np.linspace(0.0, 5e3, 60):
        made.set("radial_force", radial)
        made.refresh()
        counts.append(made["loaded_balls"])
        values.append(made["conductance"])
    assert counts[0] == 16
    assert counts[-1] <= 3
    assert (np.diff(counts) <= 0).all()
    # no jump where a ball lifts off: the largest change between neighbours is that of the steepest stretch
    assert np.abs(np.diff(values)).max() < 0.2 * values[0]


def coupled(step, stop, algorithm="gauss-seidel"):
    """The conductance under a constant load, its radiation at the temperatures it brings about; 40 W of friction."""
    scene = read_scene({
        "stop_time": stop,
        "connections": [
            "path.conductance -> heat.conductance",
            "heat.inner_temperature -> path.radiation.inner_temperature",
            "heat.outer_temperature -> path.radiation.outer_temperature",
        ],
        "units": {
            "path": {"component": "AngularContactConductance", "effects": ["ball_bulk", "gas_path", "radiation"],
                     "parameters": {"axial_force": 300.0, "radiation.emissivity": 1.0}},
            "heat": {"component": "BearingTemperatures", "parameters": {"friction_power": 40.0, "substep": min(step, 20.0)}},
        },
        "master": {"algorithm": algorithm, "step": step},
    })  # fmt: skip
    result = run_scene(scene, in_process=True)
    assert result.outcome == "done", result.message
    return result


@pytest.mark.full
def test_conductance_and_temperatures_settle_whatever_the_step():
    """The steady state does not know the step, up to more than an hour."""
    ends = []
    for step in (20.0, 200.0, 4000.0):
        result = coupled(step, 40000.0)
        ends.append([result[f"heat.{part}_temperature"][-1] for part in ("inner", "ball", "outer")])
    np.testing.assert_allclose(ends[1:], np.array(ends[:1]).repeat(2, 0), rtol=0.0, atol=1e-2)  # K, of a rise of 40 K


@pytest.mark.full
def test_first_order_in_the_macro_step_without_extrapolation():
    """Held inputs: what couples is the weak radiation, so the error is small, and falls with the step."""
    fine = coupled(2.0, 800.0)["heat.inner_temperature"][-1]
    errors = [abs(coupled(step, 800.0, "jacobi")["heat.inner_temperature"][-1] - fine) for step in (100.0, 50.0)]
    assert errors[0] < 0.05  # K
    assert errors[1] < 0.7 * errors[0]
