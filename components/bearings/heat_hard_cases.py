"""Hard cases of bearings' heat: no load, no heat, infinite conductances and capacities, steps of a quarter hour."""

from __future__ import annotations

import numpy as np

from ..core.component import Component
from ..core.hard_cases import (
    AtLeast,
    AtMost,
    Ends,
    Falling,
    Finite,
    HardCase,
    InputSignal,
    Like,
    Reaches,
    Refused,
    jumps,
    outputs,
)

PATHS = ("gas_path", "convection", "radiation")
BIG_RINGS = {"ball_capacity": 5e-4, "inner_capacity": 5e5, "outer_capacity": 5e5}


def _rise(component: Component) -> np.ndarray:
    return component.x[:4] - 293.15


def _balance(component: Component) -> float:
    return component["heat_supplied"] - component["heat_stored"] - component["heat_released"]


def _side_paths(component: Component) -> float:
    return component["conductance"] - component["ball_conductance"]


def _conductances(component: Component) -> np.ndarray:
    """Of a contact that is open: all, and through balls that carry nothing."""
    return np.array([component["conductance"], component["loaded_balls"]])


def _ball_above_rings(component: Component) -> float:
    return component.x[1] - 0.5 * (component.x[0] + component.x[2])


HEAT_HARD_CASES = {
    "AngularContactConductance": {
        "load over twelve decades": HardCase(
            "Contacts that vanish with the cube root of the load: no division by their size.",
            (AtLeast("conductance", 0.0), Ends("conductance", 1e-4)),
            inputs={"axial_force": InputSignal(lambda t: 10.0 ** (3.0 - t), smooth=False)},
            run=(13.0, 1.0),
        ),
        "balls unload one after the other": HardCase(
            "A radial load beside an axial one, up to ten times as large.",
            (Falling("loaded_balls"), AtLeast("loaded_balls", 0.0, low=1.0), AtLeast("conductance", 0.0), Finite()),
            parameters={"balls": 16},
            inputs={"axial_force": 500.0, "radial_force": InputSignal(lambda t: 5e3 * t)},
            run=(1.0, 0.05),
        ),
        "a load that comes and goes": HardCase(
            "It leaves no trace.",
            (Like(outputs, 0.0, "all outputs without a load", instead={"inputs": {}}),),
            effects=("ball_bulk", "gas_path"),
            inputs={"axial_force": jumps(0.0, (1.0, 3000.0), (2.0, 1e-9), (3.0, 50.0), (4.0, 0.0))},
            run=(5.0, 1.0),
        ),
        "rings thinner than nothing": HardCase(
            "A bore beyond the race.",
            Refused("walls around", accepted={"ring_walls.bore": 0.045}),
            effects=("ring_walls",),
            parameters={"ring_walls.bore": 0.05},
        ),
        "no load at all": HardCase(
            "Nothing passes balls that touch nothing.",
            (AtMost(_conductances, 0.0, "conductance, loaded balls"),),
            effects=("ball_bulk", "ring_walls", "film"),
            run=(0.1, 0.1),
        ),
        "no load beside the contacts": HardCase(
            "Gas, convection and radiation stay when they open.",
            (AtMost("conductance", 0.2), Reaches("ball_conductance", high=1e-6), Reaches(_side_paths, high=1e-6)),
            effects=("ball_bulk", "ring_walls", "film", *PATHS),
            run=(0.1, 0.1),
        ),
        **{
            f"load over fifteen decades, {name}": HardCase(
                "Continuous down to none: the cube root still leaves 1e-3 at 1e-9 N.",
                (Falling("conductance"), Like("conductance", 1e-3, instead={"inputs": {}, "run": (1.0, 1.0)})),
                effects=effects,
                inputs={"axial_force": InputSignal(lambda t: 10.0 ** (3.0 - t), smooth=False)},
                run=(16.0, 1.0),
            )
            for name, effects in (
                ("film", ("film",)),
                ("side paths", PATHS),
                ("everything", ("ball_bulk", "ring_walls", "film", "lubricant_path", *PATHS)),
            )
        },
    },
    "BearingTemperatures": {
        "no heat": HardCase(
            "Nothing changes, to rounding of 293 K through flows that should be 0.",
            (AtMost(_rise, 1e-9, "rise of the temperatures"), AtMost("clearance_change", 1e-14)),
            effects=("housing", "oil_flow", "radiation", "shaft_heat"),
            parameters={"substep": 500.0},
            inputs={"conductance": 0.7},
            run=(20e3, 1e3),
        ),
        "capacities of nothing": HardCase(
            "Time constants of nanoseconds under steps of a quarter of an hour: the steady state.",
            (
                Ends("inner_temperature", 1e-9, value=293.15 + 350.0 / 11.0),
                Ends("ball_temperature", 1e-9, value=293.15 + 387.5 / 11.0),
                AtMost(_balance, 1e-6, "balance of heat, J"),
            ),
            parameters={f"{part}_capacity": 1e-9 for part in ("inner", "ball", "outer")} | {"substep": 1000.0},
            inputs={"friction_power": 20.0},
            run=(3e3, 1e3),
        ),
        "an infinite conductance": HardCase(
            "1e12 W/K: one mass, P over both ways out.",
            (
                Ends("inner_temperature", 1e-6, value=293.15 + 20.0 / 1.2),
                Ends("ball_temperature", 1e-6, value=293.15 + 20.0 / 1.2),
            ),
            parameters={"substep": 100.0},
            inputs={"friction_power": 20.0, "conductance": 1e12},
            run=(2e4, 1e3),
        ),
        "a negative conductance": HardCase(
            "An extrapolated input may fall below 0: the balls keep what is theirs.",
            (Ends("ball_temperature", 1e-9, value=293.15 + 10.0 * 100.0 / 15.0),),
            inputs={"friction_power": 20.0, "conductance": -0.5},
            run=(100.0, 100.0),
        ),
        "more heat shared out than there is": HardCase(
            "Shares above 1.",
            Refused("at most 1", accepted={"inner_share": 0.5}),
            parameters={"inner_share": 0.6, "outer_share": 0.5},
        ),
        "no conductance": HardCase(
            "The balls keep what is theirs, the rings lose it on their own.",
            (
                Ends("inner_temperature", 1e-4, value=293.15 + 0.25 * 20.0 / 0.2),
                Ends("outer_temperature", 1e-4, value=293.15 + 0.25 * 20.0),
                Ends("ball_temperature", 1e-3, value=293.15 + 10.0 * 2e5 / 15.0),
            ),
            parameters={"substep": 100.0},
            inputs={"friction_power": 20.0, "conductance": 0.0},
            run=(2e5, 1e3),
        ),
        "balls of a milligram between rings of a tonne": HardCase(
            "They are warmer by what passes 2 G to either side.",
            (Ends(_ball_above_rings, 1e-2, "balls above rings, K", value=10.0 / (4.0 * 0.2), share=True),),
            parameters=BIG_RINGS | {"substep": 1000.0},
            inputs={"friction_power": 20.0},
            run=(1e3, 1e3),
        ),
        "macro steps of any length": HardCase(
            "A thousand seconds and ten: the same internal steps, but for rounded times.",
            (Like(lambda c: c.x, 1e-13, "state after steps of 10 s", instead={"run": (2e3, 10.0)}, share=True),),
            effects=("radiation", "housing"),
            parameters={"substep": 10.0},
            inputs={"friction_power": 20.0},
            run=(2e3, 1e3),
        ),
        "very hot from absolute zero": HardCase(
            "100 kW from 0 K into 0 K.",
            (Reaches("inner_temperature", high=1.0), AtLeast("outer_temperature", 0.0), AtMost("clearance_change", 1.0)),
            effects=("radiation",),
            parameters={"start_temperature": 0.0, "ambient": 0.0},
            inputs={"friction_power": 1e5},
            run=(1e3, 10.0),
        ),
    },
}
