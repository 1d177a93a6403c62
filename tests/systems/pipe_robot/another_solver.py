"""A body that sticks and slips, shaken by an inner mass on a spring: solved from event to event, the equations written anew."""

import math

import numpy as np
from scipy.integrate import solve_ivp


def reference(duration, amplitude, friction, masses=(1.0, 1.0)) -> tuple[np.ndarray, list[int]]:
    """(state, sequence of modes) by DOP853 under a force of an amplitude, N, at 60 rad/s; friction, masses: forward and backward."""
    forward, backward = friction

    def internal(t, x):
        return 2000.0 * (x[2] - x[0]) + 5.0 * (x[3] - x[1]) + amplitude * math.sin(60.0 * t)

    def event(function, direction):
        function.direction, function.terminal = direction, True
        return function

    t, x, mode, modes = 0.0, np.zeros(4), 0, [0]
    while t < duration:

        def rate(t, x, mode=mode):
            f = internal(t, x)
            a = {1: (f - forward) / masses[0], -1: (f + backward) / masses[1], 0: 0.0}[mode]
            return [x[1], a, x[3], -f / 0.5]

        if mode:
            events = [event(lambda t, x: x[1], -mode)]
        else:
            events = [event(lambda t, x: internal(t, x) - forward, 1), event(lambda t, x: internal(t, x) + backward, -1)]
        part = solve_ivp(rate, (t, duration), x, method="DOP853", rtol=1e-11, atol=1e-13, events=events)
        t, x = part.t[-1], part.y[:, -1].copy()
        if part.status == 1:
            if mode:
                x[1], f = 0.0, internal(t, x)
                mode = 1 if f > forward else -1 if f < -backward else 0
            else:
                mode = 1 if part.t_events[0].size else -1
            x[1] = mode * 1e-15
            modes.append(mode)
    return x, modes
