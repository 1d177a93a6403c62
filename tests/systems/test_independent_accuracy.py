"""What `run --accuracy 1%` promises, against solutions that share no code with the runs: equations of tests, closed forms.

A study finds the setting with a reference of its own; here the run at that setting is compared with a solution that the study
does not know. The study's reference, too, has to be as good as it says.
"""

import math

import numpy as np
import pytest
from cosimo import accuracy, load_scene, read_scene
from cosimo.orchestrator.harness.studies.fronts import choose
from cosimo.orchestrator.harness.studies.quantities import TimeHistory, errors, quantities_of
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems.railway.modal import Head, Line, passage
from cosimo.tests.systems.equations import CLEARANCE, LOAD, ball_bearing, lumped_catenary, solved

G = 9.81  # m/s2
ACCURACY = 0.01
BUDGET = 2.0  # s of measuring, beside the reference
RAILWAY_BUDGET = 60.0  # s; a finer mesh may take a twentieth of it, on a busy machine, too
FINE = 10_000  # instants of an independent solution beside those of the run


def mass_on_spring(t):
    """1 kg with 1 m/s on 100 N/m and 4 N.s/m: the damped oscillation in closed form."""
    decay, omega = 2.0, math.sqrt(100.0 - 4.0)
    x = np.exp(-decay * t) * np.sin(omega * t) / omega
    v = np.exp(-decay * t) * np.cos(omega * t) - decay * x
    return {"mass.base_x": x, "mass.base_velocity_x": v, "spring.second_force_x": -100.0 * x - 4.0 * v}


def damped_chain(t):
    """Two point masses of 1 kg on rods of 1 m, dampers of 0.1 and 0.05 N.m.s/rad: the textbook's equations in absolute angles."""

    def rates(_, x):
        a, b, u, v = x
        d, relative = a - b, 0.05 * (u - v)
        mass = [[2.0, math.cos(d)], [math.cos(d), 1.0]]
        torque = [
            -math.sin(d) * v**2 - 2.0 * G * math.sin(a) - 0.1 * u - relative,
            math.sin(d) * u**2 - G * math.sin(b) + relative,
        ]
        return [u, v, *np.linalg.solve(mass, torque)]

    a, b, u, v = solved(rates, [0.08, -0.05, 0.0, 0.0], t)
    return {
        "chain.first_angle": a,
        "chain.second_angle": b,
        "chain.first_rate": u,
        "chain.second_rate": v,
        "chain.tip_x": np.sin(a) + np.sin(b),
        "chain.tip_y": -np.cos(a) - np.cos(b),
    }


def link_split(t):
    """Two rods of 1 kg and 1 m on a spring of 1e5 N/m and 100 N.s/m: a pinned angle, and a free body by its centre of mass."""
    inertia = 1.0 / 12.0

    def along(angle):
        return np.array([math.sin(angle), -math.cos(angle)]), np.array([math.cos(angle), math.sin(angle)])  # and its derivative

    def force(x):
        """On the first rod's tip."""
        (first, first_turn), (second, second_turn) = along(x[0]), along(x[3])
        apart = first - (x[1:3] - 0.5 * second)
        rate = first_turn * x[4] - (x[5:7] - 0.5 * second_turn * x[7])
        return -1e5 * apart - 100.0 * rate

    def rates(_, x):
        f, torque = force(x), 0.02 * (x[7] - x[4])
        first_turn, second_turn = along(x[0])[1], along(x[3])[1]
        alpha = (-0.5 * G * math.sin(x[0]) + first_turn @ f + torque) / (inertia + 0.25)
        beta = (0.5 * second_turn @ f - torque) / inertia  # the base is half a metre behind the centre, and feels -f
        return [*x[4:8], alpha, -f[0], -f[1] - G, beta]

    base = np.array([0.717356090899523, -0.696706709347165])
    start = [0.8, *(base + 0.5 * along(1.2)[0]), 1.2, 0.0, 0.0, 0.0, 0.0]
    x = solved(rates, start, t, rtol=1e-9, atol=1e-11)
    first_force = np.array([force(state) for state in x.T])
    return {
        "first.angle": x[0],
        "second.angle": x[3],
        "first.rate": x[4],
        "second.rate": x[7],
        "second.tip_x": x[1] + 0.5 * np.sin(x[3]),
        "second.tip_y": x[2] - 0.5 * np.cos(x[3]),
        "first.tip_x": np.sin(x[0]),
        "first.tip_y": -np.cos(x[0]),
        "joint.first_force_x": first_force[:, 0],
        "joint.first_force_y": first_force[:, 1],
    }


def rov_added_mass(t):
    """11.5 kg and 14.57 kg of water sink under 10 N against 5.18 N.s/m: an exponential."""
    final, rate = 10.0 / 5.18, 5.18 / (11.5 + 14.57)
    speed, depth = final * -np.expm1(-rate * t), final * (t + np.expm1(-rate * t) / rate)
    acceleration = final * rate * np.exp(-rate * t)
    columns = {"depth": depth, "heave": speed, "external.acceleration_z": acceleration}
    return {f"{unit}.{name}": values for unit in ("hull", "whole") for name, values in columns.items()} | {
        "water.force_z": -14.57 * acceleration
    }


def rov_tumbling(t):
    """Kirchhoff's body in a perfect fluid: p' = p x w, h' = h x w + p x v with p = M v, h = I w, added masses included."""
    masses, inertias = 11.5 + np.array([5.5, 12.7, 14.57]), np.full(3, 0.16 + 0.12)

    def rates(_, x):
        v, w, (a, b, c, d) = x[:3], x[3:6], x[6:10]
        p, h = masses * v, inertias * w
        turn = 0.5 * np.array(
            [
                -b * w[0] - c * w[1] - d * w[2],
                a * w[0] + c * w[2] - d * w[1],
                a * w[1] + d * w[0] - b * w[2],
                a * w[2] + b * w[1] - c * w[0],
            ]
        )
        matrix = np.array(
            [
                [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
                [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
                [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
            ]
        )
        return [*(np.cross(p, w) / masses), *((np.cross(h, w) + np.cross(p, v)) / inertias), *turn, *(matrix @ v)]

    x = solved(rates, [0.7, -0.4, 0.5, 1.0, -0.5, 0.75, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0], t)
    names = ("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")
    return {f"hull.{n}": x[k] for k, n in enumerate(names)} | {
        "hull.position_north": x[10],
        "hull.position_east": x[11],
        "hull.depth": x[12],
    }


def jeffcott(t):
    """10 kg on 1e5 N/m and 40 N.s/m, 10 um off centre at 80 rad/s from rest: forced and free oscillation in closed form."""
    m, c, k, w = 10.0, 40.0, 1e5, 80.0
    forced = m * 1e-5 * w**2 / (k - m * w**2 + 1j * c * w)
    s1, s2 = np.roots([m, c, k])
    b1 = (s2 - 1j * w) * forced / (s1 - s2)  # z(0) = z'(0) = 0
    z = forced * np.exp(1j * w * t) + b1 * np.exp(s1 * t) - (forced + b1) * np.exp(s2 * t)
    v = 1j * w * forced * np.exp(1j * w * t) + s1 * b1 * np.exp(s1 * t) - s2 * (forced + b1) * np.exp(s2 * t)
    columns = {"displacement_x": z.real, "displacement_y": z.imag, "velocity_x": v.real, "velocity_y": v.imag}
    return {f"rotor.{name}": values for name, values in columns.items()}


def pantograph_and_catenary(speed, stop_time):
    """Six spans of EN 50318:2002: both wires as sine series of 3600 modes, exact in time; the pantograph with them."""
    force = passage(Line(spans=6), Head(), speed, 30.0, stop_time, 3600, 5e-4)

    def independent(t):
        return {"pantograph.contact_force": np.interp(t, force[0], force[2])}

    return independent


def railway(speed_kmh, stop_time):
    """The EN 50318:2002 scene on six spans, and its independent solution."""
    speed = speed_kmh / 3.6
    scene = load_scene("en50318-2002")
    parameters = {**scene.units["catenary"].parameters, "spans": 6, "first_watched_support": 0}
    return pantograph_and_catenary(speed, stop_time), lambda: scene.with_changes(
        {
            "stop_time": stop_time,
            "pantograph.speed": speed,
            "units.catenary.parameters": parameters,
            "record.snapshots": [],
            "record.snapshot_interval": None,
        }
    )


ROTOR = {
    "stop_time": 2.0,
    "master": {"step": 5e-3},
    "units": {"rotor": {"component": "JeffcottRotor", "effects": ["unbalance"], "parameters": {"start_speed": 80.0}}},
    "record": {"signals": [f"rotor.{n}_{a}" for n in ("displacement", "velocity") for a in "xy"]},
}
BEARING = {
    "stop_time": 0.1,
    "analysis": {},
    "sweep": {},
    "units.bearing.parameters": {"speed": 104.71975511965978, "clearance.radial_clearance": CLEARANCE, "load": LOAD},
}
SYSTEMS = {
    "mass-on-spring": (mass_on_spring, lambda: load_scene("mass-on-spring").with_changes({"stop_time": 3.0})),
    "damped-chain": (damped_chain, lambda: load_scene("damped-chain").with_changes({"stop_time": 10.0})),
    "link-split": (link_split, lambda: load_scene("link-split").with_changes({"stop_time": 0.5})),
    "rov-added-mass": (rov_added_mass, lambda: load_scene("rov-added-mass").with_changes({"stop_time": 2.0})),
    "rov-tumbling": (rov_tumbling, lambda: load_scene("rov-tumbling").with_changes({"stop_time": 10.0})),
    "lumped-catenary": (lumped_catenary, lambda: load_scene("lumped-catenary").with_changes({"stop_time": 2.0, "analysis": {}})),
    "ball-bearing-clearance": (ball_bearing, lambda: load_scene("ball-bearing-clearance").with_changes(BEARING)),
    "jeffcott-rotor": (jeffcott, lambda: read_scene(ROTOR)),
}


def compared(scene, independent):
    """The scene's quantities that the independent solution has; it is computed at a run's instants."""
    known = independent(np.linspace(0.0, 1e-3, 3))
    chosen = [q for q in quantities_of(scene) if q.signal in known]
    assert len(chosen) >= 2
    return scene.with_changes({"study.quantities": [q.name for q in chosen]}), chosen


@pytest.mark.full
@pytest.mark.parametrize("name", SYSTEMS)
def test_one_percent_holds_against_an_independent_solution(name):
    holds(*SYSTEMS[name], [ACCURACY], BUDGET)


@pytest.mark.full
@pytest.mark.parametrize(("speed", "shares"), [(250.0, [0.01, 0.005]), (300.0, [0.01])])
def test_filtered_contact_force_holds_against_sine_series(speed, shares):
    """20 Hz-filtered force, its error in shares of its standard deviation."""
    holds(*railway(speed, 3.0), shares, RAILWAY_BUDGET)


def holds(independent, make, shares, budget):
    """Assert that the settings advised for some shares keep them."""
    scene, quantities = compared(make(), independent)
    measured = accuracy(scene, budget=budget, repeats=1)
    for share in shares:
        point = choose(measured, share)
        result = run(scene.with_changes(point.changes), in_process=True)
        time = np.union1d(result.time, np.linspace(0.0, scene.stop_time, FINE + 1))  # a coarse run misses peaks, which count
        exact = TimeHistory(time, independent(time))
        actual = errors(quantities, TimeHistory(result.time, result.columns), exact)
        assert max(actual.values()) <= share, actual
        for q in quantities:  # and what the study says of this setting is no less than what it is
            if q.kind == "time history":  # a maximum is that of the samples
                assert actual[q.name] <= 1.01 * (point.errors[q.name] + measured.uncertainty[q.name]) + 1e-9
