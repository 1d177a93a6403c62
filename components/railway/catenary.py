"""Distributed catenary: contact wire and messenger wire, droppers, supports."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..core.contract import Kernels, Refusal
from ..core.errors import BadInput
from ..core.kernels import DONE, OUT_OF_RANGE, OWN, in_python, kernel
from ..core.linear import banded_product
from ..core.variables import choice, input_, output, parameter
from . import gusts as wind
from . import mesh as meshes
from . import statics
from .catenary_effects import (
    FURTHER,
    PROFILE,
    BendingStiffness,
    BlowOff,
    Damping,
    DropperSlackening,
    FurtherPantographs,
    GravitySag,
    LevelSupport,
    LineProfile,
    LineTable,
    MovingWindow,
    PreSag,
    Scatter,
    SecondPantograph,
    SecondWire,
    Stagger,
    SteadyArm,
    Temperature,
    Wear,
    WireProfile,
)
from .catenary_presets import PRESETS
from .contact import (
    add_contact,
    blown_off,
    contact_compliance,
    contact_points,
    element_at,
    follow_contacts,
    heights_around,
    hung_around,
    in_range,
    lateral_position,
    wire_motion,
)
from .explicit import BLOCK, explicit_limit, explicit_steps, fill_damping, fill_wire_rows, margin
from .gust_loads import FIRST, LAST, SAMPLE, UNREADY, follow_gusts, gust_state, load_at
from .gusts import ACROSS, Gusts, blow, empty_buffeting, raise_wind
from .hung_line import LATER, HungLine, given_by
from .implicit import Solver, implicit_steps, start_solver
from .line import plan as plans
from .line.form import empty_network, find_form_at_rest
from .line.later import find_form_later, later_by
from .line.plan import empty_numbers, fill_droppers, fill_layout, plan_of
from .mesh import (
    NO_WIRE,
    Mesh,
    Space,
    add_fittings,
    discretisation,
    empty_mesh,
    find_pushed,
    hang_wires_on_droppers,
    packed,
    spread_wires,
    unpacked,
)
from .moving_window import WINDOW, begin_front, open_window, warn_of_narrow_window
from .statics import PRESENT, UNBALANCED, add_ground, empty_balance, find_balance, put_droppers
from .stiffness import fill_stiffness, highest_eigenvalue, stiffness_of_wires
from .wires import Laws, Motion, contacts_at, last_step, row_length, shown, state_rows

WATCHED = 5  # supports whose uplift is an output
SUBSTEP_TOO_LONG = OWN  # status of `initialize`, beside those of its parts


class Catenary(HungLine):
    """Contact wire and messenger wire as tensioned strings or beams, coupled by droppers, in the vertical plane.

        m u_tt = T u_xx - EI u_xxxx - alpha m u_t + beta (T u_xx - EI u_xxxx)_t + droppers + supports + contact

    for either wire, linear about the static equilibrium; a dropper pulls with F0 + k (u_messenger - u_contact), never
    below 0 if it can slacken. Both wires are fixed at the ends of the section. The contact force is an input: the
    partner owns the contact law. Numerics: linear elements with a mass between lumped and consistent that cancels the
    leading dispersion error of space and time together, explicit (leapfrog) or implicit (generalised-alpha).
    Defaults: the EN 50318:2002 reference model. Tensions, masses, span, dropper positions and stiffness, messenger support:
    read in two public sources (whether the support's 50 kN/m is in the standard itself is not known). No dropper and clamp
    masses, no damping of the supports: from memory. Element, substep and method: by error against work, docs/railway-contact.md.
    """

    title = "Distributed catenary with droppers"
    system = "railway"
    default_stop = 2.0
    start_inputs = (
        "contact_position",
        "contact_force",
        "second_pantograph.contact_position",
        "second_pantograph.contact_force",
        "further_pantographs.contact_position",
        "further_pantographs.contact_force",
        "second_wire.contact_force",
    )
    kept = (
        "ready",
        "numbers",
        "indices",
        "grid",
        "plan",
        "filled",
        "network",
        "balance",
        "limits",
        "refused",
        "gusts",
        "rows",
        "solver",
        "random",
        "at_rest",
    )
    ports = {"contact": ("contact_position", "contact_force", "wire_height", "contact_compliance")}
    counters = ("steps", "solves", "factorizations")
    former = {
        "moving_window.ahead": "Leave it out: the front follows the motion, see front_threshold.",
        "moving_window.speed": "Leave it out: the length behind follows the speed of the run.",
    }

    dropper_slackening = DropperSlackening
    bending_stiffness = BendingStiffness
    gravity_sag = GravitySag
    pre_sag = PreSag
    damping = Damping
    steady_arm = SteadyArm
    level_support = LevelSupport
    second_pantograph = SecondPantograph
    further_pantographs = FurtherPantographs
    moving_window = MovingWindow
    line_table = LineTable
    temperature = Temperature
    wear = Wear
    scatter = Scatter
    second_wire = SecondWire
    stagger = Stagger
    blow_off = BlowOff
    gusts = Gusts
    wire_profile = WireProfile
    line_profile = LineProfile

    method = choice("explicit", ("explicit", "implicit"), "time integration")
    element = parameter(0.4, "m", "longest element", low=0.01, high=30.0, mesh="shorter")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-7, high=0.1)
    front_threshold = parameter(
        1e-4, "1", "explicit: wires ahead rest until they move by this share of 0.07 m or 0.6 m/s; 0: all move", low=0.0, high=0.1
    )
    spectral_radius = parameter(1.0, "1", "generalised-alpha: spectral radius at infinite frequency", low=0.0, high=1.0)

    contact_position = input_(30.0, "m", "position of the contact point", nominal=100.0, moving=True)
    contact_force = input_(0.0, "N", "force on the wire, positive upwards", nominal=100.0)
    wire_height = output("m", "height of the contact wire at the contact point", nominal=0.05, feedthrough=("contact_position",))
    wire_velocity = output(
        "m/s", "vertical velocity of the wire at the contact point", nominal=0.1, feedthrough=("contact_position",)
    )
    contact_compliance = output(
        "m/N", "compliance that the mesh leaves out under the moving contact, in series with its spring", nominal=1e-6
    )
    static_residual = output("1", "unbalanced forces of the initial equilibrium over the dropper preloads (root sums of squares)")
    support_uplift = output("m", "uplift of the contact wire at a watched support, 0 beyond the end", nominal=0.05, size=WATCHED)

    presets = PRESETS

    refusals = {
        SUBSTEP_TOO_LONG: Refusal(
            "substep = {substep} s",
            "at most {limits[1]} s, the explicit method's limit",
            "Reduce substep, enlarge element, or set method = 'implicit'.",
        ),
        **plans.REFUSALS,
        **meshes.REFUSALS,
        **wind.REFUSALS,
        **statics.REFUSALS,
    }

    # -- memory ------------------------------------------------------------------------------------------------------
    @property
    def by_midpoint_rule(self) -> bool:  # type: ignore[override]
        """Which the generalised-alpha method is without numerical damping."""
        return bool(self.parameters["method"] == "implicit" and self.parameters["spectral_radius"] == 1.0)

    def shapes(self) -> dict[str, Any]:
        """Geometry, the numbers that follow from parameters, and workspace.

        `numbers`, `indices`: the mesh, see `mesh.packed`; `grid`: further arrays that fill it.  `plan`, `filled`, `network`:
        the line without and with the numbers of parameters, and its form finding.  `ready`: 1 when all that follows from
        parameters alone is there.  `points`: see `contact_points`.  `lateral`: rows of contact wire, position, stagger and wire.
        `random`: of a line as built; `at_rest`: its displacement by slack droppers.  `balance`: the static equilibrium.  `limits`:
        longest stable step, s, and, where it is refused, its first three digits, for it follows the substep.  `refused`: numbers
        of a refusal.  `window`: of what moves, see `moving_window`.  `gusts`: the wind.  `rows`: of the explicit method, see
        `fill_wire_rows`; `solver`: of the implicit one.
        """
        _, e = self._declared_arguments()
        implicit = self.parameters["method"] == "implicit"
        if implicit and e.moving_window is not None:
            raise BadInput(
                self.name,
                "effect 'moving_window' with method 'implicit'",
                "method 'explicit'",
                "The window moves through the wires; a factorised matrix does not.",
            )
        layout, fixed = self._layout()
        if len(layout.contact_lanes) > 1 and e.second_wire is None:
            raise BadInput(
                self.name,
                "a line with two contact wires, or sections that overlap, without 'second_wire'",
                "the effect second_wire",
                "Switch it on, here and at the pantographs.",
            )
        plan = plan_of(layout, fixed)
        mesh, grid = empty_mesh(layout, plan, float(self.get("element")))
        numbers, indices = packed(mesh)
        n, N, W, d = mesh.position.size, mesh.mass.size, layout.lanes, mesh.dropper.size
        points = contact_points(OWN_POINT, e, len(layout.contact_lanes))
        reach = 3 if e.bending_stiffness is not None else 2  # nodes
        parts = [
            in_python(contacts_at)(N),
            2 * len(points),
            0 if e.gusts is None else 3 + 2 * N,
            d if implicit else 0,
            0 if implicit else 2,
        ]
        cut = bool(np.isnan(layout.droppers.height).any()) or bool(LATER & set(self.on))
        band, beside = (N, reach * W + 1), in_python(margin)(W)
        return {
            "x": sum(parts),
            "ready": 1,
            "numbers": numbers,
            "indices": indices,
            "grid": grid,
            "plan": plan,
            "filled": empty_numbers(len(layout.wires), d, layout.holds.position.size),
            "network": empty_network(plan, cut) if e.line_table is not None else None,
            "points": points,
            "random": self._deviations(plan),
            "at_rest": None if e.scatter is None else N,
            "lateral": layout.lateral[:, [0, 1, 2, 4]] if e.stagger is not None else None,
            "balance": empty_balance(mesh),
            "space": Space(np.zeros((8, N)), np.zeros((2, n, 4))),
            "limits": 2,
            "refused": 4,
            "window": None if implicit else WINDOW,
            "gusts": empty_buffeting(mesh, e.gusts.components, e.gusts.seed) if e.gusts is not None else None,
            "work": (5, N) if implicit else BLOCK + 5 * beside,
            "rows": None if implicit else (reach + 3, in_python(row_length)(N) + beside),
            "solver": Solver(np.zeros(band), np.zeros(band), np.zeros(band), np.zeros(d), np.zeros(1)) if implicit else None,
        }

    @property
    def mesh(self) -> Mesh:
        """The mesh that `initialize` has filled."""
        s = self.arguments[0]
        return in_python(unpacked)(s.numbers, s.indices)

    # -- the run -----------------------------------------------------------------------------------------------------
    def _initialize(self, t: float) -> int:
        status = super()._initialize(t)
        if status == DONE and "moving_window" in self.on:
            alpha, beta = (self.get(f"damping.{n}") if "damping" in self.on else 0.0 for n in ("alpha", "beta"))
            behind, whole = self.get("moving_window.behind"), self.mesh.position[-1]
            warn_of_narrow_window(self.name, behind, alpha, beta, self.arguments[0].window, float(whole))
        return status

    @property
    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacements, m, and velocities, m/s, of all degrees of freedom above the static equilibrium, (N,) each."""
        q, w, a = in_python(state_rows)(self.x, N := self.mesh.mass.size)
        return q.copy(), w + 0.5 * in_python(last_step)(self.x, N) * a

    def energy(self) -> float:
        """Energy above the static equilibrium without contact force, J: motion, wires, droppers, supports."""
        mesh, (q, v) = self.mesh, self.motion
        mass = np.where(np.isinf(mesh.mass), 0.0, mesh.mass)
        total = 0.5 * q @ (banded_product(stiffness_of_wires(mesh, 3), q) + mesh.ground * q) + 0.5 * v @ (mass * v)
        stretch = q[mesh.upper] - q[mesh.lower]
        tension = mesh.preload + mesh.dropper_stiffness * stretch
        if "dropper_slackening" in self.on:
            tension = np.maximum(tension, 0.0)
        return float(total + np.sum((tension**2 - mesh.preload**2) / (2.0 * mesh.dropper_stiffness) - mesh.preload * stretch))

    def left_range(self) -> str:
        """The contact points, their speeds, and the part of the wire on which they may be."""
        columns = dict.fromkeys(self.arguments[0].points[:, 0].tolist())
        points = [f"{self.inputs[i]} = {self.u[0, i]:g} m moving at {self.u[1, i]:g} m/s" for i in columns]
        first = int(self.x[-2]) if self.parameters["method"] == "explicit" and self.x.size else 1
        low, high = self.mesh.position[[first, -2]]
        back = "; the moving window does not go back (moving_window.behind)" if first > 1 else ""
        return f"{', '.join(points)}, expected from {low:g} to {high:g} m{back}"

    def stable_step(self) -> float:
        """Limit of the explicit method, s; inf if implicit."""
        return math.inf if self.parameters["method"] == "implicit" else self.of_initialization("limits", 0)

    def unused(self, names: Iterable[str]) -> dict[str, str]:
        """See `HungLine.unused`; also what the method or the wind has no use for."""
        names = tuple(names)
        reasons = super().unused(names)
        if "spectral_radius" in names and self.parameters["method"] == "explicit":
            reasons["spectral_radius"] = "method 'explicit' has none"
        if "front_threshold" in names and self.parameters["method"] == "implicit":
            reasons["front_threshold"] = "method 'implicit' moves the whole line"
        elif "front_threshold" in names and "gusts" in self.on:
            reasons["front_threshold"] = "gusts move the whole line"
        if "gusts" in self.on and self.parameters["gusts.lift_coefficient"] == 0.0:
            reasons |= dict.fromkeys(ACROSS.intersection(names), "without gusts.lift_coefficient only vertical gusts act")
        return reasons


IN = Catenary.input_places()
OUT = Catenary.output_places()
OWN_POINT = (IN.contact_position, IN.contact_force, OUT.wire_height, 1, 0)  # see `contact_points`


@kernel
def put_outputs(t, mesh, s, p, e):
    """Outputs for the present state and inputs at the time t."""
    N, W = mesh.mass.size, mesh.bending_gradient.size
    x, u, y, points = s.x, s.u[0], s.y, s.points
    q = x[:N]
    for k in range(points.shape[0]):
        position, i, next_one, wire = u[points[k, 0]], points[k, 2], points[k, 3], points[k, 4]
        y[i], y[i + next_one] = wire_motion(position, x, wire, mesh)
        y[i + 2 * next_one] = contact_compliance(x[contacts_at(N) + 2 * k + 1], position, wire, mesh)
    for k in range(WATCHED):
        j = W * mesh.support[min(p.first_watched_support + k, mesh.support.size - 1)]
        y[OUT.support_uplift + k] = q[j]
        if (
            mesh.height.size > mesh.position.size and mesh.mass[j + 2] > 0.0
        ):  # of the wires that are there the one that rises further
            y[OUT.support_uplift + k] = max(q[j], q[j + 2]) if mesh.mass[j] > 0.0 else q[j + 2]
        if s.at_rest is not None:
            y[OUT.support_uplift + k] -= s.at_rest[j]
    if e.gusts is not None:
        position = u[points[0, 0]]
        y[e.gusts.y] = load_at(t, position, element_at(position, mesh), x[gust_state(points, mesh) :], mesh, s.gusts)
    if e.moving_window is not None:
        y[e.moving_window.y] = mesh.position[int(x[x.size - 2])] if x[x.size - 2] > 1.0 else 0.0
    if e.stagger is not None:
        for wire in range(2):
            y[e.stagger.y + wire] = lateral_position(u[IN.contact_position], wire, s.lateral)
            if e.blow_off is not None:
                y[e.stagger.y + wire] += blown_off(u[IN.contact_position], wire, s.lateral, s.filled.tension, e.blow_off)
    if e.wire_profile is not None:
        heights_around(u[IN.contact_position], q, mesh, y[e.wire_profile.y : e.wire_profile.y + PROFILE])
    if e.line_profile is not None:
        hung = y[e.line_profile.y : e.line_profile.y + 3 * PROFILE]
        hung_around(u[IN.contact_position], q, mesh, s.plan.lanes, hung)


# -- the kernels -------------------------------------------------------------------------------------------------------
@kernel
def catenary_initialize(t, s, p, e):
    """The line and its mesh for the present parameters, and their static equilibrium under the present contact forces.

    One kernel: Numba would compile all that stands below another one once more.
    """
    mesh, given, refused = unpacked(s.numbers, s.indices), given_by(p, e), s.filled.refused
    alpha, beta = 0.0, 0.0
    if e.damping is not None:
        alpha, beta = e.damping.alpha, e.damping.beta
    nodal, unilateral, status = s.space.nodal, e.dropper_slackening is not None, DONE
    if s.ready[0] == 0.0:
        # the parts of the line and their places
        if e.temperature is not None or e.wear is not None or e.scatter is not None:
            status = find_form_later(later_by(e), s.random, s.plan, given, s.filled, s.network)
        elif e.line_table is not None:
            status = find_form_at_rest(s.plan, given, s.filled, s.network)
            fill_droppers(s.plan.dropper_numbers, given, s.filled.dropper)
        else:
            status = fill_layout(s.plan, given, s.filled)

        # its mesh
        if status == DONE:
            way = discretisation(alpha, beta, s.solver is not None, s.filled, p)
            status = spread_wires(mesh, s.plan, s.filled, s.grid, way, s.space)
        if status == DONE:
            add_fittings(mesh, s.plan, s.filled, s.grid, s.space)
            hang_wires_on_droppers(mesh, s.plan, s.filled, s.grid, s.space, e.gravity_sag is not None)
            if e.dropper_slackening is not None and e.scatter is None:
                status = find_pushed(mesh, refused)

        # stiffness, equilibrium in the wind, longest stable step
        s.limits[0] = math.inf
        if status == DONE:
            omega2, damped = 0.0, 0.0
            fill_stiffness(mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.length, s.balance.stiffness)
            if s.solver is not None:
                start_solver(s.balance.stiffness, s.solver)
            if s.rows is not None:
                fill_wire_rows(s.balance.stiffness, mesh, s.rows)
                if beta > 0.0:
                    damped = beta * highest_eigenvalue(
                        s.balance.stiffness, mesh.inverse_mass, mesh.clamped, mesh.clamp, nodal[0], nodal[1]
                    )
                nodal[2] = 1.0
                taut = s.balance.factors[0]  # as long as nothing is factored
                put_droppers(
                    nodal[2, : mesh.dropper.size], mesh.lower, mesh.upper, mesh.dropper_stiffness, s.balance.stiffness, taut
                )
                for j in range(taut.shape[0]):
                    taut[j, 0] += mesh.ground[j]
                omega2 = highest_eigenvalue(taut, mesh.inverse_mass, mesh.clamped, mesh.clamp, nodal[0], nodal[1])
            add_ground(mesh, s.balance)
            if e.gusts is not None:
                if e.gusts.lift_coefficient != 0.0:
                    status = blow(e.gusts, unilateral, mesh, s.plan, s.grid, s.balance, s.space, refused)
                if status == DONE:
                    status = raise_wind(e.gusts, mesh, s.plan, s.grid, s.gusts)
            if e.scatter is not None and status == DONE:  # what slack droppers do not push
                nodal[0] = 0.0
                if math.isnan(find_balance(nodal[0], unilateral, s.at_rest, mesh, s.balance)):
                    status = UNBALANCED
            if s.rows is not None and status == DONE:
                for j in range(nodal.shape[1]):
                    nodal[0, j] = mesh.ground_damping[j]
                    if e.gusts is not None:
                        nodal[0, j] += s.gusts.push[0, j]
                fill_damping(alpha, nodal[0], mesh, s.rows)
                s.limits[0] = explicit_limit(omega2, damped, nodal[0], mesh.inverse_mass)
                if p.substep > s.limits[0]:
                    digits = 10.0 ** (2.0 - math.floor(math.log10(s.limits[0])))
                    s.limits[1] = math.floor(s.limits[0] * digits + 0.5) / digits
                    status = SUBSTEP_TOO_LONG
        for k in range(s.refused.size):
            s.refused[k] = refused[k]
        s.ready[0] = 1.0 if status == DONE else 0.0
        if status != DONE:
            return status

    # equilibrium under the contact forces
    u, x, points, N, front = s.u, s.x, s.points, mesh.mass.size, -math.inf
    nodal[0] = 0.0
    for k in range(points.shape[0]):
        position = u[0, points[k, 0]]
        if not in_range(position, mesh):
            return OUT_OF_RANGE
        front = max(front, position)
        add_contact(position, u[0, points[k, 1]], nodal[0], points[k, 4], mesh)
        x[contacts_at(N) + 2 * k] = position
    s.y[OUT.static_residual] = find_balance(nodal[0], unilateral, x[:N], mesh, s.balance)
    if math.isnan(s.y[OUT.static_residual]):
        return UNBALANCED

    # what only one method or effect remembers
    if s.solver is not None:
        for k in range(mesh.dropper.size):
            x[x.size - mesh.dropper.size + k] = s.balance.taut[PRESENT, k]
    if s.rows is not None:
        open_window(p.front_threshold if e.gusts is None else 0.0, mesh, s.window, e.moving_window)
        begin_front(front, x, mesh, s.window)
    if e.gusts is not None:
        loads = x[gust_state(points, mesh) :]
        loads[SAMPLE], loads[FIRST], loads[LAST] = UNREADY, 0.0, -1.0
        follow_gusts(t, 0, mesh.position.size - 1, loads, mesh, s.gusts)
    if e.second_wire is not None:  # where it is not touched
        s.y[e.second_wire.y : e.second_wire.y + 2 + FURTHER] = NO_WIRE
    return DONE


@kernel
def catenary_step(t, h, s, p, e):
    """Equal internal steps over h, then the outputs."""
    mesh = unpacked(s.numbers, s.indices)
    n = max(1, math.ceil(h / p.substep * (1.0 - 1e-9)))
    motion = Motion(s.x, s.u, s.points, s.work, s.counts, s.window, s.gusts)
    laws = Laws(e.dropper_slackening, e.bending_stiffness, e.damping)
    status = DONE
    if s.solver is not None:
        status = implicit_steps(t, h, n, motion, mesh, s.solver, p.spectral_radius, laws)
    if s.rows is not None:
        status = explicit_steps(t, h, n, motion, mesh, s.rows, laws)
    follow_contacts(h, s.x, s.u, s.points, mesh)
    put_outputs(t + h, mesh, s, p, shown(e))
    return status


@kernel
def catenary_outputs(t, s, p, e):
    """Outputs for the present state and inputs."""
    put_outputs(t, unpacked(s.numbers, s.indices), s, p, shown(e))
    return DONE


Catenary.kernels = Kernels(catenary_initialize, catenary_step, catenary_outputs)
