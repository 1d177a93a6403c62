"""Effects of the catenary."""

from __future__ import annotations

from ..core.component import Effect
from ..core.variables import PARTS, SEED, input_, integer, output, parameter, text

FURTHER = 6  # contact points that `further_pantographs` can have
PROFILE = 121  # points of the wire's profile, 1 m apart, the contact point in the middle


class DropperSlackening(Effect):
    """Droppers carry tension only; off, they also push."""

    read_by = ("initialize", "step")
    either_in = ("initialize",)


class BendingStiffness(Effect):
    """Bending stiffness of the wires: Euler-Bernoulli beams under tension instead of strings.

    Values read in two public sources; the 2002 standard gives none.
    """

    read_by = ("initialize", "step")
    either_in = ("initialize",)

    contact_wire = parameter(195.0, "N.m2", "bending stiffness EI of the contact wire", low=0.0)
    messenger = parameter(131.7, "N.m2", "bending stiffness EI of the messenger wire", low=0.0)


class GravitySag(Effect):
    """Sag of the contact wire between its clamps, in the geometry of the contact; off, straight lines between clamps."""

    read_by = ("initialize",)
    either_in = ("initialize",)


class PreSag(Effect):
    """Parabolic pre-sag of the dropper clamps, 0 at the first and last dropper of a span; 55 mm as read for AC simple."""

    explicit_only = True
    read_by = ("initialize",)
    either_in = ("initialize",)

    depth = parameter(0.055, "m", "pre-sag in the middle of the span", low=0.0)


class Damping(Effect):
    """Rayleigh damping of the wires, alpha M + beta K; droppers and supports are not part of K.

    The 2002 standard prescribes none. beta = 1 ms is a choice: undamped wires do not converge with the mesh, with it they do.
    """

    read_by = ("initialize", "step")
    either_in = ("initialize",)

    alpha = parameter(0.0, "1/s", "mass-proportional coefficient", low=0.0)
    beta = parameter(1e-3, "s", "stiffness-proportional coefficient", low=0.0)


class SteadyArm(Effect):
    """Steady arm at every support: a vertical spring and a mass at the contact wire.

    300 N/m read in two public sources, whether it is in the 2002 standard is not known.
    """

    read_by = ("initialize",)
    either_in = ("initialize",)

    stiffness = parameter(300.0, "N/m", "vertical stiffness of the steady arm", low=0.0)
    mass = parameter(0.0, "kg", "mass of the steady arm at the contact wire", low=0.0)


class LevelSupport(Effect):
    """The steady arms hold the contact wire at dropper level at rest; off, it hangs free at the supports."""

    explicit_only = True
    read_by = ()


class SecondPantograph(Effect):
    """A second contact point, in the wake of the first."""

    explicit_only = True
    read_by = ()

    contact_position = input_(30.0, "m", "position of the second contact point", nominal=100.0, moving=True)
    contact_force = input_(0.0, "N", "force of the second pantograph on the wire, positive upwards", nominal=100.0)
    wire_height = output(
        "m", "height of the contact wire at the second contact point", nominal=0.05, feedthrough=(".contact_position",)
    )
    wire_velocity = output(
        "m/s", "vertical velocity of the wire at the second contact point", nominal=0.1, feedthrough=(".contact_position",)
    )
    contact_compliance = output("m/N", "compliance that the mesh leaves out at the second contact point", nominal=1e-6)


class FurtherPantographs(Effect):
    """A third contact point and more, in any order along the track; elements beyond `count` do not take part."""

    explicit_only = True
    requires = ("second_pantograph",)
    read_by = ()

    count = integer(1, "number of contact points beyond the second", low=1, high=FURTHER, structural=PARTS)
    contact_position = input_(30.0, "m", "position of a further contact point", nominal=100.0, moving=True, size=FURTHER)
    contact_force = input_(0.0, "N", "force of a further pantograph on the wire, positive upwards", nominal=100.0, size=FURTHER)
    wire_height = output(
        "m",
        "height of the contact wire at a further contact point",
        nominal=0.05,
        size=FURTHER,
        feedthrough=tuple(f".contact_position[{i + 1}]" for i in range(FURTHER)),
    )
    wire_velocity = output(
        "m/s",
        "vertical velocity of the wire at a further contact point",
        nominal=0.1,
        size=FURTHER,
        feedthrough=tuple(f".contact_position[{i + 1}]" for i in range(FURTHER)),
    )
    contact_compliance = output(
        "m/N", "compliance that the mesh leaves out at a further contact point", nominal=1e-6, size=FURTHER
    )


class MovingWindow(Effect):
    """Wires far behind the last contact point are no longer followed: they go back to their static equilibrium.

    The edge lets waves out, but not back in from the spans beyond: the length is that from which they come back damped, for an
    error of at most 0.5 % of the 20 Hz-filtered force at the speed of the slowest contact point, see `moving_window.width`. A shorter
    one warns. On lines with little damping it is longer than the line may be. Ahead the wires rest in any case until motion
    arrives, see `front_threshold`.
    """

    explicit_only = True
    read_by = ("initialize", "outputs", "step")
    either_in = ("initialize",)

    behind = parameter(0.0, "m", "length behind the last contact point; 0: from damping and speed", low=0.0)
    rear = output("m", "place from which on the wires are followed; a support before it has an uplift of 0 that says nothing")


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
    read_by = ("initialize",)

    table = text(SIX_SPANS, "table of the line, as TOML text; a scene may name its file")
    droppers = text("", "droppers in the place of those of the table, as CSV text; a scene may name its file")


class Temperature(Effect):
    """Another temperature than that of the table: tensions and heights of wires that are anchored at both ends (`fixed = true`).

    The equation of state of every such wire, with the shape of the whole line on droppers of unchanged length; wires with
    automatic tensioning keep their tension. What is neglected stands in docs/own-line.md.
    """

    explicit_only = True
    requires = ("line_table",)
    read_by = ("initialize",)
    either_in = ("initialize",)

    change = parameter(20.0, "K", "temperature above that at which the line is as the table says", low=-100.0, high=150.0)


class Wear(Effect):
    """A contact wire worn since the droppers were cut: it is lighter, and all wires rise on droppers of unchanged length.

    Beside the `wear` of spans in the table, for which droppers are cut. Tensions of tensioned wires stay; a wire that is anchored at
    both ends has less EA. The bending stiffness stays that of the table: how a section wears is not said.
    """

    explicit_only = True
    requires = ("line_table",)
    read_by = ("initialize",)
    either_in = ("initialize",)

    share = parameter(
        0.1, "1", "share of the contact wires' section that is gone since; their mass falls by it", low=0.0, high=0.5
    )


class Scatter(Effect):
    """A line as it was built: dropper lengths, heights of supports and tensions differ at random from those of the table.

    Independent normal deviations, the same for the same seed. Droppers that are too long hang slack at rest. The deviations are
    choices: no measured ones were at hand. All uplifts count from the built line at rest.
    """

    explicit_only = True
    requires = ("line_table",)
    excludes = ("moving_window",)
    read_by = ("initialize",)

    seed = integer(1, "of the random deviations", low=0, high=2**31 - 1, structural=SEED)
    dropper_length = parameter(0.003, "m", "standard deviation of the cut lengths of droppers", low=0.0, high=1.0)
    support_height = parameter(0.01, "m", "standard deviation of the heights of the messenger at supports", low=0.0, high=1.0)
    tension = parameter(
        0.02, "1", "standard deviation of the tensions of contact wires and messengers, as a share", low=0.0, high=0.2
    )


class SecondWire(Effect):
    """Contacts with a second contact wire: of a twin, or where sections overlap.

    Elements count the contact points: 1 is the own one, 2 that of second_pantograph, 3 and up those of further_pantographs. Where
    there is no second wire its height is 10 m, out of reach.
    """

    explicit_only = True
    requires = ("line_table",)
    read_by = ("initialize",)
    either_in = ("initialize",)

    contact_force = input_(0.0, "N", "force on the second contact wire, positive upwards", nominal=100.0, size=2 + FURTHER)
    wire_height = output(
        "m",
        "height of the second contact wire at a contact point",
        nominal=0.05,
        size=2 + FURTHER,
        feedthrough=("contact_position",),
    )
    wire_velocity = output(
        "m/s",
        "vertical velocity of the second contact wire at a contact point",
        nominal=0.1,
        size=2 + FURTHER,
        feedthrough=("contact_position",),
    )
    contact_compliance = output(
        "m/N", "compliance that the mesh leaves out at a contact point of the second contact wire", nominal=1e-6, size=2 + FURTHER
    )


class Stagger(Effect):
    """Lateral position of the contact wires, straight from support to support as the table says: where a head is touched.

    Statics of a string: lateral and vertical motion decouple to first order, and lateral motion is not integrated. The arms'
    lateral forces and vertical stiffness belong to the table itself.
    """

    explicit_only = True
    requires = ("line_table",)
    read_by = ("step", "outputs")

    lateral_position = output(
        "m", "lateral position of the contact wire at the contact point", nominal=0.1, feedthrough=("contact_position",)
    )
    second_lateral_position = output("m", "the same of the second contact wire", nominal=0.1, feedthrough=("contact_position",))


class BlowOff(Effect):
    """A steady wind across the line moves the contact wires to the side: x (L - x) p / 2 T between supports, p L² / 8 T at most.

    Quasi-static, beside the vertical motion: p = rho/2 C_D d U² on the wire alone, a string that its supports hold. Neglected: what
    droppers take over from or to the messenger, the messenger's own drag, the supports' give. Values of C_D and d from memory.
    """

    explicit_only = True
    requires = ("stagger",)
    read_by = ("step", "outputs")

    speed = parameter(20.0, "m/s", "speed of the wind across the line, positive towards positive stagger", low=-100.0, high=100.0)
    density = parameter(1.225, "kg/m3", "density of the air", low=0.0)
    drag_coefficient = parameter(1.0, "1", "drag coefficient C_D of the contact wires", low=0.0)
    diameter = parameter(0.0145, "m", "diameter d of the contact wires", low=0.0)


class WireProfile(Effect):
    """Shape of the contact wire around the contact point as outputs, for pictures."""

    explicit_only = True
    read_by = ("step", "outputs")

    height = output(
        "m",
        "height of the contact wire, from 60 m behind to 60 m ahead of the contact point in steps of 1 m",
        nominal=0.05,
        size=PROFILE,
        feedthrough=("contact_position",),
    )


class LineProfile(Effect):
    """What the contact wire hangs from, at the points of its profile, for pictures."""

    explicit_only = True
    requires = ("wire_profile",)
    read_by = ("step", "outputs")

    messenger_uplift = output(
        "m",
        "displacement of the messenger wire at the points of the profile",
        nominal=0.05,
        size=PROFILE,
        feedthrough=("contact_position",),
    )
    dropper_tension = output(
        "N",
        "smallest tension of the droppers within half a metre of each point, 0 where one is slack, -1 without any",
        nominal=100.0,
        size=PROFILE,
        feedthrough=("contact_position",),
    )
    auxiliary_uplift = output(
        "m",
        "displacement of the auxiliary wire at the points of the profile, 0 without one",
        nominal=0.05,
        size=PROFILE,
        feedthrough=("contact_position",),
    )
