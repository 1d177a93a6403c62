"""What the order of units means to each algorithm, that every input comes to its place, and exact input polynomials."""

import numpy as np
import pytest
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms.polynomials import end_of, extrapolation
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import open_master
from cosimo.tests.support import Integrals, OfTime, two_masses
from scipy.linalg import expm


class Traces(Integrals):
    """Integrates a place that moves on, and the same number as one that does not."""

    place = input_(0.0, "m", "a place that moves on", moving=True)
    number = input_(0.0, "m", "another input")
    traced = output("m.s", "integral of the place")
    summed = output("m.s", "integral of the number")


@pytest.mark.parametrize(("places", "held"), [("linear", 1), ("held", 10)])
def test_a_place_that_moves_on_is_held_only_where_the_scene_says_so(places, held):
    """x = 2 t over 1 s in 10 steps; `held`: steps in which the place is, which without a past the first one is."""
    result = run(
        read_scene(
            {
                "stop_time": 1.0,
                "connections": ["a.x_out -> b.place", "a.x_out -> b.number"],
                "master": {"algorithm": "jacobi", "step": 0.1, "extrapolation": 0, "moving_places": places},
                "units": {
                    "a": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}},
                    "b": {"component": "cosimo.tests.engine.algorithms.test_places:Traces"},
                },
            }
        )
    )
    missed = 2.0 * 0.1**2 / 2.0  # by a step with a held place
    assert result["b.summed"][-1] == pytest.approx(1.0 - 10 * missed, rel=1e-12)
    assert result["b.traced"][-1] == pytest.approx(1.0 - held * missed, rel=1e-12)


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
    mass = "cosimo.tests.support:Mass"
    scene = {
        "stop_time": 1.0,
        "master": {"algorithm": "gauss-seidel", "step": 0.05, "extrapolation": 1},
        "connections": ["early.x_out -> b.position", "late.v_out -> b.velocity"],
        "units": {
            "early": {"component": mass, "parameters": {"v0": 2.0}},
            "b": {"component": "cosimo.tests.support:Oscillator", "parameters": {"cc": 4.0}},
            "late": {"component": mass, "parameters": {"v0": 3.0}},
        },
    }
    # states x, v, 2 t, 1 of x'' = -1100 x - 4.01 v + 100 (2 t) + 4 * 3
    A = np.array([[0, 1, 0, 0], [-1100.0, -4.01, 100.0, 12.0], [0, 0, 0, 2.0], [0, 0, 0, 0]])
    exact = expm(A) @ np.array([0.0, -100.0, 0.0, 1.0])
    result = run(read_scene(scene))
    reached = [result["b.x_out"][-1], result["b.v_out"][-1]]
    np.testing.assert_allclose(reached, exact[:2], rtol=1e-10)  # rounding of 20 steps with amplitudes a thousand times larger


def test_feedthrough_follows_through_a_chain_of_units():
    """m -> p1 -> p2 -> p3, each three times its input: at each instant the last belongs to the position now."""
    gain = {"component": "cosimo.tests.support:Probe"}
    chain = {
        "stop_time": 1.0,
        "master": {"algorithm": "jacobi", "step": 0.1},
        "record": {"signals": ["m.x_out", "p3.profile[3]"]},
        "units": {"p3": gain, "p1": gain, "m": {"component": "cosimo.tests.support:Mass"}, "p2": gain},
        "connections": ["m.x_out -> p1.length", "p1.profile[3] -> p2.length", "p2.profile[3] -> p3.length"],
    }
    result = run(read_scene(chain))
    # rounding: an input that its polynomial has led to the fresh value but for the last bits is left there
    np.testing.assert_allclose(result["p3.profile[3]"], 27_000.0 * result["m.x_out"], rtol=1e-14)
    assert result["m.x_out"][-1] == pytest.approx(1.0, rel=1e-12)  # free flight at 1 m/s; ten rounded steps


class Polynomial(OfTime):
    """Gives c0 + c1 t + c2 t^2."""

    c = parameter(0.0, "m", "coefficients", size=3)
    y = output("m", "polynomial")

    def _outputs(self, t):
        c = [self.parameters[f"c[{k}]"] for k in (1, 2, 3)]
        self.y[0] = c[0] + t * (c[1] + t * c[2])


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])  # extrapolated; led to the new value
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_polynomials_are_exact_on_their_own_degree_with_uneven_steps(degree, algorithm):
    """What an input is given begins at the value of now, once there are enough samples, and ends at that of the new instant."""
    here, c = "cosimo.tests.engine.algorithms.test_places", [0.7, -1.3, 2.1][: degree + 1]
    p = np.polynomial.Polynomial(c)
    master = open_master(
        {
            "stop_time": 1.0,
            "connections": ["p.y -> i.number"],
            "units": {
                "p": {"component": f"{here}:Polynomial", "parameters": {"c": [*c, 0.0, 0.0][:3]}},
                "i": {"component": f"{here}:Traces"},
            },
            "master": {"algorithm": algorithm, "step": 0.1, "extrapolation": degree},
        },
        (),
    )
    node, t = master.node_of["i"], 0.0
    for k, h in enumerate((0.1, 0.03, 0.2, 0.07, 0.11)):
        master.step(t, h)
        value, slope, half, given, _ = node.given[0]
        if k >= degree:  # as many samples as a polynomial of the degree needs, and the one it is led to
            assert given == degree
            s = np.linspace(0.0, h, 5)
            np.testing.assert_allclose(value + s * (slope + s * half), p(t + s), rtol=1e-13)  # a few divided differences
            assert node.ends[1, 0] == pytest.approx(p(t + h), rel=1e-13)
        t += h


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_polynomial_through_samples_is_exact_on_its_own_degree(degree):
    p, h1, h2, h = np.polynomial.Polynomial([0.7, -1.3, 2.1][: degree + 1]), 0.2, 0.03, 0.07
    terms = extrapolation(degree + 1, p(0.0), p(-h1), p(-h1 - h2), h1, h2)
    assert terms == pytest.approx([*p.coef, 0.0, 0.0][:3], rel=1e-12)
    assert end_of(*terms, degree, h) == pytest.approx(p(h), rel=1e-13)  # rounding of a few divided differences
