"""What follows from the parameters of a catenary alone, computed once for all with the same: line, mesh, limit of the step."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from ..core.banded import banded_product
from ..core.errors import BadInput
from .explicit import PAD
from .gusts import buffeting, in_mean_wind
from .line.layout import Layout
from .mesh import Mesh, add_droppers, build_mesh, diagonals_of_wires, packed, stiffness_of_wires
from .statics import Statics


class PreparedLine:
    """A line on its mesh. Nothing of it may be changed: catenaries share it. p, e: parameters and effects of `Catenary`."""

    def __init__(self, layout: Layout, p: Any, e: Any, implicit: bool, name: str) -> None:
        # Verlet makes waves too fast by (omega h)²/24, the midpoint rule too slow by twice that; what each does to a force
        # that moves at v and to the height read there goes with v²/c², taken at 1/2. Beyond 0.7 the series says nothing.
        element_time = p.element * math.sqrt(layout.wires[0].mass / layout.wires[0].tension)
        h2 = min(p.substep**2, 0.7 * element_time**2)
        time_errors = (2.0 * h2, 1.125 * h2) if implicit else (-h2, -0.75 * h2)
        self.layout = layout
        self.mesh = build_mesh(layout, p.element, e.dropper_slackening, e.gravity_sag, e.damping, *time_errors)
        self.buffeting = None
        if e.gusts is not None:
            self.mesh = in_mean_wind(e.gusts, self.mesh, layout, e.dropper_slackening is not None)
            self.buffeting = buffeting(e.gusts, self.mesh, layout, name)
        self.packed = packed(self.mesh)
        self.statics = Statics(self.mesh)
        reach = 3 if e.bending_stiffness is not None else 2  # nodes
        self.wires = stiffness_of_wires(self.mesh, reach) if implicit else diagonals_of_wires(self.mesh, reach, PAD)
        self.limit = math.inf if implicit else _explicit_limit(self.mesh, e.damping, self.buffeting)  # s


_PREPARED: WeakValueDictionary[Hashable, PreparedLine] = WeakValueDictionary()


def prepared_line(key: Hashable, layout: Callable[[], Layout], p: Any, e: Any, implicit: bool, name: str) -> PreparedLine:
    """The prepared line of parameters and effects, `key`: that of a living catenary if one has it. name: for messages."""
    line = _PREPARED.get(key)
    if line is None:
        laid_out = layout()
        if len(laid_out.contact_lanes) > 1 and e.second_wire is None:
            raise BadInput(name, "a line with two contact wires, or sections that overlap, without 'second_wire'",
                           "the effect second_wire", "Switch it on, here and at the pantographs.")
        _PREPARED[key] = line = PreparedLine(laid_out, p, e, implicit, name)
    return line


def _explicit_limit(mesh: Mesh, damping: Any, gusts: Any) -> float:
    """(omega h)² + 4 (beta omega_w² + c/m) h = 4 with the highest frequencies of everything and of the wires alone."""
    wires = stiffness_of_wires(mesh, 3)
    taut = wires.copy()
    taut[:, 0] += mesh.ground
    add_droppers(taut, mesh, 1.0)
    omega2 = _highest_eigenvalue(taut, mesh)
    dashpots = mesh.ground_damping if gusts is None else mesh.ground_damping + gusts.push[0]
    b = 2.0 * float(np.max(dashpots * mesh.inverse_mass))
    if damping is not None:
        b += 2.0 * damping.beta * _highest_eigenvalue(wires, mesh)
    return (math.sqrt(b * b + 4.0 * omega2) - b) / omega2


def _highest_eigenvalue(stiffness: np.ndarray, mesh: Mesh) -> float:
    """Largest omega², 1/s², by power iteration; 2 % are added for what is still missing."""
    W, by_column = mesh.bending_gradient.size, np.asfortranarray(stiffness)
    x = (-1.0) ** (np.arange(mesh.mass.size) // W) * (1.0 + 0.1 * np.sin(np.arange(mesh.mass.size)))
    x[1::W] *= -1.0  # the wires swing against each other: droppers take part
    value = 0.0
    for _ in range(60):
        x[mesh.clamped] = x[mesh.clamp]
        force = banded_product(by_column, x)
        np.add.at(force, mesh.clamp, force[mesh.clamped])
        y = mesh.inverse_mass * force
        value = float(np.linalg.norm(y))
        x = y / value
    return 1.02 * value
