"""Components refuse parameters that cannot be, in words, and their steps inputs that cannot be, in plain Python.

Refusals that are as sharp as what is accepted beside them are hard cases of the component.
"""

import math

import pytest
from cosimo import BadInput, StepFailed, component_class
from cosimo.tests.contract.configurations import in_plain_python

RK4 = "limit of RK4"
BESIDE = ("disks", "linear_supports", "bearing_b")
WIND = ("gusts", "dropper_slackening")
SHORT = {"spans": 1, "element": 5.0}
CROSS = r"axes that cross at a sine of .* one motion instead of two"
RIGID = {"constraint.kind": "rigid"} | {f"constraint.off_axis[{j}]": 0.0 for j in range(1, 6)}
NO_INERTIA = {"transverse_inertia": 0.0, "axial_inertia": 0.0, "morphology.row_offset": 0.0}
LINKS = ("crank", "coupler", "rocker", "ground")
REFUSED = [  # component, effects, parameters, words
    ("BallBearing", ("cage_fault",), {"cage_fault.offset": 0.5}, "half the distance of two of 8 balls"),
    ("BallBearing", ("cage_fault",), {"cage_fault.ball": 9}, "four or more balls"),
    ("AngularContactConductance", ("ring_walls",), {"ring_walls.bore": 47e-3}, "walls around"),
    ("AngularContactConductance", ("ring_walls",), {"width": 1e-3}, "part of the ring"),
    ("AngularContactConductance", (), {"outer_conformity": 10.0}, "outer_conformity"),
    ("DeepGrooveBearing", (), {"diametral_clearance": 1e-3}, "play of the balls"),
    ("DeepGrooveBearing", ("ball_defect",), {"ball_defect.ball": 10}, "ball"),
    ("TorqueMotor", ("inductance",), {"inductance.inductance": 1e-6}, RK4),
    *(("FrictionWheels", (law,), {"creep": 100.0}, f"creep = 100 N.s/m with '{law}'") for law in ("lugre_slip", "exact_slip")),
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
    ("BeamRotor", (), {"youngs_modulus": 70e9}, "Poisson's ratio -0.56.*Give both moduli"),
    ("BeamRotor", ("disks",), {"disks.polar_inertia[2]": 1.0}, "a disk at 1 m with a polar inertia"),
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
    *(
        ("ForearmTendons", ("programme",), {f"programme.{name}": value for name, value in wrong.items()}, r"programme\.time")
        for wrong in ({"time[1]": 0.3, "time[2]": 0.1, "time[3]": 0.2}, {"time[1]": 0.3, "fcu[2]": 0.1})
    ),
    *(
        (component, effects, {f"{prefix}proximal_tilt": tilts[0], f"{prefix}distal_tilt": tilts[1]}, CROSS)
        for component, effects, prefix in (("Wrist", ("morphology",), "morphology."), ("LigamentBundle", (), ""))
        for tilts in ((0.0, 0.0), (0.4, -0.4), (0.005, 0.005), (0.5 * math.pi, 0.5 * math.pi))
    ),
    *(
        (component, effects, {"coupling_model": "opensim_half", tilt: 0.3}, "tilts with the coupling model 'rules' only")
        for component, effects, tilt in (
            ("Wrist", ("morphology",), "morphology.proximal_tilt"),
            ("LigamentBundle", (), "proximal_tilt"),
        )
    ),
    ("Wrist", ("interaction",), {"interaction.stiffness": 1e6}, "Reduce substep"),
    # three more hold the proximal row
    (
        "Wrist",
        ("morphology", "constraint"),
        {"constraint.kind": "rigid", "constraint.cut": 1},
        r"hold both rows \(.* take the springs",
    ),
    (
        "Wrist",
        ("interaction",),
        {"interaction.contact_lower": 0.5, "interaction.contact_upper": 0.2},
        "limits of contact at 0.5 and 0.2 rad",
    ),
    *(("Wrist", ("morphology",), NO_INERTIA | {name: 0.0}, "mass matrix is singular") for name in ("hand_mass", "hand_distance")),
    ("Wrist", ("morphology",), {"flexion_stiffness": 2.0, "coupling_stiffness": 1.5}, r"at most 1\.414"),
    ("Wrist", ("morphology",), {"hand_mass": 1e308, "hand_distance": 1e10}, None),
    *(
        ("Wrist", ("morphology", "constraint"), RIGID | wrong, words)
        for wrong, words in (
            ({"constraint.prestrain": 0.01}, "apart at the start"),
            ({"start_proximal_angle": 0.1, "constraint.off_axis[1]": 1e-3}, "apart at the start"),
            ({"start_proximal_rate": 0.1, "constraint.off_axis[1]": 1e-3}, "of a row that rigid ligaments hold"),
            ({"coupling_model": "opensim_half"}, "every length depends on both angles"),
            ({"constraint.toe": 0.01}, "rigid ligaments have none"),
            ({"constraint.stiffness[3]": 1e6}, "rigid ligaments have none"),
        )
    ),
    *(
        ("FourBar", (), dict(zip(LINKS, lengths, strict=True)) | word, words)
        for lengths, word, words in (
            ((0.02, 0.02, 0.02, 0.07), {}, "longest link"),
            ((0.02, 0.02, 0.03, 0.07), {}, "longest link"),  # in one line for ever
            ((0.03, 0.04, 0.04, 0.03), {"change_point": "through"}, "whatever the crank does"),
            ((0.02, 0.05, 0.02, 0.05), {}, "change point at the crank angle 0 and 180 degrees"),
            ((0.02, 0.05, 0.04, 0.055), {"change_point": "fold"}, "no effect"),
        )
    ),
    *(
        (
            "GimbalBody",
            (),
            {"axis_orientation": way, "frame_inertia": 0.0, none: 0.0},
            r"(?s)falls to 0 kg\.m2.*Give the frame inertia",
        )
        for way in ("vertical", "horizontal")
        for none in ("cross_inertia", "axial_inertia")
    ),
    *(
        ("ServoController", (), {"layout": layout, "angle": angle}, rf"(?s)(?=.*'{layout}').*The {lost} is lost")
        for layout in ("skewed", "skewed_free_rollers")
        for angle, lost in ((0.0, "rotation"), (1e-4, "rotation"), (0.5 * math.pi, "feed"))
    ),
    ("RovController", (), {"priority[1]": 0.0}, r"Weight of an axis's error .* per N\.m\."),
]


@pytest.mark.parametrize(("component", "effects", "parameters", "words"), in_plain_python(REFUSED))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.uncompiled
def test_parameters_that_cannot_be_are_refused(component, effects, parameters, words):
    with pytest.raises(BadInput, match=words):
        component_class(component)(effects, parameters).initialize(0.0)


FAILED = [  # component, effects, parameters, inputs, length of a step, words
    ("InertialConverter", (), {"crank_inertia": 1.0}, {"turbine_speed": 400.0}, 1.0, "range"),
    ("AveragedConverter", (), {"largest_turbine_speed": 5.0}, {"turbine_speed": 5.1}, 0.1, "range"),
    (
        "PlanetaryTransmission",
        ("centrifugal_brake",),
        {"centrifugal_brake.largest_speed": 5.0, "centrifugal_brake.coefficient": 1e-3, "third_damping": 0.1},
        {"turbine_speed": 4.0, "load_torque": 1e3},
        5.0,
        "range",
    ),
    *(
        (component, (), {}, {name: value}, 0.01, None)
        for component, name in (
            ("WindTurbine", "torque"),
            ("FixedTransmission", "turbine_speed"),
            ("AveragedConverter", "turbine_speed"),
            ("PlanetaryTransmission", "turbine_speed"),
            ("PistonPump", "speed"),
            ("CentrifugalPump", "head"),
            ("WaterPipe", "flow"),
        )
        for value in (math.inf, math.nan)
    ),
    *(
        ("RollingPipeRobot", ("harmonic_force", "tow", "route"), {}, {name: value}, 1e-3, "contact")
        for name, value in (
            ("diameter", 0.2041),
            ("diameter", 0.16),
            ("route.friction_factor", -0.1),
            ("harmonic_force.frequency", 3000.0),
        )
    ),
    *(("GimbalBody", (), {}, {"outer_torque": torque}, 0.01, "not finite") for torque in (1e300, math.inf, math.nan)),
    *(
        ("Wrist", ("morphology",), {}, {name: torque}, 5.0, "Give the effect interaction")
        for name, torque in (("tau_flexion", math.nan), ("tau_deviation", -30.0))
    ),
    (
        "DeepGrooveBearing",
        ("damping", "film"),
        {},
        {"displacement_x": 1e-5, "displacement_z": 3e-5, "speed": math.nan},
        1e-4,
        "not finite",
    ),
    # equal moments: nothing is stiff, but a substep is two radians
    ("GimbalBody", (), {"axial_inertia": 0.03, "start_outer_rate": 2e3}, {}, 0.01, "radian"),
    *(
        ("ForearmTendons", ("fibres", "force_velocity", "varying_arms"), {}, {name: math.nan}, 1e-3, "ForearmTendons")
        for name in ("excitation[3]", "flexion", "deviation_rate")
    ),
]


@pytest.mark.parametrize(("component", "effects", "parameters", "inputs", "h", "words"), in_plain_python(FAILED))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.uncompiled
def test_steps_that_cannot_be_made_are_refused(component, effects, parameters, inputs, h, words):
    made = component_class(component)(effects, parameters)
    made.initialize(0.0)
    for name, value in inputs.items():
        made.set(name, value)
    with pytest.raises(StepFailed, match=words):
        made.step(0.0, h)


ACCEPTED = [
    ("BearingTemperatures", (), {"inner_share": 0.7, "outer_share": 0.3}),
    ("ServoController", (), {"layout": "orthogonal"}),
    ("BeamRotor", (), {"youngs_modulus": 3e30, "shear_modulus": 1e30}),  # incompressible
    ("WaterCurrent", ("waves",), {"waves.height": 0.8, "waves.period": 8.0, "waves.water_depth": 1.0}),
    ("PlanarLink", ("pinned",), {"inertia": 0.0}),  # a point mass on a rod
    ("GimbalBody", (), {"frame_inertia": 0.0}),
    ("GimbalBody", (), {"cross_inertia": 0.05, "inner_inertia": 0.05, "axial_inertia": 0.0}),
]


@pytest.mark.parametrize(("component", "effects", "parameters"), in_plain_python(ACCEPTED))
@pytest.mark.uncompiled
def test_what_is_at_the_edge_and_can_be_is_accepted(component, effects, parameters):
    component_class(component)(effects, parameters).initialize(0.0)
