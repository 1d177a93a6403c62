"""The deep groove bearing against the published force law written the slow way, derivatives, frequencies of waves and defects."""

import math
import warnings

import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.film import Lubricant, film_thickness
from cosimo.components.bearings.hertz import effective_modulus, exact_ellipse
from cosimo.components.bearings.motion import DISPLACEMENT, VELOCITY
from cosimo.components.core.errors import StepFailed
from cosimo.components.core.kernels import DONE, OUT_OF_RANGE

pytestmark = pytest.mark.interpreted

LOAD = ("force_x", "force_y", "force_z", "moment_x", "moment_y")
MOTION = (*DISPLACEMENT, *VELOCITY)


def moved(effects=(), q=(0.0,) * 5, v=(0.0,) * 5, speed=0.0, **parameters):
    """A bearing at a displacement, with velocities and a speed; parameters with __ for the dot."""
    bearing = DeepGrooveBearing(effects, {n.replace("__", "."): value for n, value in parameters.items()})
    bearing.initialize(0.0)
    return at(bearing, q, v, speed)


def at(bearing, q=(0.0,) * 5, v=(0.0,) * 5, speed=0.0):
    for name, value in zip((*MOTION, "speed"), (*q, *v, speed), strict=True):
        bearing.set(name, value)
    bearing.refresh()
    return bearing


def load(bearing):
    return np.array([bearing[n] for n in LOAD])


def published_law(q, cage, clearance, film, moment_lever):
    """Force and moment on the shaft after Sopanen and Mikkola, term by term, for the default bearing; SI units."""
    d, dm, f, Z = 0.0111, 0.0535, 0.52, 9
    r_out, r_in = 0.5 * dm + 0.5 * d + 0.25 * clearance, 0.5 * dm - 0.5 * d - 0.25 * clearance
    groove = f * d
    modulus = effective_modulus(2.06e11, 0.3, 2.06e11, 0.3)
    stiffness = []
    for sign in (-1.0, 1.0):
        rx, ry = 0.5 * d * (1.0 + sign * d / dm), f * d / (2.0 * f - 1.0)
        R, e = rx * ry / (rx + ry), exact_ellipse(ry / rx)
        stiffness.append(math.pi * e.k * modulus * math.sqrt(R * e.second / (4.5 * e.first**3)))
    K = (stiffness[0] ** (-2.0 / 3.0) + stiffness[1] ** (-2.0 / 3.0)) ** -1.5
    total = np.zeros(5)
    for j in range(Z):
        beta = cage + 2.0 * math.pi * j / Z
        c, s = math.cos(beta), math.sin(beta)
        er = q[0] * c + q[1] * s
        ea = q[2] - (-q[3] * s + q[4] * c) * (r_in + groove)
        X = er + r_in + groove - r_out + groove
        phi = math.atan(ea / X)
        delta = d + film - (2.0 * groove - X / math.cos(phi))
        F = K * max(delta, 0.0) ** 1.5
        lever = r_in + (groove if moment_lever == "groove" else 0.5 * d)
        total -= F * np.array(
            [math.cos(phi) * c, math.cos(phi) * s, math.sin(phi), lever * math.sin(phi) * s, -lever * math.sin(phi) * c]
        )
    return total


@pytest.mark.parametrize(("effects", "lever"), [((), "groove"), (("published_levers",), "ball")])
@pytest.mark.parametrize("clearance", [0.0, 15e-6, -6e-6])
def test_force_and_moment_are_those_of_the_published_law(effects, lever, clearance):
    rng = np.random.default_rng(2)
    for _ in range(10):
        q, cage = rng.normal(size=5) * np.array([2e-5, 2e-5, 8e-5, 2e-3, 2e-3]), rng.uniform(0.0, 6.0)
        found = load(moved(effects, q, diametral_clearance=clearance, first_ball=cage))
        expected = published_law(q, cage, clearance, 0.0, lever)
        assert expected.any()
        # The published form takes delta as a difference of lengths near 12 mm: rounding of 1e-18 m of 1e-6 m
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


@pytest.mark.known_answers(DeepGrooveBearing="film")
def test_film_thickness_over_speed_and_what_it_does():
    """Both films together at 200 N and four speeds, um: independent numbers; the film fills the gap like larger balls."""
    q = (1e-5, 0.0, 2e-5, 0.0, 0.0)
    for rpm, thickness in ((100.0, 0.140), (1000.0, 0.654), (3000.0, 1.365), (10000.0, 3.057)):
        bearing = moved(["film"], q, speed=rpm * math.pi / 30.0, hertz="brewe-hamrock")
        film = bearing["film.inner_thickness"] + bearing["film.outer_thickness"]
        assert 1e6 * film == pytest.approx(thickness, abs=6e-4)
    exact = moved(["film"], q, speed=314.0)
    both = exact["film.inner_thickness"] + exact["film.outer_thickness"]
    np.testing.assert_allclose(load(exact), published_law(q, 0.0, 0.0, both, "groove"), rtol=1e-8, atol=1e-8 * 1e3)
    assert load(exact)[0] < load(moved((), q))[0] < 0.0  # more oil, more force


def test_film_parameters_are_those_of_the_races():
    bearing = moved(["film"], speed=100.0, film__viscosity=0.1, film__nominal_load=900.0)
    modulus = effective_modulus(2.06e11, 0.3, 2.06e11, 0.3)
    geometry = bearing.geometry
    speed = (geometry.pitch_diameter**2 - geometry.ball_diameter**2) / (4.0 * geometry.pitch_diameter) * 100.0
    for race in ("inner", "outer"):
        expected = film_thickness(geometry.contact(race, modulus), geometry.radii(race)[0], 500.0, speed, Lubricant(0.1, 2.3e-8))
        assert bearing[f"film.{race}_thickness"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.known_answers(DeepGrooveBearing="linearisation")
@pytest.mark.parametrize("effects", [(), ("published_levers",)])
def test_linearisation_is_the_tangent_and_its_intercept(effects):
    """Stiffness by differences of the outputs; force - K q - C v is the present load."""
    effects = (*effects, "linearisation", "damping")
    q = np.array([1.1e-5, -0.7e-5, 4e-5, 1e-3, -5e-4])
    v = np.array([1e-3, -2e-3, 1e-3, 0.02, 0.01])
    bearing = moved(effects, q, v, diametral_clearance=4e-6)
    K, C = (
        np.array([[bearing[f"linearisation.{n}[{5 * i + j + 1}]"] for j in range(5)] for i in range(5)])
        for n in ("stiffness", "damping")
    )
    intercept = np.array([bearing[f"linearisation.{n}"] for n in LOAD])
    scale = np.abs(intercept).max()
    np.testing.assert_allclose(intercept - K @ q - C @ v, load(bearing), rtol=0.0, atol=1e-12 * scale)
    tangent, damping = np.zeros((5, 5)), np.zeros((5, 5))
    for j, (h, dv) in enumerate(zip((1e-9, 1e-9, 1e-9, 3e-8, 3e-8), (1e-4, 1e-4, 1e-4, 1e-3, 1e-3), strict=True)):
        e = np.eye(5)[j]
        ahead, behind = (load(at(bearing, q + s * h * e)) for s in (1.0, -1.0))  # at rest: no dampers
        tangent[:, j] = -(ahead - behind) / (2.0 * h)
        ahead, behind = (load(at(bearing, q, v + s * dv * e)) for s in (1.0, -1.0))
        damping[:, j] = -(ahead - behind) / (2.0 * dv)
    at(bearing, q)
    at_rest = np.array([[bearing[f"linearisation.stiffness[{5 * i + j + 1}]"] for j in range(5)] for i in range(5)])
    units = np.sqrt(np.outer(np.diag(K), np.diag(K)))
    # 1 nm of deflections of some um: curvature of delta^1.5, (h / delta)² / 24; rounding of the load over h, 1e-13 / 1e-9 / 1e7
    np.testing.assert_allclose(tangent / units, at_rest / units, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(damping / units, C / units, rtol=0.0, atol=1e-12)
    # with velocity only the dampers' part in the turning of the contacts is added, a share of their force
    np.testing.assert_allclose(K / units, at_rest / units, rtol=0.0, atol=1e-2)


@pytest.mark.known_answers(DeepGrooveBearing="published_levers")
def test_published_levers_break_the_symmetry_by_under_one_percent():
    """Lever of the moments Ri + d/2 = 26.75 mm against Ri + f d = 26.97 mm of the tilts: 0.8 % of the coupling terms."""
    q = (1e-5, -5e-6, 4e-5, 5e-4, -3e-4)
    asymmetry = {}
    for effects in ((), ("published_levers",)):
        bearing = moved((*effects, "linearisation"), q)
        K = np.array([bearing[f"linearisation.stiffness[{i}]"] for i in range(1, 26)]).reshape(5, 5)
        units = np.sqrt(np.abs(np.outer(np.diag(K), np.diag(K))))
        asymmetry[effects] = np.abs((K - K.T) / units).max()
    assert asymmetry[()] == 0.0
    assert asymmetry["published_levers",] == pytest.approx(0.222e-3 / 26.97e-3, rel=0.3)  # times the largest coupling, below 1


def test_without_contact_the_linearisation_has_a_spring_and_the_bearing_none():
    """A search for the static position finds it in the outputs of `initialize`; what follows in a run has no spring."""
    bearing = DeepGrooveBearing(["linearisation"], {"diametral_clearance": 2e-5, "linearisation.idle_stiffness": 5e5})
    bearing.set("displacement_x", 3e-6)
    for _ in range(2):
        bearing.initialize(0.0)
        assert not load(bearing).any()
        assert bearing["linearisation.stiffness[1]"] == bearing["linearisation.stiffness[7]"] == 5e5
        assert bearing["linearisation.force_x"] == pytest.approx(5e5 * 3e-6, rel=1e-12)
        bearing.refresh()
        assert not bearing.y[bearing.output_positions([n for n in bearing.outputs if n.startswith("linearisation")])].any()
        bearing.step(0.0, 1e-4)
        assert bearing["linearisation.stiffness[1]"] == bearing["linearisation.force_x"] == 0.0


def test_a_mass_on_the_tangent_falls_freely_inside_the_clearance():
    """The midpoint rule with the tangent of each step's start, as a rotor takes it: exact for a constant force, g t^2 / 2."""
    bearing = DeepGrooveBearing(["linearisation"], {"diametral_clearance": 2e-4})
    bearing.initialize(0.0)
    bearing.step(0.0, 0.0)
    m, g, h, q, v = 4.0, 9.81, 1e-4, 0.0, 0.0
    for k in range(30):
        force, stiffness = bearing["linearisation.force_y"] - m * g, bearing["linearisation.stiffness[7]"]
        start = v
        v += h * (force - stiffness * (q + 0.5 * h * v)) / (m + 0.25 * h * h * stiffness)
        q += 0.5 * h * (start + v)
        bearing.set("displacement_y", q)
        bearing.step(k * h, h)
    assert q == pytest.approx(-0.5 * g * 3e-3**2, rel=1e-12)  # 44 um of 100


def test_what_leaves_the_model_is_told_by_refresh_and_initialize_too():
    for name, value, reason in (("displacement_x", 1e-3, "left the range"), ("displacement_y", math.nan, "not finite")):
        bearing = moved(["damping", "linearisation"], (1e-5, 0.0, 0.0, 0.0, 0.0))
        bearing.set(name, value)
        with pytest.raises(StepFailed, match=reason):
            bearing.refresh()
        with pytest.raises(StepFailed, match=reason):
            bearing.initialize(0.0)


def test_a_contact_longer_than_the_radius_of_its_ball_is_refused():
    """Long axis (6 k^2 E Q R / (pi E'))^(1/3) of the inner race: 5.55 mm at Q, so that 1.01 Q is too much, 0.99 Q is not."""
    bearing = moved(["film", "thermal_growth"])
    inner = bearing.geometry.contact("inner", effective_modulus(2.06e11, 0.3, 2.06e11, 0.3))
    k, E = inner.ellipse.k, inner.ellipse.second
    largest = (0.5 * 0.0111 / 2.0) ** 3 * math.pi * inner.modulus / (6.0 * k * k * E * inner.radius)
    K = bearing.arguments[0].contacts.stiffness
    for share in (0.99, 1.01):
        approach = (share * largest / K) ** (2.0 / 3.0)
        for name, value in (("displacement_x", approach), ("thermal_growth.clearance_change", -2.0 * approach)):
            bearing = moved(["film", "thermal_growth"])
            bearing.set(name, value)
            if share < 1.0:
                bearing.refresh()
                assert bearing["max_ball_load"] == pytest.approx(share * largest, rel=1e-9)
                continue
            with pytest.raises(StepFailed, match="left the range"):
                bearing.refresh()
            if name == "displacement_x":
                bearing.initialize(0.0)  # on the way to a static position
                assert bearing["max_ball_load"] > largest
            else:
                with pytest.raises(StepFailed, match="left the range"):
                    bearing.initialize(0.0)
            with pytest.raises(StepFailed, match="left the range"):
                bearing.step(0.0, 1e-4)
    for share, status in ((2.0, DONE), (2.1, OUT_OF_RANGE)):  # a ball on the load line carries 4.385 / 9 of it, see test_stribeck
        assert moved().equilibrium(np.array([share * largest, 0.0, 0.0, 0.0, 0.0])).status == status
    thick = DeepGrooveBearing(["film"], {"film.viscosity": 1e3})
    thick.set("speed", 3000.0)
    with pytest.raises(StepFailed, match="left the range"):
        thick.initialize(0.0)


def test_energy_is_what_the_force_takes():
    """Work along a straight path in displacement, by Simpson's rule, against the difference of energies."""
    bearing = moved((), diametral_clearance=-4e-6)
    q0, q1 = np.zeros(5), np.array([1.2e-5, -8e-6, 6e-5, 1e-3, 5e-4])
    s = np.linspace(0.0, 1.0, 401)
    power = np.array([-load(at(bearing, q0 + t * (q1 - q0))) @ (q1 - q0) for t in s])
    work = (power[0] + power[-1] + 4.0 * power[1:-1:2].sum() + 2.0 * power[2:-1:2].sum()) / 1200.0
    energies = [at(bearing, q).energy() for q in (q0, q1)]
    assert energies[0] > 0.0  # preload
    # Simpson, order 2.5 at the points where balls begin to carry: (1/400)^2.5
    assert work == pytest.approx(energies[1] - energies[0], rel=1e-6)


def test_equilibrium_balances_the_bearing_as_it_stands():
    effects = ["film", "inner_waviness", "outer_defect", "published_levers", "thermal_growth"]
    bearing = moved(effects, speed=200.0, diametral_clearance=1e-5, first_ball=0.1, outer_defect__position=-1.5)
    bearing.set("thermal_growth.clearance_change", -4e-6)
    forces = np.array([300.0, -900.0, 200.0, 2.0, -3.0])
    found = bearing.equilibrium(forces)
    assert found.status == DONE
    at(bearing, found.displacement, speed=200.0)
    np.testing.assert_allclose(load(bearing), -forces, rtol=0.0, atol=1e-6)
    assert bearing["max_ball_load"] == pytest.approx(found.ball_loads.max(), rel=1e-9)
    assert bearing["loaded_balls"] == np.count_nonzero(found.ball_loads)


@pytest.mark.known_answers(DeepGrooveBearing="thermal_growth")
def test_growth_is_a_change_of_the_diametral_clearance():
    q = (1e-5, 3e-6, 2e-5, 1e-4, 0.0)
    grown = moved(["thermal_growth"], q, diametral_clearance=1e-5)
    grown.set("thermal_growth.clearance_change", -6e-6)
    grown.refresh()
    smaller = moved((), q, diametral_clearance=4e-6)
    # the lever, 27 mm, is that of the cold bearing: 1.5 um of it, 6e-5
    np.testing.assert_allclose(load(grown), load(smaller), rtol=1e-4, atol=1e-4)


@pytest.mark.known_answers(DeepGrooveBearing="friction")
def test_friction_turns_power_into_heat():
    q = (1e-5, -2e-5, 4e-5, 0.0, 0.0)
    for speed in (100.0, -100.0, 0.0):
        bearing = moved(["friction"], q, speed=speed, friction__coefficient=0.002, friction__bore_diameter=0.04)
        resultant = np.linalg.norm(load(bearing)[:3])
        assert bearing["friction.torque"] == pytest.approx(-np.sign(speed) * 0.5 * 0.002 * 0.04 * resultant, rel=1e-12)
        assert bearing["friction.power"] == pytest.approx(-bearing["friction.torque"] * speed, abs=1e-12)


def test_angles_follow_the_integral_of_the_speed():
    """A quadratic speed is integrated exactly, in one step or in many; the cage turns by (1 - d/dm) / 2 of it."""
    one, many = moved(speed=100.0), moved(speed=100.0)
    SPEED = one.inputs.index("speed")
    one.u[1:, SPEED] = (-300.0, 5000.0)
    one.step(0.0, 0.05)
    for k in range(50):
        many.u[1:, SPEED] = (-300.0 + 2.0 * 5000.0 * 1e-3 * k, 5000.0)
        many.step(1e-3 * k, 1e-3)
    turn = 100.0 * 0.05 - 300.0 * 0.05**2 / 2.0 + 5000.0 * 0.05**3 / 3.0
    for bearing in (one, many):
        assert bearing["inner_angle"] == pytest.approx(turn, rel=1e-13)
        assert bearing["cage_angle"] == pytest.approx(0.5 * (1.0 - 11.1 / 53.5) * turn, rel=1e-13)


def spectrum(bearing, names, speed, steps=2**14, h=1e-3, window=True):
    """(orders of the shaft's turns, amplitudes (k, n)) of outputs at a fixed displacement and speed."""
    rows = np.empty((steps, len(names)))
    positions = bearing.output_positions(names)
    for k in range(steps):
        bearing.step(k * h, h)
        rows[k] = bearing.y[positions]
    rows -= rows.mean(axis=0)
    weight = np.hanning(steps)[:, None] if window else 1.0
    amplitude = np.abs(np.fft.rfft(rows * weight, axis=0)).T
    return np.fft.rfftfreq(steps, h) * 2.0 * math.pi / speed, amplitude


@pytest.mark.known_answers(DeepGrooveBearing=("inner_waviness", "outer_waviness"))
@pytest.mark.first
@pytest.mark.parametrize(
    ("race", "order", "output", "lines"),
    [
        # radial lines at i Z (fr - FTF) ± fr for order i Z ± 1 of the inner, at i Z FTF for that of the outer race (Wardle)
        ("inner", 10, "force_x", lambda ftf: 9.0 * (1.0 - ftf) + 1.0),
        ("inner", 8, "force_x", lambda ftf: 9.0 * (1.0 - ftf) - 1.0),
        ("outer", 10, "force_x", lambda ftf: 9.0 * ftf),
        ("outer", 8, "force_x", lambda ftf: 9.0 * ftf),
        # order Z: axial, where the contacts stand inclined
        ("inner", 9, "force_z", lambda ftf: 9.0 * (1.0 - ftf)),
        ("outer", 9, "force_z", lambda ftf: 9.0 * ftf),
    ],
)
def test_lines_of_waviness(race, order, output, lines):
    """A preloaded bearing, centred, so that nothing but the waves varies; order 1 of the shaft is fr."""
    speed = 60.0
    bearing = moved(
        [f"{race}_waviness"],
        (0.0, 0.0, 1e-4, 0.0, 0.0),
        speed=speed,
        diametral_clearance=-1e-5,
        **{f"{race}_waviness__order[1]": order, f"{race}_waviness__amplitude[1]": 1e-8},
    )
    orders, (amplitude,) = spectrum(bearing, [output], speed)
    ftf = bearing.geometry.cage_ratio
    # resolution of 16.4 s and 156 turns: a hundredth of an order
    assert orders[np.argmax(amplitude)] == pytest.approx(lines(ftf), abs=0.01)


@pytest.mark.full
def test_an_oval_inner_ring_is_felt_twice_a_turn_at_a_ball():
    """Low orders l of the turning ring move with it: lines at l fr in the load of the bearing as a whole, l = 2: cage beats."""
    speed = 60.0
    bearing = moved(
        ["inner_waviness"],
        (4e-6, 0.0, 0.0, 0.0, 0.0),
        speed=speed,
        diametral_clearance=-1e-5,
        **{"inner_waviness__order[1]": 2, "inner_waviness__amplitude[1]": 2e-7},
    )
    orders, (amplitude,) = spectrum(bearing, ["force_x"], speed)
    assert orders[np.argmax(amplitude)] == pytest.approx(2.0, abs=0.01)


@pytest.mark.known_answers(DeepGrooveBearing=("inner_defect", "outer_defect", "ball_defect"))
@pytest.mark.first
@pytest.mark.parametrize(("race", "key"), [("inner", "inner"), ("outer", "outer"), ("ball", "ball")])
def test_a_defect_is_met_at_its_frequency(race, key):
    """Dips of the force at a fixed displacement, counted: BPFI, BPFO, and twice BSF from one ball."""
    speed, steps, h = 40.0, 24000, 4e-4
    bearing = moved(
        [f"{race}_defect"],
        speed=speed,
        diametral_clearance=-1e-5,
        **{f"{race}_defect__depth": 1e-6, f"{race}_defect__width": 0.15, f"{race}_defect__position": 1.0},
    )
    loaded = np.empty(steps)
    for k in range(steps):
        bearing.step(k * h, h)
        loaded[k] = bearing.energy()
    dips = np.count_nonzero((loaded[1:] < 0.999 * loaded.max()) & (loaded[:-1] >= 0.999 * loaded.max()))
    frequency = bearing.geometry.defect_frequencies(speed / (2.0 * math.pi))[key] * (2.0 if race == "ball" else 1.0)
    assert dips == pytest.approx(frequency * steps * h, abs=1.0)


ALL = ("film", "damping", "inner_waviness", "outer_waviness", "linearisation", "friction", "thermal_growth")


@pytest.mark.full
@pytest.mark.parametrize("clearance", [-2e-5, -1e-6, 0.0, 1e-6, 5e-5])
@pytest.mark.parametrize("force", [0.0, 1e-6, 1.0, 1000.0, 8000.0])
def test_clearance_of_either_sign_under_any_load(clearance, force):
    """From nothing to nearly the largest load of a ball, 6.5 kN: an equilibrium, and the component gives the load back there."""
    bearing = moved(ALL, diametral_clearance=clearance, film__viscosity=0.02, speed=0.0)
    for direction in (0.0, 1.3, math.radians(20.0), -0.5 * math.pi):
        forces = force * np.array([math.cos(direction), math.sin(direction), 0.3, 0.0, 0.0])
        found = bearing.equilibrium(forces)
        assert found.status == DONE
        for name, value in zip(DISPLACEMENT, found.displacement, strict=True):
            bearing.set(name, value)
        bearing.refresh()
        assert np.isfinite(bearing.y).all()
        # 1e-10 of the load and the preload; the component and the solver place the balls by different arithmetic
        scale = force + 9.0 * found.ball_loads.max()
        np.testing.assert_allclose([bearing[n] for n in LOAD[:3]], -forces[:3], rtol=0.0, atol=1e-8 * scale + 2e-10)


@pytest.mark.full
def test_newton_with_the_tangent_settles_a_weight_in_a_bearing_with_clearance():
    """What a rotor does with the linearised bearing while it initializes: K q = intercept + weight, again and again.

    The first answer has no contact: the idle spring is what brings the shaft to the ball below. 30 sweeps are allowed.
    """
    weight = np.array([0.0, -196.0])
    for clearance in (0.0, 1e-5, 5e-5):
        bearing = moved(["linearisation"], diametral_clearance=clearance)
        q, residuals = np.zeros(2), []
        while not residuals or residuals[-1] > 1e-6:
            for name, value in zip(("displacement_x", "displacement_y"), q, strict=True):
                bearing.set(name, value)
            bearing.initialize(0.0)
            left = np.array([bearing["force_x"], bearing["force_y"]]) + weight
            residuals.append(np.abs(left).max())
            K = np.array([[bearing[f"linearisation.stiffness[{i}]"] for i in row] for row in ((1, 2), (6, 7))])
            intercept = np.array([bearing[f"linearisation.force_{n}"] for n in "xy"])
            q = np.linalg.solve(K + 1e3 * np.eye(2), intercept + weight + 1e3 * q)
            assert len(residuals) < 25, residuals


@pytest.mark.full
def test_ten_million_steps_do_not_drift():
    """The angles' sum in one compiled loop: 1e7 steps of an exactly known turn, against the product."""
    from cosimo.components.bearings.six_dof import roll

    bearing = moved(speed=314.159)
    k, u, h = bearing.arguments[0].constants, bearing.u, 1e-5

    def many(x, n):
        for _ in range(n):
            roll(h, x, u, 0.0, k, None)

    try:
        from numba import njit
    except ImportError:
        steps = 10**5
    else:
        steps, many = 10**7, njit(many)
    x = bearing.x.copy()
    many(x, steps)
    turn = 314.159 * h * steps
    for angle, ratio in zip(x, (1.0, k.cage_ratio), strict=True):
        away = (angle - ratio * turn + math.pi) % (2.0 * math.pi) - math.pi
        # each step rounds an angle below 2 pi, by 4e-16 on average without preference: sqrt(1e7) of them are 1e-12, and with
        # all the same sign 4e-9; the product of 3e4 rad itself rounds by 4e-12
        assert abs(away) < 5e-9


def warned(bearing, h, steps=1):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for k in range(steps):
            bearing.step(k * h, h)
    return [str(w.message) for w in caught]


@pytest.mark.full
@pytest.mark.parametrize(("effect", "ratio"), [("outer_defect", 0.4), ("inner_defect", 0.6), ("ball_defect", 2.3)])
def test_a_defect_narrower_than_the_step_is_refused_and_a_scarcely_resolved_one_announced(effect, ratio):
    """2 degrees at 300 rad/s. With under four steps a passage: one warning a run; with under one: no step, and what to do."""
    width = math.radians(2.0)
    parameters = {f"{effect}__width": width}
    passage = width / (300.0 * ratio)  # s, roughly
    assert warned(moved([effect], speed=300.0, **parameters), 0.2 * passage, 3) == []
    messages = warned(moved([effect], speed=300.0, **parameters), 0.6 * passage, 3)
    assert len(messages) == 1
    assert effect in messages[0]
    assert "need a macro step" in messages[0]
    for speed in (300.0, -300.0):
        bearing = moved([effect], speed=speed, **parameters)
        state = bearing.save()
        with pytest.raises(StepFailed, match=f"{effect}.*may miss it.*Reduce the macro step"):
            bearing.step(0.0, 1.3 * passage)
        assert bearing.save() == state  # nothing has moved: a smaller step may follow
        bearing.step(0.0, 0.1 * passage)


@pytest.mark.full
def test_waves_shorter_than_two_steps_are_refused():
    """They would show at a wrong frequency: 100 waves at 300 rad/s are 2800 a second, half of one passes in 0.18 ms."""
    fast = {"outer_waviness__order[1]": 100}
    assert warned(moved(["outer_waviness"], speed=300.0, **fast), 4e-5) == []
    assert len(warned(moved(["outer_waviness"], speed=300.0, **fast), 1e-4)) == 1
    with pytest.raises(StepFailed, match="order 100"):
        moved(["outer_waviness"], speed=300.0, **fast).step(0.0, 3e-4)


@pytest.mark.full
def test_at_contact_angle_zero_the_equilibrium_lies_on_the_side_of_the_force():
    """The axial stiffness is zero there: no division by it anywhere."""
    for force in (1e-6, 1.0, -1000.0):
        found = moved().equilibrium([0.0, 0.0, force, 0.0, 0.0])
        assert found.status == DONE
        assert math.copysign(1.0, found.displacement[2]) == math.copysign(1.0, force)
