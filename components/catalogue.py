"""The list of all components: a name here puts a component under the contract tests, the FMU builder and the command line."""

from __future__ import annotations

import importlib
import traceback
from pathlib import Path

from .core.component import TABLES, Component
from .core.declaration import check_declaration, line_of
from .core.errors import BadInput, nearest, pick

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
    "PassiveWalker": "two_axis_joint.walker",
    "PlanarLink": "two_axis_joint.link",
    "CompliantJoint": "two_axis_joint.compliant_joint",
    "RovHull": "rov.hull",
    "AddedMassForce": "rov.added_mass",
    "Thruster": "rov.thruster",
    "WaterCurrent": "rov.current",
    "RovController": "rov.controller",
    "Tether": "rov.tether",
    "RovSensors": "rov.sensors",
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
    """The class of a catalogue name or of "module:Class"; raises `BadInput` with the near names, or with file and line."""
    if name.startswith(TABLES):
        from .core.signals import KNOWN

        if name not in KNOWN:
            raise BadInput(where, f"component {name!r}", "the table of signals of a scene that this process has read")
        return KNOWN[name]
    module, own, class_name = name.partition(":")
    if not own:
        pick(name, CATALOGUE, where, "a component (cosimo list components), or module:Class", "component")
        module, class_name = f"{__package__}.{CATALOGUE[name]}", name
    try:
        loaded = importlib.import_module(module)
    except Exception as error:  # a module may raise anything while it is imported
        raise _not_imported(name, where, error) from None
    cls = getattr(loaded, class_name, None)
    if not (isinstance(cls, type) and issubclass(cls, Component)):
        classes = [n for n, c in vars(loaded).items() if isinstance(c, type) and issubclass(c, Component)]
        raise BadInput(where, f"component {name!r}", f"a component of {module}", nearest(class_name, classes))
    if own:  # those of the catalogue are checked by the tests
        check_declaration(cls)
    return cls


def _not_imported(name: str, where: str, error: Exception) -> BadInput:
    """What is wrong with a user's module: its file and line, where the error is in one."""
    cause = error.__cause__ if isinstance(error.__cause__, BadInput) else error
    if isinstance(error, ModuleNotFoundError) and name.startswith(str(error.name)):
        return BadInput(
            where,
            f"component {name!r}",
            "module:Class that can be imported",
            f"{type(error).__name__}: {error}. The folder of a module of your own belongs into PYTHONPATH.",
        )
    others = (__file__, str(Path(__file__).parent / "core"), importlib.__file__, "<frozen")
    own = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith(others)]
    file, line = (own[-1].filename, own[-1].lineno or 1) if own else ("", 1)
    if isinstance(error, SyntaxError):
        file, line = str(error.filename), error.lineno or 1
    if isinstance(cause, BadInput):  # of a declaration: "Class.name"
        owner, _, attribute = cause.where.partition(".")
        return BadInput(
            f"{file}:{max(line_of(Path(file), owner, attribute), line)}: {cause.where}",
            cause.actual,
            cause.expected,
            cause.remedy,
        )
    place = f" ({file}:{line})" if file else ""
    return BadInput(where, f"component {name!r}", "module:Class that can be imported", f"{type(error).__name__}: {error}{place}.")


def component_name(cls: type[Component]) -> str:
    """The name of a class in scenes: its name in the catalogue, or "module:Class". Raises `BadInput` for one inside a function."""
    if cls.__module__.endswith(f".components.{CATALOGUE.get(cls.__name__, '?')}"):
        return cls.__name__
    if "." in cls.__qualname__:
        raise BadInput(
            "component",
            f"class {cls.__qualname__}",
            "a class of a module, not of a function or another class",
            "Worker processes and FMUs look it up by its name.",
        )
    return f"{cls.__module__}:{cls.__name__}"
