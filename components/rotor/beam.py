"""Flexible rotor: a Timoshenko shaft, uniform or of sections, with disks, on springs or on bearings that attach through ports."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import KernelComponent, Kernels, Refusal
from ..core.errors import BadInput
from ..core.linear import add_product
from ..core.variables import input_, output, parameter, text
from .disks import MAX_DISKS, STEEL, Disks, DiskTable, disks_of
from .frame import FrameRotation
from .initialization import (
    BEARING_BEYOND,
    DISK_BEYOND,
    HOLLOW,
    NO_BODY,
    NO_MATERIAL,
    NO_METAL,
    SPEED_BEYOND,
    SUPPORT_BEYOND,
    UNBALANCE_LOST,
    WATCHED_BEYOND,
    rotor_initialize,
)
from .integration import NODES, rotor_outputs, rotor_step
from .model import DOFS, WIDTH, Matrices, dense, most_nodes
from .ports import Bearing
from .sections import sections_of
from .spin import RunUp
from .supports import LinearSupports, SupportTable, add_supports, beyond_rows, follow_speed, supports_of

ON_SHAFT = "a place on the shaft, 0 to {extent} m"


class ShaftTable(Effect):
    """A shaft of sections, as drawings and other programs list them, in the place of a uniform one.

    A CSV table with a header, a row for each section from the left end: `length`, `outer_diameter`, and, where needed,
    `inner_diameter`, `youngs_modulus`, `shear_modulus` and `density`; the last three are the parameters' where the table has none.
    Such as `length [mm];outer_diameter [mm]`. Each section begins with a node.
    """

    explicit_only = True
    replaces = ("length", "outer_diameter", "inner_diameter")
    read_by = ("initialize",)

    table = text(
        "length [mm],outer_diameter [mm]\n500,50\n500,60\n500,50\n",
        "sections of the shaft as a CSV table; a scene may name its file",
    )


class Gyroscopic(Effect):
    """Gyroscopic moments of the shaft and of the disks."""

    read_by = ()


class Unbalance(Effect):
    """Masses beside the axis, one a disk."""

    requires = ("disks",)
    read_by = ("initialize",)

    moment = parameter((1e-3, 0.0, 0.0, 0.0), "kg.m", "mass times eccentricity at a disk", size=MAX_DISKS, low=0.0)
    phase = parameter(0.0, "rad", "angle by which the mass is ahead of the rotor's angle", size=MAX_DISKS)


class InternalDamping(Effect):
    """Viscous damping in the turning shaft, proportional to its stiffness; it drives the rotor above an onset speed.

    0.2 ms is a choice of ours: a loss factor of 0.02 at 100 rad/s.
    """

    read_by = ("initialize",)

    time_constant = parameter(2e-4, "s", "damping over stiffness of the shaft", low=0.0)


class Gravity(Effect):
    """Weight, along -y."""

    read_by = ("initialize",)
    either_in = ("initialize",)

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity")


class BearingA(Bearing):
    """Port of a bearing at the start of the shaft: motion out, force, moment and tangent in."""


class BearingB(Bearing):
    """Port of a bearing at the end of the shaft."""

    position = parameter(1.5, "m", "place of the bearing on the shaft", low=0.0)


class BeamRotor(KernelComponent):
    """Uniform shaft of Timoshenko elements with disks, in bending; x horizontal, y upwards, z along the shaft.

        M q'' + (C + Omega G) q' + (K + Omega H) q = f

    with G the gyroscopic and H the circulatory matrix (internal damping). Speed and angle are imposed; in a run-up the
    driving torque is taken to act about each section's own axis, so that it needs no term here. Without supports and
    bearings the rotor is free. Time integration: generalised-alpha, one banded factorisation a speed and tangent; with 20
    elements 2.4 us a substep, 9 us with a new speed or tangent. The midpoint rule shifts a frequency by (w h)²/12: the substep
    of 20 us resolves the journals' motion on rolling bearings (0.9 % of it with a macro step of 100 us, 2.6 % with a substep of
    50 us, 8.5 % with 100 us); without bearings 200 us do for the first modes of a slender rotor.
    Defaults: Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, example 5.9.1 (numbers read in public code).
    """

    title = "Rotor of Timoshenko beam elements with disks and ports for bearings"
    system = "rotor"
    counters = ("steps", "factorizations")
    default_step = 1e-4
    start_inputs = (
        "force_x",
        "force_y",
        "bearing_a.force_x",
        "bearing_a.force_y",
        "bearing_a.moment_x",
        "bearing_a.moment_y",
        "bearing_a.stiffness",
        "bearing_b.force_x",
        "bearing_b.force_y",
        "bearing_b.moment_x",
        "bearing_b.moment_y",
        "bearing_b.stiffness",
        "frame_rotation.rate_x",
        "frame_rotation.rate_y",
    )

    refusals = {
        HOLLOW: Refusal("inner_diameter = {inner_diameter} m", "less than the outer diameter of {outer_diameter} m"),
        NO_MATERIAL: Refusal(
            "youngs_modulus = {youngs_modulus} Pa with shear_modulus = {shear_modulus} Pa: Poisson's ratio {refused}",
            "more than -1 and at most 0.5",
            "The shear modulus is E / (2 (1 + nu)), E / 2.6 of steel.",
        ),
        NO_METAL: Refusal(
            "moduli of a section with Poisson's ratio {refused}",
            "0 to 0.5, or nearly -1 for a shaft without shear",
            "Give both moduli of a material: shear_modulus is E / (2 (1 + nu)).",
        ),
        NO_BODY: Refusal(
            "a disk at {refused} m with a polar inertia of more than twice the diametral one",
            "inertias of a body, twice of a thin disk",
            "Are Ip and Id exchanged, or is one in another unit?",
        ),
        UNBALANCE_LOST: Refusal(
            "unbalance.moment[{refused}] without disk {refused}",
            "an unbalance at a disk",
            "Give disks.mass[{refused}], or set the unbalance to 0.",
        ),
        WATCHED_BEYOND: Refusal("watched_position at {refused} m", ON_SHAFT),
        DISK_BEYOND: Refusal("a disk at {refused} m", ON_SHAFT),
        SUPPORT_BEYOND: Refusal("a support at {refused} m", ON_SHAFT),
        BEARING_BEYOND: Refusal("a bearing at {refused} m", ON_SHAFT),
        SPEED_BEYOND: Refusal(
            "a speed of {refused} rad/s",
            "speeds within the rows of each support in support_table.table",
            "Add rows; a support of one row holds at all speeds.",
        ),
    }

    shaft_table = ShaftTable
    gyroscopic = Gyroscopic
    disks = Disks
    disk_table = DiskTable
    unbalance = Unbalance
    internal_damping = InternalDamping
    gravity = Gravity
    run_up = RunUp
    linear_supports = LinearSupports
    support_table = SupportTable
    bearing_a = BearingA
    bearing_b = BearingB
    frame_rotation = FrameRotation

    presets = {
        "Friswell 5.9.1": Preset(
            {
                "length": 1.5,
                "outer_diameter": 0.05,
                "youngs_modulus": 211e9,
                "shear_modulus": 81.2e9,
                "density": STEEL,
                "element": 0.25,
            },
            "the defaults: Friswell et al. (2010), example 5.9.1, as read in public code of the book and of ROSS",
            "verbatim",
            ("gyroscopic", "disks", "linear_supports"),
        )
    }

    length = parameter(
        1.5, "m", "length of the shaft", low=1e-6, structural="with the longest element it decides how many elements there are"
    )
    outer_diameter = parameter(0.05, "m", "outer diameter of the shaft", low=1e-6)
    inner_diameter = parameter(0.0, "m", "inner diameter of the shaft", low=0.0, nominal=0.05)
    youngs_modulus = parameter(211e9, "Pa", "Young's modulus", low=1.0)
    shear_modulus = parameter(81.2e9, "Pa", "shear modulus", low=1.0)
    density = parameter(STEEL, "kg/m3", "density of the shaft", low=1e-6)
    element = parameter(0.25, "m", "longest element", low=1e-6, mesh="shorter")
    start_speed = parameter(100.0, "rad/s", "speed of rotation at the start, positive from x to y")
    start_angle = parameter(0.0, "rad", "angle of the rotor at the start")
    start_fall = parameter(
        1e-4,
        "m",
        "way along its constant loads, weight and input force, by which a rotor starts displaced "
        "that has ports and that nothing holds: more than the clearance of its bearings, or 0 where "
        "they offer no tangent",
        low=0.0,
        high=0.1,
    )
    watched_position = parameter(0.5, "m", "place of the shaft whose motion is an output and where a force may act", low=0.0)
    substep = parameter(2e-5, "s", "longest internal step", low=1e-9, high=1.0)
    spectral_radius = parameter(1.0, "1", "generalised-alpha: spectral radius at infinite frequency", low=0.0, high=1.0)

    force_x = input_(0.0, "N", "force on the shaft along x at the watched place", nominal=100.0)
    force_y = input_(0.0, "N", "force on the shaft along y at the watched place", nominal=100.0)

    displacement_x = output("m", "displacement along x at the watched place", nominal=1e-5)
    displacement_y = output("m", "displacement along y at the watched place", nominal=1e-5)
    velocity_x = output("m/s", "velocity along x at the watched place", nominal=1e-2)
    velocity_y = output("m/s", "velocity along y at the watched place", nominal=1e-2)
    speed = output("rad/s", "speed of rotation", nominal=100.0)
    angle = output("rad", "angle of the rotor, in [0, 2 pi)")

    @property
    def by_midpoint_rule(self) -> bool:  # type: ignore[override]
        """Which the generalised-alpha method is without numerical damping."""
        return bool(self.parameters["spectral_radius"] == 1.0)

    def shapes(self) -> dict[str, Any]:
        """Room for the most nodes; N = 4 `mesh[0]` degrees of freedom are in use, k ports.

        `x`: displacement, velocity, acceleration, (N,) each, angle.  `nodes`: m.  `mesh`: number of nodes; first degree of
        freedom of the watched one.  `mass`, `damping`, `stiffness`: bands (N, 15) of shaft and disks.  `gyroscopic`,
        `circulatory`: bands per rad/s.  `load`: (N,) constant forces, N.  `supports`: (m, 10) first degree of freedom, lever to
        the frame's axes in m, the numbers of `COEFFICIENTS`.  `spans`, `support_rows`: of a table, see `supports_of`.
        `disk_rows`: (n, 4) see `disks_of`.  `imbalance`: (4, 3) first degree of freedom, kg.m, rad.
        `ports`: (k, 3) node, first input, first output.  `about`: (2, N) gyroscopic force on the rotor per speed and rate of the
        frame about x and y.  `levers`: (k,) of ports to the frame's axes, m.
        `prepared`, `fixed`, `now`, `tangents`: see `integration`; (k, 2, 4, 4) the ports' tangents to which `now` belongs.
        `room`: right-hand side; displacement, velocity and acceleration between zeros.  `matrix`, `places`: work, of an element
        and of the nodes.  `refused`: numbers for a message.  `shaft`: (n, 6) rows of a table, see `sections_of`; None without one.
        `sections`: see `assemble_shaft`.  `extent`: length of the shaft, m.
        """
        p: Any = self.parameters
        on = self.on
        ports = np.zeros((sum(name in on for name in ("bearing_a", "bearing_b")), 3), dtype=np.int64)
        spans, rows, supports = None, None, 2 if "linear_supports" in on else 0
        if "support_table" in on:
            rows, spans = supports_of(p["support_table.table"], f"{self.name}: support_table.table")
            supports = len(spans)
        disks = np.zeros((MAX_DISKS if "disks" in on else 0, 4))
        if "disk_table" in on:
            disks = disks_of(p["disk_table.table"], f"{self.name}: disk_table.table")
        shaft = sections_of(p["shaft_table.table"], f"{self.name}: shaft_table.table") if "shaft_table" in on else None
        sections, extent = (1, p["length"]) if shaft is None else (len(shaft), float(shaft[:, 0].sum()))
        fixed = sections + len(disks) + supports + len(ports)
        nodes = most_nodes(extent, p["element"], fixed)
        N = DOFS * nodes
        band = (N, WIDTH)
        return {
            "x": 3 * N + 1,
            "nodes": nodes,
            "mesh": np.zeros(2, dtype=np.int64),
            "places": fixed + 2,
            "matrix": (DOFS, DOFS),
            "mass": band,
            "damping": band,
            "stiffness": band,
            "gyroscopic": band if "gyroscopic" in on else None,
            "circulatory": band if "internal_damping" in on else None,
            "load": N,
            "supports": (supports, 10),
            "spans": spans,
            "support_rows": rows,
            "disk_rows": disks,
            "imbalance": (MAX_DISKS, 3) if "unbalance" in on else None,
            "ports": ports,
            "levers": len(ports),
            "about": (2, N) if "frame_rotation" in on else None,
            "prepared": 2,
            "fixed": (4, *band),
            "now": (4, *band),
            "room": (4, N + WIDTH - 1),
            "tangents": (len(ports), 2, DOFS, DOFS),
            "refused": 1,
            "shaft": shaft,
            "sections": (sections, 5),
            "extent": 1,
        }

    @property
    def nodes(self) -> np.ndarray:
        """Places of the nodes of an initialized rotor along the shaft, (n,) m."""
        s = self.arguments[0]
        return s.nodes[: s.mesh[NODES]]

    def speeds_of_supports(self) -> tuple[float, float]:
        """Lowest and highest speed for which all supports of the table have rows, rad/s; of an initialized rotor."""
        s = self.arguments[0]
        ends = [s.support_rows[[int(a), int(a + n) - 1], 0] for _, a, n in s.spans if n > 1]
        return max((e[0] for e in ends), default=-math.inf), min((e[1] for e in ends), default=math.inf)

    def matrices(self, speed: float | None = None) -> Matrices:
        """Dense matrices of the equation of motion, without what attaches to ports; of an initialized rotor.

        speed: rad/s, of the supports of a table, without one that of the last output; `BadInput` beyond their rows.
        Gyroscopic and circulatory ones are zero where their effect is off.
        """
        s, N = self.arguments[0], DOFS * self.nodes.size
        if s.spans is not None:
            speed = float(s.y[4]) if speed is None else speed
            if beyond_rows(speed, s):
                where = f"{self.name}: support_table.table"
                raise BadInput(where, f"a speed of {speed:g} rad/s", "speeds within the rows of each support", "Add rows.")
            follow_speed(speed, s)
        damping, stiffness = s.damping[:N].copy(), s.stiffness[:N].copy()
        add_supports(s.supports, 1.0, 0.0, stiffness)
        add_supports(s.supports, 0.0, 1.0, damping)
        rest = (np.zeros((N, N)) if band is None else dense(band[:N]) for band in (s.gyroscopic, s.circulatory))
        return Matrices(dense(s.mass[:N]), dense(damping), dense(stiffness), *rest)

    def energy(self) -> float:
        """Energy of bending motion, shaft and supports, and of the height where there is gravity, J; kxy and kyx store their mean."""
        s, N = self.arguments[0], DOFS * self.nodes.size
        q, v, momentum = self.x[:N], self.x[N : 2 * N], np.zeros(N)
        add_product(s.mass[:N], v, momentum)
        return float(0.5 * (q @ self.matrices().stiffness @ q + v @ momentum) - q @ s.load[:N])


BeamRotor.kernels = Kernels(rotor_initialize, rotor_step, rotor_outputs)
