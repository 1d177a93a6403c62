"""A hull in waves that weighs what it displaces moves with the water. The runs are long: machine code."""

import math

import numpy as np
import pytest
from cosimo.components.rov.current import WaterCurrent
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.waves import GRAVITY
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from scipy.integrate import solve_ivp


def particle(start: np.ndarray, mean: float, height: float, period: float, times: np.ndarray) -> np.ndarray:
    """(n, 2) place along the wave and depth of a particle of water in deep water, by another method and its own equations."""
    w = 2.0 * math.pi / period
    shifted = GRAVITY + 2.0 * w * mean
    k = w * w / GRAVITY if mean == 0.0 else (shifted - math.sqrt(shifted**2 - (2.0 * w * mean) ** 2)) / (2.0 * mean**2)
    orbit = 0.5 * height * (w - k * mean)

    def velocity(t: float, x: np.ndarray) -> list[float]:
        strength = orbit * math.exp(-k * x[1])
        return [mean + strength * math.cos(k * x[0] - w * t), -strength * math.sin(k * x[0] - w * t)]

    return solve_ivp(velocity, (times[0], times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-12).y.T


@pytest.mark.parametrize(
    ("mean", "height", "period", "depth"),
    [
        (0.0, 1.0, 4.0, 2.0),
        (0.0, 0.5, 6.0, 5.0),
        (0.5, 0.5, 3.0, 2.0),
        (1.0, 1.0, 4.0, 2.0),
        (2.0, 1.0, 4.0, 3.0),
        pytest.param(0.3, 1.5, 4.0, 2.0, marks=pytest.mark.full),
        pytest.param(0.0, 1.8, 4.0, 2.5, marks=pytest.mark.full),
    ],
)
def test_a_free_neutral_hull_goes_where_a_particle_goes(mean, height, period, depth):
    """For 60 s, in steep waves and currents: within 1 % of the wave's amplitude, with the speed of the water to 0.1 %."""
    current = WaterCurrent(("waves",), {"speed": mean, "waves.height": height, "waves.period": period, "waves.water_depth": 1e3})
    current.initialize(0.0)
    current.set("waves.depth", depth)
    current.refresh()
    start = current.y[:3].copy()
    scene = read_scene(
        {
            "stop_time": 60.0,
            "master": {"step": 0.01, "algorithm": "iterative", "extrapolation": 2},
            "connections": [
                "water.* -> hull.current.*",
                "hull.position_north -> water.waves.position_north",
                "hull.depth -> water.waves.depth",
            ],
            "units": {
                "water": {
                    "component": "WaterCurrent",
                    "effects": ["waves"],
                    "parameters": {"speed": mean, "waves": {"height": height, "period": period, "water_depth": 1e3}},
                },
                "hull": {
                    "component": "RovHull",
                    "effects": ["added_mass", "linear_drag", "current", "pressure_gradient"],
                    "parameters": {
                        "start_depth": depth,
                        "centre_of_gravity_z": 0.0,
                        "start_surge": start[0],
                        "start_heave": start[2],
                        "mass": 11.5,
                        "pressure_gradient.displaced_mass": 11.5,
                    },
                },
            },
        }
    )
    result = run(scene, in_process=True)
    path = particle(np.array([0.0, depth]), mean, height, period, result.time)
    assert np.abs(result["hull.position_north"] - path[:, 0]).max() < 0.01 * 0.5 * height
    assert np.abs(result["hull.depth"] - path[:, 1]).max() < 0.01 * 0.5 * height
    speed = result["water.velocity_north"]
    assert np.abs(result["hull.surge"] - speed).max() < 1e-3 * np.abs(speed).max()
    assert path[-1, 0] - mean * 60.0 > 0.0  # and it drifts with the waves


@pytest.mark.known_answers(RovHull="pressure_gradient")
@pytest.mark.parametrize("displaced", [11.5, 11.7, 14.0])
def test_a_neutral_hull_moves_with_the_water_of_a_wave(displaced):
    """|V/u| = |(rho V + m_a) i w + d| / |(m + m_a) i w + d|, 1 where the hull weighs what it displaces; linear drag."""
    mass, added, drag, w, amplitude = 11.5, 5.5, 4.03, 1.2, 0.2
    hull = RovHull(
        ("added_mass", "linear_drag", "current", "pressure_gradient"),
        {"pressure_gradient.displaced_mass": displaced, "centre_of_gravity_z": 0.0},
    )
    hull.set("current.velocity_north", 0.0)
    response = complex(drag, w * (displaced + added)) / complex(drag, w * (mass + added))
    hull.set("start_surge", amplitude * response.imag)
    hull.initialize(0.0)
    step = 0.02
    for k in range(400):
        t = k * step
        for name, value, rate, bend in (
            ("velocity", math.sin(w * t), w * math.cos(w * t), -w * w * math.sin(w * t)),
            ("acceleration", w * math.cos(w * t), -w * w * math.sin(w * t), -(w**3) * math.cos(w * t)),
        ):
            i = hull.input_positions([f"current.{name}_north"])[0]
            hull.u[:, i] = amplitude * np.array([value, rate, 0.5 * bend])
        hull.step(t, step)
    t = 400 * step
    wanted = amplitude * (response * complex(math.cos(w * t), math.sin(w * t))).imag
    assert hull["surge"] == pytest.approx(wanted, abs=1e-6)  # of inputs as parabolas in each step
