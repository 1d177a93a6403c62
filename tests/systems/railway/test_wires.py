"""Waves on the wires against closed forms: speed, frequencies, reflection, energy, orders of convergence."""

import numpy as np
import pytest
import scipy.linalg
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.mesh import Mesh, packed, unpacked
from cosimo.components.railway.stiffness import stiffness_of_wires
from cosimo.components.railway.wires import state_rows
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized

METHODS = ["explicit", "implicit"]


def bare_wire(method: str, length: float = 120.0, effects=(), **parameters) -> Catenary:
    """A contact wire with one dropper so soft (1 N/m against 20 kN of tension) that it takes no part."""
    values = {"spans": 1, "span_length": length, "droppers": 1, "dropper_position[1]": 2.0, "dropper_stiffness": 1.0}
    whole = {"front_threshold": 0.0} if method == "explicit" else {}  # it moves far ahead of the contact point, too
    return initialized(Catenary(effects, values | {"method": method, "element": 0.5, "substep": 5e-4} | parameters | whole))


def launch(catenary: Catenary, centre: float, width: float) -> np.ndarray:
    """Put a Gaussian pulse on the contact wire that travels to the right; returns the node positions."""
    x, N = catenary.mesh.position, catenary.mesh.mass.size
    c = np.sqrt(20e3 / 1.35)
    s = (x - centre) / width
    shape = 1e-3 * np.exp(-(s**2))
    q, w, a = state_rows(catenary.x, N)
    q[::2] = shape
    w[::2] = 2.0 * c * s / width * shape  # -c u'
    a[::2] = c**2 * (4.0 * s**2 - 2.0) / width**2 * shape  # c² u''
    return x


@pytest.mark.full
@pytest.mark.parametrize("method", METHODS)
def test_pulse_travels_at_the_wave_speed_and_keeps_its_shape(method):
    catenary = bare_wire(method, length=240.0)
    x = launch(catenary, 60.0, 3.0)
    before = catenary.x[: 2 * x.size : 2].copy()
    for i in range(1000):
        catenary.step(i * 1e-3, 1e-3)
    after = catenary.x[: 2 * x.size : 2]
    travelled = (after @ x) / after.sum() - (before @ x) / before.sum()
    assert travelled == pytest.approx(np.sqrt(20e3 / 1.35), rel=1e-5)  # a millimetre in 122 m, a 500th of an element
    exact = 1e-3 * np.exp(-(((x - 60.0 - np.sqrt(20e3 / 1.35)) / 3.0) ** 2))
    assert np.abs(after - exact).max() < 2e-5  # 2 % after 40 widths; a consistent mass alone leaves 20 %


def frequencies(element: float, bending=None) -> np.ndarray:
    """Angular eigenfrequencies of the contact wire of a 60 m section, 1/s, on the mesh for a step of nothing."""
    values = {"spans": 1, "droppers": 1, "dropper_position[1]": 30.0, "element": element, "substep": 1e-7, "method": "implicit"}
    catenary = Catenary(["bending_stiffness"] if bending else [], values)
    if bending:
        catenary.set("bending_stiffness.contact_wire", bending)
    catenary.initialize(0.0)
    mesh = catenary.mesh
    stiffness, inner = full(stiffness_of_wires(mesh, 3)[::2, ::2]), slice(1, -1)
    return np.sqrt(scipy.linalg.eigh(stiffness[inner, inner], np.diag(mesh.mass[::2][inner]), eigvals_only=True))


def full(band: np.ndarray) -> np.ndarray:
    """The symmetric matrix of an upper band."""
    upper = sum(np.diag(band[: band.shape[0] - k, k], k) for k in range(band.shape[1]))
    return upper + upper.T - np.diag(np.diag(upper))


@pytest.mark.parametrize("bending", [0.0, 4e4])
def test_frequencies_converge_at_fourth_order(bending):
    """Pinned string or beam under tension: k sqrt((T + EI k²) / m); EI raised so that bending carries a third of mode 10."""
    k = 10 * np.pi / 60.0
    exact = k * np.sqrt((20e3 + bending * k**2) / 1.35)
    elements = np.array([2.0, 1.5, 1.0])
    errors = [abs(frequencies(e, bending)[9] / exact - 1.0) for e in elements]
    assert 3.7 < slope(elements, errors) < 4.3


@pytest.mark.parametrize("method", METHODS)
def test_reflection_at_a_mass(method):
    """M v' = 2 sqrt(T m) (v_in - v) at a point mass: the transmitted pulse beyond it, the reflected one before it."""
    mass, Z, c = 5.0, np.sqrt(20e3 * 1.35), np.sqrt(20e3 / 1.35)
    catenary = bare_wire(method, 240.0, contact_clamp_mass=mass, element=0.25, substep=2.5e-4, **{"dropper_position[1]": 120.0})
    x = launch(catenary, 90.0, 3.0)
    for i in range(500):
        catenary.step(i * 1e-3, 1e-3)
    u, t = catenary.x[: 2 * x.size : 2], 0.5

    def incoming(s):
        return 1e-3 * np.exp(-((s / 3.0) ** 2))  # displacement where s = x - c t - 90

    # u_mass(tau) at x = 120: M u'' = 2 Z (u_in' - u'), once integrated M u' = 2 Z (u_in - u)
    tau, dt = np.linspace(0.0, t, 200_001, retstep=True)
    drive = incoming(120.0 - c * tau - 90.0)
    rate = 2.0 * Z / mass
    at_mass = np.zeros_like(tau)
    for i in range(tau.size - 1):  # exact for a linear drive within dt
        mean = 0.5 * (drive[i] + drive[i + 1])
        at_mass[i + 1] = mean + (at_mass[i] - mean) * np.exp(-rate * dt)
    beyond = x > 121.0
    transmitted = np.interp(t - (x[beyond] - 120.0) / c, tau, at_mass, left=0.0)
    before = (x > 60.0) & (x < 119.0)
    back = t - (120.0 - x[before]) / c
    reflected = np.interp(back, tau, at_mass - drive, left=0.0) + incoming(x[before] - c * t - 90.0)
    # 2 % of the pulse: the mass rings with wavelengths down to a few elements
    assert np.abs(u[beyond] - transmitted).max() < 2e-5
    assert np.abs(u[before] - reflected).max() < 2e-5
    assert np.abs(reflected).max() > 3e-4  # there is something to see: a third of the pulse comes back


def struck(method: str, substep: float, **parameters) -> tuple[Catenary, float]:
    """A taut, undamped catenary hit for 40 ms by a smooth force; returns it and the work done on it, J."""
    values = {"spans": 3, "method": method, "element": 1.0, "substep": substep, "first_watched_support": 0}
    catenary = Catenary([], values | parameters)
    catenary.set("contact_position", 77.0)
    catenary.initialize(0.0)
    h, work, n = 5e-4, 0.0, 80
    for i in range(n):
        a, b = (800.0 * np.sin(np.pi * k / n) ** 2 for k in (i, i + 1))
        before = catenary["wire_height"]
        catenary.u[:, 1] = a, (b - a) / h, 0.0
        catenary.step(i * h, h)
        work += 0.5 * (a + b) * (catenary["wire_height"] - before)
    catenary.set("contact_force", 0.0)
    return catenary, work


@pytest.mark.parametrize("method", METHODS)
def test_energy_of_the_undamped_wire_is_the_work_done_on_it(method):
    catenary, work = struck(method, 2.5e-4)
    start = catenary.energy()
    assert start == pytest.approx(work, rel=2e-3)  # trapezoid of the work, substep of half the force's step
    energies = []
    for i in range(400):
        catenary.step(i * 5e-3, 5e-3)
        energies.append(catenary.energy())
    # midpoint rule: exact for a linear system; Verlet: an oscillation of (omega h)² / 8 about a constant, no drift
    assert np.ptp(energies) < (1e-9 if method == "implicit" else 2e-2) * start
    assert abs(np.mean(energies[200:]) - np.mean(energies[:200])) < (1e-9 if method == "implicit" else 1e-3) * start


@pytest.mark.parametrize("method", METHODS)
def test_order_in_the_step_is_two(method):
    """State after 0.2 s on a fixed mesh against a step 16 times smaller, with damping and a moving force."""

    def state(substep):
        effects = ["damping"]
        values = {"spans": 2, "element": 2.0, "substep": substep, "method": method, "first_watched_support": 0}
        catenary = Catenary(effects, values | {"damping.alpha": 0.1, "damping.beta": 1e-3})
        catenary.initialize(0.0)
        # the mesh depends on the nominal substep; the same mesh for all isolates the time integration
        fine = Catenary(effects, catenary.parameters | {"substep": 1e-7})
        fine.initialize(0.0)
        catenary.arguments[0].numbers[:] = fine.arguments[0].numbers
        if method == "implicit":
            catenary.arguments[0].solver.stiffness[:] = fine.arguments[0].solver.stiffness
        for i in range(10):
            catenary.u[:, 0] = 40.0, 0.0, 0.0
            catenary.u[:, 1] = 100.0 * (i * 0.02) ** 2, 200.0 * i * 0.02, 100.0  # a force growing as t²
            catenary.step(i * 0.02, 0.02)
        return catenary.x[: catenary.mesh.mass.size].copy()

    steps = np.array([4e-3, 2e-3, 1e-3]) / 2.0
    exact = state(steps[-1] / 16.0)
    errors = [np.abs(state(s) - exact).max() for s in steps]
    assert abs(slope(steps, errors) - 2.0) < 0.1


@pytest.mark.known_answers(Catenary="damping")
def test_mass_proportional_damping_decays_every_mode_alike():
    catenary = bare_wire("implicit", 60.0, ["damping"], **{"damping.alpha": 0.8, "damping.beta": 0.0})
    x, N = catenary.mesh.position, catenary.mesh.mass.size
    catenary.x[:N:2] = 1e-3 * np.sin(3.0 * np.pi * x / 60.0)
    state_rows(catenary.x, N)[2][::2] = -((3.0 * np.pi / 60.0) ** 2) * 20e3 / 1.35 * catenary.x[:N:2]
    start = catenary.energy()
    period = 2.0 * np.pi / np.sqrt((3.0 * np.pi / 60.0) ** 2 * 20e3 / 1.35 - 0.4**2)
    for _ in range(6 * 400):
        catenary.step(0.0, period / 400.0)
    exact = start * np.exp(-0.8 * 6.0 * period)
    assert catenary.energy() == pytest.approx(exact, rel=1e-3)  # whole periods: the ripple of alpha/omega = 4 % is in phase


def test_stiffness_proportional_damping_grows_with_the_square_of_the_frequency():
    rates = []
    for n in (2, 4):
        catenary = bare_wire("explicit", 60.0, ["damping"], **{"damping.alpha": 0.0, "damping.beta": 1e-3})
        x, N = catenary.mesh.position, catenary.mesh.mass.size
        catenary.x[:N:2] = 1e-3 * np.sin(n * np.pi * x / 60.0)
        state_rows(catenary.x, N)[2][::2] = -((n * np.pi / 60.0) ** 2) * 20e3 / 1.35 * catenary.x[:N:2]
        start = catenary.energy()
        for i in range(4000):
            catenary.step(i * 1e-3, 1e-3)
        omega2 = (n * np.pi / 60.0) ** 2 * 20e3 / 1.35
        rates.append(-np.log(catenary.energy() / start) / 4.0)
        assert rates[-1] == pytest.approx(1e-3 * omega2, rel=0.02)  # the energy ripples by beta omega = 1 to 2.5 %


def test_packed_mesh_comes_back_whole():
    catenary = Catenary(["gravity_sag", "bending_stiffness"], {"spans": 2, "first_watched_support": 0})
    catenary.initialize(0.0)
    back = unpacked(*packed(catenary.mesh))
    for name in Mesh._fields:
        assert np.array_equal(getattr(back, name), getattr(catenary.mesh, name)), name
