"""Stable, inaccurate, unstable: runs of a mass on a spring and damper against the exact map of their macro steps.

The map is written down here anew: motion under a polynomial force by the exponential of a matrix, and its spectral radius.
"""

import itertools
from math import ceil, log

import cosimo
import numpy as np
import pytest
from cosimo.orchestrator.judgement.verification import made_by_coupling
from cosimo.orchestrator.run.comparison import difference, signal_errors
from numba import config
from scipy.linalg import expm

STIFFNESS = 100.0  # N/m, of 1 kg
DAMPINGS = (1.0, 6.0, 30.0)  # N.s/m; with the lowest, held inputs have a limit below 0.01 s
# damping, degree, whether it is solved for: held inputs that are solved for have no limit
LIMITS = [(c, degree, solved) for c in DAMPINGS for degree in (0, 1, 2) for solved in (False, True) if degree or not solved]
SHARES = (0.9, 0.98, 1.02, 1.1)
LENGTHS = (4, 8, 30, 300)  # steps
BEYOND = 1e4  # growth that is beyond bounds
# algorithm, damping, degree of the extrapolation: settings with a growth that few steps show
RUNS = [(a, c, d) for a in ("jacobi", "gauss-seidel") for c, d in ((30.0, 0), (6.0, 1), (6.0, 2))]
RUNS += [pytest.param("iterative", c, degree, marks=pytest.mark.full) for c, degree in ((6.0, 1), (30.0, 2))]

pytestmark = pytest.mark.interpreted


def step_map(h: float, damping: float, degree: int, solved: bool) -> np.ndarray:
    """Map of (x, v, earlier forces) over a step in which 1 kg follows the polynomial through its last forces.

    solved: also through the one at the end of the step, as an iteration finds it; without the earliest then.
    States of the exponential: x, v, f, f', f''; the force's derivatives come from the differences of its samples.
    """
    chain = np.zeros((5, 5))
    chain[0, 1] = chain[1, 2] = chain[2, 3] = chain[3, 4] = 1.0
    motion = expm(h * chain)[:2]
    size = 2 + degree
    present = np.zeros(size)
    present[:2] = -STIFFNESS, -damping
    samples = np.vstack([present, *np.eye(size)[2:]])  # newest first
    times = -h * np.arange(degree + 1.0)
    if solved:
        samples, times = np.vstack([np.zeros(size), samples[:-1]]), times + h
    taylor = np.zeros((3, degree + 1))  # value and derivatives, of samples
    taylor[: degree + 1] = np.linalg.inv(np.vander(times, degree + 1, increasing=True))
    taylor[2] *= 2.0
    end = motion[:, 2:] @ taylor
    now = np.hstack([motion[:, :2], np.zeros((2, degree))]) + end @ samples
    if solved:  # the newest sample is that of the state at the end
        now = np.linalg.solve(np.eye(2) - np.outer(end[:, 0], present[:2]), now)
    return np.vstack([now, present, *np.eye(size)[2:]])[: 2 + degree]


def radius(h: float, damping: float, degree: int, solved: bool) -> float:
    """Growth a step in the long run."""
    return float(np.abs(np.linalg.eigvals(step_map(h, damping, degree, solved))).max())


def limit(damping: float, degree: int, solved: bool) -> float:
    """The longest stable step, s: where the radius passes 1."""
    steps = np.geomspace(5e-3, 0.5, 400)
    first = int(np.argmax([radius(h, damping, degree, solved) > 1.0 + 1e-12 for h in steps]))
    low, high = steps[first - 1], steps[first]
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if radius(middle, damping, degree, solved) > 1.0 + 1e-12 else (middle, high)
    return float(low)


def motion(h: float, damping: float, degree: int, solved: bool, steps: int) -> dict[str, np.ndarray]:
    """Place, speed and force, (steps + 1,) each, from x = 0 with 1 m/s; the degree rises as there are earlier forces."""
    maps = [step_map(h, damping, d, solved)[:2] for d in range(degree + 1)]
    states, forces = [np.array([0.0, 1.0])], [0.0] * degree + [-damping]
    for k in range(steps):
        d = min(k + solved, degree)
        states.append(maps[d] @ [*states[-1], *forces[-2 : -2 - d : -1]])
        forces.append(-STIFFNESS * states[-1][0] - damping * states[-1][1])
    x, v = np.array(states).T
    return {"x": x, "v": v, "force": np.array(forces[degree:])}


def judged(h: float, damping: float, degree: int, solved: bool, steps: int) -> list[str]:
    """What the judgement of three runs calls unstable, of signals made by the map."""
    runs = [motion(h / n, damping, degree, solved, n * steps) for n in (1, 2, 4)]
    gaps = [{name: difference(a[name], b[name][::2]) for name in a} for a, b in itertools.pairwise(runs)]
    return made_by_coupling(signal_errors(*gaps))


def scene(algorithm: str, degree: int, damping: float, step: float, steps: int) -> cosimo.Scene:
    changes = {"spring.damping": damping, "spring.stiffness": STIFFNESS}
    master = {"master.algorithm": algorithm, "master.extrapolation": degree, "master.step": step, "stop_time": steps * step}
    return cosimo.load_scene("mass-on-spring").with_changes(changes | master)


@pytest.mark.parametrize(("damping", "degree", "solved"), LIMITS)
def test_a_motion_is_unstable_where_its_map_has_a_radius_above_one(damping, degree, solved):
    longest = limit(damping, degree, solved)
    for share in SHARES:
        step = share * longest
        growth = radius(step, damping, degree, solved)
        assert (growth > 1.0) == (share > 1.0)
        for steps in LENGTHS if share < 1.0 else (ceil(log(BEYOND) / log(growth)),):
            assert bool(judged(step, damping, degree, solved, steps)) == (share > 1.0), (share, steps)


@pytest.mark.parametrize(("algorithm", "damping", "degree"), RUNS)
def test_runs_follow_the_map_and_are_judged_by_it(algorithm, damping, degree):
    """A repetition judges what decays; to see what grows beyond bounds it is needed only where inputs are solved for."""
    solved = algorithm == "iterative"
    longest = limit(damping, degree, solved)
    decays = cosimo.run(scene(algorithm, degree, damping, 0.98 * longest, 12), in_process=True)
    assert decays.outcome == "done", decays.message
    assert decays.info.warnings
    exact = motion(0.98 * longest, damping, degree, solved, 12)
    assert decays["mass.base_x"] == pytest.approx(exact["x"], abs=1e-9)
    assert decays["mass.base_velocity_x"] == pytest.approx(exact["v"], abs=1e-8)
    steps = ceil(log(BEYOND) / log(radius(1.1 * longest, damping, degree, solved)))
    grows = cosimo.run(
        scene(algorithm, degree, damping, 1.1 * longest, steps), in_process=True, verify="auto" if solved else "no"
    )
    assert grows.outcome == "unstable"


@pytest.mark.full
@pytest.mark.parametrize(("algorithm", "damping", "degree"), RUNS)
@pytest.mark.parametrize("share", SHARES)
def test_runs_of_any_length_are_judged_by_the_map(algorithm, damping, degree, share):
    """Growth that a short run cannot show is an error that the repetition shows: it warns."""
    solved = algorithm == "iterative"
    step = share * limit(damping, degree, solved)
    growth = radius(step, damping, degree, solved)
    for steps in (*LENGTHS, *([ceil(log(BEYOND) / log(growth))] if share > 1.0 else [])):
        result = cosimo.run(scene(algorithm, degree, damping, step, steps), in_process=True)
        where = f"{steps} steps: {result.message}"
        if growth < 1.0:
            assert result.outcome == "done", where
        elif growth**steps >= BEYOND:
            assert result.outcome == "unstable", where
        else:
            assert result.outcome == "unstable" or result.info.warnings, where


@pytest.mark.parametrize("steps", [4, 6, 10, 19, 40])
def test_growth_beyond_bounds_is_seen_without_a_repetition(steps):
    result = cosimo.run(scene("gauss-seidel", 1, 4.0, 0.5, steps), in_process=True, verify="no")
    assert result.outcome == "unstable"
    without_kernels = "Reduce the macro step"  # in plain Python nothing has a derivative
    assert (without_kernels if config.DISABLE_JIT else "stable up to 0.121 s") in result.message


def test_without_a_repetition_a_run_warns_that_it_is_not_verified():
    short = cosimo.run(scene("gauss-seidel", 1, 4.0, 0.005, 40), in_process=True, verify="no")
    assert short.info.warnings == ("not verified, as requested: the errors of the results are not known",)
    lost = cosimo.run(scene("gauss-seidel", 1, 4.0, 0.11, 100), in_process=True, verify="no")  # decays, but nothing is foretold
    assert "extrapolation misses mass.base_force_x by" in lost.info.warnings[-1]
