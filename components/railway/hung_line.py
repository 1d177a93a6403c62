"""The line that a catenary's parameters or its table describe: its parts with their places, and its form at rest."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..core.contract import KernelComponent
from ..core.kernels import in_python, kernel
from ..core.variables import NUMBERED, PARTS, integer, parameter
from .line.dropper_table import line_of
from .line.form import Form, Found, find_form_at_rest, form_of
from .line.from_table import lay_out, support_positions, unused_by
from .line.later import AS_PLANNED, deviations, find_form_later, fixed_wires, later_by
from .line.layout import Layout, uniform
from .line.plan import Given, Plan, fill_droppers, filled_layout

MAX_DROPPERS = 14  # in a span; the simple DC catenary of EN 50318:2018 has 14
# parameters that a table of a line may leave out
LINE = (
    "contact_wire_tension",
    "contact_wire_mass",
    "messenger_tension",
    "messenger_mass",
    "dropper_stiffness",
    "dropper_mass",
    "contact_clamp_mass",
    "messenger_clamp_mass",
    "support_stiffness",
    "support_damping",
)
LATER = {"temperature", "wear", "scatter"}  # effects that change what a table says
PLACED = "it decides where nodes are, and how many"


class HungLine(KernelComponent):
    """The parameters of a uniform line, and the layout of that or of the effect `line_table`."""

    spans = integer(10, "number of spans", low=1, high=1000, structural=PARTS)
    span_length = parameter(60.0, "m", "length of a span", low=1.0, structural=PLACED)
    contact_wire_tension = parameter(20e3, "N", "tension of the contact wire", low=1.0, usual=(500.0, 1e5))
    contact_wire_mass = parameter(1.35, "kg/m", "mass of the contact wire per length", low=1e-6)
    messenger_tension = parameter(16e3, "N", "tension of the messenger wire", low=1.0, usual=(500.0, 1e5))
    messenger_mass = parameter(1.07, "kg/m", "mass of the messenger wire per length", low=1e-6)
    droppers = integer(9, "droppers in a span", low=1, high=MAX_DROPPERS, structural=PARTS)
    dropper_position = parameter(
        (5.0, 10.5, 17.0, 23.5, 30.0, 36.5, 43.0, 49.5, 55.0, *(0.0,) * (MAX_DROPPERS - 9)),
        "m",
        "position of a dropper within the span; elements beyond the number of droppers do not count",
        size=MAX_DROPPERS,
        structural=PLACED,
    )
    dropper_stiffness = parameter(100e3, "N/m", "stiffness of a dropper", low=1.0)
    dropper_mass = parameter(0.0, "kg", "mass of a dropper, half of it at either wire", low=0.0)
    contact_clamp_mass = parameter(0.0, "kg", "mass of a dropper clamp on the contact wire", low=0.0)
    messenger_clamp_mass = parameter(0.0, "kg", "mass of a dropper clamp on the messenger wire", low=0.0)
    support_stiffness = parameter(50e3, "N/m", "vertical stiffness of a messenger support", low=0.0)
    support_damping = parameter(0.0, "N.s/m", "damping of a messenger support", low=0.0)
    first_watched_support = integer(
        4, "number of the first support whose uplift is an output; 0 is the start", low=0, structural=NUMBERED
    )

    def _layout(self) -> tuple[Layout, tuple[tuple[int, float, float], ...]]:
        """The line with NaN where parameters decide, and the wires whose tension changes with temperature and wear, see `fixed_wires`."""
        values: Any = self.parameters
        if "line_table" in self.on:
            line = line_of(values, self.name)
            layout = lay_out(line, "bending_stiffness" in self.on)
            return layout, tuple(fixed_wires(line, layout, "temperature" in self.on)) if LATER & set(self.on) else ()
        within = np.array([values[f"dropper_position[{i + 1}]"] for i in range(values["droppers"])])
        on = ("pre_sag" in self.on, "steady_arm" in self.on, "level_support" in self.on)
        return uniform(values["spans"], values["span_length"], within, *on), ()

    def form(self) -> Form:
        """The line at rest, for the present parameters; of a uniform catenary the messenger's supports are at the height 0."""
        layout, fixed = self._layout()
        given = in_python(given_by)(*self._declared_arguments())
        if "line_table" not in self.on:
            return form_of(layout, given)
        formed = Found(layout, given, fixed)
        if LATER & set(self.on):
            later = in_python(later_by)(self._declared_arguments()[1])
            random = self._deviations(formed.plan)
            formed.check(find_form_later(later, random, formed.plan, given, formed.filled, formed.net))
        else:
            formed.check(find_form_at_rest(formed.plan, given, formed.filled, formed.net))
            fill_droppers(formed.plan.dropper_numbers, given, formed.filled.dropper)
        return form_of(filled_layout(layout, given, formed.filled))

    def _deviations(self, plan: Plan) -> np.ndarray:
        """Of the line as built, see `deviations`; none without the effect."""
        return deviations(plan, int(self.get("scatter.seed"))) if "scatter" in self.on else AS_PLANNED

    def unused(self, names: Iterable[str]) -> dict[str, str]:
        """See `Component.unused`; also what a line's table has in every place, and a support beyond the end."""
        names = tuple(names)
        reasons = super().unused(names)
        line = line_of(self.parameters, self.name) if "line_table" in self.on else None
        if "first_watched_support" in names:
            last = self.get("spans") if line is None else support_positions(line).size - 1
            if self.get("first_watched_support") > last:
                reasons["first_watched_support"] = f"the last support of the line is number {last}"
        rest = [n for n in names if n in LINE or n.startswith("bending_stiffness.")]
        if line is not None and rest:
            layout = lay_out(line, "bending_stiffness" in self.on)
            reasons |= dict.fromkeys(unused_by(layout, rest), "line_table.table has it in every place")
        return reasons


@kernel
def given_by(p, e):
    """Parameters in place of numbers that the line does not give."""
    contact_wire_bending, messenger_bending, arm_stiffness, arm_mass, sag = 0.0, 0.0, 0.0, 0.0, 0.0
    if e.bending_stiffness is not None:
        contact_wire_bending, messenger_bending = e.bending_stiffness.contact_wire, e.bending_stiffness.messenger
    if e.steady_arm is not None:
        arm_stiffness, arm_mass = e.steady_arm.stiffness, e.steady_arm.mass
    if e.pre_sag is not None:
        sag = e.pre_sag.depth
    return Given(
        p.contact_wire_tension,
        p.contact_wire_mass,
        p.messenger_tension,
        p.messenger_mass,
        p.dropper_stiffness,
        p.dropper_mass,
        p.contact_clamp_mass,
        p.messenger_clamp_mass,
        p.support_stiffness,
        p.support_damping,
        contact_wire_bending,
        messenger_bending,
        arm_stiffness,
        arm_mass,
        sag,
    )
