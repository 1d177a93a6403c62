"""Waves on lines from tables: clamps of stitch wires in closed form, energy, both methods."""

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.explicit import kick, margin
from cosimo.components.railway.wires import add_jumps, state_rows, tension_and_bending
from cosimo.tests.support import initialized

METHODS = ["explicit", pytest.param("implicit", marks=pytest.mark.full)]
LONG_STITCH = """
[[sections]]
contact_wire = { tension = 20e3, mass = 1.35 }
messenger = { tension = 20e3, mass = 1.0 }
droppers = { stiffness = 1.0, contact_clamp = 0.0 }
support = { system_height = 20.0, stiffness = 0.0 }
stitch = { half_length = 60.0, tension = 5e3, mass = 0.4 }
spans = [{ length = 150.0, positions = [1.0] }, { length = 150.0, positions = [149.0] }]
"""
STITCHED = """
[[sections]]
contact_wire = { tension = 27e3, mass = 1.07 }
messenger = { tension = 21e3, mass = 1.06 }
stitch = { half_length = 9.0, tension = 3500.0, mass = 0.31 }
droppers = { stiffness = 200e3, mass = 0.0, contact_clamp = 0.165, messenger_clamp = 0.195 }
support = { system_height = 1.8, stiffness = 500e3 }
span.positions = [5.0, 14.167, 23.333, 32.5, 41.667, 50.833, 60.0]
spans = [65, 65, 65]
"""


def line(text, method, effects=(), **values):
    values = {"line_table.table": text, "method": method, "element": 0.5, "substep": 5e-4, "first_watched_support": 0} | values
    return initialized(Catenary(("line_table", *effects), values), {"contact_position": 30.0})


@pytest.mark.parametrize("method", METHODS)
def test_a_clamp_parts_a_wave_between_messenger_and_stitch(method):
    """A pulse on the messenger meets T_m - H inside and H in the stitch: t = 2 Z / (Z + Z_in + Z_stitch) in both, r = t - 1."""
    whole = {"front_threshold": 0.0} if method == "explicit" else {}  # a pulse far ahead of the contact point
    made = line(LONG_STITCH, method, **whole)
    x, N, W = made.mesh.position, made.mesh.mass.size, made.mesh.bending_gradient.size
    c, centre, width = np.sqrt(20e3), 60.0, 3.0
    s = (x - centre) / width
    shape = 1e-3 * np.exp(-(s**2))
    q, w, a = state_rows(made.x, N)
    q[1::W] = shape
    w[1::W] = 2.0 * c * s / width * shape
    a[1::W] = c**2 * (4.0 * s**2 - 2.0) / width**2 * shape
    Z, inside, stitch = np.sqrt(20e3), np.sqrt(15e3), np.sqrt(5e3 * 0.4)
    t = 2.0 * Z / (Z + inside + stitch)
    for _ in range(400):  # the clamp is at 90 m; 0.4 s
        made.step(0.0, 1e-3)
    u = made.x[:N].reshape(-1, W)
    assert u[:, 2].max() == pytest.approx(1e-3 * t, rel=5e-3)
    assert u[x > 91.0, 1].max() == pytest.approx(1e-3 * t, rel=5e-3)
    before = u[x < 89.0, 1]
    assert before[np.argmax(np.abs(before))] == pytest.approx(1e-3 * (t - 1.0), abs=3e-6)  # 0.3 % of the pulse
    # waves of both kinds run at their own speed: the stitch's peak is where its own c brings it
    late = 0.4 - (90.0 - centre) / c
    assert x[np.argmax(u[:, 2])] == pytest.approx(90.0 + np.sqrt(5e3 / 0.4) * late, abs=0.6)
    assert x[x > 91.0][np.argmax(u[x > 91.0, 1])] == pytest.approx(90.0 + np.sqrt(15e3) * late, abs=0.6)


@pytest.mark.parametrize("method", METHODS)
def test_energy_of_an_undamped_stitched_line_is_kept(method):
    """Let go from 200 N, droppers bilateral; Verlet swings about a constant, the midpoint rule keeps it."""
    made = line(STITCHED, method)
    made.set("contact_force", 200.0)
    made.set("contact_position", 63.0)
    made.initialize(0.0)
    made.set("contact_force", 0.0)
    energies = []
    start = made.energy()
    for i in range(150):
        made.step(i * 2e-3, 2e-3)
        energies.append(made.energy())
    assert start > 1.0
    assert np.ptp(energies) < (1e-6 if method == "implicit" else 5e-3) * start


@pytest.mark.full
def test_both_methods_agree_under_a_moving_force_on_a_stitched_line():
    heights = []
    for method in ("explicit", "implicit"):
        made = line(STITCHED, method, ("dropper_slackening", "gravity_sag", "damping"), substep=2.5e-4)
        rows = []
        for i in range(1200):
            made.u[:2, 0] = 30.0 + 80.0 * i * 1e-3, 80.0
            made.u[0, 1] = 150.0 * min(1.0, i / 200)
            made.step(i * 1e-3, 1e-3)
            rows.append(made["wire_height"])
        heights.append(np.array(rows))
    assert np.abs(heights[0] - heights[1]).max() < 0.01 * np.ptp(heights[0])


@pytest.mark.full
def test_the_window_moves_stitches_and_leaves_equilibrium_behind():
    made = line(STITCHED, "explicit", ("damping", "moving_window"), **{"moving_window.behind": 20.0})
    for i in range(400):
        made.u[:2, 0] = 30.0 + 200.0 * i * 1e-3, 200.0
        made.u[0, 1] = 100.0
        made.step(i * 1e-3, 1e-3)
    N, W = made.mesh.mass.size, made.mesh.bending_gradient.size
    u = made.x[:N].reshape(-1, W)
    assert not u[made.mesh.position < 85.0].any()
    assert np.isfinite(made.x).all()
    assert np.abs(u[(made.mesh.position > 100.0) & (made.mesh.position < 120.0), 0]).max() > 1e-3


def test_a_worn_wire_is_lighter_and_its_waves_quicker():
    text = "[[sections]]\nspans = [{ length = 60, wear = 0.2 }, 60]\nspan.positions = [5, 15, 25, 35, 45, 55]"
    made = line(text, "explicit")
    mass, x = made.mesh.mass[::2], made.mesh.position
    here, there = (np.isclose(x, p, atol=0.2) & ~np.isinf(mass) for p in (20.0, 80.0))
    assert mass[here].max() == pytest.approx(0.8 * mass[there].max(), rel=1e-9)
    assert made.mesh.preload[:6].sum() == pytest.approx(0.8 * made.mesh.preload[6:].sum(), rel=0.02)


@pytest.mark.interpreted
@pytest.mark.parametrize("effects", [(), ("bending_stiffness",)])
def test_sum_over_neighbours_is_what_slopes_and_moments_give(effects):
    """The explicit method's acceleration of wires in any shape, against the step by step sums of the implicit one."""
    made = line(STITCHED, "explicit", effects, element=1.0)
    mesh = made.mesh
    N, W = mesh.mass.size, mesh.bending_gradient.size
    free = slice(W, N - W)
    beside, z = margin(W), np.random.default_rng(1).normal(size=N)
    padded = np.zeros(N + 2 * beside)
    z[mesh.ground >= 1e17] = 0.0  # where a lane has no wire
    z[:W] = z[N - W :] = 0.0
    padded[beside : beside + N] = z
    a, w, kink, pull = np.zeros((4, N))
    bending = made.arguments[2].bending_stiffness
    kick(W, N - W, beside + W, padded, a, made.arguments[0].rows, W, bending)
    tension_and_bending(z, w, kink, mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.inverse_length, bending)
    steps = mesh.inverse_length[:-W] * (w[W:] - w[:-W])
    pull[free] = steps[W:] - steps[:-W]
    add_jumps(z, pull, 0, mesh.jump.size, mesh)
    assert mesh.jump.size > 0
    assert np.abs(a).max() > 1e3
    over_mass = mesh.inverse_mass.copy()
    over_mass[mesh.clamped] = over_mass[mesh.clamp]  # which the clamp takes over
    np.testing.assert_allclose(a[free], (over_mass * pull)[free], rtol=0, atol=1e-12 * np.abs(a).max())
