"""Flexible rotor: a uniform Timoshenko shaft with disks, on springs or on bearings that attach through ports."""

from __future__ import annotations

import math

import numpy as np

from ..core.banded import add_product, factor_general, solve_general
from ..core.component import Component, Effect, Preset
from ..core.errors import BadInput
from ..core.kernels import DONE
from ..core.variables import input_, output, parameter
from .elements import Disk, circular_section, solid_disk
from .frame import FrameRotation, add_frame_load, turning_frame
from .integration import add_imbalance, advance_rotor, make_solver, rotor_outputs
from .model import (
    DOFS,
    HALF,
    Matrices,
    add_disk,
    add_disk_gyroscopic,
    assemble_shaft,
    checked_positions,
    dense,
    nearest_node,
    node_positions,
    turned,
)
from .ports import Bearing
from .spin import TURN, RunUp, acceleration_at, speed_at
from .statics import equilibrium

MAX_DISKS = 4
STEEL = 7810.0  # kg/m³
NO_DISK = Disk(0.0, 0.0, 0.0)
DEFAULT_DISKS = (solid_disk(0.28, 0.05, 0.07, STEEL), solid_disk(0.35, 0.05, 0.07, STEEL), NO_DISK, NO_DISK)


class Gyroscopic(Effect):
    """Gyroscopic moments of the shaft and of the disks."""


class Disks(Effect):
    """Rigid disks on the shaft; a disk of mass and inertia 0 is none. `elements.solid_disk` gives the numbers of a size."""

    explicit_only = True

    position = parameter((0.5, 1.0, 0.0, 0.0), "m", "place of a disk on the shaft", size=MAX_DISKS, low=0.0)
    mass = parameter(tuple(d.mass for d in DEFAULT_DISKS), "kg", "mass of a disk", size=MAX_DISKS, low=0.0)
    polar_inertia = parameter(tuple(d.polar_inertia for d in DEFAULT_DISKS), "kg.m2", "inertia about the shaft's axis",
                              size=MAX_DISKS, low=0.0)
    diametral_inertia = parameter(tuple(d.diametral_inertia for d in DEFAULT_DISKS), "kg.m2", "inertia about a diameter",
                                   size=MAX_DISKS, low=0.0)


class Unbalance(Effect):
    """Masses beside the axis, one a disk."""

    requires = ("disks",)

    moment = parameter((1e-3, 0.0, 0.0, 0.0), "kg.m", "mass times eccentricity at a disk", size=MAX_DISKS, low=0.0)
    phase = parameter(0.0, "rad", "angle by which the mass is ahead of the rotor's angle", size=MAX_DISKS)


class InternalDamping(Effect):
    """Viscous damping in the turning shaft, proportional to its stiffness; it drives the rotor above an onset speed.

    0.2 ms is a choice of ours: a loss factor of 0.02 at 100 rad/s.
    """

    time_constant = parameter(2e-4, "s", "damping over stiffness of the shaft", low=0.0)


class Gravity(Effect):
    """Weight, along -y."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity")


class LinearSupports(Effect):
    """Two places where springs and dampers hold the shaft to the ground; values of the rotor of the defaults."""

    explicit_only = True

    position = parameter((0.0, 1.5), "m", "place of a support on the shaft", size=2, low=0.0)
    stiffness_x = parameter(1e6, "N/m", "stiffness along x", size=2, low=0.0)
    stiffness_y = parameter(1e6, "N/m", "stiffness along y", size=2, low=0.0)
    damping_x = parameter(0.0, "N.s/m", "damping along x", size=2, low=0.0)
    damping_y = parameter(0.0, "N.s/m", "damping along y", size=2, low=0.0)


class BearingA(Bearing):
    """Port of a bearing at the start of the shaft: motion out, force, moment and tangent in."""


class BearingB(Bearing):
    """Port of a bearing at the end of the shaft."""

    position = parameter(1.5, "m", "place of the bearing on the shaft", low=0.0)


class BeamRotor(Component):
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
        "force_x", "force_y", "bearing_a.force_x", "bearing_a.force_y", "bearing_a.moment_x", "bearing_a.moment_y",
        "bearing_a.stiffness", "bearing_b.force_x", "bearing_b.force_y", "bearing_b.moment_x", "bearing_b.moment_y",
        "bearing_b.stiffness", "frame_rotation.rate_x", "frame_rotation.rate_y")

    gyroscopic = Gyroscopic
    disks = Disks
    unbalance = Unbalance
    internal_damping = InternalDamping
    gravity = Gravity
    run_up = RunUp
    linear_supports = LinearSupports
    bearing_a = BearingA
    bearing_b = BearingB
    frame_rotation = FrameRotation

    presets = {
        "Friswell 5.9.1": Preset(
            {"length": 1.5, "outer_diameter": 0.05, "youngs_modulus": 211e9, "shear_modulus": 81.2e9, "density": STEEL,
             "element": 0.25},
            "the defaults: Friswell et al. (2010), example 5.9.1, as read in public code of the book and of ROSS", "verbatim",
            ("gyroscopic", "disks", "linear_supports")),
    }

    length = parameter(1.5, "m", "length of the shaft", low=1e-6)
    outer_diameter = parameter(0.05, "m", "outer diameter of the shaft", low=1e-6)
    inner_diameter = parameter(0.0, "m", "inner diameter of the shaft", low=0.0)
    youngs_modulus = parameter(211e9, "Pa", "Young's modulus", low=1.0)
    shear_modulus = parameter(81.2e9, "Pa", "shear modulus", low=1.0)
    density = parameter(STEEL, "kg/m3", "density of the shaft", low=1e-6)
    element = parameter(0.25, "m", "longest element", low=1e-6)
    start_speed = parameter(100.0, "rad/s", "speed of rotation at the start, positive from x to y")
    start_angle = parameter(0.0, "rad", "angle of the rotor at the start")
    start_fall = parameter(1e-4, "m", "way along its constant loads, weight and input force, by which a rotor starts displaced "
                           "that has ports and that nothing holds: more than the clearance of its bearings, or 0 where "
                           "they offer no tangent", low=0.0, high=0.1)
    watched_position = parameter(0.5, "m", "place of the shaft whose motion is an output and where a force may act",
                                 low=0.0)
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

    def _initialize(self, t: float) -> int:
        self.arguments = self._declared_arguments()
        p, run_up = self.arguments[0], self.arguments[1].run_up
        self._build()
        stiffness = self._stiffness
        if self._circulatory is not None:
            stiffness = stiffness + speed_at(t, p.start_speed, run_up) * self._circulatory
        load = self._load.copy()
        load[self._watched : self._watched + 2] += self.u[0, :2]
        if self._frame is not None:
            add_frame_load(0.0, speed_at(t, p.start_speed, run_up), self._frame, self.u, load)
        q, force = equilibrium(stiffness, load, self._ports, self.u, p.start_fall)
        angle, speed = p.start_angle % TURN, speed_at(t, p.start_speed, run_up)
        if self._imbalance is not None:
            add_imbalance(angle, speed, acceleration_at(t, p.start_speed, run_up), self._imbalance, force)
        factors = self._mass.copy()
        factor_general(factors)
        solve_general(factors, force)  # the acceleration: a method with a spectral radius below 1 begins with it
        self.x = np.concatenate((q, np.zeros(q.size), force, [angle]))
        self._substep = p.substep
        self._solver = make_solver(self._load.size, len(self._ports))
        return DONE

    def _build(self) -> None:
        """Bands, constant load, ports and unbalance of the parameters."""
        p, e = self.arguments
        disks, unbalance, supports = e.disks, e.unbalance, e.linear_supports
        if p.inner_diameter >= p.outer_diameter:
            actual = f"inner_diameter = {p.inner_diameter:g} m"
            raise BadInput(self.name, actual, f"less than the outer diameter of {p.outer_diameter:g} m")
        poisson = 0.5 * p.youngs_modulus / p.shear_modulus - 1.0
        if not -1.0 < poisson <= 0.5 + 1e-9:  # 0.5 itself comes with its rounding
            actual = f"youngs_modulus = {p.youngs_modulus:g} Pa with shear_modulus = {p.shear_modulus:g} Pa"
            raise BadInput(self.name, f"{actual}: Poisson's ratio {poisson:.3g}", "more than -1 and at most 0.5",
                           "The shear modulus is E / (2 (1 + nu)), E / 2.6 of steel.")
        bearings = [b for b in (e.bearing_a, e.bearing_b) if b is not None]
        present: list[int] = []
        if disks is not None:
            present = np.flatnonzero(disks.mass + disks.polar_inertia + disks.diametral_inertia).tolist()
        if unbalance is not None and (lost := set(np.flatnonzero(unbalance.moment).tolist()) - set(present)):
            k = min(lost) + 1
            raise BadInput(self.name, f"unbalance.moment[{k}] without disk {k}", "an unbalance at a disk",
                           f"Give disks.mass[{k}], or set the unbalance to 0.")

        def places(positions, what: str) -> list[float]:
            return checked_positions(positions, p.length, self.name, what)

        fixed = places([p.watched_position], "watched_position")
        fixed += places([disks.position[k] for k in present], "a disk")
        fixed += places(supports.position, "a support") if supports is not None else []
        fixed += places([b.position for b in bearings], "a bearing")
        nodes = node_positions(p.length, fixed, p.element)
        section = circular_section(p.outer_diameter, p.inner_diameter, p.youngs_modulus, p.shear_modulus, p.density)
        shaft = assemble_shaft(section, nodes)

        mass, stiffness = shaft.deflection + shaft.rotary, shaft.stiffness.copy()
        damping = np.zeros_like(mass)
        self._gyroscopic = 2.0 * turned(shaft.rotary) if e.gyroscopic is not None else None
        self._circulatory = None
        if e.internal_damping is not None:
            damping += e.internal_damping.time_constant * shaft.stiffness
            self._circulatory = e.internal_damping.time_constant * turned(shaft.stiffness)
        at = {k: nearest_node(nodes, disks.position[k]) for k in present}
        for k, node in at.items():
            add_disk(mass, node, Disk(disks.mass[k], disks.polar_inertia[k], disks.diametral_inertia[k]))
            if self._gyroscopic is not None:
                add_disk_gyroscopic(self._gyroscopic, node, disks.polar_inertia[k])
        held = np.zeros((0, 5))
        if supports is not None:
            at_supports = [nearest_node(nodes, position) for position in supports.position]
            held = np.column_stack((at_supports, supports.stiffness_x, supports.stiffness_y, supports.damping_x,
                                    supports.damping_y))
            for node, k_x, k_y, c_x, c_y in held:
                j = DOFS * int(node)
                stiffness[[j, j + 1], HALF] += k_x, k_y
                damping[[j, j + 1], HALF] += c_x, c_y
        self._mass, self._damping, self._stiffness, self.nodes = mass, damping, stiffness, nodes
        self._load = np.zeros(mass.shape[0])
        if e.gravity is not None:
            falling = np.zeros_like(self._load)
            falling[1::DOFS] = -e.gravity.acceleration
            add_product(mass, falling, self._load)
        self._imbalance = None
        if unbalance is not None:
            rows = [(DOFS * node, unbalance.moment[k], unbalance.phase[k]) for k, node in at.items()]
            self._imbalance = np.array(rows).reshape(-1, 3)
        ports = [(nearest_node(nodes, b.position), b.u, b.y) for b in bearings]
        self._ports = np.array(ports, dtype=np.int64).reshape(-1, 3)
        self._watched = DOFS * nearest_node(nodes, p.watched_position)
        self._frame = None
        if e.frame_rotation is not None and self._gyroscopic is not None:  # it requires that effect
            self._frame = turning_frame(e.frame_rotation, self._gyroscopic, nodes, held, self._ports)

    def _step(self, t: float, h: float) -> int:
        n = max(1, math.ceil(h / self._substep * (1.0 - 1e-9)))
        p, e = self.arguments
        return advance_rotor(t, h, n, self.x, self.u, self.y, self.counts, p.start_speed, p.spectral_radius, self._watched,
                             self._load, self._mass, self._damping, self._stiffness, self._solver, self._ports, self._gyroscopic,
                             self._circulatory, self._imbalance, e.run_up, self._frame)

    def _outputs(self, t: float) -> None:
        rotor_outputs(t, self.x, self.u, self.y, self._load.size, self.arguments[0].start_speed, self._watched, self._ports,
                      self.arguments[1].run_up, self._frame)

    def matrices(self) -> Matrices:
        """Dense matrices of the equation of motion, without what attaches to ports; of an initialized rotor.

        Gyroscopic and circulatory ones are zero where their effect is off.
        """
        zero = np.zeros((self._load.size,) * 2)
        gyroscopic, circulatory = (zero if b is None else dense(b) for b in (self._gyroscopic, self._circulatory))
        return Matrices(dense(self._mass), dense(self._damping), dense(self._stiffness), gyroscopic, circulatory)

    def energy(self) -> float:
        """Energy of bending motion, shaft and linear supports, and of the height where there is gravity, J."""
        N = self._load.size
        q, v = self.x[:N], self.x[N : 2 * N]
        force, momentum = np.zeros(N), np.zeros(N)
        add_product(self._stiffness, q, force)
        add_product(self._mass, v, momentum)
        return float(0.5 * (q @ force + v @ momentum) - q @ self._load)
