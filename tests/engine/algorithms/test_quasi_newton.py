"""Ways to a fixed point: published factors of the plain one, and methods that do not mind them."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.engine.algorithms.solve import QuasiNewton
from cosimo.tests.engine.algorithms.oscillators import STATES, TwoMasses, give_past, open_master

FREE = {"k1": 0.0, "k2": 0.0, "c1": 0.0, "c2": 0.0, "start": (0.0, 1.0, 0.0, -1.0)}  # two free masses


def answered(respond, guess, tolerance=1e-12, limit=60) -> int:
    """Responses until the guess comes back."""
    calls = 0

    def counted(x):
        nonlocal calls
        calls += 1
        return respond(x)

    found = QuasiNewton()
    found.begin(np.ones_like(guess))
    response = counted(guess)
    while np.abs(response - guess).max() > tolerance and calls < limit:
        guess = found.following(guess, response - guess)
        response = counted(guess)
    return calls


@pytest.mark.parametrize("seed", range(5))
def test_linear_maps_of_n_signals(seed):
    """n + 1 independent differences, whatever the gains, here up to 50."""
    rng = np.random.default_rng(seed)
    for n in (1, 2, 5):
        gains, offset = 10.0 * rng.standard_normal((n, n)), rng.standard_normal(n)
        assert answered(lambda x: gains @ x + offset, np.zeros(n), 1e-8) <= n + 4  # noqa: B023 - called at once


def test_a_contact_that_opens_and_closes():
    """f = k max(0, gap - f/s): stiff where closed, flat where open; the answer lies on either side of the kink."""
    for gap in (-1e-3, 1e-3):
        exact = max(0.0, 1e6 * gap / (1.0 + 1e6 / 1e5))
        x, found = np.array([50.0]), QuasiNewton()
        found.begin(np.array([100.0]))
        for _ in range(30):
            residual = np.maximum(0.0, 1e6 * (gap - x / 1e5)) - x
            if abs(residual[0]) < 1e-9:
                break
            x = found.following(x, residual)
        assert x[0] == pytest.approx(exact, abs=1e-8)


def test_memory_is_plain_numbers_and_gives_back_the_same_way():
    rng = np.random.default_rng(1)
    gains = 3.0 * rng.standard_normal((3, 3))

    def respond(x):
        return gains @ x + np.ones(3)

    one, other = QuasiNewton(), QuasiNewton()
    one.begin(np.ones(3))
    x = np.zeros(3)
    for _ in range(3):
        x = one.following(x, respond(x) - x)
    other.memory = one.memory
    assert all(isinstance(number, float) for row in one.memory for number in row)
    for found in (one, other):
        found.begin(np.ones(3))
    assert one.following(x, respond(x) - x).tobytes() == other.following(x, respond(x) - x).tobytes()


# -- the fixed point of a macro step -----------------------------------------------------------------------------------


SIGNALS = [*STATES, ("f", "force")]


def circle(masses: TwoMasses, step: float, degree: int):
    """A master with the force between two free masses as the one signal at the cut, and its circle."""
    scene = masses.scene("FF", step, stop=100.0 * step, algorithm="iterative", extrapolation=degree)
    master = open_master(scene)
    ((chain, _),) = master.algorithm._groups
    return master, chain


FACTORS = {  # of the error in the force, from sweep to sweep: w = H² kc / m, z = H cc / m with the reduced mass m
    0: lambda w, z: w / 2.0 + z,
    1: lambda w, z: w / 6.0 + z / 2.0,
    2: lambda w, z: w / 8.0 + 5.0 * z / 12.0,
}


@pytest.mark.parametrize("degree", FACTORS)
def test_factor_of_the_plain_fixed_point(degree):
    for kc, cc, step in ((100.0, 0.0, 0.05), (1e4, 3.0, 1e-2), (10.0, 20.0, 0.4)):
        masses = TwoMasses(m1=1.0, m2=3.0, kc=kc, cc=cc, **FREE)
        master, chain = circle(masses, step, degree)
        give_past(master, lambda t: dict.fromkeys(SIGNALS, 0.0), step, degree)
        assert len(chain.cut) == 1
        chain.save()
        answers = []
        for force in (0.0, 1.0):
            chain.restore()
            answers.append(chain.respond(np.array([force]), master.machine, 0.0, step)[0])
        expected = FACTORS[degree](step**2 * kc / 0.75, step * cc / 0.75)
        # numbers of size kc * x with x up to step: their difference loses digits
        assert answers[1] - answers[0] == pytest.approx(-expected, rel=1e-9)


@pytest.mark.parametrize(("degree", "limit"), [(0, math.sqrt(2.0)), (1, math.sqrt(6.0)), (2, math.sqrt(8.0))])
def test_methods_converge_where_the_fixed_point_does_not(degree, limit):
    """Without damping the plain fixed point contracts up to w H = √2, √6, √8; at ten times that errors grow 100-fold a sweep."""
    masses = TwoMasses(m1=1.0, m2=3.0, kc=100.0, cc=0.0, **FREE)
    frequency = math.sqrt(100.0 / 0.75)
    for share, contracts in ((0.99, True), (1.01, False), (10.0, False)):
        step = share * limit / frequency
        master, chain = circle(masses, step, degree)
        give_past(master, lambda t: dict.fromkeys(SIGNALS, 0.0), step, degree)
        chain.save()
        force, misses = np.zeros(1), []
        for _ in range(4):
            chain.restore()
            answer = chain.respond(force, master.machine, 0.0, step)
            misses.append(abs(answer[0] - force[0]))
            force = answer
        assert misses[3] / misses[2] == pytest.approx(share**2, rel=1e-6)
        assert (misses[3] < misses[2]) == contracts
    master, _ = circle(masses, step, degree)
    for k in range(5):
        master.step(k * step, step)
    # a linear circle cut at one signal: one correction a step, and one more where the degree and so the gain changes
    assert master.algorithm.iterations <= 2 * master.steps + 1 + degree


def test_lagged_added_mass():
    """A light mass that carries a heavy one: the plain exchange multiplies errors by -100, and the methods find cos t."""
    here = "cosimo.tests.engine.algorithms.oscillators"
    scene = {
        "stop_time": 1.0,
        "units": {
            "a": {"component": f"{here}:Accelerated", "parameters": {"m": 1.0, "k": 1.0}},
            "b": {"component": f"{here}:Carried", "parameters": {"m": 100.0, "k": 100.0}},
        },
        "connections": ["b.force -> a.force", "a.x_out -> b.position", "a.a_out -> b.acceleration"],
        "master": {"algorithm": "iterative", "step": 0.02, "extrapolation": 1},
    }
    master = open_master(scene, [("a", "x_out")])
    ((chain, _),) = master.algorithm._groups
    chain.save()
    guess = chain.predicted(master.machine, 0.02)
    answer = chain.respond(guess, master.machine, 0.0, 0.02)
    chain.restore()
    moved = chain.respond(guess + 1.0, master.machine, 0.0, 0.02)
    chain.restore()
    # the mass answers at once, and by w²/6 = 7e-5 of that by having moved to the end of the step
    assert (moved - answer)[0] == pytest.approx(-100.0, rel=1e-3)
    for k in range(50):
        master.step(0.02 * k, 0.02)
    # second order: e = C H² with the third derivative of cos below 1 and weights below 1/12 would be 3e-5
    assert master.signals[master.positions["a", "x_out"]] == pytest.approx(math.cos(1.0), abs=1e-4)
