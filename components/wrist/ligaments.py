"""The ligaments of the wrist: as an effect of `Wrist`, and as a unit of their own."""

from __future__ import annotations

from typing import NamedTuple

from ..core.component import Effect
from ..core.kernels import DONE, kernel, kernel_tuple
from ..core.stateless import StatelessComponent
from ..core.variables import choice, input_, integer, output, parameter
from .kinematics import COUPLING_MODELS, DISTAL_TILT, PROXIMAL_TILT, ROW_OFFSET, Axes, check_axes
from .ligament_springs import COUNT, LIGAMENTS, OFF_AXIS, STIFFNESS, Ligaments, bundle_pull, make_ligaments, write_bundle

ORDER = ", ".join(f"{i + 1} {name.replace('_', '-')}" for i, name in enumerate(LIGAMENTS))
TORQUES = ("tau_flexion", "tau_deviation", "proximal_torque", "distal_torque", *(f"load.{n}" for n in (
    "flexor_radial", "flexor_ulnar", "extensor_radial", "extensor_ulnar", "tip_force_x", "tip_force_y", "tip_force_z")))


class Constraint(Effect):
    """Five isometric ligaments, as springs with a toe or rigid; any one can be cut.

    Rigid ones that are isometric change nothing. One that is not holds its row; where both rows were held, they are refused.
    """

    requires = ("morphology",)

    kind = choice("springs", ("springs", "rigid"), "springs, or rigid without stiffness, toe and damping")
    cut = integer(0, f"ligament that is cut: 0 none, {ORDER}", low=0, high=COUNT)
    stiffness = parameter(STIFFNESS, "N/m", "stiffness of each ligament beyond its toe", low=0.0, size=COUNT)
    off_axis = parameter(OFF_AXIS, "m", "distance of one end from the axis; 0: isometric", low=0.0, high=5e-3, size=COUNT)
    prestrain = parameter(0.0, "1", "strain of the ligaments at rest", low=-0.5, high=0.5)
    toe = parameter(0.03, "1", "strain over which the tension rises to its full stiffness", low=0.0)
    damping = parameter(0.0, "s", "growth of the tension with the rate of strain", low=0.0)
    lunate_extent = parameter(0.7, "1", "angle of the lunate over that of the row", low=0.0, high=1.5)
    triquetrum_extent = parameter(0.85, "1", "angle of the triquetrum over that of the row", low=0.0, high=1.5)

    tension = output("N", "tension of each ligament; of rigid ones 0, for their parts in the reaction are not determined",
                     nominal=10.0, size=COUNT)
    strain = output("1", "strain of each ligament over its slack length, of a cut one, too", nominal=0.01, size=COUNT)
    proximal_reaction = output("N.m", "torque of rigid ligaments on a proximal row that they hold", feedthrough=TORQUES)
    distal_reaction = output("N.m", "torque of rigid ligaments on a distal row that they hold", feedthrough=TORQUES)


@kernel_tuple
class Bundle(NamedTuple):
    """What the kernel of the unit gets."""

    axes: Axes
    ligaments: Ligaments


class LigamentBundle(StatelessComponent):
    """The five ligaments as a unit without mass: angles and rates of the rows in, torques on these angles out.

    Its torques are for the inputs `proximal_torque` and `distal_torque` of a `Wrist` without the effect `constraint`, with the
    same axes and coupling model. Always springs: a unit without mass cannot be rigid, for it would have to know what else acts.
    Which pairs are isometric is Sandow's (2008); attachments, extents and stiffness are ours (`ligament_springs`), the latter of
    the order that is recalled of tests of such ligaments, tens of newtons a millimetre.
    """

    title = "Ligaments of the wrist"
    system = "wrist"
    start_inputs = ()

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
    strain = output("1", "strain of each ligament over its slack length, of a cut one, too", nominal=0.01, size=COUNT,
                    feedthrough=_angles)
    stored_energy = output("J", "energy of the stretched ligaments", nominal=0.1, feedthrough=_angles)
    dissipation = output("W", "power lost in the ligaments", feedthrough=_motion)

    arguments: tuple[Bundle]

    def energy(self) -> float:
        """The output `stored_energy` at the present angles, J."""
        bundle_outputs(self.u[0], self.y, *self.arguments)
        return float(self.get("stored_energy"))

    def _initialize(self, t: float) -> int:
        p = self._declared_arguments()[0]
        axes = Axes(p.coupling_model, p.proximal_tilt, p.distal_tilt, p.row_offset)
        check_axes(axes, self.name)
        self.arguments = (Bundle(axes, make_ligaments(p)),)
        return DONE

    def _outputs(self, t: float) -> None:
        bundle_outputs(self.u[0], self.y, *self.arguments)


@kernel
def bundle_outputs(u, y, bundle):
    """Torques, tensions and strains, energy, losses."""
    y[0], y[1], y[2 + 2 * COUNT], y[3 + 2 * COUNT] = bundle_pull(u[0], u[1], u[2], u[3], bundle.axes, bundle.ligaments)
    write_bundle(u[0], u[1], u[2], u[3], y, 2, bundle.axes, bundle.ligaments)
