"""The paper of the pipe robots: the balance of the first harmonic against an integration, and thresholds."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems.pipe_robot.cases.paper_pipe_robots.balance import Design, balance, breakaway
from cosimo.orchestrator.systems.pipe_robot.cases.paper_pipe_robots.matching import FORWARDS, STANDS, matched_speed, piece
from scipy.integrate import solve_ivp


def test_amplitude_is_that_of_the_two_masses_with_both_forces():
    """A force in phase with the velocity instead of friction makes the set linear: its response is an integration's."""
    design = Design(frequency=77.0)
    answer = balance(design)
    w, tau = design.frequency, design.forward_share
    friction = 2.0 / math.pi * (design.forward + design.backward) * math.sin(math.pi * tau)
    viscous = friction / answer.amplitude  # N.s/m, the same force at the same amplitude

    def rates(t, x):
        pull = design.stiffness * (x[2] - x[0]) + design.damping * (x[3] - x[1]) + design.force * math.sin(w * t)
        return [x[1], (pull - viscous * x[1]) / design.body, x[3], -pull / design.inner]

    periods = 60
    end = periods * 2.0 * math.pi / w
    last = np.linspace(end - 2.0 * math.pi / w, end, 400)
    velocity = solve_ivp(rates, (0.0, end), [0.0] * 4, t_eval=last, rtol=1e-9, atol=1e-12).y[1]
    assert 0.5 * np.ptp(velocity) == pytest.approx(answer.amplitude, rel=1e-3)


def test_weak_friction_gives_the_known_mean_speed_of_two_bodies():
    design = Design(forward=0.002, backward=0.006)
    answer = balance(design)
    assert answer.speed == pytest.approx(answer.amplitude * math.cos(0.25 * math.pi), rel=1e-12)
    assert answer.amplitude == pytest.approx(
        20.0 / 60.0 * 2000.0 * 0.5 / 1.5 / abs(2000.0 - 1200.0 + 300.0j) / (2000.0 / 3600.0), rel=1e-3
    )


def test_speed_changes_sign_with_friction_and_load():
    assert balance(Design(forward=5.0, backward=5.0)).speed == pytest.approx(0.0, abs=1e-15)
    assert balance(Design(tow=-3.0)).speed == pytest.approx(0.0, abs=1e-15)
    assert balance(Design(forward=8.0, backward=2.0)).speed == pytest.approx(-balance(Design()).speed)
    assert math.isnan(balance(Design(sine=0.6)).speed)  # slides down: no share of forward slip balances the load


def test_breakaway_is_least_at_the_resonance_of_the_standing_body():
    at = np.linspace(40.0, 90.0, 5001)
    forces = [breakaway(Design(frequency=w, damping=1e-6)) for w in at]
    assert at[int(np.argmin(forces))] == pytest.approx(math.sqrt(2000.0 / 0.5), abs=0.02)
    assert breakaway(Design(frequency=1e5)) == pytest.approx(2.0, rel=1e-4)  # the exciter acts on the body alone


def test_matched_pieces_give_the_exact_speed_of_the_standard_robot():
    """By matrix exponentials between events, outside of this project."""
    assert matched_speed(Design()) == pytest.approx(0.3601677257, abs=1e-10)


@pytest.mark.parametrize("mode", [FORWARDS, STANDS])
def test_a_piece_solves_its_equations(mode):
    """Stretch and body's velocity against DOP853 of both bodies, on a slope, in tow."""
    d = Design(sine=0.1, tow=0.7, damping=8.0)
    now, begin = piece(d, mode, 0.3, 1e-3, -0.2), 0.3

    def rates(t, x):
        pull = d.stiffness * (x[2] - x[0]) + d.damping * (x[3] - x[1]) + d.force * math.sin(d.frequency * t)
        body = (pull + d.tow - d.forward) / d.body - 9.81 * d.sine if mode == FORWARDS else 0.0
        return [x[1], body, x[3], -pull / d.inner - 9.81 * d.sine]

    last = solve_ivp(rates, (begin, 0.37), [0.0, 0.0, 1e-3, -0.2], method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    assert [now.stretch(0.37), now.rate(0.37)] == pytest.approx([last[2] - last[0], last[3] - last[1]], rel=1e-8)
    if mode == FORWARDS:
        assert [now.body(0.37), now.way(0.37)] == pytest.approx([last[1], last[0]], rel=1e-8)


@pytest.mark.parametrize("force", [1.5, 0.25])
def test_a_weak_exciter_moves_the_body_by_stick_and_slip_or_not_at_all(force):
    speed = matched_speed(Design(force=force))
    if force < breakaway(Design(force=force)):
        assert speed == 0.0
    else:
        assert 0.0 < speed < 0.02
