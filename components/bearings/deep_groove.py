"""Deep groove ball bearing with six degrees of freedom (Sopanen & Mikkola 2003): force and moment from the motion of its rings.

The bearing has no inertia of its own: a rotor gives displacement, tilt and velocity of the inner ring and the speed, the bearing
answers with force and moment on the shaft. Its states are angles that roll with the integral of the speed, never speed times
time. Everything else follows directly from the inputs; contacts.py has the equations.

What is taken from the published model: groove geometry, Hertz contacts of both races in series, clearance, Hamrock-Dowson
films of both races under a constant nominal load, added to the balls' diameter, waves and defects of the races. What is done
differently: the moment's lever is the one with which tilts move the contacts, so that the bearing has a potential and a
symmetric stiffness (`published_levers` brings the published one back); the races' radii, not the contacts', enter the cage's
speed and the levers; damping acts contact by contact; the balls' inertia and the cage's slip are
effects, see inertia.py and cage_slip.py. Not in it: spin in the contacts,
flexible rings.

A ball whose contact is longer than its own radius is out of the model's range. The published formulas come from public code of
one of the authors; of the paper only the abstract was at hand. What a call costs is measured by
tests/benchmarks/test_deep_groove_speed.py.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import KernelComponent, Refusal
from ..core.errors import BadInput, StepFailed
from ..core.kernels import OUT_OF_RANGE
from ..core.variables import PARTS, choice, count, input_, integer, output, parameter
from .cage_slip import CageSlip
from .contacts import GAP, BallContacts
from .friction import COLDEST, HOTTEST, UPRIGHT, Friction, OilFriction, SkfFriction
from .geometry import BallGeometry
from .hertz import LARGEST_RATIO
from .inertia import BallInertia
from .life import LifeFactor, RatingLife
from .loads import StaticLoads, static_loads
from .motion import EVERYTHING
from .races import BallDefect, Defect, Waviness, wave_shapes
from .six_dof import (
    ADVICE,
    COARSE,
    FEATURES,
    HERTZ,
    KERNELS,
    LARGE_BALLS,
    MISSED,
    NO_ELLIPSE,
    NO_FLUID,
    NO_GROOVE,
    NO_OIL,
    OTHER_BALLS,
    SAMPLES,
    SPEED,
    THICKENS,
    TIGHT,
    UNSEEN,
    UPRIGHT_LOAD,
    Constants,
    elastic_energy,
    place,
    present_contacts,
    present_inertia,
)

ADVISED = (  # of `note_advice`: what the load is, and what is advised
    ("an axial load", "at most {:.4g} N: 0.5 C_0, or 0.25 C_0 of bores up to 12 mm and of the diameter series 8, 9, 0 and 1"),
    ("a load", "{:.4g} N or more at this speed and viscosity; with less the balls may slide"),
)


class Film(Effect):
    """Oil film of both races, added to the balls; its load is the nominal one, 5 Fr / Z for the most loaded ball."""

    viscosity = parameter(0.04, "Pa.s", "viscosity at ambient pressure", low=0.0)
    pressure_viscosity = parameter(2.3e-8, "1/Pa", "pressure-viscosity coefficient", low=1e-10, nominal=1e-8)
    nominal_load = parameter(200.0, "N", "radial load for which the film is computed", low=1e-3, nominal=100.0)

    inner_thickness = output("m", "film at the inner race", nominal=1e-6, feedthrough=("speed",))
    outer_thickness = output("m", "film at the outer race", nominal=1e-6, feedthrough=("speed",))


class Damping(Effect):
    """Dampers in the contacts, each in proportion to its contact's stiffness; a contact that would pull is let go.

    So the damping matrix is factor * stiffness matrix without the part that comes from turning contact directions. Only the
    rings' velocity counts, not the passing of balls.
    """

    factor = parameter(2.5e-5, "s", "damping over stiffness; the literature has 0.25e-5 to 2.5e-5", low=0.0, nominal=1e-5)


class PublishedLevers(Effect):
    """Moments with the lever to the balls' centres, tilts with that to the groove's: as published, without a potential."""

    explicit_only = True


class Linearisation(Effect):
    """The bearing as force - stiffness q - damping q', q = (x, y, z, tilt_x, tilt_y), near its present motion.

    For a partner that takes the tangent along, so that it may take large steps and find its static position by Newton's
    method. The dependence of dampers on q is left out of the stiffness.
    """

    explicit_only = True

    idle_stiffness = parameter(
        1e6,
        "N/m",
        "added along x and y while initializing and at most one ball is loaded, so that a "
        "search for the static position comes to a contact; the force itself is not changed, and in "
        "the run, where it would act like a damper, there is none",
        low=0.0,
        nominal=1e6,
    )

    force_x = output(
        "N", "force along x of the linearised bearing at zero displacement and velocity", nominal=100.0, feedthrough=EVERYTHING
    )
    force_y = output(
        "N", "force along y of the linearised bearing at zero displacement and velocity", nominal=100.0, feedthrough=EVERYTHING
    )
    force_z = output(
        "N", "force along z of the linearised bearing at zero displacement and velocity", nominal=100.0, feedthrough=EVERYTHING
    )
    moment_x = output("N.m", "moment about x of the linearised bearing at zero displacement and velocity", feedthrough=EVERYTHING)
    moment_y = output("N.m", "moment about y of the linearised bearing at zero displacement and velocity", feedthrough=EVERYTHING)
    stiffness = output(
        "1",
        "-d(force, moment)/d(x, y, z, tilt_x, tilt_y) row by row, N/m for forces by translations",
        size=25,
        nominal=1e7,
        feedthrough=EVERYTHING,
    )
    damping = output(
        "1",
        "-d(force, moment)/d(velocity, tilt rate) row by row, N.s/m for forces by translations",
        size=25,
        nominal=1e3,
        feedthrough=EVERYTHING,
    )


class ThermalGrowth(Effect):
    """Rings and balls that grow: the clearance follows an input."""

    clearance_change = input_(0.0, "m", "change of the diametral clearance", nominal=1e-6)


class DeepGrooveBearing(KernelComponent):
    """Deep groove ball bearing; outer ring fixed, x horizontal, y up, z along the shaft, angles from +x towards +y.

        Q_j = K delta_j^1.5,   F = -sum Q_j (cos phi cos beta, cos phi sin beta, sin phi)_j,
        M = L sum Q_j sin phi_j (-sin beta, cos beta)_j

    beta: angle of a ball, phi: angle of its contact line. Source: Sopanen & Mikkola, Proc. IMechE K 217 (2003), as contacts.py
    says.
    """

    title = "Deep groove ball bearing, six degrees of freedom"
    system = "bearings"
    counters = ("steps",)
    default_step = 1e-4
    start_inputs = ("speed",)  # a cage that slips starts with a share of it
    ports = {
        "shaft": (  # what a rotor with a bearing's port gives and takes; the loads without a tangent are own signals
            "displacement_x",
            "displacement_y",
            "displacement_z",
            "tilt_x",
            "tilt_y",
            "velocity_x",
            "velocity_y",
            "velocity_z",
            "tilt_rate_x",
            "tilt_rate_y",
            "speed",
            "linearisation.*",
        )
    }

    film = Film
    damping = Damping
    inner_waviness = Waviness
    outer_waviness = Waviness
    inner_defect = Defect
    outer_defect = Defect
    ball_defect = BallDefect
    published_levers = PublishedLevers
    linearisation = Linearisation
    friction = Friction
    thermal_growth = ThermalGrowth
    rating_life = RatingLife
    life_factor = LifeFactor
    ball_inertia = BallInertia
    oil_friction = OilFriction
    skf_friction = SkfFriction
    cage_slip = CageSlip

    balls = integer(9, "number of balls", low=3, high=200, structural=PARTS)
    ball_diameter = parameter(11.1e-3, "m", "diameter of the balls", low=1e-6, nominal=0.01)
    pitch_diameter = parameter(53.5e-3, "m", "diameter of the circle of their centres", low=1e-6, nominal=0.1)
    inner_conformity = parameter(0.52, "1", "groove radius of the inner race over ball diameter", low=0.5001, high=1.0)
    outer_conformity = parameter(0.52, "1", "groove radius of the outer race over ball diameter", low=0.5001, high=1.0)
    diametral_clearance = parameter(
        0.0, "m", "free way of the rings across the shaft, twice the radial gap; negative: preload", nominal=1e-5
    )
    elastic_modulus = parameter(2.06e11, "Pa", "Young's modulus of rings and balls", low=1e3, nominal=1e11)
    poisson_ratio = parameter(0.3, "1", "Poisson's ratio of rings and balls", low=0.0, high=0.5)
    hertz = choice(
        "exact",
        HERTZ,
        "solution of the elliptic contact; the fit of Brewe and Hamrock is off by -0.7 to "
        "+1.7 % at ratios of the radii of 5 to 33",
    )
    first_ball = parameter(0.0, "rad", "angle of ball 1 at the start")

    displacement_x = input_(0.0, "m", "displacement of the inner ring along x", nominal=1e-5)
    displacement_y = input_(0.0, "m", "displacement of the inner ring along y, upwards", nominal=1e-5)
    displacement_z = input_(0.0, "m", "displacement of the inner ring along the shaft", nominal=1e-5)
    tilt_x = input_(0.0, "rad", "rotation of the inner ring about x", nominal=1e-4)
    tilt_y = input_(0.0, "rad", "rotation of the inner ring about y", nominal=1e-4)
    velocity_x = input_(0.0, "m/s", "velocity along x", nominal=1e-3)
    velocity_y = input_(0.0, "m/s", "velocity along y", nominal=1e-3)
    velocity_z = input_(0.0, "m/s", "velocity along z", nominal=1e-3)
    tilt_rate_x = input_(0.0, "rad/s", "rate of tilt_x", nominal=1e-2)
    tilt_rate_y = input_(0.0, "rad/s", "rate of tilt_y", nominal=1e-2)
    speed = input_(0.0, "rad/s", "speed of the inner ring about z", nominal=30.0)

    force_x = output("N", "force on the shaft along x", nominal=100.0, feedthrough=EVERYTHING)
    force_y = output("N", "force on the shaft along y", nominal=100.0, feedthrough=EVERYTHING)
    force_z = output("N", "force on the shaft along z", nominal=100.0, feedthrough=EVERYTHING)
    moment_x = output("N.m", "moment on the shaft about x", feedthrough=EVERYTHING)
    moment_y = output("N.m", "moment on the shaft about y", feedthrough=EVERYTHING)
    max_ball_load = output("N", "load of the most loaded ball", nominal=100.0, feedthrough=EVERYTHING)
    loaded_balls = count("number of balls in contact", feedthrough=EVERYTHING)
    inner_angle = output("rad", "angle of the inner ring in [0, 2 pi)")
    cage_angle = output("rad", "angle of ball 1 in [0, 2 pi)")

    symbols = {  # ISO 281 and ISO/TS 16281; conformities f, and the clearance G_r of ISO 5753, as data sheets write them
        "Z": "balls",
        "Dw": "ball_diameter",
        "Dpw": "pitch_diameter",
        "fi": "inner_conformity",
        "fe": "outer_conformity",
        "Gr": "diametral_clearance",
        "d": "friction.bore_diameter",
        "D": "skf_friction.outside_diameter",
        "C": "rating_life.load_rating",
        "C0": "skf_friction.static_rating",
        "Cu": "life_factor.fatigue_load_limit",
    }
    presets = {
        "6205": Preset(
            {"balls": 9, "ball_diameter": 7.94e-3, "pitch_diameter": 39.04e-3},
            "geometry of the 6205 from memory; grooves of 0.52 d are a choice",
            "unconfirmed",
        ),
        "6207-like": Preset(
            {"balls": 9, "ball_diameter": 11.1e-3, "pitch_diameter": 53.5e-3},
            "geometry near that of a 6207, from memory; grooves of 0.52 d are a choice",
            "unconfirmed",
        ),
        "218-like": Preset(
            {
                "balls": 16,
                "ball_diameter": 22.225e-3,
                "pitch_diameter": 125.26e-3,
                "inner_conformity": 0.5232,
                "outer_conformity": 0.5232,
                "diametral_clearance": 4.82518e-4,
            },
            "textbooks' angular contact bearing 218, from memory; its 40 degrees as a clearance, computed",
            "unconfirmed",
        ),
        "ISO/TS 16281 example": Preset(
            {
                "balls": 7,
                "ball_diameter": 11.5e-3,
                "pitch_diameter": 43.5e-3,
                "inner_conformity": 0.52,
                "outer_conformity": 0.53,
                "elastic_modulus": 2.1e11,
            },
            "repository minzhun/ISO16281, test of the ball bearing",
            "verbatim",
        ),
    }

    refusals = {
        LARGE_BALLS: Refusal(
            "balls of {ball_diameter} m on a pitch diameter of {pitch_diameter} m", "balls smaller than the pitch diameter"
        ),
        NO_ELLIPSE: Refusal("Ry/Rx = {message[0]} of a contact", f"a ratio in [1, {LARGEST_RATIO:g}]"),
        NO_GROOVE: Refusal(
            "diametral_clearance = {diametral_clearance} m", "less than {message[0]} m, the play of the balls in the grooves"
        ),
        TIGHT: Refusal(
            "diametral_clearance = {diametral_clearance} m",
            "{message[0]} m or more; with less the preload alone makes the contacts longer than a ball's radius",
        ),
        THICKENS: Refusal(
            "oil_friction.viscosity_100 = {oil_friction.viscosity_100} m2/s",
            "at most that at 40 degrees Celsius, {oil_friction.viscosity_40} m2/s",
            "An oil thins as it warms: change the two with each other?",
        ),
        NO_OIL: Refusal(
            "oil_friction.temperature = {oil_friction.temperature} K",
            f"{COLDEST:g} to {HOTTEST:g} K, where the viscosity's equation holds",
            "Give the temperature in K",
        ),
        OTHER_BALLS: Refusal(
            "skf_friction: a bore of {friction.bore_diameter} m and an outside diameter of {skf_friction.outside_diameter} m",
            "rings inside and outside of balls of {ball_diameter} m on a circle of {pitch_diameter} m",
            "Give friction.bore_diameter and skf_friction.outside_diameter of this bearing",
        ),
        NO_FLUID: Refusal(
            "cage_slip.viscosity = {cage_slip.viscosity} Pa.s", "0 or more", "Give the dynamic viscosity of the oil"
        ),
        UPRIGHT_LOAD: Refusal(
            "an axial load of {message[0]} N with skf_friction.static_rating = {skf_friction.static_rating} N",
            f"one below {UPRIGHT:.3g} C_0, at which the catalogue's contact angle is 90 degrees",
            "Give the static rating in N",
        ),
    } | {
        MISSED + k: Refusal(
            f"a ball passes {name} in {{noted[5]}} of a macro step, and may miss it",
            "a step that sees it",
            "Reduce the macro step to {noted[6]} s or less",
        )
        for k, name in enumerate(FEATURES)
    }

    @property
    def geometry(self) -> BallGeometry:
        """Geometry of the balls, and with it the defect frequencies."""
        p: dict[str, Any] = self.parameters
        return BallGeometry(p["balls"], p["ball_diameter"], p["pitch_diameter"], p["inner_conformity"], p["outer_conformity"])

    def shapes(self) -> dict[str, Any]:
        """`constants`: see `six_dof`.  `directions`: cosine and sine of each ball seen from ball 0.  `balls`, `sums`,
        `stiffness`, `damping`, `contacts`: see `contacts`.  `features`, `noted`: see `check_passages`.  `message`: a number of a message.
        `middle`, `slipped`: inputs in the middle of a step, and the angle by which the cage slips in it.  `initializing`: whether a
        master looks for the static position.
        """
        n: Any = self.get("balls")
        if "ball_defect" in self.on and (ball := self.get("ball_defect.ball")) > n:
            raise BadInput(self.name, f"ball_defect.ball = {ball}", f"a ball of the {n} there are")
        return {
            "x": 2 + ("ball_defect" in self.on) + ("cage_slip" in self.on),
            "constants": Constants,
            "contacts": BallContacts,
            "directions": (2, n),
            "balls": (n, 7 if "ball_inertia" in self.on else 4),
            "sums": 8,
            "stiffness": (5, 5),
            "damping": (5, 5),
            "features": (len(FEATURES), 3),
            "noted": (4 if "skf_friction" in self.on else 2, 4),
            "message": 1,
            "middle": len(self.inputs) if "cage_slip" in self.on else None,
            "slipped": 1 if "cage_slip" in self.on else None,
            "initializing": 1,
        } | wave_shapes(self.on, n)

    # -- the run -----------------------------------------------------------------------------------------------------
    def _initialize(self, t: float) -> int:
        self._warned = set[int]()
        return super()._initialize(t)

    def stepped(self, t: float) -> None:
        """As of any component; warns once of a passage that the steps see too little of, and of each advice that is not kept."""
        super().stepped(t)
        for row, (what, advised) in enumerate(ADVISED if "skf_friction" in self.on else (), ADVICE):
            load, limit, when, _ = self.arguments[0].noted[row].tolist()
            if limit > 0.0 and row not in self._warned:
                self._warned.add(row)
                text = f"{self.name}: {what} of {load:.4g} N at t = {when:.4g} s; SKF advises {advised.format(limit)}"
                warnings.warn(text, stacklevel=2)
        feature, share, enough, when = self.arguments[0].noted[COARSE].tolist()
        if feature >= 0.0 and COARSE not in self._warned:
            self._warned.add(COARSE)
            warnings.warn(
                f"{self.name}: a ball passes {self._with_values(FEATURES[int(feature)])} in {share:.2g} macro steps at "
                f"t = {when:.4g} s; {SAMPLES} steps need a macro step of {enough:.2g} s",
                stacklevel=2,
            )

    def _check(self, status: int) -> None:
        if MISSED <= status < MISSED + len(FEATURES):  # a run under way
            actual, _, remedy = map(self._with_values, type(self).refusals[status])
            raise StepFailed(self.name, float(self.arguments[0].noted[UNSEEN, 3]), actual, remedy)
        if status in (NO_OIL, UPRIGHT_LOAD, NO_FLUID):
            actual, expected, remedy = map(self._with_values, type(self).refusals[status])
            raise StepFailed(self.name, self.t, f"{actual}, expected {expected}", remedy)
        super()._check(status)

    def left_range(self) -> str:
        """The displacements, and the bearing's range."""
        names = ("displacement_x", "displacement_y", "displacement_z", "tilt_x", "tilt_y")
        given = ", ".join(f"{n} = {self.get(n):g} {self.variables[n].unit}" for n in names)
        limit = self.arguments[0].constants.largest_load
        return f"{given}, expected a ring inside the grooves and less than {limit:.4g} N on a ball"

    def energy(self) -> float:
        """Elastic energy of the contacts, J; with `published_levers` that of the consistent bearing."""
        s, _, e = self.arguments
        return elastic_energy(s, e)

    def equilibrium(self, forces: np.ndarray, held: Collection[str] = ()) -> StaticLoads:
        """Static equilibrium under an external load on the shaft at the present angles and speed; see `loads.static_loads`.

        Its status is OUT_OF_RANGE, too, for a ball beyond its largest load.
        """
        s, _, e = self.arguments
        k = s.constants
        place(self.x, self.u[0, SPEED], k, s, e)
        load = np.array(forces, dtype=float)
        if e.published_levers is not None:
            load[3:] /= k.levers
        contacts = present_contacts(self.u[0], s.contacts, e.thermal_growth)
        inertia = present_inertia(self.x, self.u[0, SPEED], k, e)
        loads = static_loads(contacts, load, first_ball=self.x[1], held=held, gap=s.balls[:, GAP].copy(), inertia=inertia)
        return loads._replace(status=OUT_OF_RANGE) if loads.ball_loads.max() > k.largest_load else loads


DeepGrooveBearing.kernels = KERNELS
