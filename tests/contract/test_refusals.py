"""Components refuse parameters that cannot be, in words: (component, effects, parameters, words), in plain Python.

Refusals that are as sharp as what is accepted beside them are hard cases of the component.
"""

import math

import pytest
from cosimo import BadInput, component_class
from cosimo.tests.contract.configurations import in_plain_python

RK4 = "limit of RK4"
BESIDE = ("disks", "linear_supports", "bearing_b")
WIND = ("gusts", "dropper_slackening")
SHORT = {"spans": 1, "element": 5.0}
REFUSED = [
    ("BallBearing", ("cage_fault",), {"cage_fault.offset": 0.5}, "half the distance of two of 8 balls"),
    ("BallBearing", ("cage_fault",), {"cage_fault.ball": 9}, "four or more balls"),
    ("AngularContactConductance", ("ring_walls",), {"ring_walls.bore": 47e-3}, "walls around"),
    ("AngularContactConductance", ("ring_walls",), {"width": 1e-3}, "part of the ring"),
    ("AngularContactConductance", (), {"outer_conformity": 10.0}, "outer_conformity"),
    ("DeepGrooveBearing", (), {"diametral_clearance": 1e-3}, "play of the balls"),
    ("DeepGrooveBearing", ("ball_defect",), {"ball_defect.ball": 10}, "ball"),
    ("TorqueMotor", ("inductance",), {"inductance.inductance": 1e-6}, RK4),
    *(("FrictionWheels", (law,), {"creep": 100.0}, f"creep = 100 N.s/m with '{law}'") for law in ("lugre_slip", "exact_slip")),
    ("ServoController", (), {"layout": "skewed", "angle": 0.0}, "The rotation is lost"),
    ("ServoController", (), {"layout": "skewed_free_rollers", "angle": 1e-4}, "The rotation is lost"),
    ("ServoController", (), {"layout": "skewed", "angle": 0.5 * math.pi}, "The feed is lost"),
    *(
        (name, (), {"layout": "orthogonal", "angle": 0.4}, r"angle = 0\.4 rad in the layout 'orthogonal'")
        for name in ("ServoController", "FrictionWheels", "FrictionDrive")
    ),
    ("PipeRobot", ("bristles",), {"forward_friction": 3.0}, "forward_friction = 3 N with the effect 'bristles'"),
    ("PipeRobot", ("smoothed_friction",), {"static_ratio": 1.5}, "static_ratio = 1.5 with the effect 'smoothed_friction'"),
    ("PipeRobot", ("unbalance",), {"unbalance.mass": 0.6}, "at most the inner mass"),
    ("PipeRobot", ("unbalance",), {"unbalance.mass": 0.5, "unbalance.inertia": 0.0}, "without inertia of the rotor"),
    ("PipeRobot", ("cubic_spring", "route"), {"cubic_spring.stiffness": -1e9, "route.slope": 0.5}, "softening spring"),
    ("PipeRobot", ("bristles", "lugre_friction"), {"bristles.angle": 1.4}, "locked backwards"),
    ("PipeRobot", ("bristles", "lugre_friction", "route"), {"bristles.angle": 1.25}, "1.35431, locked backwards"),
    ("PipeRobot", ("smoothed_friction",), {"smoothed_friction.width": 1e-5}, RK4),
    ("PipeRobot", (), {"stiffness": 1e8}, RK4),
    ("PipeRoute", (), {f"place[{k}]": p for k, p in enumerate((0, 2, 1, 3, 4, 5, 6, 7), 1)}, "ascending"),
    ("Catenary", ("moving_window",), {"method": "implicit"}, "explicit"),
    ("Catenary", ("pre_sag",), {"droppers": 1}, "one dropper"),
    ("Catenary", ("dropper_slackening", "pre_sag"), {"pre_sag.depth": 0.3}, "would carry"),
    ("Catenary", WIND, SHORT | {"gusts.lowest": 6.0}, "frequencies from 6 to 5 Hz"),
    ("Catenary", WIND, SHORT | {"gusts.length": 50.0}, "only vertical gusts act"),
    ("Catenary", WIND, SHORT | {"gusts.speed": 60.0, "gusts.lift_coefficient": 2.0}, "slack at rest"),
    (
        "Pantograph",
        ("acceleration",),
        {"speed": 50.0, "acceleration.rate": 1.0, "acceleration.final_speed": 40.0},
        "leads to the final speed",
    ),
    ("Pantograph", ("aerodynamic_uplift", "wire_unevenness"), {"wire_unevenness.shortest": 70.0}, "below the"),
    ("Pantograph", ("aerodynamic_uplift", "lift_fluctuation"), {"lift_fluctuation.lowest": 30.0}, "below the"),
    ("BeamRotor", ("disks", "unbalance"), {"unbalance.moment[3]": 1e-3}, r"unbalance.moment\[3\] without disk 3"),
    ("BeamRotor", BESIDE, {"watched_position": 1.6}, "watched_position at 1.6 m"),
    ("BeamRotor", BESIDE, {"disks.position[2]": 2.0}, "a disk at 2 m"),
    ("BeamRotor", BESIDE, {"bearing_b.position": 1.51}, "a bearing at 1.51 m"),
    ("BeamRotor", BESIDE, {"linear_supports.position[1]": 9.0}, "a support at 9 m"),
    ("BeamRotor", BESIDE, {"inner_diameter": 0.05}, "inner_diameter = 0.05 m"),
    *(
        ("BeamRotor", (), {"youngs_modulus": young, "shear_modulus": shear}, r"youngs_modulus = .* with shear_modulus = ")
        for young, shear in ((211e9, 20e9), (1.0, 1e30))  # Poisson's ratios of 4.3 and, to rounding, -1
    ),
    (
        "RovHull",
        ("further_thrusters",),
        {f"further_thrusters.thruster_direction_{a}[2]": 0.0 for a in "xyz"},
        r"thruster 8 .*further_thrusters.thruster_direction_x\[2\]",
    ),
    *(
        ("RovController", ("manoeuvre",), {f"manoeuvre.time[{k}]": t for k, t in enumerate(times, 1)}, "time")
        for times in ([5.0, 3.0, 8.0], [1.0, 2.0, 0.0, 3.0])
    ),
    *(
        ("WaterCurrent", ("waves",), {"waves.height": h, "waves.period": T, "waves.water_depth": d}, "break at this period")
        for h, T, d in ((4.0, 4.0, 1e3), (1.0, 8.0, 1.0))
    ),
    ("GimbalBody", (), {"start_outer_rate": 1e4}, RK4),
    ("GimbalBody", ("stops",), {"stops.inner_lower": 1.0, "stops.inner_upper": -1.0}, "stops of the inner axis at 1 and -1 rad"),
    ("PlanarLink", (), {"inertia": 0.0}, "its centre of mass"),
    ("PlanarLink", ("pinned",), {"inertia": 0.0, "centre": 0.0}, "its joint"),
    ("PlanarLink", ("pinned",), {"start_velocity_x": 1.0}, "pinned base"),
    ("PlanarLink", ("pinned", "gravity"), {"inertia": 0.0, "centre": 1e-7}, RK4),
    ("PistonPump", (), {"rod_diameter": 0.02}, "changes nothing"),
    ("CentrifugalPump", (), {"curve_drop": 1e6}, "efficiency vanishes"),
    ("PlanetaryTransmission", (), {"turbine_on": "sun", "pump_on": "sun"}, "two different shafts"),
    ("PlanetaryTransmission", ("dry_brake",), {"dry_brake.static": 1.0}, "at least the kinetic"),
    ("PlanetaryTransmission", ("centrifugal_brake",), {"centrifugal_brake.largest_speed": 1e4}, RK4),
    ("WindTurbine", ("pitch",), {}, "curve that knows pitch"),
    ("WindTurbine", (), {"standstill_coefficient": 1.0, "runaway_ratio": 2.4}, "Betz"),
    ("WindTurbine", ("bearing_friction",), {"bearing_friction.static": 0.5}, "at least the kinetic"),
    ("WindTurbine", (), {"substep": 1.0, "inertia": 1e-3}, RK4),
    ("WaterPipe", ("tank",), {"tank.start_level": 3.0}, "at most the height"),
    ("Wind", ("gusts",), {"gusts.period": 5.0}, "duration of a gust"),
    ("Wind", ("ramp",), {"ramp.start_time": 5.0, "ramp.return_time": 4.0}, "at least the ramp's start"),
    ("Wind", ("turbulence",), {"mean_speed": 0.0}, "carries it along"),
    ("ExciterProgram", (), {"start_time": 2.0, "duration": 3.0, "return_time": 4.0}, r"return_time = 4 s.*at least 5 s"),
    ("BearingTemperatures", (), {"inner_share": 0.6, "outer_share": 0.5}, "inner_share"),
    ("ServoController", ("reference",), {"reference.time[3]": 0.2}, "times that do not decrease"),
    ("LumpedCatenary", (), {"harmonic[1]": 1.2}, "positive"),
    ("ForearmTendons", (), {"rise_time": 1e-3, "substep": 5e-3}, RK4),
]


@pytest.mark.parametrize(("component", "effects", "parameters", "words"), in_plain_python(REFUSED))
@pytest.mark.uncompiled
def test_parameters_that_cannot_be_are_refused(component, effects, parameters, words):
    with pytest.raises(BadInput, match=words):
        component_class(component)(effects, parameters).initialize(0.0)


ACCEPTED = [
    ("BearingTemperatures", (), {"inner_share": 0.7, "outer_share": 0.3}),
    ("ServoController", (), {"layout": "orthogonal"}),
    ("BeamRotor", (), {"youngs_modulus": 3e30, "shear_modulus": 1e30}),  # incompressible
    ("WaterCurrent", ("waves",), {"waves.height": 0.8, "waves.period": 8.0, "waves.water_depth": 1.0}),
    ("PlanarLink", ("pinned",), {"inertia": 0.0}),  # a point mass on a rod
]


@pytest.mark.parametrize(("component", "effects", "parameters"), in_plain_python(ACCEPTED))
@pytest.mark.uncompiled
def test_what_is_at_the_edge_and_can_be_is_accepted(component, effects, parameters):
    component_class(component)(effects, parameters).initialize(0.0)
