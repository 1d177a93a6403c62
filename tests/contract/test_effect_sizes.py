"""Effects of known size and sign whose closed form stands nowhere else; the marker `known_answers` finds all."""

import math

import numpy as np
import pytest
from cosimo.components.drives.servo_motor import ServoMotor
from cosimo.components.friction_drive.monolith import FrictionDrive
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.pantograph import Pantograph, pantograph_derivatives
from cosimo.components.railway.statics import elasticity
from cosimo.components.rotor.jeffcott import JeffcottRotor
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.thruster import Thruster
from cosimo.components.wind_pump.planetary import PlanetaryTransmission, gear_derivatives
from cosimo.components.wind_pump.turbine import WindTurbine
from cosimo.components.wrist.wrist import Wrist

pytestmark = pytest.mark.interpreted


def pushed_up(effects, wire: float, parameters=None) -> Pantograph:
    """A pantograph that has started against a wire at height 0, which then is elsewhere, m."""
    pantograph = Pantograph(effects, parameters)
    pantograph.initialize(0.0)
    pantograph.set("wire_height", wire)
    pantograph.refresh()
    return pantograph


@pytest.mark.known_answers(Pantograph="contact_loss")
def test_a_wire_that_goes_away_pulls_only_without_contact_loss():
    """5 mm above the head: -250 N from 50 kN/m, or nothing; 1 mm below it 50 N in both cases."""
    head = pushed_up((), 0.0)["head_height"]
    assert pushed_up((), head + 0.005)["contact_force"] == pytest.approx(-250.0, rel=1e-12)
    assert pushed_up(("contact_loss",), head + 0.005)["contact_force"] == 0.0
    for effects in ((), ("contact_loss",)):
        assert pushed_up(effects, head - 0.001)["contact_force"] == pytest.approx(50.0, rel=1e-10)


@pytest.mark.known_answers(Pantograph="bump_stops")
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_stop_pushes_the_head_back_from_the_end_of_its_travel(way):
    """2 mm behind the travel of 50 mm: 200 N from 100 kN/m, on the head and against it on the frame; at 49 mm nothing."""
    for depth, force in ((0.002, 200.0), (-0.001, 0.0)):
        rates = []
        for effects in ((), ("bump_stops",)):
            pantograph = Pantograph(effects)
            pantograph.initialize(0.0)
            dx = np.zeros(pantograph.x.size)
            x = np.array([way * (0.05 + depth), 0.0, 0.0, 0.0])
            pantograph_derivatives(0.0, x, pantograph.u[0], dx, *pantograph.arguments)
            rates.append(dx[[1, 3]])
        assert rates[1] - rates[0] == pytest.approx([-way * force / 7.2, way * force / 15.0], rel=1e-9, abs=1e-12)


@pytest.mark.known_answers(Catenary="steady_arm")
def test_a_steady_arm_is_a_spring_beside_the_compliance_of_the_wire():
    """c / (1 + k c) at the only support between two spans, in the limit of short elements.

    The compliance of the waves that a mesh cannot hold stands in series with contact and arm each, where the wire shares it:
    the difference is of first order in the element, and its extrapolation vanishes.
    """
    differences = []
    for element in (0.5, 0.25):
        given = {"spans": 2, "element": element, "method": "implicit", "substep": 1e-3}
        plain, held = Catenary(parameters=given), Catenary(["steady_arm"], {**given, "steady_arm.stiffness": 2000.0})
        for catenary in (plain, held):
            catenary.initialize(0.0)
        place = [plain["span_length"]]
        (c,), (with_arm,) = (elasticity(one.mesh, place, 100.0, unilateral=False) for one in (plain, held))
        differences.append(with_arm / (c / (1.0 + 2000.0 * c)) - 1.0)
    assert 0.0 < differences[0] < 0.012
    assert 2.0 * differences[1] - differences[0] == pytest.approx(0.0, abs=2e-4)


@pytest.mark.known_answers(JeffcottRotor="gravity")
def test_a_rotor_sags_by_its_weight_over_its_stiffness():
    rotor = JeffcottRotor(["gravity"], {"mass": 20.0, "stiffness": 4e5})
    rotor.initialize(0.0)
    assert rotor["displacement_y"] == pytest.approx(-20.0 * rotor["gravity.acceleration"] / 4e5, rel=1e-12)
    assert rotor["displacement_x"] == 0.0


@pytest.mark.known_answers(PlanetaryTransmission="centrifugal_brake")
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_centrifugal_brake_takes_the_square_of_the_speed(way):
    plain, braked = (PlanetaryTransmission(e, {"start_speed": 1.0}) for e in ((), ("centrifugal_brake",)))
    rates, torques = [], []
    for gear in (plain, braked):
        gear.initialize(0.0)
        gear.x[2] = 30.0 * way
        dx = np.zeros(gear.x.size)
        gear_derivatives(0.0, gear.x, gear.u[0], dx, *gear.arguments)
        gear.refresh()
        rates.append(dx[2])
        torques.append(gear["third_torque"])
    torque = braked["centrifugal_brake.coefficient"] * 900.0 * way
    assert torques[1] - torques[0] == pytest.approx(torque, rel=1e-10)
    assert rates[1] - rates[0] == pytest.approx(-torque / braked["third_inertia"], rel=1e-10)


@pytest.mark.known_answers(RovHull="external")
def test_a_force_on_a_hull_gives_it_the_acceleration_of_hull_and_water():
    hull = RovHull(["added_mass", "external"], {"centre_of_gravity_z": 0.0})
    hull.set("external.force_x", 12.0)
    hull.initialize(0.0)
    assert hull["external.acceleration_x"] == pytest.approx(12.0 / (hull["mass"] + hull["added_mass.surge"]), rel=1e-12)
    assert hull["external.acceleration_y"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.known_answers(Thruster="status")
def test_a_thruster_that_runs_is_there():
    thruster = Thruster(["status"])
    thruster.initialize(0.0)
    thruster.step(0.0, 0.1)
    assert thruster["status.available"] == 1.0


@pytest.mark.known_answers(WindTurbine="pitch")
@pytest.mark.parametrize("degrees", [0.0, 5.0, 12.0])
def test_pitch_is_that_of_the_published_fit(degrees):
    """Heier's fit written out, at a tip speed ratio of 6."""
    turbine = WindTurbine(["pitch"], {"curve": "heier", "start_speed": 20.0})
    wind = 20.0 * turbine["radius"] / 6.0
    turbine.set("wind", wind)
    turbine.set("pitch.angle", math.radians(degrees))
    turbine.initialize(0.0)
    turbine.refresh()
    inverse = 1.0 / (6.0 + 0.08 * degrees) - 0.035 / (degrees**3 + 1.0)
    share = 0.5176 * (116.0 * inverse - 0.4 * degrees - 5.0) * math.exp(-21.0 * inverse) + 0.0068 * 6.0
    assert turbine["power_coefficient"] == pytest.approx(share, rel=1e-9)
    power = share * 0.5 * turbine["density"] * math.pi * turbine["radius"] ** 2 * wind**3
    assert turbine["power"] == pytest.approx(power, rel=1e-9)


@pytest.mark.known_answers(Wrist="interaction")
@pytest.mark.parametrize(("torque", "limit"), [(1.5, 0.5), (-1.5, -0.4)])
def test_a_hand_rests_where_its_limit_and_its_stiffness_bear_the_torque(torque, limit):
    """k a + 200 (a - limit) = torque: 5 mrad behind the limit of flexion with 1 N.m/rad of the wrist's own."""
    wrist = Wrist(
        ["interaction"],
        {
            "interaction.flexion_upper": 0.5,
            "interaction.flexion_lower": -0.4,
            "interaction.contact_lower": -3.0,
            "interaction.contact_upper": 3.0,
            "proximal_damping": 0.1,
            "distal_damping": 0.1,
        },
    )
    wrist.set("tau_flexion", torque)
    wrist.initialize(0.0)
    for k in range(30):
        wrist.step(0.1 * k, 0.1)
    assert abs(wrist["flexion_rate"]) < 1e-9
    assert wrist["flexion"] == pytest.approx((torque + 200.0 * limit) / 201.0, rel=1e-9)


@pytest.mark.known_answers(FrictionDrive=("smoothed_slip", "lugre_slip", "exact_slip"))
@pytest.mark.parametrize(
    ("law", "given"),
    [("smoothed_slip", {}), ("lugre_slip", {"viscous": 0.0, "static_ratio": 1.0}), ("exact_slip", {"static_ratio": 1.0})],
)
def test_a_motor_bears_the_friction_of_its_contact_under_every_law(law, given):
    """Even plain wheels without load: R mu N sin a each, here 0.01 m * 6 N / 2, and the rate of a motor under that load."""
    drive = FrictionDrive([law], {f"{law}.{name}": value for name, value in given.items()})
    drive.set("first_voltage", 9.0)
    drive.set("second_voltage", 9.0)
    motor = ServoMotor()
    motor.set("voltage", 9.0)
    motor.set("load_torque", 0.03)
    for unit in (drive, motor):
        unit.initialize(0.0)
        unit.step(0.0, 0.3)
    assert drive["first_rate"] == pytest.approx(motor["rate"], rel=1e-6)
    assert drive["second_rate"] == pytest.approx(motor["rate"], rel=1e-6)
    assert drive["feed_rate"] == pytest.approx(0.01 * motor["rate"] * math.cos(math.pi / 6.0), rel=1e-5)
