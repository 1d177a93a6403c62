"""The pantograph against closed forms: equilibrium, eigenfrequencies, transmissibility, order, energy."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.pantograph import Pantograph, pantograph_derivatives
from cosimo.tests.slopes import slope
from cosimo.tests.systems.energy import energy_rate

pytestmark = pytest.mark.interpreted

ACCUMULATED_ROUNDING = 1e-9  # relative: a few thousand operations on numbers of one size


def linear_system(lower: bool, damped: bool = True):
    """Mass, damping and stiffness matrix written down from the docstring, independent of the kernels."""
    p = Pantograph(["lower_frame"] if lower else []).parameters
    m = [p["head_mass"], p["frame_mass"]]
    k = [p["contact_stiffness"], p["head_stiffness"], p["frame_stiffness"]]
    c = [0.0, p["head_damping"], p["frame_damping"]]
    if lower:
        m, k, c = [*m, p["lower_frame.mass"]], [*k, p["lower_frame.stiffness"]], [*c, p["lower_frame.damping"]]

    def chain(values):
        n = len(m)
        matrix = np.zeros((n, n))
        for i, value in enumerate(values):  # element i joins mass i-1 to mass i; the first and last go to wire and base
            d = np.zeros(n)
            d[max(i - 1, 0) : i] -= 1.0
            d[i : i + 1] += 1.0
            matrix += value * np.outer(d, d)
        return matrix

    return np.diag(m), chain(c) * damped, chain(k)


@pytest.mark.parametrize("lower", [False, True])
@pytest.mark.parametrize("wire", [-0.02, 0.0, 0.07])
def test_initial_state_is_an_equilibrium(lower, wire):
    pantograph = Pantograph(["aerodynamic_uplift", *(["lower_frame"] if lower else [])])
    pantograph.set("wire_height", wire)
    pantograph.set("wire_compliance", 4e-6)
    pantograph.initialize(0.0)
    before = pantograph.x.copy()
    for i in range(200):
        pantograph.step(i * 1e-3, 1e-3)
    assert np.abs(pantograph.x - before).max() < ACCUMULATED_ROUNDING * max(abs(wire), 0.1)


@pytest.mark.known_answers(Pantograph="lower_frame")
@pytest.mark.parametrize("lower", [False, True])
def test_eigenfrequencies_of_the_free_oscillation(lower):
    M, _, K = linear_system(lower, damped=False)
    undamped = {"head_damping": 0.0, "frame_damping": 0.0, "static_force": 0.0, "substep": 1e-4}
    pantograph = Pantograph(["lower_frame"] if lower else [], undamped | ({"lower_frame.damping": 0.0} if lower else {}))
    pantograph.initialize(0.0)
    squares, shapes = np.linalg.eig(np.linalg.solve(M, K))
    for omega, shape in zip(np.sqrt(squares.real), shapes.T, strict=True):
        pantograph.initialize(0.0)
        pantograph.x[::2] = shape
        quarter = 0.5 * np.pi / omega  # a mode shape at rest passes zero after a quarter of its period
        pantograph.step(0.0, quarter)
        assert np.abs(pantograph.x[::2]).max() < 1e-6  # RK4's phase error at omega h <= 0.012 is below 1e-10 per radian
        assert np.abs(pantograph.x[1::2]).max() == pytest.approx(omega * np.abs(shape).max(), rel=1e-6)


@pytest.mark.known_answers(Pantograph="base_excitation")
@pytest.mark.full
def test_transmissibility_of_the_base():
    """Steady oscillation under a shaken base, contact spring bilateral: amplitude and phase of the head."""
    M, C, K = linear_system(lower=False)
    p = Pantograph().parameters
    omega = 2.0 * np.pi * 3.0
    load = np.array([0.0, p["frame_stiffness"] + 1j * omega * p["frame_damping"]])
    exact = np.linalg.solve(K + 1j * omega * C - omega**2 * M, load)[0]
    pantograph = Pantograph(["base_excitation"], {"static_force": 0.0})
    pantograph.initialize(0.0)
    h, response = 1e-3, []
    for i in range(20_000):
        t = i * h  # the base's exact quadratic over the step is close enough: omega h = 0.019
        for name, values in (
            ("base_excitation.height", (np.sin(omega * t), omega * np.cos(omega * t), -0.5 * omega**2 * np.sin(omega * t))),
            (
                "base_excitation.velocity",
                (omega * np.cos(omega * t), -(omega**2) * np.sin(omega * t), -0.5 * omega**3 * np.cos(omega * t)),
            ),
        ):
            pantograph.u[:, pantograph.input_positions([name])[0]] = values
        pantograph.step(t, h)
        response.append(pantograph["head_height"])
    last = np.array(response[-1000:])  # three periods
    time = (np.arange(20_000)[-1000:] + 1) * h
    measured = 2.0 * np.mean(last * np.exp(-1j * omega * time)) * 1j
    assert abs(measured - exact) < 1e-4 * abs(exact)  # the start has decayed by e^-30 in 20 s; step error 1e-5


def test_order_of_the_integrator_is_four():
    def state(n):
        pantograph = Pantograph(parameters={"substep": 0.1 / n})
        pantograph.initialize(0.0)
        pantograph.x[0] += 0.01
        pantograph.step(0.0, 0.1)
        return pantograph.x.copy()

    n = np.array([80, 160, 320])
    exact = state(2000)
    errors = [np.abs(state(k) - exact).max() for k in n]
    assert abs(slope(1.0 / n, errors) - 4.0) < 0.15


@pytest.mark.parametrize("strips", [(), ("two_strips",)])
def test_energy_balance_at_random_states(strips):
    """dE/dt = work of the static force - dissipation, as an identity of the derivatives, contact unilateral, stops engaged."""
    pantograph = Pantograph(["contact_loss", "lower_frame", "bump_stops", *strips], {"bump_stops.travel": 0.005})
    pantograph.initialize(0.0)
    rng = np.random.default_rng(3)
    _, p, e = pantograph.arguments
    for _ in range(50):
        x = pantograph.x
        x[:] = rng.normal(scale=[0.05, 0.5] * (x.size // 2))
        rate, _ = energy_rate(pantograph, pantograph_derivatives, 1e-7)
        dissipated = p.head_damping * (x[3] - x[1]) ** 2 + p.frame_damping * (x[5] - x[3]) ** 2
        dissipated += e.lower_frame.damping * x[5] ** 2
        if strips:
            pitching = 0.29 * x[11]  # 20 N.s/m at each of two strips 0.58 m apart, 1 N.m.s/rad
            dissipated += 20.0 * ((x[1] + pitching - x[7]) ** 2 + (x[1] - pitching - x[9]) ** 2) + 1.0 * x[11] ** 2
        # central differences of a piecewise quadratic energy, J, which rounding changes by 1e-14
        assert rate == pytest.approx(p.static_force * x[5] - dissipated, rel=1e-6, abs=1e-5)


def test_contact_springs_in_series():
    """A wire that is soft at the contact point: force over approach is 1 / (1/kc + c)."""
    pantograph = Pantograph()
    pantograph.set("wire_compliance", 1e-5)
    pantograph.initialize(0.0)
    approach = pantograph["head_height"]
    assert pantograph["contact_force"] == pytest.approx(approach / (1.0 / 50e3 + 1e-5), rel=ACCUMULATED_ROUNDING)


@pytest.mark.known_answers(Pantograph="outer_contact")
def test_outer_contact_gives_the_motion_of_the_inner_one():
    """Fed with the force of its own spring at the end of each short step, held: the difference falls with the step."""

    def distance(h):
        own, fed = Pantograph(), Pantograph(["outer_contact"])
        for pantograph in (own, fed):
            pantograph.initialize(0.0)
            pantograph.x[0] += 1e-4
        for i in range(round(0.05 / h)):
            force = 50e3 * fed.x[0]
            fed.set("outer_contact.force", -force)
            fed.refresh()
            assert fed["contact_force"] == force
            own.step(i * h, h)
            fed.step(i * h, h)
        return abs(own["head_height"] - fed["head_height"])

    distances = [distance(h) for h in (4e-4, 2e-4, 1e-4)]
    assert abs(slope([4.0, 2.0, 1.0], distances) - 1.0) < 0.15


@pytest.mark.known_answers(Pantograph="aerodynamic_uplift")
def test_lift_grows_with_the_square_of_the_speed():
    def force(speed):
        pantograph = Pantograph(["aerodynamic_uplift"], {"speed": speed, "frame_stiffness": 0.0})
        pantograph.initialize(0.0)
        return pantograph["contact_force"]

    assert force(80.0) - 120.0 == pytest.approx(4.0 * (force(40.0) - 120.0), rel=ACCUMULATED_ROUNDING)
    assert force(80.0) - 120.0 == pytest.approx(0.01301 * 80.0**2, rel=ACCUMULATED_ROUNDING)


@pytest.mark.known_answers(Pantograph="frame_friction")
def test_frame_friction_holds_against_a_small_change_of_force():
    """Coulomb friction of 5 N: after 4 N more from the wire the smoothed law only creeps, at v = width * atanh(F/level)."""
    dry = Pantograph(["frame_friction"], {"frame_stiffness": 0.0, "frame_damping": 0.0, "static_force": 124.0})
    dry.initialize(0.0)
    # the wire yields at the creep speed that the smoothed law needs for 4 N, so that the whole pantograph moves steadily
    speed = 0.01 * np.arctanh(4.0 / 5.0)
    for i in range(12_000):
        dry.u[1, 0] = speed
        dry.step(i * 1e-3, 1e-3)
    assert dry["contact_force"] == pytest.approx(120.0, rel=1e-3)  # the head's oscillation has decayed by e^-8


def test_presets_have_a_source_and_a_provenance():
    for name, preset in Pantograph.presets.items():
        assert preset.source, name
        assert preset.provenance in ("verbatim", "unconfirmed", "inferred", "computed")
        pantograph = Pantograph(preset=name)
        pantograph.initialize(0.0)
        assert np.isfinite(pantograph.y).all()


def test_contact_is_lost_and_regained():
    """The wire drops... upwards, out of reach for 0.3 s, and returns: a free flight between two contacts."""
    h = 1e-3
    pantograph = Pantograph(
        ["contact_loss"], {"substep": 1e-4, "frame_stiffness": 0.0, "frame_damping": 0.0, "head_damping": 0.0}
    )
    pantograph.initialize(0.0)
    p = pantograph.parameters
    mass = np.array([p["head_mass"], p["frame_mass"]])
    force, momentum = [], []
    for k in range(1000):
        t = k * h
        pantograph.set("wire_height", 1.0 if 0.2 <= t < 0.5 else 0.0)
        pantograph.step(t, h)
        force.append(pantograph["contact_force"])
        momentum.append(mass @ pantograph.x[[1, 3]])
    force, momentum = np.array(force), np.array(momentum)
    assert np.isfinite(force).all()
    assert force.min() == 0.0  # a wire cannot pull
    apart = slice(200, 500)
    assert not force[apart].any()  # exactly nothing while apart
    # Only the static force acts then: momentum grows by F0 t, to rounding of 3000 internal steps (1e-16 each, of 36 N.s).
    gained = momentum[apart] - momentum[200]
    np.testing.assert_allclose(gained, p["static_force"] * h * np.arange(300), rtol=0.0, atol=1e-10)
    assert force[500] > 1e3  # N; the head has flown 0.2 m past the wire's place and is driven into it
    assert (np.diff(np.sign(force)) != 0).sum() >= 3  # and it bounces


@pytest.mark.parametrize(
    "changed",
    [{"head_mass": m} for m in (1e-6, 1e-5, 1e-4, 1e-3)] + [{"contact_stiffness": k} for k in (1e7, 1e9, 1e12)],
    ids=str,
)
def test_stiff_pantographs_are_refused_or_stable(changed):
    """What is stable is said by `stable_step`: above it the default substep is refused, at it the run stays at rest."""
    # The highest frequency is that of the head between contact spring and head spring; RK4 is trusted up to 2.61 over it.
    stiff = Pantograph(["contact_loss"], changed)
    omega = np.sqrt((stiff["contact_stiffness"] + stiff["head_stiffness"]) / stiff["head_mass"])
    limit = stiff.stable_step()
    # Damping and frame shift the eigenvalue: by c / (2 m omega) or less, most for the lightest head.
    shift = stiff["head_damping"] / (stiff["head_mass"] * omega)
    assert 1.0 / (1.0 + shift) < limit * omega / 2.61 < 1.02
    if limit < stiff["substep"]:
        with pytest.raises(BadInput, match="substep"):
            stiff.initialize(0.0)
    stiff.set("substep", min(limit, stiff["substep"]))
    stiff.initialize(0.0)
    rest = stiff.x.copy()
    push = 0.5 * stiff["static_force"] / stiff["contact_stiffness"]  # m; takes half of the contact force away
    stiff.x[0] -= push
    for k in range(5):
        stiff.step(k * 1e-3, 1e-3)
    assert np.isfinite(stiff.x).all()
    # A stable step keeps the push or damps it, an unstable one multiplies it. The frame, 15 kg, hardly moves in 5 ms.
    assert abs(stiff.x[0] - rest[0]) <= 1.1 * push
    assert abs(stiff.x[2] - rest[2]) <= 0.1 * push + 1e-15
