"""Hard cases of the wind pump: standstill, calm, gusts, shafts that may not turn back, seized and dry pumps, light levers."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import (
    AtLeast,
    AtMost,
    Ends,
    Finite,
    HardCase,
    InputSignal,
    Like,
    Reaches,
    Refused,
    events,
    jumps,
    ramp,
    sine,
)
from .converter import MODE
from .driven_shaft import STANDING

PEAK = 0.05 * 20.0 * 2.0 * 0.05 * 18.0**2  # N.m, torque of the default inertial converter at 3 rad/s of the turbine
WOUND = 2000.0 * 3.0 + 5.0 * 3.0  # N.m, of a shaft that 3 rad of the turbine wind up at 3 rad/s against a standing pump
SAME, TURNED = ("speed", "driving_torque"), ("ratio", "turbine_torque", "slider_velocity", "crank_angle", "engaged")
STILL = ("turbine_torque", "driving_torque", "ratio", "dissipation", "speed")


def _still(component: Component) -> list[float]:
    """Everything that is 0 while nothing moves."""
    return [component[name] for name in STILL]


def _water(component: Component) -> float:
    """Delivered, less supplied, overflowed and kept, m³."""
    tank = [component[f"tank.{n}"] for n in ("supplied", "overflowed", "level")]
    return component["delivered"] - tank[0] - tank[1] - 2.0 * (tank[2] - 0.5)


def _mode(component: Component) -> float:
    """What the driven shaft does."""
    return float(component.x[MODE])


def _seen(component: Component) -> np.ndarray:
    return np.array([component[n] for n in (*SAME, *TURNED)])


def _mirrored(component: Component) -> np.ndarray:
    return np.array([*(component[n] for n in SAME), *(-component[n] for n in TURNED)])


OWN_ROTOR = "tip_speed_ratio,power_coefficient\n0.4,0.03\n0.8,0.12\n1.2,0.26\n1.6,0.29\n2,0.21\n"
SHEET = "flow [l/s],head [m],power [W]\n0,30,180\n0.6,{},315\n1.2,20,428\n"

CALM = {
    "nothing moves": HardCase(
        "Drive and load are exactly equal: 0.", (AtMost(_still, 0.0, "speed, torques, ratio"),), run=(1.0, 0.1)
    )
}
STANDSTILL = {
    "through standstill and back": HardCase(
        "A turbine that swings about standstill: the driven shaft never turns back.",
        (AtLeast("speed", 0.0), AtMost("driving_torque", WOUND)),
        parameters={"driven_inertia": 0.1},
        inputs={"load_torque": 2.0, "turbine_speed": sine(3.0, 2.0)},
        run=(4.0, 0.02),
    )
}
LIGHT = {
    "a shaft of a milligram": HardCase(
        "Its relaxation is far quicker than the substep.",
        Refused("limit of RK4", accepted={"substep": 2.6e-7}),
        parameters={"driven_inertia": 1e-6},
        run=(0.1, 1e-5),
    )
}
NO_NUMBER = {
    "a speed that is no number": HardCase(
        "The run ends, and the state before the step can be taken back.",
        Refused("failed at t = 0 s", "step", {"turbine_speed": 1.0}),
        inputs={"turbine_speed": jumps(0.0, (0.0, math.nan))},
        run=(0.05, 0.01),
    )
}


HARD_CASES = {
    "WindTurbine": {
        "calm and standstill": HardCase(
            "0 / 0 in the tip speed ratio and in the coefficient.",
            (AtMost("speed", 0.0), AtMost("power_coefficient", 0.0)),
            parameters={"curve": "heier"},
            inputs={"wind": 0.0},
            run=(1.0, 0.1),
        ),
        "a breath of wind on a turning rotor": HardCase(
            "1e-300 m/s: a tip speed ratio without bound, a coefficient within 1e9.",
            (AtMost("power_coefficient", 1e9), AtMost("aerodynamic_torque", 10.0)),
            parameters={"start_speed": 3.0},
            inputs={"wind": 1e-300},
            run=(1.0, 0.1),
        ),
        "a gust from 5 to 60 m/s": HardCase(
            "The storm in which the stable step is stated, within one step.",
            (AtMost("speed", 96.001),),
            parameters={"start_speed": 4.0},
            inputs={"wind": jumps(5.0, (1.0, 60.0))},
            run=(4.0, 0.05),
        ),
        "friction at its level": HardCase(
            "The load is exactly the static friction, and then grows: T t²/2 / J.",
            (Ends("speed", 1e-12, value=0.5 / 15.0),),
            effects=("bearing_friction",),
            inputs={"torque": ramp(-1.0, -1.0)},
            run=(1.0, 0.1),
        ),
        "more than Betz": HardCase(
            "A farm windmill better than any.",
            Refused("Betz's limit", accepted={"standstill_coefficient": 0.9}),
            parameters={"standstill_coefficient": 1.2},
        ),
        "a table that stops before runaway": HardCase(
            "Behind its last row an unloaded rotor would gather speed without end.",
            Refused("ends at runaway", accepted={"performance_table.table": OWN_ROTOR + "2.4,0\n"}),
            effects=("performance_table",),
            parameters={"performance_table.table": OWN_ROTOR},
        ),
        "calm and storm on a table": HardCase(
            "A turning rotor in no wind, and a gust far outside the table: the first and the last coefficient, within one step.",
            (AtLeast("speed", 0.0), AtMost("speed", 60.0 * 2.4 / 1.5 + 1e-9)),
            effects=("performance_table",),
            parameters={"start_speed": 4.0, "performance_table.table": OWN_ROTOR + "2.4,0\n"},
            inputs={"wind": jumps(0.0, (1.0, 60.0))},
            run=(4.0, 0.05),
        ),
    },
    "Wind": {
        "gusts without a rise": HardCase(
            "Steps of the wind up and down, across macro steps: never below 0, never above both.",
            (AtLeast("speed", 0.0), AtMost("speed", 12.0)),
            effects=("gusts",),
            parameters={"gusts.rise": 0.0, "gusts.stay": 0.35, "gusts.period": 1.0, "gusts.start_time": 0.5},
            run=(20.0, 1e-3),
        ),
        "turbulence that calms the wind": HardCase(
            "As strong as the mean: where it takes all, the wind is 0 and not negative.",
            (AtLeast("speed", 0.0), Finite(limit=10.0)),
            effects=("turbulence",),
            parameters={"turbulence.intensity": 1.0, "turbulence.length": 1.0, "turbulence.interval": 0.01},
            run=(50.0, 0.1),
        ),
        "gusts that overlap": HardCase(
            "A period shorter than a gust.",
            Refused("the duration of a gust", accepted={"gusts.period": 15.0}),
            effects=("gusts",),
            parameters={"gusts.period": 10.0},
        ),
        "turbulence without a mean": HardCase(
            "Nothing carries it along.",
            Refused("a mean speed", accepted={"mean_speed": 1e-3}),
            effects=("turbulence",),
            parameters={"mean_speed": 0.0},
        ),
    },
    "FixedTransmission": CALM
    | STANDSTILL
    | LIGHT
    | NO_NUMBER
    | {
        "a rest that is left as the drive grows": HardCase(
            "Drive and load are exactly 0; the turbine's speed grows as t².",
            (AtMost(events, 9.0, "events"), AtLeast("speed", 0.0)),
            inputs={"turbine_speed": InputSignal(lambda t: t * t)},
            run=(0.5, 0.05),
        ),
        "a seized pump": HardCase(
            "A load that nothing moves: the shaft winds up and the pump stays exactly at rest.",
            (AtMost("speed", 0.0),),
            inputs={"load_torque": 1e9, "turbine_speed": ramp(0.2)},
            run=(2.0, 0.05),
        ),
        "a load that comes and goes": HardCase(
            "Jumps of 100 N.m every tenth of a second on a turning shaft.",
            (AtLeast("speed", 0.0), Finite()),
            effects=("mesh_friction",),
            parameters={"start_speed": 3.0},
            inputs={"turbine_speed": 3.0, "load_torque": jumps(0.0, *((0.1 * k, 100.0 * (k % 2)) for k in range(1, 20)))},
            run=(2.0, 0.02),
        ),
    },
    "PlanetaryTransmission": CALM
    | STANDSTILL
    | LIGHT
    | NO_NUMBER
    | {
        "a brake at its level": HardCase(
            "Dry brake of the third shaft between holding and slipping, with a load that jumps.",
            (AtLeast("speed", 0.0), Finite()),
            effects=("dry_brake",),
            parameters={"dry_brake.static": 12.0},
            inputs={"turbine_speed": ramp(1.0), "load_torque": jumps(10.0, (1.0, 40.0), (2.0, 1.0))},
            run=(3.0, 0.02),
        ),
        "a seized pump": HardCase(
            "It stands; the third shaft turns instead of it.",
            (AtMost("speed", 0.0), Finite()),
            inputs={"load_torque": 1e9, "turbine_speed": 3.0},
            run=(2.0, 0.05),
        ),
        "one shaft for two": HardCase(
            "Turbine and pump on the same one.",
            Refused("two different shafts", accepted={"pump_on": "sun"}),
            parameters={"pump_on": "ring"},
        ),
    },
    "AveragedConverter": CALM
    | STANDSTILL
    | LIGHT
    | NO_NUMBER
    | {
        "a seized pump": HardCase(
            "A load above the peak: it stands, and takes nothing from the turbine.",
            (AtMost("speed", 0.0), AtMost("turbine_torque", 0.0)),
            inputs={"load_torque": 1e9, "turbine_speed": 3.0},
            run=(2.0, 0.05),
        ),
        "a gust": HardCase(
            "The turbine from 2 to 8 rad/s in a tenth of a second under load.",
            (AtLeast("speed", 0.0), Finite()),
            inputs={"load_torque": 10.0, "turbine_speed": InputSignal(lambda t: min(max(2.0 + 60.0 * (t - 1.0), 2.0), 8.0))},
            run=(4.0, 0.05),
        ),
    },
    "InertialConverter": CALM
    | {
        "through standstill and back": HardCase(
            "A turbine that swings about standstill, under load: the pump never turns back.",
            (
                AtLeast("speed", 0.0),
                Finite(),
                AtMost(lambda c: max(abs(c["slider_velocity"]) - 0.05 * c["speed"], 0.0), 1e-14, "slider beyond its clutch, m/s"),
            ),
            inputs={"load_torque": 5.0, "turbine_speed": sine(3.0, 2.0)},
            run=(3.0, 0.05),
        ),
        "a load above the peak": HardCase(
            "1.2 times what the lever gives: it is not moved by a bit.",
            (AtMost("speed", 0.0), AtMost("ratio", 0.0)),
            inputs={"turbine_speed": 3.0, "load_torque": 1.2 * PEAK},
            run=(2.0, 0.05),
        ),
        **{
            f"four events a revolution, {load:g} N.m": HardCase(
                "Clutches that close and open at 18 rad/s for a minute: none is missed and none doubled, and they cost little.",
                (
                    AtMost(lambda c: events(c) - 2.0 * c["crank_angle"] / math.pi, 8.0, "events beside four a revolution"),
                    AtLeast("speed", 0.0),
                    Ends(
                        lambda c: c.work["derivative_calls"] / (4.0 * max(c.work["steps"], 1)), 0.5, "cost of a step", value=1.0
                    ),
                ),
                inputs={"turbine_speed": 3.0, "load_torque": load},
                run=(60.0, 1.0),
            )
            for load in (0.5, 5.0, 15.0)
        },
        **{
            f"a resting turbine under load, {name}": HardCase(
                "It moves nothing.",
                (
                    AtMost(lambda c: c.x[:6], 0.0, "state"),
                    AtMost(_still, 0.0, "torques"),
                    Ends(_mode, 0.0, "mode", value=STANDING),
                ),
                effects=effects,
                inputs={"turbine_speed": 0.0, "load_torque": 5.0},
                run=(0.2, 0.1),
            )
            for name, effects in (("rigid clutches", ()), ("slipping clutches", ("compliant_clutches",)))
        },
        "a rest left with slipping clutches": HardCase(
            "Nothing moves and nothing brakes; then the shaft follows as it does with rigid ones.",
            (
                Like("speed", 1e-3, instead={"effects": (), "parameters": {}}, share=True),
                AtMost(events, 10.0, "events"),
                Reaches("speed", high=1e-3),
            ),
            effects=("compliant_clutches",),
            inputs={"turbine_speed": ramp(1.0)},
            run=(1.0, 1.0),
        ),
        "slipping clutches under a load that drives": HardCase(
            "It falls below 0 from 0: 1 N.m/s on 1 kg m².",
            (Ends("speed", 1e-9, value=0.5 * 0.25**2),),
            effects=("compliant_clutches",),
            inputs={"turbine_speed": 0.0, "load_torque": ramp(-1.0)},
            run=(0.25, 0.25),
        ),
        "a load above the peak on slipping clutches": HardCase(
            "It is not moved by a bit.",
            (AtMost("speed", 0.0), AtMost("ratio", 0.0)),
            effects=("compliant_clutches",),
            inputs={"turbine_speed": 3.0, "load_torque": 1.2 * PEAK},
            run=(0.25, 0.05),
        ),
        "a turbine that stops": HardCase(
            "The driven shaft runs out by load over inertia, and stands.",
            (Ends("speed", 0.0), Ends(_mode, 0.0, "mode", value=STANDING)),
            parameters={"start_speed": 5.0},
            inputs={"turbine_speed": jumps(3.0, (5.0, 0.0)), "load_torque": 2.0},
            run=(35.0, 1.0),
        ),
        "a load that drives": HardCase(
            "2 N.m on 1 kg m², and the lever at rest; it never turns back.",
            (Ends("speed", 1e-11, value=6.0), AtMost("slider_velocity", 0.0)),
            inputs={"turbine_speed": 0.0, "load_torque": -2.0},
            run=(3.0, 0.5),
        ),
        "a load that drives and then brakes": HardCase(
            "It stops, and does not turn back.",
            (Ends("speed", 0.0), AtLeast("speed", 0.0), Reaches("speed", high=5.9)),
            inputs={"turbine_speed": 0.0, "load_torque": jumps(-2.0, (3.0, 3.0))},
            run=(8.0, 0.5),
        ),
        "backwards": HardCase(
            "Crank and slider change their sign, the driven shaft turns the same way: to the last bit.",
            (
                Like(
                    _seen,
                    0.0,
                    "mirrored outputs",
                    instead={"inputs": {"turbine_speed": -3.0, "load_torque": 5.0}},
                    mirror=_mirrored,
                ),
                Reaches("speed", high=0.1),
            ),
            inputs={"turbine_speed": 3.0, "load_torque": 5.0},
            run=(10.0, 0.1),
        ),
        "a turbine that turns over": HardCase(
            "From one step to the next, in both directions: the pump's shaft starts again.",
            (AtLeast("speed", 0.0), Ends(lambda c: min(c["speed"], 0.1), 0.0, "speed up to 0.1 rad/s", value=0.1)),
            inputs={"turbine_speed": jumps(-3.0, (5.0, 3.0), (10.0, -3.0), (15.0, 3.0)), "load_torque": 5.0},
            run=(20.0, 5.0),
        ),
        "a light lever on a light shaft": HardCase(
            "Without load the shaft follows up to the largest speed, rho m b w / ((m + m_s) r).",
            (Ends("speed", 1e-2, value=0.5 * 18.0 * 2.0, share=True),),
            parameters={"lever_mass": 1e-6, "slider_mass": 1e-6, "driven_inertia": 1e-6},
            inputs={"turbine_speed": 3.0},
            run=(100.0, 10.0),
        ),
        "a slider without mass": HardCase(
            "The mass matrix stays regular, as the lever's mass moves with the slider.",
            (AtMost("speed", 100.0), Reaches("speed", high=1e-3)),
            parameters={"slider_mass": 0.0},
            inputs={"turbine_speed": 3.0, "load_torque": 5.0},
            run=(30.0, 1.0),
        ),
        "a macro step of ten seconds": HardCase(
            "It is a thousand of ten milliseconds: rounding, through 110 events.",
            (
                Like(lambda c: c.x, 1e-7, "state after short steps", instead={"run": (10.0, 0.01)}),
                Like(events, 0.0, "events of short steps", instead={"run": (10.0, 0.01)}),
                Reaches(events, high=100.0),
            ),
            inputs={"turbine_speed": 3.0, "load_torque": 5.0},
            run=(10.0, 10.0),
        ),
        "a lever of a milligram": HardCase(
            "It pushes nothing: the pump stands, and the crank turns as if it were alone.",
            (AtMost("speed", 0.0), Ends("crank_speed", 1e-6, value=18.0)),
            parameters={"lever_mass": 1e-6, "slider_mass": 0.0},
            inputs={"turbine_speed": 3.0, "load_torque": 1.0},
            run=(3.0, 0.1),
        ),
        "stiff clutches": HardCase(
            "Slipping ones that relax far more quickly than their substep.",
            Refused("limit of RK4", accepted={"compliant_clutches.damping": 4e3}),
            effects=("compliant_clutches",),
            parameters={"compliant_clutches.damping": 1e5},
        ),
        "a crank too fast for the substep": HardCase(
            "240 rad/s at 2 ms.",
            Refused("range", "step", {"substep": 2e-4}),
            inputs={"turbine_speed": jumps(3.0, (0.0, 40.0))},
            run=(1.0, 0.1),
        ),
    },
    "PistonPump": {
        "through standstill and back": HardCase(
            "It takes no negative speed: the crank stands, and nothing flows back.",
            (AtLeast("flow", 0.0), AtLeast("hydraulic_power", 0.0), Finite()),
            effects=("leakage", "seal_friction"),
            parameters={"action": "double"},
            inputs={"speed": sine(30.0, 10.0)},
            run=(2.0, 0.02),
        ),
        "a dry well": HardCase(
            "No head: no torque, no power, and it turns.",
            (AtMost("torque", 0.0), AtMost("hydraulic_power", 0.0)),
            inputs={"head": 0.0, "speed": 10.0},
            run=(1.0, 0.02),
        ),
        "a rod as thick as the piston": HardCase(
            "No return stroke is left.",
            Refused("less than the piston's", accepted={"rod_diameter": 0.059}),
            parameters={"action": "double", "rod_diameter": 0.06},
        ),
        "a speed that is no number": HardCase(
            "The run ends.",
            Refused("not finite", "step", {"speed": 1.0}),
            inputs={"speed": jumps(0.0, (0.0, math.nan))},
            run=(0.1, 0.01),
        ),
    },
    "CentrifugalPump": {
        "standstill against a head": HardCase(
            "No flow and no 0 / 0 in the efficiency; friction alone is left.",
            (AtMost("flow", 0.0), AtMost("torque", 0.2)),
            effects=("seal_friction",),
            inputs={"speed": 0.0, "head": 100.0},
            run=(0.1, 0.01),
        ),
        "a valve that opens and closes": HardCase(
            "Speed through the shut-off head: flow from 0 without a jump, never negative.",
            (AtLeast("flow", 0.0), AtLeast("hydraulic_power", 0.0), Finite()),
            inputs={"speed": InputSignal(lambda t: 150.0 * math.sin(3.0 * t) ** 2), "head": 10.0},
            run=(2.0, 0.01),
        ),
        "a negative speed and a negative head": HardCase(
            "They count as standstill and as none.",
            (AtMost("flow", 0.0), AtMost("torque", 0.0)),
            inputs={"speed": -1e9, "head": -1e9},
            run=(0.1, 0.01),
        ),
        "a curve beyond its efficiency": HardCase(
            "It reaches flows at which the parabola is negative.",
            Refused("less than twice", accepted={"best_flow": 1.2e-3}),
            parameters={"best_flow": 0.9e-3},
        ),
        "a table whose head rises with the flow": HardCase(
            "One head would have two flows.",
            Refused("a head that falls", accepted={"curve_table.table": SHEET.format(28)}),
            effects=("curve_table",),
            parameters={"curve_table.table": SHEET.format(31)},
        ),
        "a table whose pump speeds up and slows down": HardCase(
            "Through the shut-off head and behind the last row: a flow without a jump, never negative.",
            (AtLeast("flow", 0.0), AtLeast("hydraulic_power", 0.0), Finite()),
            effects=("curve_table",),
            inputs={"speed": InputSignal(lambda t: 150.0 * math.sin(3.0 * t) ** 2), "head": 4.0},
            run=(2.0, 0.01),
        ),
    },
    "WaterPipe": {
        "a tank that is full, empty and full": HardCase(
            "Each limit is met and left; no water is lost or made.",
            (AtMost(_water, 1e-12, "balance of the water, m³"), AtLeast("tank.level", 0.0), AtMost("tank.level", 2.0)),
            effects=("tank", "friction"),
            parameters={"tank.start_level": 0.5, "tank.area": 2.0},
            inputs={"flow": jumps(1.0, (5.0, 0.0), (10.0, 2.0)), "tank.demand": jumps(0.0, (5.0, 1.5), (10.0, 0.5))},
            run=(15.0, 0.1),
        ),
        "water hammer on a thimble of air": HardCase(
            "A pump that stops within a step: the column swings, and friction damps it.",
            (Finite(), AtLeast("head", 0.0, low=-10.33)),
            effects=("air_vessel", "friction"),
            parameters={"air_vessel.gas_volume": 5e-4},
            inputs={"flow": jumps(0.0, (0.0, 1e-3), (1.0, 0.0))},
            run=(3.0, 0.02),
        ),
        "no air to speak of": HardCase(
            "A cubic millimetre: the column's frequency is beyond the substep.",
            Refused("limit of RK4", accepted={"substep": 7.5e-4}),
            effects=("air_vessel",),
            parameters={"air_vessel.gas_volume": 1e-9},
        ),
        "a tank that begins above its rim": HardCase(
            "Its level is beyond the overflow.",
            Refused("at most the height", accepted={"tank.start_level": 2.0}),
            effects=("tank",),
            parameters={"tank.start_level": 2.1},
        ),
    },
}
