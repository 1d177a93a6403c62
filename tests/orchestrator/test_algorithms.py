"""Order of accuracy and stability of the algorithms, against published errors and closed forms."""

import numpy as np
import pytest
from scipy.linalg import expm

from orchestrator.algorithms import ALGORITHMS
from orchestrator.algorithms.polynomial import History
from orchestrator.coupling import settle
from orchestrator.run import run
from orchestrator.scene import read_scene
from orchestrator.units import open_unit
from tests.support import exact_two_masses, two_masses

STATES = [("a", "x_out"), ("a", "v_out"), ("b", "x_out"), ("b", "v_out")]
STEPS = (1e-2, 5e-3, 2.5e-3, 1.25e-3)  # s

# Largest error of the four states at t = 1, for held, linear and quadratic inputs and the steps above, with the exact
# solution as history; LIM linear oscillator, case 1. Computed with a separate program that knows only the matrices.
ERRORS = {
    ("jacobi", "fresh"): (
        (15.45, 7.205, 3.482, 1.712), (1.648, 0.4017, 0.09887, 0.02451), (0.06237, 0.004462, 0.001336, 0.0002152)),
    ("jacobi", "stale"): (
        (80.89, 32.46, 14.52, 6.873), (3.189, 0.8080, 0.2054, 0.05188), (0.3643, 0.04125, 0.004910, 0.0005994)),
    ("gauss-seidel", "fresh"): (
        (20.87, 9.546, 4.566, 2.234), (1.140, 0.2834, 0.07069, 0.01765), (0.03317, 0.002646, 0.0007195, 0.000115)),
}


def final_error(algorithm: str, feedthrough: str, degree: int, step: float) -> float:
    """Largest error of the states at t = 1, started with the exact solution at t = 0, -step and -2 step as history."""
    scene = read_scene(two_masses(algorithm, step, degree, feedthrough))
    units = {name: open_unit(name, settings, in_process=True) for name, settings in scene.units.items()}
    master = ALGORITHMS[algorithm](units, settle(scene), STATES, degree=degree, feedthrough=feedthrough)
    master.initialize(0.0)
    for node in master.nodes:
        node.history.count = 0
        for k in range(degree, -1, -1):
            x1, v1, x2, v2 = exact_two_masses(-k * step)
            node.history.push([100.0 * (x2 - x1) + 0.01 * (v2 - v1)] if node.unit.name == "a" else [x1, v1], step)
    for k in range(round(1.0 / step)):
        master.step(k * step, step)
    reached = np.array([master.signals[master.positions[end]] for end in STATES])
    return float(np.abs(reached - exact_two_masses(1.0)).max())


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("scheme", ERRORS, ids=" ".join)
def test_errors_and_order_of_the_two_mass_oscillator(scheme, degree):
    errors = np.array([final_error(*scheme, degree, step) for step in STEPS])
    # the published numbers have four digits; 2 % would still tell any neighbouring scheme apart
    np.testing.assert_allclose(errors, ERRORS[scheme][degree], rtol=0.02)
    order = np.log2(errors[-2] / errors[-1])
    # the quadratic scheme reaches its asymptote late: its error changes sign between these steps
    assert abs(order - (degree + 1)) < (0.15 if degree < 2 else 0.7)


def test_order_from_a_start_without_history():
    """The start-up with lower degree costs nothing up to linear extrapolation."""
    for degree in (0, 1):
        errors = []
        for step in (2.5e-3, 1.25e-3, 6.25e-4):
            result = run(read_scene(two_masses("jacobi", step, degree)))
            reached = [result[f"{u}.{n}"][-1] for u, n in STATES]
            errors.append(np.abs(reached - exact_two_masses(1.0)).max())
        slope = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0]
        assert abs(slope - (degree + 1)) < 0.15, degree


# Limits of w0 H for a mass under the force of a spring-damper of damping ratio D, by degree of the input's polynomial:
# roots of the characteristic polynomials in the docstring of `Jacobi`, to six digits.
LIMITS = {
    ("fresh", 0.1): (0.4, 0.902731, 1.143517), ("fresh", 0.5): (2.0, 1.101021, 0.593485),
    ("fresh", 1.0): (1.0, 0.510875, 0.277997),
    ("stale", 0.1): (0.131753,), ("stale", 0.5): (0.481608,), ("stale", 1.0): (0.426159,),
}
CASES = [(*case, degree, limit) for case, limits in LIMITS.items() for degree, limit in enumerate(limits)]

# Limits of the two-mass oscillator in s, from the spectral radius of the step's matrix, by degree.
# Jacobi's linear limits are left out: there the radius exceeds 1 by only 5e-6 at a step 1 % above.
TWO_MASS_LIMITS = [
    ("jacobi", "fresh", 2, 37.07e-3), ("jacobi", "stale", 2, 35.31e-3),
    ("gauss-seidel", "fresh", 1, 18.06e-3), ("gauss-seidel", "fresh", 2, 35.65e-3),
]


def growth(scene: dict, signal: str, steps: int) -> float:
    """Ratio of the amplitudes in the last tenth and in the tenth around the middle."""
    result = run(read_scene({**scene, "stop_time": steps * scene["master"]["step"]}))
    x, tenth = np.abs(result[signal]), steps // 10
    return np.inf if result.outcome == "failed" else x[-tenth:].max() / x[(steps - tenth) // 2 :][:tenth].max()


def contact(feedthrough: str, damping_ratio: float, degree: int, step: float) -> dict:
    """A unit mass on a spring-damper with w0 = 1/s."""
    return {
        "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
        "units": {"m": {"component": "tests.support:Mass"},
                  "s": {"component": "tests.support:SpringDamper", "parameters": {"k": 1.0, "d": 2.0 * damping_ratio}}},
        "master": {"algorithm": "jacobi", "step": step, "extrapolation": degree, "feedthrough": feedthrough},
    }


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # a coupling that grows overflows, as it should
@pytest.mark.parametrize(("feedthrough", "ratio", "degree", "limit"), CASES)
def test_stability_limit_of_a_mass_on_a_spring_damper(feedthrough, ratio, degree, limit):
    assert growth(contact(feedthrough, ratio, degree, 0.99 * limit), "m.x_out", 4000) < 1.0
    assert growth(contact(feedthrough, ratio, degree, 1.01 * limit), "m.x_out", 4000) > 1.0


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(("algorithm", "feedthrough", "degree", "limit"), TWO_MASS_LIMITS)
def test_stability_limit_of_the_two_mass_oscillator(algorithm, feedthrough, degree, limit):
    assert growth(two_masses(algorithm, 0.99 * limit, degree, feedthrough), "b.x_out", 6000) < 1.0
    assert growth(two_masses(algorithm, 1.01 * limit, degree, feedthrough), "b.x_out", 6000) > 1.0


def test_undamped_contact_with_held_force_grows_at_any_step():
    """|lambda|² = 1 + (w0 H)²/2: the amplitude grows by sqrt(1 + (w0 H)²/2) in a step."""
    step = 0.02
    # 2700 of 6000 steps lie between the two tenths; the largest samples miss the peaks by up to 1 - cos(w0 H / 2), and the
    # last of a growing tenth by more
    assert growth(contact("fresh", 0.0, 0, step), "m.x_out", 6000) == pytest.approx((1.0 + step**2 / 2.0) ** (2700 / 2), rel=0.05)


def test_order_of_units_is_irrelevant_for_jacobi():
    scene = two_masses("jacobi", 5e-3, 1)
    swapped = {**scene, "units": dict(reversed(scene["units"].items())), "connections": scene["connections"][::-1]}
    one, other = run(read_scene(scene)), run(read_scene(swapped))
    for name in one.columns:
        assert one[name].tobytes() == other[name].tobytes()


def test_order_of_units_matters_for_gauss_seidel_and_can_be_given():
    scene = two_masses("gauss-seidel", 5e-3, 1)
    swapped = {**scene, "units": dict(reversed(scene["units"].items()))}
    ordered = {**scene, "master": {**scene["master"], "order": ["b", "a"]}}
    runs = [run(read_scene(s))["a.x_out"] for s in (scene, swapped, ordered)]
    assert (runs[0] != runs[1]).any()
    assert runs[1].tobytes() == runs[2].tobytes()


def test_inputs_from_earlier_and_later_units_keep_their_places():
    """An oscillator between two flying masses: position 2 t from the earlier, velocity 3 from the later; exact from the start."""
    mass = "tests.support:Mass"
    scene = {"stop_time": 1.0, "master": {"algorithm": "gauss-seidel", "step": 0.05, "extrapolation": 1},
             "connections": ["early.x_out -> b.position", "late.v_out -> b.velocity"],
             "units": {"early": {"component": mass, "parameters": {"v0": 2.0}},
                       "b": {"component": "tests.support:Oscillator", "parameters": {"cc": 4.0}},
                       "late": {"component": mass, "parameters": {"v0": 3.0}}}}
    # states x, v, 2 t, 1 of x'' = -1100 x - 4.01 v + 100 (2 t) + 4 * 3
    A = np.array([[0, 1, 0, 0], [-1100.0, -4.01, 100.0, 12.0], [0, 0, 0, 2.0], [0, 0, 0, 0]])
    exact = expm(A) @ np.array([0.0, -100.0, 0.0, 1.0])
    result = run(read_scene(scene))
    reached = [result["b.x_out"][-1], result["b.v_out"][-1]]
    np.testing.assert_allclose(reached, exact[:2], rtol=1e-10)  # rounding of 20 steps with amplitudes a thousand times larger


def test_feedthrough_follows_through_a_chain_of_units():
    """m -> p1 -> p2 -> p3, each three times its input: at each instant the last belongs to the position now."""
    gain = {"component": "tests.support:Probe"}
    chain = {"stop_time": 1.0, "master": {"algorithm": "jacobi", "step": 0.1},
             "record": {"signals": ["m.x_out", "p3.profile[3]"]},
             "units": {"p3": gain, "p1": gain, "m": {"component": "tests.support:Mass"}, "p2": gain},
             "connections": ["m.x_out -> p1.length", "p1.profile[3] -> p2.length", "p2.profile[3] -> p3.length"]}
    result = run(read_scene(chain))
    # rounding: an input that its polynomial has led to the fresh value but for the last bits is left there
    np.testing.assert_allclose(result["p3.profile[3]"], 27_000.0 * result["m.x_out"], rtol=1e-14)
    assert result["m.x_out"][-1] == pytest.approx(1.0, rel=1e-12)  # free flight at 1 m/s; ten rounded steps


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_polynomials_are_exact_on_their_own_degree_with_uneven_steps(degree):
    p = np.polynomial.Polynomial([0.7, -1.3, 2.1][: degree + 1])
    history, t = History(degree), 0.0
    history.push([p(t)], 0.0)
    for h in (0.1, 0.03, 0.2):
        t += h
        history.push([p(t)], h)
    h = 0.07
    for value, slope, half in (history.ahead(), history.towards([p(t + h)], h)):
        reached = value[0] + h * ((slope or [0.0])[0] + h * (half or [0.0])[0])
        assert reached == pytest.approx(p(t + h), rel=1e-13)  # rounding of a few divided differences
