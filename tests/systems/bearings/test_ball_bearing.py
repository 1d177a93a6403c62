"""Ball bearing with two degrees of freedom: against its equations written the slow way, closed forms, and its own scaling."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.dimensionless import DimensionlessBallBearing, dimensionless, scales
from cosimo.components.bearings.two_dof import bearing_derivatives, elastic_force
from cosimo.components.core.errors import BadInput
from cosimo.tests.slopes import slope
from cosimo.tests.support import RPM, ball_bearing
from cosimo.tests.systems.energy import energy_rate

pytestmark = pytest.mark.interpreted

MICRO = 1e-6
ALL = (
    "clearance",
    "contact_damping",
    "unbalance",
    "inner_waviness",
    "outer_waviness",
    "inner_defect",
    "outer_defect",
    "ball_defect",
    "cage_fault",
    "load_variation",
    "speed_ramp",
)
ORDERS = {"order": (2, 7, 9), "amplitude": (1e-6, 0.4e-6, 0.2e-6), "phase": (0.3, -1.0, 2.0)}
WAVES = {
    f"{ring}_waviness.{name}[{i + 1}]": v
    for ring in ("inner", "outer")
    for name, values in ORDERS.items()
    for i, v in enumerate(values)
}
DEFECTS = {
    "inner_defect.width": 0.5,
    "outer_defect.width": 0.6,
    "inner_defect.position": 1.0,
    "ball_defect.width": 0.7,
    "ball_defect.ball": 3,
}


def with_clearance(micrometres, rpm=1000.0, **parameters):
    return ball_bearing(["clearance"], {"clearance.radial_clearance": micrometres * MICRO, **parameters}, rpm)


def run(bearing, duration, h=1e-3):
    """Outputs at the end of every step, (n, k)."""
    rows = []
    for k in range(round(duration / h)):
        bearing.step(k * h, h)
        rows.append(bearing.y.copy())
    return np.array(rows)


def slow_derivatives(bearing, t, x):
    """The equations of the module's docstring with one sine and cosine a ball, and the gaps differentiated numerically."""
    p, on = bearing.parameters, bearing.on
    gamma = p["ball_diameter"] / p["pitch_diameter"]
    ramp = p["speed_ramp.acceleration"] if "speed_ramp" in on else 0.0
    w = bearing["speed"] + ramp * t
    cage, spin = 0.5 * (1.0 - gamma) * w, 0.5 / gamma * (1.0 - gamma**2) * w

    def profile(s, effect):
        s = (s - p[f"{effect}.position"] + math.pi) % (2.0 * math.pi) - math.pi
        half = 0.5 * p[f"{effect}.width"]
        return 0.5 * p[f"{effect}.depth"] * (1.0 + math.cos(math.pi * s / half)) if abs(s) < half else 0.0

    def place(j):
        ahead = p["cage_fault.offset"] if "cage_fault" in on and j == p["cage_fault.ball"] - 1 else 0.0
        return x[5] + 2.0 * math.pi * j / p["balls"] + ahead

    def gap(j, dt):
        at, inner = place(j) + cage * dt, x[4] + w * dt
        total = p["clearance.radial_clearance"] if "clearance" in on else 0.0
        for ring, angle in (("inner", at - inner), ("outer", at)):
            if f"{ring}_waviness" in on:
                total += sum(
                    p[f"{ring}_waviness.amplitude[{i}]"]
                    * math.cos(p[f"{ring}_waviness.order[{i}]"] * angle + p[f"{ring}_waviness.phase[{i}]"])
                    for i in range(1, 9)
                )
            if f"{ring}_defect" in on:
                total += profile(angle, f"{ring}_defect")
        if "ball_defect" in on and j == p["ball_defect.ball"] - 1:
            total += profile(x[6] + spin * dt, "ball_defect") + profile(x[6] + spin * dt + math.pi, "ball_defect")
        return total

    def approach(j, dt):
        at = place(j) + cage * dt
        return (x[0] + x[2] * dt) * math.cos(at) + (x[1] + x[3] * dt) * math.sin(at) - gap(j, dt)

    fx = bearing["load"] - p["damping"] * x[2]
    fy = bearing["transverse_load"] - p["damping"] * x[3]
    for j in range(p["balls"]):
        delta = approach(j, 0.0)
        if delta > 0.0:
            q = p["contact_stiffness"] * delta**1.5
            if "contact_damping" in on:
                q *= 1.0 + 1.5 * p["contact_damping.coefficient"] * (approach(j, 1e-7) - approach(j, -1e-7)) / 2e-7
            at = place(j)
            fx, fy = fx - max(q, 0.0) * math.cos(at), fy - max(q, 0.0) * math.sin(at)
    if "unbalance" in on:
        a, e = x[4] + p["unbalance.phase"], p["mass"] * p["unbalance.eccentricity"]
        fx, fy = fx + e * (w**2 * math.cos(a) + ramp * math.sin(a)), fy + e * (w**2 * math.sin(a) - ramp * math.cos(a))
    if "load_variation" in on:
        fx += p["load_variation.amplitude"] * math.sin(2.0 * math.pi * p["load_variation.frequency"] * t)
    return np.array([x[2], x[3], fx / p["mass"], fy / p["mass"], w, cage, spin][: x.size])


@pytest.mark.known_answers(
    BallBearing=(
        "clearance",
        "contact_damping",
        "unbalance",
        "inner_defect",
        "outer_defect",
        "ball_defect",
        "cage_fault",
        "load_variation",
        "speed_ramp",
    )
)
@pytest.mark.parametrize("effects", [(), ALL], ids=["none", "all"])
def test_the_equations_are_those_of_the_docstring(effects):
    parameters = WAVES | DEFECTS | {"unbalance.phase": 0.4, "contact_damping.coefficient": 2.0}
    given = {n: v for n, v in parameters.items() if n.partition(".")[0] in effects}
    bearing = ball_bearing(effects, given, transverse_load=30.0)
    rng, dx = np.random.default_rng(5), np.empty(bearing.x.size)
    for _ in range(200):
        x = np.concatenate((rng.normal(size=2) * 2e-5, rng.normal(size=2) * 0.05, rng.uniform(0.0, 6.28, bearing.x.size - 4)))
        bearing_derivatives(0.3, x, bearing.u[0], dx, *bearing.arguments)
        # rounding of angles of some rad, 1e-15, times 2e-5 m, over the deformation; with damping the difference quotient,
        # (w 1e-7)² / 6 of a third derivative of order 10³ of the gap
        np.testing.assert_allclose(dx, slow_derivatives(bearing, 0.3, x), rtol=1e-6 if effects else 1e-10, atol=1e-6)


@pytest.mark.known_answers(
    DimensionlessBallBearing=(
        "clearance",
        "contact_damping",
        "unbalance",
        "inner_defect",
        "outer_defect",
        "ball_defect",
        "cage_fault",
        "load_variation",
        "speed_ramp",
        "inner_waviness",
        "outer_waviness",
    )
)
@pytest.mark.first
@pytest.mark.parametrize("effects", [(), ("clearance",), ALL], ids=["none", "clearance", "all"])
def test_dimensional_and_dimensionless_are_the_same_trajectory(effects):
    given = {n: v for n, v in (WAVES | DEFECTS).items() if n.partition(".")[0] in effects}
    bearing = ball_bearing(effects, given, transverse_load=10.0)
    other, by = dimensionless(bearing)
    other.initialize(0.0)
    scaled = other.arguments[0].constants
    assert (scaled.mass, scaled.damping, scaled.stiffness) == pytest.approx(
        (1.0, bearing["damping"] / (bearing["mass"] / by.time), 1.0), rel=1e-14
    )
    largest = np.zeros(bearing.y.size)
    worst = np.zeros(bearing.y.size)
    scale = np.array([by.of(bearing.variables[n].unit) for n in bearing.outputs])
    for k in range(100):
        bearing.step(k * 1e-3, 1e-3)
        other.step(k * 1e-3 / by.time, 1e-3 / by.time)
        worst = np.maximum(worst, np.abs(other.y * scale - bearing.y))
        largest = np.maximum(largest, np.abs(bearing.y))
    assert other.work["steps"] == bearing.work["steps"] == 2000
    # 8000 evaluations with roundings of 1e-16 each, not damped within 0.1 s, and forces that are 1.5 times as sensitive
    np.testing.assert_array_less(worst, 1e-11 * largest + 1e-300)


def test_scales_of_the_published_set():
    """JIS 6306 with 196 N: x_s = 5.99883 um, w_0 = 1278.1435 rad/s, zeta = 0.0039119, computed independently."""
    bearing = BallBearing(preset="JIS 6306")
    by = scales(bearing)
    other, _ = dimensionless(bearing)
    assert by.length == pytest.approx(5.99883e-6, rel=1e-6)  # six printed digits
    assert 1.0 / by.time == pytest.approx(1278.1435, rel=1e-7)
    assert other["damping_ratio"] == pytest.approx(0.0039119, rel=1e-5)
    assert (by.of("N"), by.of("rad"), by.of("Hz")) == pytest.approx((196.0, 1.0, 1278.1435), rel=1e-7)
    assert bearing.geometry.defect_frequencies(1.0)["outer"] == pytest.approx(3.08462, rel=2e-6)  # literature: 3.08
    bearing.set("load", 0.0)
    with pytest.raises(BadInput, match="load to scale by"):
        scales(bearing)


@pytest.mark.known_answers(DimensionlessBallBearing="given_start")
def test_defaults_of_the_dimensionless_bearing_are_the_scaled_ones():
    effects = (*ALL, "given_start")
    scaled, _ = dimensionless(BallBearing(effects))
    own = DimensionlessBallBearing(effects)
    found = {n: own[n] for n in (*own.parameters, *own.inputs)}
    assert found == pytest.approx({n: scaled[n] for n in found}, rel=5e-4)  # four digits are written there


@pytest.mark.parametrize(("cage", "expected"), [(0.0, 3.9937e-6), (math.pi / 8.0, 4.0213e-6)])
def test_static_deflection_without_clearance(cage, expected):
    bearing = ball_bearing(parameters={"start_cage_angle": cage})
    assert bearing["displacement_x"] == pytest.approx(expected, rel=2e-5)  # five printed digits
    assert bearing["displacement_y"] == pytest.approx(0.0, abs=1e-18)
    assert bearing["force_x"] == pytest.approx(-196.0, rel=1e-12)  # on the shaft, against a load along +x
    # a continuum of balls: (W / (Z K Jr))^(2/3) with Sjövall's integral 0.22883 lies between the two
    assert bearing["displacement_x"] == pytest.approx((196.0 / (8.0 * 1.334e10 * 0.22883)) ** (2.0 / 3.0), rel=4e-3)


def test_radial_clearance_is_half_the_diametral_one():
    """The commonest mistake: a diametral clearance of 20 um in one model is a radial gap of 10 um in the other."""
    other = DeepGrooveBearing((), {"diametral_clearance": 20e-6})
    other.initialize(0.0)
    ours = {"balls": 9, "contact_stiffness": other.arguments[0].contacts.stiffness}
    radial = with_clearance(10.0, **ours)
    # the other one's balls stand at the same angles; held in the plane, its contact lines do not turn out of it
    diametral = other.equilibrium(np.array([196.0, 0.0, 0.0, 0.0, 0.0]), held=("z", "tilt_x", "tilt_y"))
    assert diametral.displacement[0] == pytest.approx(radial["displacement_x"], rel=1e-9)


def test_one_ball_under_the_load_stands_at_its_gap_and_its_deformation():
    bearing = with_clearance(20.0)
    assert bearing["loaded_balls"] == 1.0
    assert bearing["displacement_x"] == pytest.approx(20e-6 + (196.0 / 1.334e10) ** (2.0 / 3.0), rel=1e-12)


@pytest.mark.parametrize(("cage", "along", "across"), [(0.0, 305.3, 206.4), (math.pi / 8.0, 304.3, 260.7)])
def test_linearised_frequencies_without_clearance(cage, along, across):
    bearing = ball_bearing(parameters={"start_cage_angle": cage})
    _, _, kxx, _, kyy = elastic_force(bearing.x, bearing.arguments[0])
    found = [math.sqrt(k / bearing["mass"]) / (2.0 * math.pi) for k in (kxx, kyy)]
    assert found == pytest.approx((along, across), rel=2e-4)  # four printed digits


def test_stiffness_across_the_load_with_clearance():
    """Nothing at all with a ball on the line of the load, which carries alone; 1.17e7 N/m between two balls (20 um)."""
    assert elastic_force(with_clearance(20.0).x, with_clearance(20.0).arguments[0])[4] == 0.0
    between = with_clearance(20.0, start_cage_angle=math.pi / 8.0)
    assert elastic_force(between.x, between.arguments[0])[4] == pytest.approx(1.17e7, rel=5e-3)  # three printed digits


@pytest.mark.parametrize("offset", [0.1, -0.3])
def test_a_broken_cage_brings_up_its_own_frequency(offset):
    """At rest under the load, over a turn of the cage: with balls at equal distances there are only multiples of their number,
    with one ball out of its place all. Either position balances loads that are summed here ball by ball."""
    turn = np.linspace(0.0, 2.0 * math.pi, 32, endpoint=False)

    def lines(effects, given):
        found = []
        for angle in turn:
            parameters = {"clearance.radial_clearance": 2e-6, "start_cage_angle": angle}
            bearing = ball_bearing(["clearance", *effects], parameters | given)
            at = angle + 2.0 * math.pi * np.arange(8) / 8.0
            at[1] += given.get("cage_fault.offset", 0.0)
            delta = bearing["displacement_x"] * np.cos(at) + bearing["displacement_y"] * np.sin(at) - 2e-6
            loads = 1.334e10 * np.maximum(delta, 0.0) ** 1.5
            assert (loads @ np.cos(at), loads @ np.sin(at)) == pytest.approx((196.0, 0.0), abs=1e-9)
            found.append(bearing["displacement_x"])
        return np.abs(np.fft.rfft(found))[1:9] / 32.0

    even, broken = lines((), {}), lines(("cage_fault",), {"cage_fault.offset": offset})
    assert even[:7].max() < 1e-17
    assert even[7] > 1e-9
    assert broken[:3].min() > 1e-9  # the cage's own frequency and its multiples


def test_energy_changes_by_the_power_of_load_and_damping():
    """dE/dt = W v_x - c v² at random states of a bearing that does not turn: no integration, so nothing to excuse."""
    bearing = ball_bearing(["clearance"], rpm=0.0)
    rng = np.random.default_rng(3)
    for _ in range(50):
        bearing.x[:4] = np.concatenate((rng.normal(size=2) * 2e-5, rng.normal(size=2) * 0.01))
        _, _, *v = bearing.x[:4]
        power = 196.0 * v[0] - 200.0 * (v[0] ** 2 + v[1] ** 2)
        # central differences over 1e-9 m of 1.5e-5 m: 1e-8 relative; rounding 1e-16 E / 1e-9 m * v = 1e-9 W
        assert energy_rate(bearing, bearing_derivatives, 1e-7)[0] == pytest.approx(power, rel=1e-5, abs=1e-5)


def test_order_of_convergence():
    """Fourth order where no contact opens or closes: preload keeps all balls in contact."""

    def end(substep):
        bearing = with_clearance(-10.0, rpm=3000.0, substep=substep)
        bearing.set("load", 400.0)  # away from the equilibrium of the start
        bearing.step(0.0, 8e-3)
        return bearing.x[:4] / (1e-6, 1e-6, 1e-3, 1e-3)

    exact = end(1e-6)
    steps = np.array([2e-4, 1e-4, 5e-5, 2.5e-5])
    errors = [np.abs(end(h) - exact).max() for h in steps]
    assert slope(steps, errors) == pytest.approx(4.0, abs=0.15)


@pytest.mark.known_answers(BallBearing="given_start")
@pytest.mark.full
def test_restitution_of_the_contact_damping():
    """Hunt and Crossley chose their law so that a slow impact at speed v returns with 1 - k v of it."""
    k, v = 0.2, 0.05
    bearing = ball_bearing(
        ["clearance", "contact_damping", "given_start"],
        {
            "balls": 1,
            "damping": 0.0,
            "clearance.radial_clearance": 50e-6,
            "contact_damping.coefficient": k,
            "substep": 1e-6,
            "given_start.velocity_x": v,
        },
        rpm=0.0,
        load=0.0,
    )
    run(bearing, 0.01)
    assert bearing["loaded_balls"] == 0.0
    assert bearing["velocity_x"] / -v == pytest.approx(1.0 - k * v, abs=(k * v) ** 2)  # next order


@pytest.mark.full
def test_contacts_with_strong_damping_never_pull():
    bearing = ball_bearing(["clearance", "contact_damping"], {"contact_damping.coefficient": 1e4, "substep": 2e-7})
    loads = run(bearing, 0.02, 1e-5)[:, bearing.outputs.index("max_ball_load")]
    assert loads.min() >= 0.0
    assert loads.max() > 0.0


ALONE = {"balls": 1, "damping": 0.0, "clearance.radial_clearance": 50e-6, "contact_damping.coefficient": 2.0}


@pytest.mark.parametrize(("velocity", "factor"), [(-0.1, 0.7), (-1.0 / 3.0 + 1e-3, 3e-3), (-1.0 / 3.0 - 1e-3, 0.0), (-10.0, 0.0)])
def test_a_contact_that_opens_fast_carries_nothing(velocity, factor):
    """1 + 1.5 k v is negative below v = -1/3 m/s: the spring recovers more slowly than the bodies part."""
    start = {"given_start.x": 60e-6, "given_start.velocity_x": velocity, "substep": 1e-8}
    bearing = ball_bearing(["clearance", "contact_damping", "given_start"], ALONE | start, rpm=0.0, load=0.0)
    assert bearing["loaded_balls"] == 1.0
    expected = 1.334e10 * 10e-6**1.5 * factor
    assert bearing["max_ball_load"] == pytest.approx(expected, rel=1e-10, abs=0.0)  # 60 - 50 um, and 1 - 0.997: rounding
    assert bearing["force_x"] == pytest.approx(-expected, rel=1e-10, abs=0.0)
    assert bearing["acceleration_x"] == pytest.approx(-expected / bearing["mass"], rel=1e-10, abs=0.0)


def test_no_pull_while_a_load_tears_a_contact_open():
    """A free rebound never reaches v = -1/(1.5 k); a load of -20 kN does, within the contact."""
    start = {"given_start.x": 150e-6, "substep": 1e-7}
    bearing = ball_bearing(["clearance", "contact_damping", "given_start"], ALONE | start, rpm=0.0, load=-2e4)
    rows = run(bearing, 1e-3, 1e-6)
    force, loaded, x = (rows[:, bearing.outputs.index(n)] for n in ("force_x", "loaded_balls", "displacement_x"))
    assert (force <= 0.0).all()  # on the shaft, away from the ball
    assert force.min() < -1e3
    assert ((force == 0.0) & (loaded == 1.0)).sum() > 10  # still in contact, already torn open
    assert x[-1] < 50e-6


@pytest.mark.full
def test_angles_follow_a_ramp():
    ramp = {"speed_ramp.acceleration": 50.0, "speed_ramp.duration": 0.2}
    bearing = ball_bearing(["speed_ramp"], ramp, rpm=0.0)
    run(bearing, 0.5)
    turned = 0.5 * 50.0 * 0.2**2 + 10.0 * 0.3
    assert bearing["inner_angle"] == pytest.approx(turned % (2.0 * math.pi), rel=1e-12)  # roundings of 10^4 steps
    assert bearing["cage_angle"] == pytest.approx(0.5 * (1.0 - 11.9 / 52.0) * turned, rel=1e-12)


def test_a_slope_of_the_speed_is_a_ramp():
    """The angle comes from the input's polynomial, not from its value at the start of a step."""
    bearing = ball_bearing(rpm=0.0)
    bearing.u[:, bearing.inputs.index("speed")] = 3.0, 50.0, -20.0
    bearing.step(0.0, 0.1)
    assert bearing["inner_angle"] == pytest.approx(3.0 * 0.1 + 25.0 * 0.01 - 20.0 * 1e-3 / 3.0, rel=1e-13)  # integral of it


@pytest.mark.full
def test_a_slope_of_the_speed_drives_an_unbalance_like_a_ramp():
    """The same speed as a ramp and as an input, in steps that begin at other times than 0; w' is about w² here."""
    heavy = {"unbalance.eccentricity": 1e-3, "damping": 3e3}
    ramp = ball_bearing(["unbalance", "speed_ramp"], heavy | {"speed_ramp.acceleration": 500.0, "speed_ramp.duration": 1.0}, 0.0)
    sloped = ball_bearing(["unbalance"], heavy, 0.0)
    at = sloped.inputs.index("speed")
    for k in range(50):
        sloped.u[1, at] = 500.0
        for bearing in (ramp, sloped):
            bearing.step(k * 1e-3, 1e-3)
        # sums of 20 roundings a step in the speed, 1e-16 each, and 1e-13 of the stiff balance
        np.testing.assert_allclose(sloped.x[:4], ramp.x[:4], rtol=1e-9, atol=1e-14)
    refreshed = sloped.y.copy()
    sloped.refresh()
    assert refreshed.tobytes() == sloped.y.tobytes()  # the slope is used up at the end of the step, in the outputs as well


@pytest.mark.full
def test_a_curved_speed_drives_an_unbalance():
    """Free of contact: m x'' = m e (w² cos a + w' sin a) is x = -e cos a, whatever the speed, for x + e cos a moves evenly."""
    free = {
        "balls": 1,
        "clearance.radial_clearance": 1.0,
        "unbalance.eccentricity": 1e-3,
        "damping": 0.0,
        "substep": 1e-5,
        "given_start.x": -1e-3,
        "given_start.velocity_y": -3e-3,
    }
    bearing = ball_bearing(["clearance", "unbalance", "given_start"], free, rpm=0.0, load=0.0)
    speed, t = (3.0, 50.0, 4000.0), 0.0
    for _ in range(20):
        w, slope, half = speed[0] + t * (speed[1] + t * speed[2]), speed[1] + 2.0 * t * speed[2], speed[2]
        bearing.u[:, bearing.inputs.index("speed")] = w, slope, half
        bearing.step(t, 5e-3)
        t += 5e-3
    angle = 3.0 * t + 25.0 * t**2 + 4000.0 / 3.0 * t**3
    # RK4 with w h = 5e-4 at most: (w h)^4 / 120 a radian
    assert bearing["displacement_x"] == pytest.approx(-1e-3 * math.cos(angle), abs=1e-12)
    assert bearing["displacement_y"] == pytest.approx(-1e-3 * math.sin(angle), abs=1e-12)


def test_a_heavy_unbalance_drives_a_stiff_bearing_in_its_own_rhythm():
    """Preload makes the bearing nearly linear: the orbit is the circle m e w² / (k - m w²), by the linearised stiffness."""
    bearing = ball_bearing(
        ["clearance", "unbalance"],
        {"clearance.radial_clearance": -20e-6, "unbalance.eccentricity": 1e-6, "damping": 3e4},
        rpm=3000.0,
        load=0.0,
    )
    _, _, kxx, kxy, kyy = elastic_force(bearing.x, bearing.arguments[0])
    assert (kxy, kyy) == pytest.approx((0.0, kxx), abs=1e-9 * kxx)
    w = 3000.0 * RPM
    run(bearing, 0.2)
    rows = run(bearing, 0.02, 1e-4)
    radius = np.hypot(rows[:, 0], rows[:, 1])
    k, m, c = kxx, bearing["mass"], bearing["damping"]
    expected = m * 1e-6 * w**2 / math.hypot(k - m * w**2, c * w)
    # the curvature of the contact's law: (radius / preload)² / 24 is far below a permille at 1 % of the preload
    np.testing.assert_allclose(radius, expected, rtol=1e-3)


@pytest.mark.known_answers(BallBearing=("inner_waviness", "outer_waviness"))
@pytest.mark.full
@pytest.mark.parametrize(
    ("ring", "order", "line"),
    [
        ("outer", 7, "Z FTF"), ("outer", 9, "Z FTF"),
        ("inner", 9, "Z (fr - FTF) + fr"), ("inner", 7, "Z (fr - FTF) - fr"), ("inner", 1, "fr"),
    ],
)  # fmt: skip
def test_waves_of_a_race_shake_the_shaft_at_the_known_lines(ring, order, line):
    """Wardle's rule: radial motion comes from orders i Z ± 1; preload makes the bearing so linear that no other line shows."""
    bearing = ball_bearing(
        ["clearance", f"{ring}_waviness"],
        {
            "clearance.radial_clearance": -20e-6,
            "damping": 2e4,
            f"{ring}_waviness.order[1]": order,
            f"{ring}_waviness.amplitude[1]": 1e-8,
        },
        rpm=1800.0,
        load=0.0,
    )
    fr = 30.0
    ftf = 0.5 * fr * (1.0 - 11.9 / 52.0)
    passing = 8 * (fr - ftf)
    expected = {"Z FTF": 8 * ftf, "Z (fr - FTF) + fr": passing + fr, "Z (fr - FTF) - fr": passing - fr, "fr": fr}[line]
    bearing.step(0.0, 0.2)  # a transient decays with c / (2 m) = 500 1/s
    y = run(bearing, 2.0)[:, bearing.outputs.index("displacement_y")]
    amplitude = np.abs(np.fft.rfft(y * np.hanning(y.size)))
    frequency = np.fft.rfftfreq(y.size, 1e-3)
    assert frequency[np.argmax(amplitude)] == pytest.approx(expected, abs=0.5)  # spacing of the bins
    away = np.abs(frequency - expected) > 3.0
    assert amplitude[away].max() < 0.01 * amplitude.max()


@pytest.mark.parametrize("ring", ["inner", "outer"])
def test_waves_as_many_as_balls_do_not_shake_the_shaft(ring):
    bearing = ball_bearing(
        ["clearance", f"{ring}_waviness"],
        {"clearance.radial_clearance": -20e-6, f"{ring}_waviness.order[1]": 8, f"{ring}_waviness.amplitude[1]": 1e-6},
        rpm=1800.0,
        load=0.0,
    )
    rows = run(bearing, 0.1)
    assert np.abs(rows[:, :2]).max() < 1e-15  # m; all balls are squeezed alike, what is left is rounding
    loads = rows[:, bearing.outputs.index("max_ball_load")]
    assert np.ptp(loads) > 0.1 * loads.mean()
