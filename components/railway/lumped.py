"""Lumped catenary: one mass on a spring whose stiffness varies along the span."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.errors import BadInput, counted
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.spectrum import step_within
from ..core.variables import input_, output, parameter
from .statics import elasticity, stiffness_series

HARMONICS = 10
PLACES = 720  # along a span, at which the stiffness is looked at
NO_STIFFNESS = OWN + 1  # status


class Inerter(Effect):
    """The inertia acts on the deviation from the static height F_ref / k(x) instead of the height itself.

    A lumped mass is dragged up and down the static line of the wire and answers with a forced oscillation at the
    span-passing frequency that no wire has. An inerter (inertance, with its second terminal on that line) does not.
    Source: the idea from the abstract of Mikhailov, Sidorov, Salya 2025 (Izvestiia Transsiba 61); equations ours.
    """

    explicit_only = True

    reference_force = parameter(120.0, "N", "force whose static line the second terminal follows", low=0.0)


class LumpedCatenary(OdeComponent):
    """Mass with stiffness varying along the span, the class of Kaniewski & Cichoński 2019 (of which only the abstract was read).

        m w'' + c w' + k(x) w = F,        k(x) = k0 (1 + sum a[n] cos(2 pi n x / L))
        m d'' + c d' + k(x) d = F - F_ref,   w = d + F_ref / k(x)         with `inerter`

    x = 0 at a support. The defaults are computed, not read: k(x) is fitted to the static elasticity of the
    EN 50318:2002 catenary under 120 N (`from_line`). Mass and damping are a choice (inferred): the contact wire of
    one dropper interval, and the dashpot 2 sqrt(T m_l) as which a long wire answers. A mass of a whole span would put the
    span-passing frequency near resonance. Terms with dk/dx are dropped, as usual in this class.
    """

    title = "Lumped catenary with stiffness varying along the span"
    system = "railway"
    default_stop = 2.0
    start_inputs = ("contact_position", "contact_force")
    ports = {"contact": ("contact_position", "contact_force", "wire_height")}

    inerter = Inerter

    span_length = parameter(60.0, "m", "length of a span", low=1.0)
    mean_stiffness = parameter(2807.0, "N/m", "mean stiffness k0 along the span", low=1.0)
    harmonic = parameter(
        (0.3603, 0.0977, -0.0004, -0.0392, -0.0489, -0.0437, -0.0332, -0.0253, -0.0284, 0.0165),
        "1",
        "harmonic of the stiffness over the mean stiffness",
        size=HARMONICS,
    )
    mass = parameter(8.775, "kg", "lumped mass, or inertance", low=1e-6)
    damping = parameter(328.6, "N.s/m", "damping to the ground", low=0.0)
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    contact_position = input_(30.0, "m", "position of the contact point", nominal=100.0, moving=True)
    contact_force = input_(0.0, "N", "force on the wire, positive upwards", nominal=100.0)
    wire_height = output(
        "m", "height of the wire at the contact point", nominal=0.05, feedthrough=("contact_position",)
    )  # through the static line of `inerter`
    wire_velocity = output("m/s", "vertical velocity of the wire at the contact point", nominal=0.1)
    wire_stiffness = output("N/m", "stiffness at the contact point", nominal=1e3, feedthrough=("contact_position",))

    @classmethod
    def from_line(cls, line, force: float, span: int | None = None, effects: Iterable[str] = ()) -> LumpedCatenary:
        """A lumped catenary with the static elasticity of one span of a distributed one; arguments as of `fit_span`."""
        return cls(effects, fit_span(line, force, span).parameters)

    refusals = {NO_STIFFNESS: Refusal("harmonic: a stiffness down to {least} of the mean", "a positive one everywhere")}

    def states(self) -> int:
        """Height or deviation, its rate."""
        return 2

    def shapes(self) -> dict[str, Any]:
        """`least`: smallest stiffness along the span over the mean one."""
        return super().shapes() | {"least": 1}

    def energy(self) -> float:
        """Kinetic energy plus that of the spring, J; with `inerter`, of the deviation."""
        p = self.arguments[1]
        return 0.5 * (p.mass * self.x[1] ** 2 + stiffness_at(self.u[0, IN.contact_position], p) * self.x[0] ** 2)


IN = LumpedCatenary.input_places()
OUT = LumpedCatenary.output_places()


@kernel
def stiffness_at(position, p):
    """k(x), N/m."""
    total = 1.0
    for n in range(p.harmonic.size):
        total += p.harmonic[n] * math.cos(2.0 * math.pi * (n + 1) * position / p.span_length)
    return p.mean_stiffness * total


@kernel
def lumped_start(t, s, p, e):
    """Static equilibrium under the present force."""
    s.least[0] = math.inf
    for i in range(PLACES + 1):
        s.least[0] = min(s.least[0], stiffness_at(p.span_length * i / PLACES, p) / p.mean_stiffness)
    if s.least[0] <= 0.0:
        return NO_STIFFNESS
    force = s.u[0, IN.contact_force]
    if e.inerter is not None:
        force -= e.inerter.reference_force
    s.x[0] = force / stiffness_at(s.u[0, IN.contact_position], p)
    return DONE


@kernel
def fastest_of(mass, damping, stiffness):
    """Largest |eigenvalue| of an oscillator, 1/s."""
    left = damping * damping - 4.0 * mass * stiffness
    return 0.5 * (damping + math.sqrt(left)) / mass if left > 0.0 else math.sqrt(stiffness / mass)


@kernel
def lumped_stable(t, s, p, e):
    """Limit of the internal step, radius / max |eigenvalue|, s: at the stiffest point or, with strong damping, the softest."""
    spread = 0.0
    for n in range(p.harmonic.size):
        spread += abs(p.harmonic[n])
    stiffest, softest = p.mean_stiffness * (1.0 + spread), p.mean_stiffness * max(1.0 - spread, 0.0)
    fastest = max(fastest_of(p.mass, p.damping, stiffest), fastest_of(p.mass, p.damping, softest))
    return step_within(RK4_STABILITY_RADIUS, fastest)


@kernel
def lumped_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (height or deviation, its rate)."""
    force = u[IN.contact_force]
    if e.inerter is not None:
        force -= e.inerter.reference_force
    dx[0] = x[1]
    dx[1] = (force - p.damping * x[1] - stiffness_at(u[IN.contact_position], p) * x[0]) / p.mass


@kernel
def lumped_outputs(t, s, p, e):
    """Height, velocity, stiffness at the contact point; the velocity is that of the mass, without the static line's."""
    x, y = s.x, s.y
    y[OUT.wire_stiffness] = stiffness_at(s.u[0, IN.contact_position], p)
    y[OUT.wire_height], y[OUT.wire_velocity] = x[0], x[1]
    if e.inerter is not None:
        y[OUT.wire_height] += e.inerter.reference_force / y[OUT.wire_stiffness]
    return DONE


LumpedCatenary.kernels = ode_kernels(
    __name__, start=lumped_start, derivatives=lumped_derivatives, outputs=lumped_outputs, stable=lumped_stable
)


@dataclass(frozen=True)
class SpanFit:
    """Parameters of a `LumpedCatenary`, and how well its stiffness follows the static one of the span they were fitted to.

    rms, worst: differences of the stiffness over its mean.  asymmetry: share of the stiffness's swing about its mean that is odd
    about the middle of the span, of which a series of cosines has nothing.
    """

    parameters: dict[str, float]
    rms: float
    worst: float
    asymmetry: float


def fit_span(line, force: float, span: int | None = None, harmonics: int = HARMONICS) -> SpanFit:
    """Fit a `LumpedCatenary` to the static elasticity of one span of a distributed catenary.

    line: an initialised component with a `mesh` and, where droppers can slacken, the effect `dropper_slackening` on.
    force: N, at which the elasticity is taken.  span: counted from 1 at the start of the line; without it the middle one.
    Mass: contact wire of a mean dropper interval, kg; damping: 2 sqrt(T m') of the contact wire, N.s/m.
    """
    mesh = line.mesh
    supports = mesh.position[mesh.support]
    spans = supports.size - 1
    number = spans // 2 + 1 if span is None else span
    if spans < 3:
        raise BadInput(
            line.name, f"a line of {counted(spans, 'span')}", "at least three: the ends of a line are fixed", "Add spans."
        )
    if not 1 < number < spans:
        raise BadInput(f"{line.name}: span", str(number), f"2 to {spans - 1}: the first and the last one end at a fixed point")
    if not (math.isfinite(force) and force > 0.0):
        raise BadInput(f"{line.name}: force", f"{force:g} N", "a positive force, such as the mean contact force")
    start, length = float(supports[number - 1]), float(supports[number] - supports[number - 1])
    x = np.arange(0.0, length, 0.5)
    k = 1.0 / elasticity(mesh, start + x, force, "dropper_slackening" in line.on)
    k0, a = stiffness_series(x, k, length, harmonics)
    left = k - k0 * (1.0 + np.cos(2.0 * np.pi * x[:, None] / length * np.arange(1, harmonics + 1)) @ a)
    odd = 0.5 * (k - np.interp(length - x, np.append(x, length), np.append(k, k[0])))
    droppers = mesh.position[mesh.dropper]
    inside = droppers[(droppers > start) & (droppers < start + length)]
    interval = float(np.diff(inside).mean()) if inside.size > 1 else length
    node = mesh.bending_gradient.size * mesh.support[number - 1]  # of the contact wire
    tension, impedance = float(mesh.tension[node]), float(mesh.impedance[node])
    values = {"span_length": length, "mean_stiffness": k0, "mass": impedance**2 / tension * interval, "damping": 2.0 * impedance}
    values |= {f"harmonic[{n + 1}]": float(a[n]) if n < harmonics else 0.0 for n in range(HARMONICS)}
    swing = float(np.std(k))
    return SpanFit(
        values,
        float(np.sqrt(np.mean(left**2)) / k0),
        float(np.abs(left).max() / k0),
        float(np.sqrt(np.mean(odd**2)) / swing) if swing > 0.0 else 0.0,
    )
