"""Halves of the two masses of `tests.engine.algorithms.oscillators` as kernels, with steps that are exact for quadratic inputs."""

from __future__ import annotations

from cosimo.components.core.contract import KernelComponent, Kernels
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.variables import input_, output, parameter

HERE = "cosimo.tests.derivatives.coupled_masses"
TERMS = 14  # of Taylor's series over at most half a millisecond


@kernel
def start(t, s, p, e):
    s.x[0], s.x[1] = p.x0, p.v0
    return outputs(t, s, p, e)


@kernel
def step(t, h, s, p, e):
    n = 1 + int(h * 2000.0)
    d = h / n
    stiffness, damping = (p.k + p.kc) / p.m, (p.c + p.cc) / p.m
    u = s.u
    for i in range(n):
        a = i * d
        dx, dv, term = s.x[0], s.x[1], 1.0
        for j in range(1, TERMS):
            push = 0.0
            for k, gain in enumerate((1.0, p.kc, p.cc)):
                if j == 1:
                    push += gain * (u[0, k] + a * (u[1, k] + a * u[2, k])) / p.m
                elif j == 2:
                    push += gain * (u[1, k] + 2.0 * a * u[2, k]) / p.m
                elif j == 3:
                    push += gain * 2.0 * u[2, k] / p.m
            dx, dv = dv, push - stiffness * dx - damping * dv
            term *= d / j
            s.x[0] += term * dx
            s.x[1] += term * dv
    hold(h, u)
    return outputs(t + h, s, p, e)


@kernel
def hold(h, u):
    for k in range(u.shape[1]):
        u[0, k] += h * (u[1, k] + h * u[2, k])
        u[1, k], u[2, k] = 0.0, 0.0


@kernel
def outputs(t, s, p, e):
    s.y[0], s.y[1] = s.x[0], s.x[1]
    s.y[2] = p.kc * (s.x[0] - s.u[0, 1]) + p.cc * (s.x[1] - s.u[0, 2])
    return DONE


class Owner(KernelComponent):
    """A mass on a spring that gets a force, and owns a spring to a moving end."""

    m = parameter(1.0, "kg", "mass")
    k = parameter(0.0, "N/m", "spring to the ground")
    c = parameter(0.0, "N.s/m", "damper to the ground")
    kc = parameter(0.0, "N/m", "coupling spring")
    cc = parameter(0.0, "N.s/m", "coupling damper")
    x0 = parameter(0.0, "m", "position at the start")
    v0 = parameter(0.0, "m/s", "velocity at the start")
    force = input_(0.0, "N", "force")
    position = input_(0.0, "m", "position of the coupling's end")
    velocity = input_(0.0, "m/s", "velocity of the coupling's end")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")
    reaction = output("N", "force on the coupling's end", feedthrough=("position", "velocity"))
    kernels = Kernels(start, step, outputs)

    def shapes(self):
        return {"x": 2}


@kernel
def between(t, s, p, e):
    s.y[0] = p.kc * (s.u[0, 2] - s.u[0, 0]) + p.cc * (s.u[0, 3] - s.u[0, 1])
    return DONE


@kernel
def between_step(t, h, s, p, e):
    hold(h, s.u)
    return between(t + h, s, p, e)


class Between(KernelComponent):
    """Spring and damper between two ends."""

    kc = parameter(100.0, "N/m", "stiffness")
    cc = parameter(0.01, "N.s/m", "damping")
    x1 = input_(0.0, "m", "position of the first end")
    v1 = input_(0.0, "m/s", "velocity of the first end")
    x2 = input_(0.0, "m", "position of the second end")
    v2 = input_(0.0, "m/s", "velocity of the second end")
    force = output("N", "force on the first end", feedthrough=("x1", "v1", "x2", "v2"))
    kernels = Kernels(between, between_step, between)


def as_kernels(scene: dict) -> dict:
    """A scene of `TwoMasses` with its units as kernels."""
    names = {"Mass": "Owner", "Oscillator": "Owner", "Between": "Between"}
    units = {
        name: {**unit, "component": f"{HERE}:{names[unit['component'].rpartition(':')[2]]}"}
        for name, unit in scene["units"].items()
    }
    owners = {name for name, unit in units.items() if unit["component"].endswith("Owner")}

    def reaction(connection):
        if isinstance(connection, str):
            source, arrow, target = connection.partition(" -> ")
            owned = source.partition(".")[0] in owners and source.endswith(".force")
            return f"{source.replace('.force', '.reaction') if owned else source}{arrow}{target}"
        return connection

    return {**scene, "units": units, "connections": [reaction(c) for c in scene["connections"]]}
