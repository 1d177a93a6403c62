"""Stability limits of every algorithm: closed forms, and tables of two masses between springs and dampers.

What is measured is the spectral radius of one macro step of the master itself; runs show that it tells their fate.
"""

import math

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import TwoMasses, radius

NEUTRAL = 1.0 + 1e-9  # eigenvalues of a matrix of up to 22 columns, some of them defective zeros, are rounded

# -- a mass under the force of a spring-damper -------------------------------------------------------------------------


def contact(damping_ratio: float, step: float, feedthrough: str = "immediate", degree: int = 0, stop: float = 1.0) -> dict:
    """A unit mass on a spring-damper with w0 = 1/s."""
    return {
        "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
        "units": {
            "m": {"component": "cosimo.tests.support:Mass"},
            "s": {"component": "cosimo.tests.support:SpringDamper", "parameters": {"k": 1.0, "d": 2.0 * damping_ratio}},
        },
        "master": {"algorithm": "jacobi", "step": step, "extrapolation": degree, "feedthrough": feedthrough},
        "stop_time": stop,
    }


# Limits of w0 H by damping ratio D: roots of the characteristic polynomials in the docstring of `Jacobi`. The stale forms of
# higher degree are from a separate recursion of forces and motions in which the spring, too, gets extrapolated inputs. (With
# inputs that the spring holds, a loop of other masters, that recursion gives 0.0200 and 0.0200 at D = 0.01.)
RATIOS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.7071067811865476, 1.0)
LIMITS = {
    ("immediate", 0): (0.040000, 0.080000, 0.200000, 0.400000, 0.800000, 2.000000, 1.414214, 1.000000),
    ("immediate", 1): (0.395364, 0.501644, 0.694174, 0.902731, 1.213169, 1.101021, 0.739315, 0.510875),
    ("immediate", 2): (0.989325, 1.009576, 1.063371, 1.143517, 1.301332, 0.593485, 0.401216, 0.277997),
    ("delayed", 0): (0.013332, 0.026654, 0.066469, 0.131753, 0.254046, 0.481608, 0.494085, 0.426159),
    ("delayed", 1): (0.244970, 0.307394, 0.412848, 0.509969, 0.597782, 0.408960, 0.288426, 0.202283),
    ("delayed", 2): (0.626958, 0.624831, 0.614996, 0.582026, 0.391120, 0.132297, 0.091945, 0.064466),
}


@pytest.mark.parametrize(("feedthrough", "degree"), LIMITS)
def test_limit_of_a_mass_on_a_spring_damper(feedthrough, degree):
    for ratio, limit in zip(RATIOS, LIMITS[feedthrough, degree], strict=True):
        # six decimals are given: 1e-4 is ten times the rounding of the smallest
        below, above = (radius(contact(ratio, q * limit, feedthrough, degree, stop=10.0)) for q in (1.0 - 1e-4, 1.0 + 1e-4))
        assert below < 1.0 < above, ratio


def growth(scene: dict, signal: str) -> float:
    """Ratio of the amplitudes in the last tenth and in the tenth around the middle."""
    result = run(read_scene(scene))
    x, tenth = np.abs(result[signal]), result.time.size // 10
    return np.inf if result.outcome == "unstable" else x[-tenth:].max() / x[(x.size - tenth) // 2 :][:tenth].max()


@pytest.mark.first(2)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # a coupling that grows overflows, as it should
@pytest.mark.parametrize(("feedthrough", "degree"), LIMITS)
def test_runs_decay_below_the_limit_and_grow_above(feedthrough, degree):
    limit = LIMITS[feedthrough, degree][RATIOS.index(0.5)]
    for share, grows in ((0.98, False), (1.02, True)):
        scene = contact(0.5, share * limit, feedthrough, degree, stop=3000 * share * limit)
        assert (growth(scene, "m.x_out") > 1.0) == grows


def test_undamped_contact_with_held_force_grows_at_any_step():
    """|lambda|² = 1 + (w0 H)²/2: the amplitude grows by sqrt(1 + (w0 H)²/2) in a step."""
    for step in (1e-3, 0.02, 0.5, 3.0):
        assert radius(contact(0.0, step, stop=10.0)) == pytest.approx(math.sqrt(1.0 + step**2 / 2.0), rel=1e-13)


# -- two masses --------------------------------------------------------------------------------------------------------

SCHEMES = {
    "FF Jacobi": {"algorithm": "jacobi"},
    "FD Jacobi immediate": {"algorithm": "jacobi"},
    "FD Jacobi delayed": {"algorithm": "jacobi", "feedthrough": "delayed"},
    "DD Jacobi": {"algorithm": "jacobi"},
    "FD GS": {"algorithm": "gauss-seidel", "order": ["a", "b"]},
    "DD GS": {"algorithm": "gauss-seidel", "order": ["a", "b"]},
    "FF implicit": {"algorithm": "iterative"},
    "FD implicit": {"algorithm": "iterative"},
    "DD implicit": {"algorithm": "iterative"},
}
INF = math.inf


def radius_of(masses: TwoMasses, scheme: str, degree: int, step: float) -> float:
    return radius(masses.scene(scheme[:2], step, 100.0 * step, **SCHEMES[scheme], extrapolation=degree))


# Largest stable H in ms for the LIM oscillator, case 1, by degree; inf: none found up to 0.5 s
LIM_LIMITS = {
    "FF Jacobi": (0.367, 7.977, 35.74),
    "FD Jacobi immediate": (0.455, 14.02, 37.07),
    "FD Jacobi delayed": (0.130, 11.24, 35.31),
    "DD Jacobi": (2.222, 14.30, 29.77),
    "FD GS": (0.364, 18.06, 35.65),
    "DD GS": (INF, 18.86, 35.74),
    "FF implicit": (INF, 95.25, 16.06),
    "FD implicit": (150.0, 343.0, 30.1),
    "DD implicit": (1.82, 280.0, 30.6),
}


@pytest.mark.parametrize("scheme", LIM_LIMITS)
def test_limits_of_the_lim_oscillator(scheme):
    for degree, limit in enumerate(LIM_LIMITS[scheme]):
        if limit < INF:
            below, above = (radius_of(TwoMasses(), scheme, degree, q * limit * 1e-3) for q in (0.98, 1.02))
            assert below < 1.0 < above, degree
        else:
            assert max(radius_of(TwoMasses(), scheme, degree, h) for h in np.geomspace(1e-5, 0.5, 12)) < 1.0, degree


# Spectral radius without damping at H = 10 ms, by scheme and degree
UNDAMPED = {
    ("FF Jacobi", 0): 1.002956916,
    ("FF Jacobi", 1): 1.000220837,
    ("FF Jacobi", 2): 0.999985102,
    ("FD Jacobi immediate", 0): 1.001979462,
    ("DD Jacobi", 0): 1.000481891,
    ("DD GS", 0): 1.000000000,
    ("FF implicit", 0): 0.998000155,
    ("FF implicit", 1): 1.0,
    ("FD implicit", 1): 1.0,
    ("DD implicit", 1): 1.0,
}


@pytest.mark.parametrize(("scheme", "degree"), UNDAMPED)
def test_spectral_radius_without_damping(scheme, degree):
    reached = radius_of(TwoMasses(c1=0.0, cc=0.0, c2=0.0), scheme, degree, 1e-2)
    assert reached == pytest.approx(UNDAMPED[scheme, degree], abs=1.1e-9)  # nine decimals are given


def test_quadratic_inputs_without_damping_grow_slowly_with_iteration_too():
    undamped = TwoMasses(c1=0.0, cc=0.0, c2=0.0)
    assert radius_of(undamped, "DD implicit", 2, 1e-2) == pytest.approx(1.0 + 4.5e-6, abs=0.05e-6)
    assert radius_of(undamped, "FF implicit", 2, 1e-2) == pytest.approx(1.0 + 27.2e-6, abs=0.05e-6)


# Limit of w_c H (w_c² = kc / reduced mass) over mass ratio m2/m1, stiffness ratio kc/k1 and damping ratio of every damper, with
# m1 = k1 = k2 = 1, where the second mass owns the coupling in FD. First crossing on a logarithmic grid from 1e-3 to 30.
COLUMNS = (
    (1, 1, 0.05),
    (1, 100, 0.05),
    (1, 1e4, 0.05),
    (10, 100, 0.05),
    (100, 100, 0.05),
    (0.01, 100, 0.05),
    (1, 100, 0.01),
    (1, 100, 0.2),
)
TABLE = {
    ("FF Jacobi", 0): (0.3425, 0.2142, 0.2014, 0.218, 0.2198, 0.2198, 0.04283, 0.8598),
    ("FF Jacobi", 1): (0.7376, 0.7078, 0.6957, 0.711, 0.7125, 0.7125, 0.4035, 1.241),
    ("FF Jacobi", 2): (0.9845, 1.065, 1.064, 1.065, 1.065, 1.065, 0.9887, 1.313),
    ("FD Jacobi immediate", 0): (0.4593, 0.2857, 0.2686, 0.2198, 0.2198, 11.24, 0.05711, 1.152),
    ("FD Jacobi immediate", 1): (0.8118, 0.7771, 0.7634, 0.713, 0.7125, 7.99, 0.4433, 1.373),
    ("FD Jacobi immediate", 2): (1.042, 1.13, 1.128, 1.067, 1.065, 3.644, 1.038, 1.416),
    ("FD Jacobi delayed", 0): (0.2811, 0.05659, 0.00566, 0.08205, 0.07398, 0.2173, 0.01132, 0.2279),
    ("FD Jacobi delayed", 1): (0.5681, 0.5638, 0.5556, 0.4385, 0.4233, 8.699, 0.3409, 0.8435),
    ("DD Jacobi", 0): (0.7052, 0.4303, 0.4042, 3.961, 13.77, 13.77, 0.08567, 1.882),
    ("DD Jacobi", 1): (0.9663, 0.9109, 0.8935, 1.322, 8.154, 8.154, 0.5117, 1.694),
    ("DD Jacobi", 2): (1.129, 1.251, 1.247, 1.482, 3.624, 3.624, 1.116, 1.649),
    ("FD GS", 0): (0.5677, 0.0566, 0.00566, 0.08843, 0.2242, 0.2215, 0.01132, 0.228),
    ("FD GS", 1): (0.9756, 0.9167, 0.8987, 0.7359, 0.7151, INF, 0.5124, 1.75),
    ("DD GS", 0): (INF,) * 8,
    ("DD GS", 1): (1.531, 1.312, 1.277, 3.145, 15.06, 24.19, 0.6733, 3.254),
    ("FF implicit", 0): (INF,) * 8,
    ("FF implicit", 1): (2.755, 3.455, 3.464, 3.449, 3.446, 3.446, 3.454, 3.475),
    ("FF implicit", 2): (1.798, 1.566, 1.524, 1.578, 1.584, 1.584, 0.8318, 3.072),
    ("FD implicit", 0): (0.587, 0.0566, 0.00566, 0.087, 0.2208, 0.226, 0.01132, 0.2281),
    ("FD implicit", 1): (2.741, 3.378, 3.384, 3.446, 3.446, INF, 3.364, 3.741),
    ("DD implicit", 0): (0.2859, 0.02829, 0.002831, 0.04386, 0.1116, 0.1116, 0.005658, 0.1136),
    ("DD implicit", 1): (2.726, 3.311, 3.316, 5.344, 29.42, 29.42, 3.289, 4.51),
}


def masses(mass_ratio: float, stiffness_ratio: float, damping_ratio: float) -> tuple[TwoMasses, float]:
    """The two masses of a column, and w_c."""
    reduced = mass_ratio / (1.0 + mass_ratio)
    twice = 2.0 * damping_ratio
    return TwoMasses(
        m1=1.0,
        m2=mass_ratio,
        k1=1.0,
        k2=1.0,
        kc=stiffness_ratio,
        c1=twice,
        c2=twice * math.sqrt(mass_ratio),
        cc=twice * math.sqrt(stiffness_ratio * reduced),
    ), math.sqrt(stiffness_ratio / reduced)


@pytest.mark.first(6)
@pytest.mark.parametrize(("scheme", "degree"), TABLE, ids=lambda value: str(value))
def test_limits_over_mass_stiffness_and_damping_ratios(scheme, degree):
    for column, limit in zip(COLUMNS, TABLE[scheme, degree], strict=True):
        system, frequency = masses(*column)
        if limit < INF:
            below, above = (radius_of(system, scheme, degree, q * limit / frequency) for q in (0.98, 1.02))
            assert below <= 1.0 < above, column
        else:
            grid = np.geomspace(1e-3, 30.0, 12) / frequency
            assert max(radius_of(system, scheme, degree, step) for step in grid) < NEUTRAL, column


def test_force_force_with_iteration_and_a_stiff_contact_is_limited_like_newmark():
    """Linear acceleration between the ends of a step: w_c H = √12 without damping, for a contact far stiffer than the rest."""
    stiff = TwoMasses(m1=1.0, m2=3.0, k1=1.0, k2=1.0, kc=1e6, c1=0.0, cc=0.0, c2=0.0)
    frequency = math.sqrt(1e6 / 0.75)
    # the springs to the ground are a millionth of the contact, and so is their share in w²
    below, above = (radius_of(stiff, "FF implicit", 1, q * math.sqrt(12.0) / frequency) for q in (1.0 - 1e-4, 1.0 + 1e-4))
    assert below < NEUTRAL < 1.001 < above
