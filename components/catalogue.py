"""The list of all components: a name here puts a component under the contract tests, the FMU builder and the command line."""

from __future__ import annotations

from importlib import import_module

from .core.component import Component
from .core.errors import BadInput, nearest

CATALOGUE = {
    "Pantograph": "railway.pantograph",
    "Catenary": "railway.catenary",
    "LumpedCatenary": "railway.lumped",
    "BallBearing": "bearings.ball_bearing",
    "DimensionlessBallBearing": "bearings.dimensionless",
    "DeepGrooveBearing": "bearings.deep_groove",
    "AngularContactConductance": "bearings.conductance",
    "BearingTemperatures": "bearings.temperatures",
    "JeffcottRotor": "rotor.jeffcott",
    "BeamRotor": "rotor.beam",
    "GimbalBody": "two_axis_joint.gimbal",
    "GimbalController": "two_axis_joint.controller",
    "TorqueMotor": "drives.torque_motor",
    "ServoMotor": "drives.servo_motor",
    "TwoLinkChain": "two_axis_joint.chain",
    "PlanarLink": "two_axis_joint.link",
    "CompliantJoint": "two_axis_joint.compliant_joint",
    "RovHull": "rov.hull",
    "AddedMassForce": "rov.added_mass",
    "Thruster": "rov.thruster",
    "WaterCurrent": "rov.current",
    "RovController": "rov.controller",
    "Tether": "rov.tether",
    "WindTurbine": "wind_pump.turbine",
    "Wind": "wind_pump.wind",
    "FixedTransmission": "wind_pump.fixed",
    "PlanetaryTransmission": "wind_pump.planetary",
    "AveragedConverter": "wind_pump.averaged",
    "InertialConverter": "wind_pump.converter",
    "PistonPump": "wind_pump.piston_pump",
    "CentrifugalPump": "wind_pump.centrifugal_pump",
    "WaterPipe": "wind_pump.pipe",
    "FourBar": "wrist.four_bar",
    "ForearmTendons": "wrist.tendons",
    "PipeRobot": "pipe_robot.robot",
    "RollingPipeRobot": "pipe_robot.rolling",
    "PipeRoute": "pipe_robot.route",
    "TowCoupling": "pipe_robot.tow",
    "ExciterProgram": "pipe_robot.program",
    "ServoController": "friction_drive.controller",
    "FrictionWheels": "friction_drive.wheels",
    "FrictionDrive": "friction_drive.monolith",
    "Wrist": "wrist.wrist",
    "LigamentBundle": "wrist.ligaments",
}


def component_class(name: str, where: str = "component") -> type[Component]:
    """The class behind a catalogue name; raises `BadInput` with the near names."""
    if name not in CATALOGUE:
        raise BadInput(where, f"component {name!r}", "a component of the catalogue", nearest(name, CATALOGUE))
    return getattr(import_module("." + CATALOGUE[name], __package__), name)
