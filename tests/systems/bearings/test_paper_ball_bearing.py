"""The paper of the dimensionless bearing: its measures against integrations and counts of another kind."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.lyapunov import lyapunov_spectrum
from cosimo.orchestrator.harness.analysis.recurrence import quantify
from cosimo.orchestrator.systems.bearings.cases.paper_ball_bearing import conditioning, groups, six_sets, transition


def test_equations_written_out_give_the_component_s_motion():
    """The classical steps in double, in metres and dimensionless, against the component with its own kernel."""
    model = conditioning.bearing(conditioning.GAP)
    rows = []
    for k in range(round(conditioning.SHORT / conditioning.STEP)):
        model.step(k * conditioning.STEP, conditioning.STEP)
        rows.append(model.x[:2].copy())
    length = conditioning.magnitudes()["deflection"]
    for scaled in (False, True):
        written = conditioning.classical(np.float64, scaled) * (length if scaled else 1.0)
        assert written == pytest.approx(np.array(rows), abs=1e-12 * length)


def test_powers_of_two_as_units_change_no_bit():
    assert conditioning.binary_units() == 0.0


@pytest.mark.parametrize("clearance", [0.0, 2e-6])
def test_conditions_follow_from_stiffness_damping_and_mass(clearance):
    """Singular values of [[0, 1], [-k/m, -c/m]] for each principal direction; k/m is what SI units make of it."""
    matrix = conditioning.jacobian(conditioning.bearing(clearance))
    squares = np.linalg.eigvalsh(-matrix[2:, :2])
    blocks = [np.linalg.svd([[0.0, 1.0], [-s, matrix[2, 2]]], compute_uv=False) for s in squares]
    one, other = conditioning.conditions(clearance)
    assert one == pytest.approx(max(b[0] for b in blocks) / min(b[1] for b in blocks), rel=1e-6)
    assert one == pytest.approx(squares.max(), rel=1e-4)
    assert other < 3.0


def test_range_of_half_precision():
    assert conditioning.magnitudes()["stiffness"] > np.finfo(np.float16).max
    assert conditioning.short_numbers(np.float16, scaled=False) == math.inf


def test_frequency_of_a_free_oscillation_is_that_of_the_stiffness():
    """Eight balls, one on the load line: deflection and stiffness by sums."""
    theta = 2.0 * math.pi * np.arange(8) / 8.0
    cosine = np.maximum(np.cos(theta), 0.0)
    deflection = (196.0 / (1.334e10 * (cosine**2.5).sum())) ** (2.0 / 3.0)
    stiffness = 1.5 * 1.334e10 * math.sqrt(deflection) * (cosine**2.5).sum()
    measured = groups.free_oscillation(196.0)
    assert measured[0] == pytest.approx(deflection, rel=1e-9)
    assert measured[1] == pytest.approx(math.sqrt(stiffness / 20.0) / (2.0 * math.pi), rel=1e-4)


def test_recurrence_has_the_chosen_rate_outside_the_window():
    rows = np.random.default_rng(3).normal(size=(400, 4))
    window = 7
    assert quantify(transition.recurrence(rows, window), theiler=window).rate == pytest.approx(transition.RATE, abs=2e-5)


def test_first_value_beyond_a_limit():
    values = np.zeros(transition.GAPS.size)
    assert transition.first_beyond(values, 0.5) == math.inf
    values[[4, 9]] = 1.0
    assert transition.first_beyond(values, 0.5) == 4.0


def test_the_largest_exponent_alone_is_that_of_the_whole_spectrum():
    def model():
        bearing = transition.bearing(5.0)
        bearing.step(0.0, 2.0)
        return bearing

    settings = {"interval": transition.INTERVAL, "intervals": 300, "transient": 50}
    whole = lyapunov_spectrum(model(), transition.STATES, transition.SCALES, **settings)
    alone = lyapunov_spectrum(model(), transition.STATES, transition.SCALES, count=1, **settings)
    assert alone.exponents.shape == (1,)
    assert alone.largest == pytest.approx(whole.largest, abs=0.5)
    assert alone.largest == pytest.approx(-5.0, abs=0.5)
    with pytest.raises(BadInput, match="1 to 4"):
        lyapunov_spectrum(model(), transition.STATES, transition.SCALES, interval=1e-3, intervals=1, count=5)


def test_the_rule_of_sampling_is_a_natural_period_and_no_whole_part_of_a_passage():
    for load in six_sets.LOADS:
        interval = six_sets.NATURAL * six_sets.natural_time(load)
        assert 1.0 < interval / (2.0 * math.pi * six_sets.natural_time(load)) < 1.4  # softer across the load
        for speed in six_sets.SPEEDS:
            parts = six_sets.passage(speed) / interval
            assert abs(parts - round(parts)) > 0.05


def test_the_orbit_beside_order_has_the_exponent_of_the_motion():
    largest, size, product, _, _ = six_sets.kind_of(1000.0, 196.0, 5.0)
    assert math.log(size) / six_sets.passage(1000.0) == pytest.approx(largest, abs=0.25)
    assert product == pytest.approx(six_sets.contraction(1000.0), rel=1e-4)


def test_a_load_of_a_set_is_that_of_the_equilibrium():
    """Lengths grow as W^(2/3): twice the load and clearance times 2^(2/3) is one dimensionless bearing at rest."""
    scale = 2.0 ** (2.0 / 3.0)
    at = []
    for load, gap in ((196.0, 10e-6), (392.0, 10e-6 * scale)):
        model = six_sets.bearing(1000.0, load, 1e6 * gap)
        at.append(model["displacement_x"])
    assert at[1] / at[0] == pytest.approx(scale, rel=1e-6)
