"""Where a deep groove bearing is at its limits: no contact, one, preload, no speed, defects between two steps, long runs."""

import math
import warnings

import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DISPLACEMENT, DeepGrooveBearing
from cosimo.components.core.errors import StepFailed
from cosimo.components.core.kernels import DONE

pytestmark = pytest.mark.full

LOAD = ("force_x", "force_y", "force_z", "moment_x", "moment_y")
ALL = ("film", "damping", "inner_waviness", "outer_waviness", "linearisation", "friction", "thermal_growth")


def moved(effects=(), q=(0.0,) * 5, speed=0.0, **parameters):
    """A bearing at a displacement and a speed; parameters with __ for the dot."""
    bearing = DeepGrooveBearing(effects, {n.replace("__", "."): value for n, value in parameters.items()})
    for name, value in zip((*DISPLACEMENT, "speed"), (*q, speed), strict=True):
        bearing.set(name, value)
    bearing.initialize(0.0)
    return bearing


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


def test_no_ball_in_contact_is_free_flight():
    """No force, no tangent but the spring for the search, no power, no NaN, in the whole play of the rings."""
    for x in np.linspace(-9.9e-6, 9.9e-6, 21):
        bearing = moved(
            ["damping", "linearisation", "friction"],
            (x, 0.0, 0.0, 0.0, 0.0),
            500.0,
            diametral_clearance=2e-5,
            linearisation__idle_stiffness=0.0,
        )
        bearing.set("velocity_x", 1.0)
        bearing.step(0.0, 1e-5)
        assert not bearing.y[:7].any()
        assert not any(bearing[n] for n in bearing.outputs if n.startswith(("linearisation", "friction")))


def test_touch_down_is_smooth():
    """Load and damping grow from zero without a jump: over 1 pm around the first contact the force changes by pN."""
    gap = 1e-5
    for effects in ((), ("damping",)):
        forces = []
        for x in (gap - 1e-12, gap, gap + 1e-12):
            bearing = moved(effects, (x, 0.0, 0.0, 0.0, 0.0), diametral_clearance=2.0 * gap)
            bearing.set("velocity_x", 1e-3)
            bearing.refresh()
            forces.append(bearing["force_x"])
        # K (1 pm)^1.5 = 1e-8 N, and the damper 2.5e-5 s * 1.5 K sqrt(1 pm) * 1 mm/s = 4e-4 N
        assert np.abs(forces).max() < 1e-3
        assert forces[0] == 0.0


def test_one_ball_in_contact_holds_along_its_line_only():
    bearing = moved(["linearisation"], (2.2e-5, 0.0, 0.0, 0.0, 0.0), diametral_clearance=4e-5, linearisation__idle_stiffness=0.0)
    assert bearing["loaded_balls"] == 1.0
    assert bearing["linearisation.stiffness[1]"] > 1e7
    assert bearing["linearisation.stiffness[7]"] == 0.0
    found = bearing.equilibrium([100.0, 0.0, 0.0, 0.0, 0.0])
    assert found.status == DONE
    assert np.count_nonzero(found.ball_loads) == 1


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


@pytest.mark.parametrize("speed", [0.0, 1e-12, -1e-12, 1e-3, -500.0, 500.0])
def test_film_at_no_speed_and_at_reversed_speed(speed):
    """|speed|^0.67 has an infinite slope at 0 and a value; the film does not know the direction, the balls' way does."""
    bearing = moved(["film", "friction", "linearisation"], (1e-5, 0.0, 0.0, 0.0, 0.0), speed)
    film = bearing["film.inner_thickness"] + bearing["film.outer_thickness"]
    # 0.654 um at 1000 rpm, of a contact after Brewe and Hamrock
    assert film == pytest.approx(0.654e-6 * abs(speed / 104.72) ** 0.67, rel=0.03)
    assert np.isfinite(bearing.y).all()
    assert bearing["friction.power"] >= 0.0
    other = moved(["film", "friction", "linearisation"], (1e-5, 0.0, 0.0, 0.0, 0.0), -speed)
    assert other["force_x"] == bearing["force_x"]


def test_a_run_there_and_back_ends_where_it_began():
    bearing = moved(["ball_defect"], (1e-5, 0.0, 0.0, 0.0, 0.0), 50.0, ball_defect__width=1.0)
    start = bearing.x.copy()
    for k in range(400):
        bearing.set("speed", 50.0 if k < 200 else -50.0)
        bearing.step(k * 1e-3, 1e-3)
    turned = np.abs((bearing.x - start + math.pi) % (2.0 * math.pi) - math.pi)
    assert turned.max() < 1e-12  # 400 roundings of angles below 2 pi
    assert (bearing.x >= 0.0).all()
    assert (bearing.x < 2.0 * math.pi).all()


def test_ten_million_steps_do_not_drift():
    """The angles' sum in one compiled loop: 1e7 steps of an exactly known turn, against the product."""
    from cosimo.components.bearings.six_dof import constants, roll

    bearing = moved(speed=314.159)
    k, u, h = constants(bearing.arguments[0]), bearing.u, 1e-5

    def many(x, n):
        for _ in range(n):
            roll(h, x, u, k)

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


def test_a_defect_is_refused_by_the_speed_at_the_end_of_a_step():
    bearing = moved(["outer_defect"], speed=0.0)
    bearing.u[1, bearing.inputs.index("speed")] = 3e5
    with pytest.raises(StepFailed, match="outer_defect"):
        bearing.step(0.0, 1e-2)


def test_a_defect_is_refused_by_the_speed_between_the_ends_of_a_step():
    """The inputs are parabolas: 300 rad/s in the middle, none at either end."""
    bearing = moved(["outer_defect"], speed=0.0)
    h = 2.0 * math.radians(3.0) / (300.0 * 0.4)  # s: at full speed a ball passes two pits
    bearing.u[1:, bearing.inputs.index("speed")] = (1200.0 / h, -1200.0 / h**2)
    with pytest.raises(StepFailed, match="outer_defect"):
        bearing.step(0.0, h)


def test_waves_shorter_than_two_steps_are_refused():
    """They would show at a wrong frequency: 100 waves at 300 rad/s are 2800 a second, half of one passes in 0.18 ms."""
    fast = {"outer_waviness__order[1]": 100}
    assert warned(moved(["outer_waviness"], speed=300.0, **fast), 4e-5) == []
    assert len(warned(moved(["outer_waviness"], speed=300.0, **fast), 1e-4)) == 1
    with pytest.raises(StepFailed, match="order 100"):
        moved(["outer_waviness"], speed=300.0, **fast).step(0.0, 3e-4)


def test_axial_stiffness_at_contact_angle_zero():
    """At z = 0 without clearance the axial stiffness is zero and the force is finite: no division by it anywhere."""
    for z in (0.0, 1e-30, 1e-12, 1e-9, -1e-9):
        bearing = moved(["linearisation", "damping"], (0.0, 0.0, z, 0.0, 0.0))
        assert np.isfinite(bearing.y).all()
        assert abs(bearing["linearisation.stiffness[13]"]) < 1.0
    for force in (1e-6, 1.0, -1000.0):
        found = moved().equilibrium([0.0, 0.0, force, 0.0, 0.0])
        assert found.status == DONE
        assert math.copysign(1.0, found.displacement[2]) == math.copysign(1.0, force)


@pytest.mark.parametrize("name", ["displacement_x", "tilt_y", "speed", "velocity_z"])
def test_a_value_that_is_no_number_fails_the_step(name):
    bearing = moved(["damping", "film"], (1e-5, 0.0, 3e-5, 0.0, 0.0), 10.0)
    bearing.set(name, math.nan)
    with pytest.raises(StepFailed, match="not finite"):
        bearing.step(0.0, 1e-4)
