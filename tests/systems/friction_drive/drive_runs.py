"""Made-up runs of friction-wheel drives, as the report sees them: exponential answers to steps, a shaft that stands.

Beside them the effects with which single ones of the wheels are tested.
"""

import numpy as np
from cosimo.orchestrator.run.results import Result
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import read_scene

STEP, AT, RATE, TURN = 0.02, 0.1, 25.0, 0.4  # m and s of the step, 1/s of the answer, rad of the ramp
LINKS = [
    "controller.first_voltage -> left.voltage", "controller.second_voltage -> right.voltage",
    "left.rate -> wheels.first_rate", "right.rate -> wheels.second_rate",
    "wheels.first_torque -> left.load_torque", "wheels.second_torque -> right.load_torque",
    "wheels.feed -> controller.feed", "wheels.rotation -> controller.rotation",
]  # fmt: skip
FULL = ("exact_slip", "trocar_friction", "gravity", "preload_loss")  # one compilation for all tests of single effects
NEUTRAL = {"trocar_friction.level": 0.0, "gravity.acceleration": 0.0, "preload_loss.first": 0.0}


def drive_run(analysis=None, law=("exact_slip",), controller=True, starts=0, overshoot=0.0):
    """A step of the feed that is answered with exp(-RATE t), a ramp of the rotation that is followed with a lag; 2 s.

    starts: how often the first shaft breaks loose in the second half.  overshoot: of the feed, a share of the step, that stays.
    """
    t = np.arange(0.0, 2.0, 1e-3)
    since = np.maximum(t - AT, 0.0)
    wanted = np.where(t >= AT, STEP, 0.0)
    ramp = TURN * np.clip((t - 0.2) / 0.3, 0.0, 1.0)
    feed = STEP * (1.0 + overshoot) * -np.expm1(-RATE * since)
    stuck = (t > 0.8).astype(float)
    for k in range(starts):
        stuck[(t > 1.0 + 0.1 * k) & (t < 1.02 + 0.1 * k)] = 0.0
    ones = np.ones_like(t)
    columns = {"wheels.feed": feed, "wheels.rotation": 0.98 * ramp, "wheels.first_torque": 0.02 * ones,
               "wheels.second_torque": 0.01 * ones, "wheels.margin": 0.4 * ones, "wheels.contact_power": 0.05 * ones,
               "wheels.mechanical_energy": 0.2 * t, "left.rate": 10.0 * ones, "right.rate": 5.0 * ones,
               "left.current": 0.5 * ones, "right.current": 0.2 * ones, "left.electrical_power": 2.0 * ones,
               "right.electrical_power": 1.0 * ones, "left.shaft_friction.stuck": stuck,
               "right.shaft_friction.stuck": (t > 0.8).astype(float)}  # fmt: skip
    for name, size in (("first", 3.0), ("second", 2.0)):
        columns |= {f"wheels.{name}_traction_axial": size * ones, f"wheels.{name}_traction_around": 0.0 * ones,
                    f"wheels.{name}_slip_axial": 1e-3 * ones, f"wheels.{name}_slip_around": 0.0 * ones}  # fmt: skip
    units = {"wheels": {"component": "FrictionWheels", "effects": list(law)},
             **{n: {"component": "ServoMotor", "effects": ["shaft_friction"]} for n in ("left", "right")},
             "controller": {"component": "ServoController"}}  # fmt: skip
    links = list(LINKS)
    if controller:
        columns |= {"controller.wanted_feed": wanted, "controller.wanted_rotation": ramp}
    else:
        del units["controller"]
        links = [k for k in LINKS if "controller" not in k]
    scene = {"stop_time": float(t[-1]), "master": {"step": 1e-3}, "units": units, "connections": links,
             "analysis": {"system": "friction_drive", **(analysis or {})}}  # fmt: skip
    return Result(read_scene(scene), t, columns, {}, dict.fromkeys(columns, "1"), RunRecord(outcome="done"))
