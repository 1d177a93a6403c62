"""Distributed catenary: contact wire and messenger wire, droppers, supports."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable

import numpy as np

from ..core.banded import banded_product
from ..core.component import Component, Effect, Preset
from ..core.errors import BadInput
from ..core.kernels import DONE, OUT_OF_RANGE, hold_inputs, kernel
from ..core.variables import choice, input_, integer, output, parameter, text
from .contact import at_contact, contact_compliance, element_at, heights_around, hung_around, in_range, wire_height
from .explicit import PAD, explicit_steps, move_window
from .gust_loads import empty_gust_state, gust_state, load_at, start_gusts
from .gusts import ACROSS, Gusts
from .implicit import implicit_steps
from .line.dropper_table import line_of
from .line.form import Form, form_of
from .line.from_table import support_positions, unused_by
from .line.layout import Layout, uniform
from .line.temperature import formed_layout
from .mesh import NO_WIRE, stiffness_of_wires, unpacked
from .moving_window import ENOUGH, echo, width
from .prepared import PreparedLine, prepared_line

MAX_DROPPERS = 14  # in a span; the simple DC catenary of EN 50318:2018 has 14
WATCHED = 5  # supports whose uplift is an output
FURTHER = 6  # contact points that `further_pantographs` can have
# parameters that a table of a line may leave out
LINE = ("contact_wire_tension", "contact_wire_mass", "messenger_tension", "messenger_mass", "dropper_stiffness", "dropper_mass",
        "contact_clamp_mass", "messenger_clamp_mass", "support_stiffness", "support_damping")
PROFILE = 121  # points of the wire's profile, 1 m apart, the contact point in the middle


class DropperSlackening(Effect):
    """Droppers carry tension only; off, they also push."""


class BendingStiffness(Effect):
    """Bending stiffness of the wires: Euler-Bernoulli beams under tension instead of strings.

    Values read in two public sources; the 2002 standard gives none.
    """

    contact_wire = parameter(195.0, "N.m2", "bending stiffness EI of the contact wire", low=0.0)
    messenger = parameter(131.7, "N.m2", "bending stiffness EI of the messenger wire", low=0.0)


class GravitySag(Effect):
    """Sag of the contact wire between its clamps, in the geometry of the contact; off, straight lines between clamps."""


class PreSag(Effect):
    """Parabolic pre-sag of the dropper clamps, 0 at the first and last dropper of a span; 55 mm as read for AC simple."""

    explicit_only = True

    depth = parameter(0.055, "m", "pre-sag in the middle of the span", low=0.0)


class Damping(Effect):
    """Rayleigh damping of the wires, alpha M + beta K; droppers and supports are not part of K.

    The 2002 standard prescribes none. beta = 1 ms is a choice: undamped wires do not converge with the mesh, with it they do.
    """

    alpha = parameter(0.0, "1/s", "mass-proportional coefficient", low=0.0)
    beta = parameter(1e-3, "s", "stiffness-proportional coefficient", low=0.0)


class SteadyArm(Effect):
    """Steady arm at every support: a vertical spring and a mass at the contact wire.

    300 N/m read in two public sources, whether it is in the 2002 standard is not known.
    """

    stiffness = parameter(300.0, "N/m", "vertical stiffness of the steady arm", low=0.0)
    mass = parameter(0.0, "kg", "mass of the steady arm at the contact wire", low=0.0)


class LevelSupport(Effect):
    """The steady arms hold the contact wire at dropper level at rest; off, it hangs free at the supports."""

    explicit_only = True


class SecondPantograph(Effect):
    """A second contact point, in the wake of the first."""

    explicit_only = True

    contact_position = input_(30.0, "m", "position of the second contact point", nominal=100.0, moving=True)
    contact_force = input_(0.0, "N", "force of the second pantograph on the wire, positive upwards", nominal=100.0)
    wire_height = output("m", "height of the contact wire at the second contact point", nominal=0.05,
                         feedthrough=(".contact_position",))
    wire_velocity = output("m/s", "vertical velocity of the wire at the second contact point", nominal=0.1,
                           feedthrough=(".contact_position",))
    contact_compliance = output("m/N", "compliance that the mesh leaves out at the second contact point", nominal=1e-6)


class FurtherPantographs(Effect):
    """A third contact point and more, in any order along the track; elements beyond `count` do not take part."""

    explicit_only = True
    requires = ("second_pantograph",)

    count = integer(1, "number of contact points beyond the second", low=1, high=FURTHER)
    contact_position = input_(30.0, "m", "position of a further contact point", nominal=100.0, moving=True, size=FURTHER)
    contact_force = input_(0.0, "N", "force of a further pantograph on the wire, positive upwards", nominal=100.0, size=FURTHER)
    wire_height = output("m", "height of the contact wire at a further contact point", nominal=0.05, size=FURTHER,
                         feedthrough=tuple(f".contact_position[{i + 1}]" for i in range(FURTHER)))
    wire_velocity = output("m/s", "vertical velocity of the wire at a further contact point", nominal=0.1, size=FURTHER,
                           feedthrough=tuple(f".contact_position[{i + 1}]" for i in range(FURTHER)))
    contact_compliance = output("m/N", "compliance that the mesh leaves out at a further contact point", nominal=1e-6,
                                size=FURTHER)


class MovingWindow(Effect):
    """Only the wires around the contact points move; the rest stays in its static equilibrium.

    The edges let waves out, but not back in from the spans beyond: the width is that from which they come back damped, for an
    error of at most 0.5 % of the 20 Hz-filtered force, see `moving_window.width`. A narrower one warns. On lines with little
    damping the window is wider than the line may be long.
    """

    explicit_only = True

    ahead = parameter(0.0, "m", "length ahead of the first contact point; 0: from damping and speed", low=0.0)
    behind = parameter(0.0, "m", "length behind the last contact point; 0: from damping and speed", low=0.0)
    speed = parameter(250.0 / 3.6, "m/s", "speed of the slowest contact point, for which the widths are", low=0.0)


SIX_SPANS = """title = "Six unequal spans, all else as the parameters say"
[[sections]]
messenger = { fixed = true, axial_stiffness = 1.36e7 }  # with `temperature`; inferred: 120 mm2 of bronze, 113 GPa
spans = [50.0, 65.0, 55.0, 45.0, 60.0, 50.0]
"""


class LineTable(Effect):
    """A line from a table instead of uniform spans: sections, spans, droppers, supports, stitch wires (docs/own-line.md).

    What the table leaves out comes from the parameters; one that the table leaves no use for is refused where it is given.
    """

    explicit_only = True
    excludes = ("pre_sag", "level_support", "steady_arm")
    replaces = ("spans", "span_length", "droppers", "dropper_position")

    table = text(SIX_SPANS, "table of the line, as TOML text; a scene may name its file")
    droppers = text("", "droppers in the place of those of the table, as CSV text; a scene may name its file")


class Temperature(Effect):
    """Another temperature than that of the table: tensions and heights of wires that are anchored at both ends (`fixed = true`).

    The equation of state of every such wire, with the shape of the whole line on droppers of unchanged length; wires with
    automatic tensioning keep their tension. What is neglected stands in docs/own-line.md.
    """

    explicit_only = True
    requires = ("line_table",)

    change = parameter(20.0, "K", "temperature above that at which the line is as the table says", low=-100.0, high=150.0)


class SecondWire(Effect):
    """Contacts with a second contact wire: of a twin, or where sections overlap.

    Elements count the contact points: 1 is the own one, 2 that of second_pantograph, 3 and up those of further_pantographs. Where
    there is no second wire its height is 10 m, out of reach.
    """

    explicit_only = True
    requires = ("line_table",)

    contact_force = input_(0.0, "N", "force on the second contact wire, positive upwards", nominal=100.0, size=2 + FURTHER)
    wire_height = output("m", "height of the second contact wire at a contact point", nominal=0.05, size=2 + FURTHER,
                         feedthrough=("contact_position",))
    wire_velocity = output("m/s", "vertical velocity of the second contact wire at a contact point", nominal=0.1,
                           size=2 + FURTHER, feedthrough=("contact_position",))
    contact_compliance = output("m/N", "compliance that the mesh leaves out at a contact point of the second contact wire",
                                nominal=1e-6, size=2 + FURTHER)


class Stagger(Effect):
    """Lateral position of the contact wires, straight from support to support as the table says: where a head is touched.

    Statics of a string: lateral and vertical motion decouple to first order, and lateral motion is not integrated. The arms'
    lateral forces and vertical stiffness belong to the table itself.
    """

    explicit_only = True
    requires = ("line_table",)

    lateral_position = output("m", "lateral position of the contact wire at the contact point", nominal=0.1,
                              feedthrough=("contact_position",))
    second_lateral_position = output("m", "the same of the second contact wire", nominal=0.1, feedthrough=("contact_position",))


class WireProfile(Effect):
    """Shape of the contact wire around the contact point as outputs, for pictures."""

    explicit_only = True

    height = output("m", "height of the contact wire, from 60 m behind to 60 m ahead of the contact point in steps of 1 m",
                    nominal=0.05, size=PROFILE, feedthrough=("contact_position",))


class LineProfile(Effect):
    """What the contact wire hangs from, at the points of its profile, for pictures."""

    explicit_only = True
    requires = ("wire_profile",)

    messenger_uplift = output("m", "displacement of the messenger wire at the points of the profile", nominal=0.05, size=PROFILE,
                              feedthrough=("contact_position",))
    dropper_tension = output("N", "smallest tension of the droppers within half a metre of each point, 0 where one is slack, -1 "
                             "without any", nominal=100.0, size=PROFILE, feedthrough=("contact_position",))


class Catenary(Component):
    """Contact wire and messenger wire as tensioned strings or beams, coupled by droppers, in the vertical plane.

        m u'' = T u'' (x) - EI u'''' - alpha m u' + beta (T u'' - EI u'''')' + droppers + supports + contact

    for either wire, linear about the static equilibrium; a dropper pulls with F0 + k (u_messenger - u_contact), never
    below 0 if it can slacken. Both wires are fixed at the ends of the section. The contact force is an input: the
    partner owns the contact law. Numerics: linear elements with a mass between lumped and consistent that cancels the
    leading dispersion error of space and time together, explicit (velocity Verlet) or implicit (generalised-alpha).
    Defaults: the EN 50318:2002 reference model. Tensions, masses, span, dropper positions and stiffness, messenger support:
    read in two public sources (whether the support's 50 kN/m is in the standard itself is not known). No dropper and clamp
    masses, no damping of the supports: recalled. Element, substep and method: by error against work, docs/railway-contact.md.
    """

    title = "Distributed catenary with droppers"
    system = "railway"
    default_stop = 2.0
    start_inputs = (
        "contact_position", "contact_force", "second_pantograph.contact_position", "second_pantograph.contact_force",
        "further_pantographs.contact_position", "further_pantographs.contact_force", "second_wire.contact_force")
    ports = {"contact": ("contact_position", "contact_force", "wire_height")}
    counters = ("steps", "solves", "factorizations")

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
    second_wire = SecondWire
    stagger = Stagger
    gusts = Gusts
    wire_profile = WireProfile
    line_profile = LineProfile

    spans = integer(10, "number of spans", low=1, high=1000)
    span_length = parameter(60.0, "m", "length of a span", low=1.0)
    contact_wire_tension = parameter(20e3, "N", "tension of the contact wire", low=1.0)
    contact_wire_mass = parameter(1.35, "kg/m", "mass of the contact wire per length", low=1e-6)
    messenger_tension = parameter(16e3, "N", "tension of the messenger wire", low=1.0)
    messenger_mass = parameter(1.07, "kg/m", "mass of the messenger wire per length", low=1e-6)
    droppers = integer(9, "droppers in a span", low=1, high=MAX_DROPPERS)
    dropper_position = parameter(
        (5.0, 10.5, 17.0, 23.5, 30.0, 36.5, 43.0, 49.5, 55.0, *(0.0,) * (MAX_DROPPERS - 9)), "m",
        "position of a dropper within the span; elements beyond the number of droppers do not count", size=MAX_DROPPERS)
    dropper_stiffness = parameter(100e3, "N/m", "stiffness of a dropper", low=1.0)
    dropper_mass = parameter(0.0, "kg", "mass of a dropper, half of it at either wire", low=0.0)
    contact_clamp_mass = parameter(0.0, "kg", "mass of a dropper clamp on the contact wire", low=0.0)
    messenger_clamp_mass = parameter(0.0, "kg", "mass of a dropper clamp on the messenger wire", low=0.0)
    support_stiffness = parameter(50e3, "N/m", "vertical stiffness of a messenger support", low=0.0)
    support_damping = parameter(0.0, "N.s/m", "damping of a messenger support", low=0.0)
    first_watched_support = integer(4, "number of the first support whose uplift is an output; 0 is the start", low=0)

    method = choice("explicit", ("explicit", "implicit"), "time integration")
    element = parameter(0.4, "m", "longest element", low=0.01, high=30.0)
    substep = parameter(1e-3, "s", "longest internal step", low=1e-7, high=0.1)
    spectral_radius = parameter(1.0, "1", "generalised-alpha: spectral radius at infinite frequency", low=0.0, high=1.0)

    contact_position = input_(30.0, "m", "position of the contact point", nominal=100.0, moving=True)
    contact_force = input_(0.0, "N", "force on the wire, positive upwards", nominal=100.0)
    wire_height = output("m", "height of the contact wire at the contact point", nominal=0.05,
                         feedthrough=("contact_position",))
    wire_velocity = output("m/s", "vertical velocity of the wire at the contact point", nominal=0.1,
                           feedthrough=("contact_position",))
    contact_compliance = output("m/N", "compliance that the mesh leaves out under the moving contact, in series with its spring",
                                nominal=1e-6)
    static_residual = output("1", "largest unbalanced force of the initial equilibrium over the largest dropper tension")
    support_uplift = output("m", "uplift of the contact wire at a watched support, 0 beyond the end", nominal=0.05, size=WATCHED)

    presets = {
        "EN 50318:2002": Preset(
            {"support_stiffness": 50e3, "dropper_stiffness": 100e3},
            "the defaults: repository ChandraguptSharma07/faraway; script after Liu et al., Appl. Sci. 13 (2023) 6819",
            "verbatim", ("dropper_slackening", "gravity_sag")),
        "EN 50318:2018 AC simple": Preset(
            {"substep": 2.5e-4, "span_length": 55.0, "contact_wire_tension": 22e3, "contact_wire_mass": 1.35,
             "messenger_tension": 16e3, "messenger_mass": 1.08, "droppers": 9,
             **{f"dropper_position[{i + 1}]": 4.5 + 5.75 * i for i in range(9)},
             "dropper_stiffness": 200e3, "dropper_mass": 0.117, "contact_clamp_mass": 0.165, "messenger_clamp_mass": 0.195,
             "support_stiffness": 500e3, "support_damping": 1000.0, "pre_sag.depth": 0.055,
             "bending_stiffness.contact_wire": 195.0, "bending_stiffness.messenger": 131.7,
             "damping.alpha": 0.0125, "damping.beta": 1e-4},
            "repository vivek-nexus/pantograph-catenary-model-ui and a public MATLAB program; dropper stiffness and support "
            "damping recalled, steady arm left out", "recalled",
            ("dropper_slackening", "gravity_sag", "pre_sag", "bending_stiffness", "damping")),
    }

    def _initialize(self, t: float) -> int:
        self.arguments = self._declared_arguments()
        p, e = self.arguments
        implicit = self.parameters["method"] == "implicit"
        if implicit and e.moving_window is not None:
            raise BadInput(self.name, "effect 'moving_window' with method 'implicit'", "method 'explicit'",
                           "The window moves through the wires; a factorised matrix does not.")
        line = self._line(p, e)
        self.mesh, self._packed = line.mesh, line.packed
        if line.buffeting is not None:  # with a workspace of its own
            gusts = line.buffeting._replace(at_station=np.zeros_like(line.buffeting.at_station))
            self.arguments = p, e = p, e._replace(gusts=gusts)
        if p.substep > line.limit:
            raise BadInput(self.name, f"substep = {p.substep:g} s", f"at most {line.limit:.3g} s, the explicit method's limit",
                           "Reduce substep, enlarge element, or set method = 'implicit'.")
        if e.moving_window is not None:
            self.arguments = p, e = p, e._replace(moving_window=self._window(p, e))
        N, W = self.mesh.mass.size, self.mesh.bending_gradient.size
        rows = line.layout.lateral[:, :3]
        self._points = contact_points(e, len(line.layout.contact_lanes))
        self._lateral = rows.copy() if rows.size else np.zeros((1, 3))
        loads = [(self.u[0, position], self.u[0, force], wire) for position, force, _, _, wire in self._points]
        for position, *_ in loads:
            if not in_range(position, self.mesh):
                return OUT_OF_RANGE
        q, taut, residual = line.statics.under(loads, e.dropper_slackening is not None)
        # displacement, velocity, acceleration; place and speed of each contact; then what only one method or effect remembers
        contacts = [value for position, *_ in loads for value in (position, 0.0)]
        edges = [1.0, N // W - 2.0] if e.moving_window is not None else []
        of_gusts = empty_gust_state(self.mesh) if e.gusts is not None else np.zeros(0)
        self.x = np.concatenate((q, np.zeros(2 * N), contacts, of_gusts, taut if implicit else [], edges))
        if e.moving_window is not None:
            positions = [position for position, *_ in loads]
            _, hi = move_window(max(positions), min(positions), self.x, self.mesh, e.moving_window)
            self.x[W * hi + W : N] = 0.0
        self.y[STATIC_RESIDUAL] = residual
        if e.second_wire is not None:  # where it is not touched
            self.y[e.second_wire.y : e.second_wire.y + 2 + FURTHER] = NO_WIRE
        self._stiffness = line.wires
        self._work = np.zeros((5, N) if implicit else (2, N + 2 * PAD * W))
        if implicit:
            self._band, self._factors = np.zeros((2, *self._stiffness.shape))
            self._factored = np.full(taut.size, -1.0)
            self._prepared = np.zeros(1)
        return DONE

    def _start(self, t: float) -> int:
        _, e = self.arguments
        if e.gusts is not None:
            start_gusts(t, self._points, self.x, *self._packed, e.moving_window, e.gusts)
        return DONE

    def _step(self, t: float, h: float) -> int:
        p, e = self.arguments
        n = max(1, math.ceil(h / p.substep * (1.0 - 1e-9)))
        watched = p.first_watched_support
        if self.parameters["method"] == "explicit":
            return advance_explicit(t, h, n, self.x, self.u, self.y, self._points, self._lateral, *self._packed,
                                    self._stiffness, self._work, self.counts, watched, e.dropper_slackening, e.bending_stiffness,
                                    e.damping, e.moving_window, e.gusts, e.stagger, e.wire_profile, e.line_profile)
        return advance_implicit(t, h, n, self.x, self.u, self.y, self._points, self._lateral, *self._packed, self._work,
                                self.counts, watched, p.spectral_radius, self._prepared, self._stiffness, self._band,
                                self._factors, self._factored, e.dropper_slackening, e.bending_stiffness, e.damping,
                                e.gusts, e.stagger, e.wire_profile, e.line_profile)

    def _outputs(self, t: float) -> None:
        p, e = self.arguments
        refresh_outputs(t, self.x, self.u[0], self.y, self._points, self._lateral, *self._packed, p.first_watched_support,
                        e.gusts, e.stagger, e.wire_profile, e.line_profile)

    def energy(self) -> float:
        """Energy above the static equilibrium without contact force, J: motion, wires, droppers, supports."""
        mesh, N = self.mesh, self.mesh.mass.size
        q, v, mass = self.x[:N], self.x[N : 2 * N], np.where(np.isinf(mesh.mass), 0.0, mesh.mass)
        total = 0.5 * q @ (banded_product(stiffness_of_wires(mesh, 3), q) + mesh.ground * q) + 0.5 * v @ (mass * v)
        stretch = q[mesh.upper] - q[mesh.lower]
        tension = mesh.preload + mesh.dropper_stiffness * stretch
        if "dropper_slackening" in self.on:
            tension = np.maximum(tension, 0.0)
        return float(total + np.sum((tension**2 - mesh.preload**2) / (2.0 * mesh.dropper_stiffness) - mesh.preload * stretch))

    def _window(self, p, e):
        """The effect's values with the widths that are not given; warns of a given one that is too narrow for the error."""
        mesh, window = self.mesh, e.moving_window
        wires = mesh.impedance > 0.0
        wave = float((mesh.tension[wires] / mesh.impedance[wires]).max())
        alpha, beta = (e.damping.alpha, e.damping.beta) if e.damping is not None else (0.0, 0.0)
        span = float(np.diff(mesh.position[mesh.support]).max()) if mesh.support.size > 1 else p.span_length
        line = wave, span, alpha, beta, window.speed
        wanted, whole = width(*line), float(mesh.position[-1])
        for name in ("ahead", "behind"):
            if 0.0 < (given := getattr(window, name)) < min(wanted, whole):
                cost, takes = 100.0 * echo(given, *line), "the whole line" if wanted >= whole else f"{wanted:.0f} m"
                warnings.warn(f"{self.name}: moving_window.{name} = {given:g} m may cost {cost:.2g} % of the contact force: "
                              f"{100.0 * ENOUGH:g} % takes {takes}; 0 is as much as it takes", stacklevel=2)
        return window._replace(ahead=window.ahead or min(wanted, whole), behind=window.behind or min(wanted, whole))

    def left_range(self) -> str:
        """The contact points, their speeds, and the part of the wire on which they may be."""
        columns = dict.fromkeys(self._points[:, 0].tolist())
        points = [f"{self.inputs[i]} = {self.u[0, i]:g} m moving at {self.u[1, i]:g} m/s" for i in columns]
        first = int(self.x[-2]) if "moving_window" in self.on and self.x.size else 1
        low, high = self.mesh.position[[first, -2]]
        back = "; the moving window does not go back (moving_window.behind)" if first > 1 else ""
        return f"{', '.join(points)}, expected from {low:g} to {high:g} m{back}"

    def stable_step(self) -> float:
        """Limit of the explicit method, s; inf if implicit."""
        return self._line(*self._declared_arguments()).limit

    def form(self) -> Form:
        """The line at rest, for the present parameters; of a uniform catenary the messenger's supports are at the height 0."""
        return form_of(self._layout_for(*self._declared_arguments()))

    def unused(self, names: Iterable[str]) -> dict[str, str]:
        """See `Component.unused`; also what a line's table or the method has no use for, and a support beyond the end."""
        names = tuple(names)
        reasons = super().unused(names)
        if "spectral_radius" in names and self.parameters["method"] == "explicit":
            reasons["spectral_radius"] = "method 'explicit' has none"
        if "gusts" in self.on and self.parameters["gusts.lift_coefficient"] == 0.0:
            reasons |= dict.fromkeys(ACROSS.intersection(names), "without gusts.lift_coefficient only vertical gusts act")
        if "first_watched_support" in names:
            last = self.get("spans") if "line_table" not in self.on else (
                support_positions(line_of(self.parameters, self.name)).size - 1)
            if self.get("first_watched_support") > last:
                reasons["first_watched_support"] = f"the last support of the line is number {last}"
        rest = [n for n in names if n in LINE or n.startswith("bending_stiffness.")]
        if "line_table" in self.on and rest:
            p, e = self._declared_arguments()
            unused = unused_by(line_of(self.parameters, self.name), p, e.bending_stiffness, rest)
            reasons |= dict.fromkeys(unused, "line_table.table has it in every place")
        return reasons

    def _line(self, p, e) -> PreparedLine:
        """What the present parameters make, for all catenaries with the same; kept, for initialization is repeated."""
        key = (type(self), self.on, tuple(self.parameters.values()))
        if getattr(self, "_line_key", None) != key:
            self._prepared_line = prepared_line(key, lambda: self._layout_for(p, e), p, e,
                                                self.parameters["method"] == "implicit", self.name)
            self._line_key = key
        return self._prepared_line

    def _layout_for(self, p, e) -> Layout:
        if e.line_table is not None:
            return formed_layout(line_of(self.parameters, self.name), p, e.bending_stiffness, e.temperature)
        return uniform(p, e.bending_stiffness, e.pre_sag, e.steady_arm, e.level_support)


POSITION, FORCE = Catenary.input_indices("contact_position", "contact_force")
HEIGHT, STATIC_RESIDUAL, UPLIFT = Catenary.output_indices("wire_height", "static_residual", "support_uplift[1]")


def contact_points(e, wires: int) -> np.ndarray:
    """Of each contact point its position and force in u, its first output in y and how far the next ones are, its contact wire.

    (p, 5) int; e: effects; wires: number of contact wires. Points of `further_pantographs` beyond their number do not take part.
    """
    points = [(POSITION, FORCE, HEIGHT, 1, 0)]
    if e.second_pantograph is not None:
        second = e.second_pantograph
        points.append((second.u, second.u + 1, second.y, 1, 0))
    if e.further_pantographs is not None:
        more = e.further_pantographs
        points += [(more.u + i, more.u + FURTHER + i, more.y + i, FURTHER, 0) for i in range(int(more.count))]
    if e.second_wire is not None and wires > 1:
        wide = 2 + FURTHER
        points += [(points[k][0], e.second_wire.u + k, e.second_wire.y + k, wide, 1) for k in range(len(points))]
    return np.array(points, dtype=np.int64)


@kernel
def lateral_position(position, wire, lateral):
    """Lateral position of a contact wire, m, straight between the rows (wire, position, stagger) of `lateral`, 0 beyond them."""
    for k in range(lateral.shape[0] - 1):
        a, b = lateral[k, 1], lateral[k + 1, 1]
        if lateral[k, 0] == wire and lateral[k + 1, 0] == wire and a <= position <= b and b > a:
            s = (position - a) / (b - a)
            return (1.0 - s) * lateral[k, 2] + s * lateral[k + 1, 2]
    return 0.0


@kernel
def catenary_outputs(t, x, u, y, points, lateral, mesh, watched, gusts, stagger, profile, hung):
    """Outputs for the state x at the time t and the present inputs u, (m,)."""
    N, W = mesh.mass.size, mesh.bending_gradient.size
    q, v = x[:N], x[N : 2 * N]
    for k in range(points.shape[0]):
        position, i, next_one, wire = u[points[k, 0]], points[k, 2], points[k, 3], points[k, 4]
        y[i] = wire_height(position, q, wire, mesh)
        y[i + next_one] = at_contact(position, v, wire, mesh)
        y[i + 2 * next_one] = contact_compliance(x[3 * N + 2 * k + 1], position, wire, mesh)
    for k in range(WATCHED):
        j = W * mesh.support[min(watched + k, mesh.support.size - 1)]
        y[UPLIFT + k] = q[j]
        if mesh.height.size > mesh.position.size:  # of the second contact wire, where that rises further
            y[UPLIFT + k] = max(q[j], q[j + 2])
    if gusts is not None:
        position = u[points[0, 0]]
        y[gusts.y] = load_at(t, position, element_at(position, mesh), x[gust_state(points, mesh) :], mesh, gusts)
    if stagger is not None:
        for wire in range(2):
            y[stagger.y + wire] = lateral_position(u[POSITION], wire, lateral)
    if profile is not None:
        heights_around(u[POSITION], q, mesh, y[profile.y : profile.y + PROFILE])
    if hung is not None:
        hung_around(u[POSITION], q, mesh, y[hung.y : hung.y + PROFILE], y[hung.y + PROFILE : hung.y + 2 * PROFILE])


@kernel
def follow_contacts(h, x, u, points, mesh):
    """End of a step of length h: the inputs are held, and place (m) and speed (m/s) of the contact points are remembered.

    The speed from two places, not from an input's slope, which partners that hand over bare values do not give. A jump faster
    than the wire's waves is no motion.
    """
    hold_inputs(u, h)
    fastest = 0.0
    for k in range(mesh.fastest.size):
        fastest = max(fastest, mesh.fastest[k])
    for k in range(points.shape[0]):
        i, position = 3 * mesh.mass.size + 2 * k, u[0, points[k, 0]]
        speed = (position - x[i]) / h
        x[i] = position
        if abs(speed) <= fastest:
            x[i + 1] = speed


@kernel
def refresh_outputs(t, x, u, y, points, lateral, numbers, indices, watched, gusts, stagger, profile, hung):
    """`catenary_outputs` for a packed mesh."""
    catenary_outputs(t, x, u, y, points, lateral, unpacked(numbers, indices), watched, gusts, stagger, profile, hung)


@kernel
def advance_explicit(t, h, n, x, u, y, points, lateral, numbers, indices, stiffness, work, counts, watched, slack, bending,
                     damping, window, gusts, stagger, profile, hung):
    """One macro step with the explicit method, then the outputs."""
    mesh = unpacked(numbers, indices)
    status = explicit_steps(t, h, n, x, u, points, mesh, stiffness, work, counts, slack, bending, damping, window,
                            gusts)
    follow_contacts(h, x, u, points, mesh)
    catenary_outputs(t + h, x, u[0], y, points, lateral, mesh, watched, gusts, stagger, profile, hung)
    return status


@kernel
def advance_implicit(t, h, n, x, u, y, points, lateral, numbers, indices, work, counts, watched, radius, prepared, stiffness,
                     band, factors, factored, slack, bending, damping, gusts, stagger, profile, hung):
    """One macro step with the implicit method, then the outputs."""
    mesh = unpacked(numbers, indices)
    status = implicit_steps(t, h, n, x, u, points, mesh, work, counts, radius, prepared, stiffness, band, factors, factored,
                            slack, bending, damping, gusts)
    follow_contacts(h, x, u, points, mesh)
    catenary_outputs(t + h, x, u[0], y, points, lateral, mesh, watched, gusts, stagger, profile, hung)
    return status
