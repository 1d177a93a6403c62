"""Equations of machines written down and solved without the project's code: what runs and estimates are judged by."""

import math

import numpy as np
from scipy.integrate import solve_ivp

CLEARANCE, LOAD = 5e-6, 200.0  # m, N; of the ball bearing


def solved(rates, start, t, **options):
    """States (n, len(t)) of x' = rates(t, x)."""
    options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12} | options
    solution = solve_ivp(rates, (0.0, float(t[-1])), start, t_eval=t, **options)
    assert solution.success
    return solution.y


def lumped_catenary(t, static_force=120.0):
    """Pantograph of EN 50318:2002 under a mass on a spring whose stiffness varies along the span; a contact that can open.

    static_force: N.
    """
    harmonics = np.array([0.3603, 0.0977, -0.0004, -0.0392, -0.0489, -0.0437, -0.0332, -0.0253, -0.0284, 0.0165])
    orders = np.arange(1, 11)

    def stiffness(x):
        return 2807.0 * (1.0 + harmonics @ np.cos(2.0 * np.pi * orders * x / 60.0))

    def rates(s, x):
        wire, head, frame, wire_rate, head_rate, frame_rate = x
        contact = max(50e3 * (head - wire), 0.0)
        between = 4200.0 * (head - frame) + 10.0 * (head_rate - frame_rate)
        return [
            wire_rate,
            head_rate,
            frame_rate,
            (contact - 328.6 * wire_rate - stiffness(30.0 + 69.444444 * s) * wire) / 8.775,
            (-between - contact) / 7.2,
            (between - 50.0 * frame - 90.0 * frame_rate + static_force) / 15.0,
        ]

    soft = 1.0 / stiffness(30.0) + 1.0 / 50e3 + 1.0 / 4200.0  # at rest: the frame's spring takes a share of the static force
    force = static_force / (1.0 + 50.0 * soft)
    wire, head, frame = force / stiffness(30.0), force * (soft - 1.0 / 4200.0), force * soft
    x = solved(rates, [wire, head, frame, 0.0, 0.0, 0.0], t, max_step=2e-3)
    return {
        "catenary.wire_height": x[0],
        "pantograph.head_height": x[1],
        "pantograph.frame_height": x[2],
        "pantograph.head_velocity": x[4],
        "pantograph.contact_force": np.maximum(50e3 * (x[1] - x[0]), 0.0),
    }


def ball_bearing(t, clearance=CLEARANCE, load=LOAD):
    """Eight Hertzian contacts of exponent 1.5 that run around with the cage; start from the static position under the load (m, N)."""
    balls = 2.0 * np.pi / 8.0 * np.arange(8)
    cage = 104.71975511965978 * 0.5 * (1.0 - 11.9 / 52.0)

    def force(x, y, angle):
        direction = np.array([np.cos(balls + angle), np.sin(balls + angle)])
        return direction @ (1.334e10 * np.maximum(direction.T @ [x, y] - clearance, 0.0) ** 1.5)

    def rates(s, state):
        fx, fy = force(state[0], state[1], cage * s)
        return [state[2], state[3], (load - fx - 200.0 * state[2]) / 20.0, (-fy - 200.0 * state[3]) / 20.0]

    low, high = 0.0, 1e-3
    for _ in range(100):  # the static position lies on the line of the load: ball 1 stands on it
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle, 0.0, 0.0)[0] < load else (low, middle)
    x = solved(rates, [low, 0.0, 0.0, 0.0], t, rtol=1e-9, atol=1e-14, max_step=1e-4)
    return {f"bearing.{n}": x[k] for k, n in enumerate(("displacement_x", "displacement_y", "velocity_x", "velocity_y"))}


def gimbal_scan(t, frame_inertia=0.02, inner_inertia=0.05):
    """Pan and tilt head: motors with inductance and limits, a PID controller every 2 ms, Coulomb friction that sticks (kg.m2).

    Steps of Runge and Kutta of 0.05 ms; an axis whose rate changes sign in one stands at its end.
    """
    h, cross, axial, weight = 5e-5, 0.03, 0.06, 2.0 * 9.81 * 3e-3
    kinetic, static = (0.05, 0.03), 1.3
    axes = ((640.0, 0.0, 1.0, 0.25), (400.0, 0.5 * math.pi, 0.18, 1.0))  # gain, mean of the set point, amplitude, Hz

    def drives(x):
        swing = (cross - axial) * math.sin(x[1]) * math.cos(x[1])
        return 0.1 * x[4] - 2.0 * swing * x[2] * x[3], 0.1 * x[5] - weight * math.sin(x[1]) + swing * x[2] ** 2

    def winding(volt, rate, current):
        induced = 0.1 * rate
        given = min(max(volt, induced - 10.0), induced + 10.0)  # 5 A at 2 Ohm
        return (min(max(given, -24.0), 24.0) - 2.0 * current - induced) / 1e-3

    def rates(x):
        inertias = (frame_inertia + cross * math.sin(x[1]) ** 2 + axial * math.cos(x[1]) ** 2, inner_inertia)
        turned = zip(drives(x), modes, kinetic, inertias, strict=True)
        turns = [(drive - mode * level) / inertia if mode else 0.0 for drive, mode, level, inertia in turned]
        return [x[2], x[3], *turns, winding(volts[0], x[2], x[4]), winding(volts[1], x[3], x[5])]

    def beyond(x, step, slope):
        return [one + step * rate for one, rate in zip(x, slope, strict=True)]

    x, modes, volts, integrals, rows = [0.0, 0.5 * math.pi, 0.0, 0.0, 0.0, 0.0], [0, 0], [0.0, 0.0], [0.0, 0.0], []
    for k in range(round(t[-1] / h) + 1):
        for n, drive in enumerate(drives(x)):
            if not modes[n] and abs(drive) > static * kinetic[n]:  # it breaks loose
                modes[n] = int(math.copysign(1.0, drive))
        if k % 40 == 0:
            rows.append(x[:2])
            for n, (gain, mean, amplitude, frequency) in enumerate(axes):
                w = 2.0 * math.pi * frequency
                error = mean + amplitude * math.sin(w * k * h) - x[n]
                wanted = gain * (error + 0.1 * (amplitude * w * math.cos(w * k * h) - x[n + 2])) + integrals[n]
                volts[n] = min(max(wanted, -24.0), 24.0)
                integrals[n] += 2e-3 * (gain * error + (volts[n] - wanted) / 0.1)
        k1 = rates(x)
        k2 = rates(beyond(x, 0.5 * h, k1))
        k3 = rates(beyond(x, 0.5 * h, k2))
        x = beyond(
            x, h / 6.0, [a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(k1, k2, k3, rates(beyond(x, h, k3)), strict=True)]
        )
        for n in (0, 1):
            if modes[n] * x[n + 2] < 0.0:
                x[n + 2], modes[n] = 0.0, 0
    times, angles = 2e-3 * np.arange(len(rows)), np.array(rows)
    return {f"body.{name}_angle": np.interp(t, times, angles[:, n]) for n, name in enumerate(("outer", "inner"))}
