"""The ligaments of the wrist: as an effect of `Wrist`, and as a unit of their own."""

from __future__ import annotations

from typing import Any

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import NUMBERED, choice, input_, integer, output, parameter
from .kinematics import COUPLING_MODELS, DISTAL_TILT, PROXIMAL_TILT, ROW_OFFSET, Axes, axes_refusals, axes_status, crossing
from .ligament_springs import (
    COLUMNS,
    COUNT,
    LIGAMENTS,
    OFF_AXIS,
    STIFFNESS,
    TOE_STRAIN,
    bundle_pull,
    make_ligaments,
    write_bundle,
)

ORDER = ", ".join(f"{i + 1} {name.replace('_', '-')}" for i, name in enumerate(LIGAMENTS))
TORQUES = (
    "tau_flexion",
    "tau_deviation",
    "proximal_torque",
    "distal_torque",
    *(
        f"load.{n}"
        for n in (
            "flexor_radial",
            "flexor_ulnar",
            "extensor_radial",
            "extensor_ulnar",
            "tip_force_x",
            "tip_force_y",
            "tip_force_z",
        )
    ),
)


class Constraint(Effect):
    """Five isometric ligaments, as springs with a toe or rigid; any one can be cut.

    Rigid ones that are isometric change nothing. One that is not holds its row; where both rows were held, they are refused.
    """

    requires = ("morphology",)

    kind = choice("springs", ("springs", "rigid"), "springs, or rigid without stiffness, toe and damping")
    cut = integer(0, f"ligament that is cut: 0 none, {ORDER}", low=0, high=COUNT, structural=NUMBERED)
    stiffness = parameter(STIFFNESS, "N/m", "stiffness of each ligament beyond its toe", low=0.0, size=COUNT)
    off_axis = parameter(OFF_AXIS, "m", "distance of one end from the axis; 0: isometric", low=0.0, high=5e-3, size=COUNT)
    prestrain = parameter(0.0, "1", "strain of the ligaments at rest", low=-0.5, high=0.5)
    toe = parameter(TOE_STRAIN, "1", "strain over which the tension rises to its full stiffness", low=0.0)
    damping = parameter(0.0, "s", "growth of the tension with the rate of strain", low=0.0)
    lunate_extent = parameter(0.7, "1", "angle of the lunate over that of the row", low=0.0, high=1.5)
    triquetrum_extent = parameter(0.85, "1", "angle of the triquetrum over that of the row", low=0.0, high=1.5)

    tension = output(
        "N",
        "tension of each ligament; of rigid ones 0, for their parts in the reaction are not determined",
        nominal=10.0,
        size=COUNT,
    )
    strain = output("1", "strain of each ligament over its slack length, of a cut one, too", nominal=0.01, size=COUNT)
    proximal_reaction = output("N.m", "torque of rigid ligaments on a proximal row that they hold", feedthrough=TORQUES)
    distal_reaction = output("N.m", "torque of rigid ligaments on a distal row that they hold", feedthrough=TORQUES)


class LigamentBundle(StatelessComponent):
    """The five ligaments as a unit without mass: angles and rates of the rows in, torques on these angles out.

    Its torques are for the inputs `proximal_torque` and `distal_torque` of a `Wrist` without the effect `constraint`, with the
    same axes and coupling model. Always springs: a unit without mass cannot be rigid, for it would have to know all other forces.
    Which pairs are isometric is Sandow's (2008); attachments, extents and stiffness are ours (`ligament_springs`), the latter of
    the order of tests of such ligaments, from memory, tens of newtons a millimetre.
    """

    title = "Ligaments of the wrist"
    system = "wrist"

    coupling_model = choice("rules", COUPLING_MODELS, "how the rows of the wrist share the motion")
    proximal_tilt = parameter(PROXIMAL_TILT, "rad", "tilt of the proximal row's axis from that of flexion, towards deviation")
    distal_tilt = parameter(DISTAL_TILT, "rad", "tilt of the distal row's axis from that of flexion, the other way")
    row_offset = parameter(ROW_OFFSET, "m", "distance of the distal row's axis from the proximal one's along the hand", low=0.0)
    cut = Constraint.cut
    stiffness = Constraint.stiffness
    off_axis = Constraint.off_axis
    prestrain = Constraint.prestrain
    toe = Constraint.toe
    damping = Constraint.damping
    lunate_extent = Constraint.lunate_extent
    triquetrum_extent = Constraint.triquetrum_extent

    proximal_angle = input_(0.0, "rad", "angle of the proximal row")
    distal_angle = input_(0.0, "rad", "angle of the distal row against the proximal row")
    proximal_rate = input_(0.0, "rad/s", "rate of the proximal row")
    distal_rate = input_(0.0, "rad/s", "rate of the distal row against the proximal row")

    _angles = ("proximal_angle", "distal_angle")
    _motion = (*_angles, "proximal_rate", "distal_rate")
    proximal_torque = output("N.m", "torque on the proximal row's angle", feedthrough=_motion)
    distal_torque = output("N.m", "torque on the distal row's angle", feedthrough=_motion)
    tension = output("N", "tension of each ligament", nominal=10.0, size=COUNT, feedthrough=_motion)
    strain = output(
        "1", "strain of each ligament over its slack length, of a cut one, too", nominal=0.01, size=COUNT, feedthrough=_angles
    )
    stored_energy = output("J", "energy of the stretched ligaments", nominal=0.1, feedthrough=_angles)
    dissipation = output("W", "power lost in the ligaments", feedthrough=_motion)

    refusals = axes_refusals("{proximal_tilt}", "{distal_tilt}", "{crossing}")

    def shapes(self) -> dict[str, Any]:
        """`ligaments`: see `ligament_springs`.  `crossing`: sine of the angle between the axes."""
        return {"ligaments": (COUNT, COLUMNS), "crossing": 1}

    def energy(self) -> float:
        """The output `stored_energy` at the present angles, J."""
        self.refresh()
        return float(self.get("stored_energy"))


IN = LigamentBundle.input_places()
OUT = LigamentBundle.output_places()


@kernel
def bundle_axes(p):
    """Where the axes lie at rest."""
    return Axes(p.coupling_model, p.proximal_tilt, p.distal_tilt, p.row_offset)


@kernel
def bundle_start(t, s, p, e):
    """Axes that leave two motions, and the ligaments."""
    axes = bundle_axes(p)
    s.crossing[0] = crossing(axes)
    make_ligaments(p, s.ligaments)
    return axes_status(axes)


@kernel
def bundle_outputs(t, s, p, e):
    """Torques, tensions and strains, energy, losses."""
    u, y, axes = s.u[0], s.y, bundle_axes(p)
    y[OUT.proximal_torque], y[OUT.distal_torque], y[2 + 2 * COUNT], y[3 + 2 * COUNT] = bundle_pull(
        u[IN.proximal_angle], u[IN.distal_angle], u[IN.proximal_rate], u[IN.distal_rate], axes, s.ligaments
    )
    write_bundle(u[IN.proximal_angle], u[IN.distal_angle], u[IN.proximal_rate], u[IN.distal_rate], y, 2, axes, s.ligaments)
    return DONE


LigamentBundle.kernels = stateless_kernels(__name__, bundle_outputs, bundle_start)
