"""Kernels of the deep groove bearing with six degrees of freedom: from motion of the inner ring to force and moment on it.

State: angle of the inner ring, angle of the cage (of ball 0), with a pit on a ball its turn against the cage, and at the end, with
`cage_slip`, the speed of the cage.
The balls' angles are those of ball 0 and a fixed table: a call costs one sine and cosine for all of them.
"""

from __future__ import annotations

import math

from ..core.contract import Kernels
from ..core.kernels import DONE, NOT_FINITE, OUT_OF_RANGE, OWN, hold_inputs, kernel
from .cage_slip import cage_drive, put_slip, set_inertia, turned_cage
from .contacts import (
    COS,
    ENERGY,
    GAP,
    INNER_ANGLE,
    LARGEST_CONTACT,
    LOAD,
    LOADED,
    MAX_LOAD,
    OUTER_ANGLE,
    OUTER_LOAD,
    SIN,
    BallContacts,
    contact_forces,
    groove_contacts,
    note_contacts,
)
from .film import CENTRAL_EXPONENT, film_height, mean_surface_speed
from .friction import COLDEST, HOTTEST, UPRIGHT, note_advice, put_friction
from .geometry import INNER, OUTER, cage_turn, diameter_share, grooved_contact, relative_radii, spin_turn
from .hertz import LARGEST_RATIO, effective_modulus, hertz_axes, hertz_stiffness, two_in_series
from .inertia import Inertia, centrifugal_factor
from .life import put_life, ring_ratings
from .races import TWO_PI, add_faults, highest_order, start_waves, wrapped

SPEED = 10  # in u, behind displacement (5) and velocity (5)
TRIALS, SETTLED = 40, 1e-11  # of the cage's speed behind a step, and how exactly, of the speed
SAMPLES = 4  # steps a passage over a defect or a wave should take at least
COARSE, UNSEEN, ADVICE = 0, 1, 2  # rows of what `check_passages` notes, and first of those of `note_advice`
FORCE, LARGEST, NUMBER, RING, CAGE = 0, 5, 6, 7, 8  # in y; five elements from FORCE on
HERTZ = ("exact", "brewe-hamrock")
FITTED = 1  # of them

# Rows of `s.features`: extent, rad, turn of the feature under a ball per turn of the inner ring, and of waves the highest order.
# Without a turn it is not there.
EXTENT, TURN, ORDER = range(3)
INNER_FEATURES = (0, 2)
FEATURES = (
    "inner_waviness of order {features[2]}",
    "outer_waviness of order {features[5]}",
    "inner_defect",
    "outer_defect",
    "ball_defect",
)

# Statuses; the last name the feature that a ball may have missed, in the order of `FEATURES`
LARGE_BALLS, NO_ELLIPSE, NO_GROOVE, TIGHT, THICKENS, NO_OIL = OWN + 1, OWN + 2, OWN + 3, OWN + 4, OWN + 5, OWN + 6
OTHER_BALLS, UPRIGHT_LOAD, NO_FLUID = OWN + 7, OWN + 8, OWN + 9
MISSED = OWN + 10


class Constants:
    """The record `s.constants`: what the parameters determine, beside that of the contacts, `s.contacts`."""

    cage_ratio: float
    spin_ratio: float
    largest_load: float  # N, of a ball; beyond it the contacts are no small spots any more
    inner_film: float  # m (s/rad)^0.67; thickness = factor * |speed|^0.67
    outer_film: float
    inner_rating: float  # N, load of a ball at which the inner ring has a rating life of 1; with `rating_life`
    outer_rating: float
    levers: float  # lever of the moments over that of the tilts
    inner_stiffness: float  # K_i, K_o, N/m^1.5; these and those below with `ball_inertia`
    outer_stiffness: float
    inner_distance: float  # from a ball's centre to those of the grooves when they just touch, m
    outer_distance: float
    centrifugal: float  # force of a ball over the square of the speed, kg.m
    set_inertia: float  # of balls and cage about the shaft, kg.m²; with `cage_slip`


@kernel
def bearing_start(t, s, p, e):
    """Contacts, films, waves and places of the balls."""
    if not p.ball_diameter < p.pitch_diameter:
        return LARGE_BALLS
    if e.oil_friction is not None and e.oil_friction.viscosity_100 > e.oil_friction.viscosity_40:
        return THICKENS
    if e.skf_friction is not None and not (
        e.friction.bore_diameter < p.pitch_diameter - p.ball_diameter
        and e.skf_friction.outside_diameter > p.pitch_diameter + p.ball_diameter
    ):
        return OTHER_BALLS
    gamma = diameter_share(p.ball_diameter, p.pitch_diameter, 0.0)
    modulus = effective_modulus(p.elastic_modulus, p.poisson_ratio, p.elastic_modulus, p.poisson_ratio)
    inner_x, inner_y = relative_radii(INNER, p.inner_conformity, p.ball_diameter, gamma)
    outer_x, outer_y = relative_radii(OUTER, p.outer_conformity, p.ball_diameter, gamma)
    s.message[0] = max(inner_y / inner_x, outer_y / outer_x)
    if not s.message[0] <= LARGEST_RATIO:
        return NO_ELLIPSE
    inner = grooved_contact(inner_x, inner_y, modulus, p.hertz == FITTED)
    outer = grooved_contact(outer_x, outer_y, modulus, p.hertz == FITTED)
    inner_stiffness = hertz_stiffness(inner.radius, modulus, inner.ellipse)
    outer_stiffness = hertz_stiffness(outer.radius, modulus, outer.ellipse)
    stiffness = two_in_series(inner_stiffness, outer_stiffness)
    contacts = groove_contacts(
        p.balls, stiffness, p.inner_conformity, p.outer_conformity, p.ball_diameter, p.pitch_diameter, 0.0, p.diametral_clearance
    )
    if contacts.radial <= 0.0:
        s.message[0] = 2.0 * contacts.distance
        return NO_GROOVE
    _, inner_axis = hertz_axes(1.0, inner.radius, modulus, inner.ellipse)
    _, outer_axis = hertz_axes(1.0, outer.radius, modulus, outer.ellipse)
    semi_axis = max(0.5 * inner_axis, 0.5 * outer_axis)  # under 1 N; it grows with the cube root of the load
    largest_load = (LARGEST_CONTACT * 0.5 * p.ball_diameter / semi_axis) ** 3
    s.message[0] = -2.0 * (largest_load / stiffness) ** (2.0 / 3.0)
    if p.diametral_clearance < s.message[0]:
        return TIGHT
    k = s.constants
    note_contacts(contacts, s.contacts)
    k.cage_ratio, k.spin_ratio = cage_turn(gamma), spin_turn(p.ball_diameter, p.pitch_diameter, gamma)
    k.largest_load = largest_load
    if e.film is not None:
        load, speed = 5.0 * e.film.nominal_load / p.balls, mean_surface_speed(p.ball_diameter, p.pitch_diameter, 1.0)
        k.inner_film = film_height(inner, inner_x, load, speed, e.film, False)
        k.outer_film = film_height(outer, outer_x, load, speed, e.film, False)
    if e.rating_life is not None:
        k.inner_rating, k.outer_rating = ring_ratings(
            p.balls, gamma, p.inner_conformity, p.outer_conformity, e.rating_life.load_rating
        )
    if e.published_levers is not None:
        # the moments' lever ends at the balls' centres, on the radius of the inner race and half a ball
        k.levers = (0.5 * p.pitch_diameter - 0.25 * p.diametral_clearance) / contacts.lever
    if e.ball_inertia is not None:
        k.inner_stiffness, k.outer_stiffness = inner_stiffness, outer_stiffness
        k.inner_distance = (p.inner_conformity - 0.5) * p.ball_diameter
        k.outer_distance = (p.outer_conformity - 0.5) * p.ball_diameter
        k.centrifugal = centrifugal_factor(e.ball_inertia.density, p.ball_diameter, p.pitch_diameter, k.cage_ratio)
    if e.cage_slip is not None:
        k.set_inertia = set_inertia(p.balls, p.ball_diameter, p.pitch_diameter, e.ball_inertia.density, e.cage_slip)
        s.x[s.x.size - 1] = k.cage_ratio * s.u[0, SPEED] * (1.0 - e.cage_slip.start_slip)
    for j in range(p.balls):
        at = TWO_PI * j / p.balls
        s.directions[0, j], s.directions[1, j] = math.cos(at), math.sin(at)
    start_waves(s, e)
    list_features(s, e)
    s.noted[COARSE, 0], s.noted[UNSEEN, 0] = -1.0, -1.0
    s.x[1] = wrapped(p.first_ball)
    if preload(s, e) > largest_load:
        return OUT_OF_RANGE
    s.initializing[0] = 1.0
    return DONE


@kernel
def list_features(s, e):
    """Features that a ball should not pass within one step, into s.features."""
    k, features = s.constants, s.features
    inner, outer = 1.0 - k.cage_ratio, k.cage_ratio
    if e.inner_waviness is not None:
        put_waves(features[0], highest_order(e.inner_waviness), inner)
    if e.outer_waviness is not None:
        put_waves(features[1], highest_order(e.outer_waviness), outer)
    if e.inner_defect is not None:
        features[2, EXTENT], features[2, TURN] = e.inner_defect.width, inner
    if e.outer_defect is not None:
        features[3, EXTENT], features[3, TURN] = e.outer_defect.width, outer
    if e.ball_defect is not None:
        features[4, EXTENT], features[4, TURN] = e.ball_defect.width, k.spin_ratio


@kernel
def put_waves(feature, order, turn):
    """Half a wave of the highest order, if there is one."""
    if order > 0:
        feature[EXTENT], feature[TURN], feature[ORDER] = math.pi / order, turn, order


@kernel
def preload(s, e):
    """Largest load of a ball at no displacement, N: of clearance, growth, films, waves and bumps."""
    u = s.u[0]
    k = s.constants
    place(s.x, u[SPEED], k, s, e)
    contacts, tightest = present_contacts(u, s.contacts, e.thermal_growth), math.inf
    for j in range(s.balls.shape[0]):
        tightest = min(tightest, s.balls[j, GAP])
    return contacts.stiffness * max(contacts.radial - contacts.distance - tightest, 0.0) ** 1.5


@kernel
def place(x, speed, k, s, e):
    """Directions and gaps of all balls into s.balls; k: `Constants`."""
    balls = s.balls
    cosine, sine = math.cos(x[1]), math.sin(x[1])
    film_thickness = 0.0
    if e.film is not None:
        film_thickness = (k.inner_film + k.outer_film) * abs(speed) ** CENTRAL_EXPONENT
    for j in range(balls.shape[0]):
        balls[j, COS] = cosine * s.directions[0, j] - sine * s.directions[1, j]
        balls[j, SIN] = sine * s.directions[0, j] + cosine * s.directions[1, j]
        balls[j, GAP] = -film_thickness
    add_faults(balls[:, GAP], None, x, speed, k, s.inner_waves, s.outer_waves, e)


@kernel
def present_contacts(u, k, growth):
    """The contacts k with the present clearance."""
    radial = k.radial
    if growth is not None:
        radial -= 0.5 * u[growth.u]
    return BallContacts(k.balls, k.stiffness, k.distance, radial, k.axial, k.lever)


@kernel
def present_inertia(x, speed, k, e):
    """The balls' inertia at the present speed, or None without the effect; k: `Constants`."""
    if e.ball_inertia is None:
        return None
    if e.cage_slip is not None:
        speed = x[x.size - 1] / k.cage_ratio
    return Inertia(k.inner_stiffness, k.outer_stiffness, k.inner_distance, k.outer_distance, k.centrifugal * speed * speed)


@kernel
def roll(h, x, u, behind, k, ball_defect):
    """Turn ring, cage and ball with the integral of the speed's polynomial over a step h; k: `Constants`.

    behind: angle by which the cage turns less than without slip.
    """
    turn = h * (u[0, SPEED] + h * (0.5 * u[1, SPEED] + h * u[2, SPEED] / 3.0))
    x[0] = wrapped(x[0] + turn)
    x[1] = wrapped(x[1] + k.cage_ratio * turn - behind)
    if ball_defect is not None:
        x[2] = wrapped(x[2] + k.spin_ratio * (turn - behind / k.cage_ratio))


@kernel
def slide(h, s, p, e):
    """The cage's speed behind a step h into s.x, the angle by which it has slipped into s.slipped; a status.

    The loads are those of the middle of the step, with the centrifugal force of the mean of the cage's speeds at both ends. The faster
    the cage, the less load and drive: the step has one solution, which secants find within a bracket.
    """
    k, x, middle = s.constants, s.x, s.middle
    last, half = x.size - 1, 0.5 * h
    ring, cage, start = x[0], x[1], x[last]
    for i in range(middle.size):
        middle[i] = s.u[0, i] + half * (s.u[1, i] + half * s.u[2, i])
    viscosity = middle[e.cage_slip.u]
    if viscosity < 0.0:
        return NO_FLUID
    ended, low, high, before, left_before = start, -math.inf, math.inf, start, 0.0
    x[0], x[1] = ring + 0.5 * half * (s.u[0, SPEED] + middle[SPEED]), cage + half * start
    place(x, middle[SPEED], k, s, e)
    x[0], x[1] = ring, cage
    for trial in range(TRIALS):
        x[last] = 0.5 * (start + ended)
        contacts, inertia = present_contacts(middle, s.contacts, e.thermal_growth), present_inertia(x, middle[SPEED], k, e)
        if e.damping is not None:
            factor = e.damping.factor
            status = contact_forces(middle[:5], contacts, s.balls, s.sums, None, middle[5:10], factor, None, inertia)
        else:
            status = contact_forces(middle[:5], contacts, s.balls, s.sums, None, None, None, None, inertia)
        if status != DONE:
            return status
        x[last], s.slipped[0] = turned_cage(h, start, s.u[:, SPEED], k.cage_ratio, present_drive(viscosity, s, p, e))
        left = x[last] - ended
        if abs(left) <= SETTLED * (abs(start) + abs(x[last])):
            break
        if left > 0.0:
            low = ended
        else:
            high = ended
        to = x[last]
        if trial > 0:
            to = ended + left * (ended - before) / (left_before - left) if left != left_before else math.inf
            if not low < to < high:
                to = 0.5 * (low + high)
        before, left_before, ended = ended, left, to
    return DONE


@kernel
def present_drive(viscosity, s, p, e):
    """What turns the cage under the balls' loads; viscosity: Pa.s."""
    load = 0.0
    for j in range(s.balls.shape[0]):
        load += s.balls[j, LOAD]
    return cage_drive(load, viscosity, s.constants.set_inertia, p.balls, p.ball_diameter, p.pitch_diameter, e.cage_slip)


@kernel
def fastest_turn(h, u, against):
    """Largest speed of the inner ring over a step h against a speed, rad/s."""
    now, slope, half = u[0, SPEED] - against, u[1, SPEED], u[2, SPEED]
    fastest = max(abs(now), abs(now + h * (slope + h * half)))
    if half != 0.0:
        vertex = -0.5 * slope / half
        if 0.0 < vertex < h:
            fastest = max(fastest, abs(now + 0.5 * slope * vertex))
    return fastest


@kernel
def check_passages(t, h, s, on_inner, on_outer):
    """Refuses a step in which a defect, or half a wave, could pass unseen; notes the first one that sees too little of it.

    s.noted: (2, 4) the feature, of a macro step what a passage takes, the macro step that sees enough, s, and the beginning, s;
    feature -1 where there was none.
    The bearing has no internal step that could be capped: between two macro steps it does not know where the rotor is.
    on_inner, on_outer: largest speed of an inner ring without slip that passes places of that race, and of the outer race and
    the balls, as fast as the present one, rad/s.
    """
    features, noted = s.features, s.noted
    for k in range(features.shape[0]):
        if features[k, TURN] > 0.0:
            passed = h * (on_inner if k in INNER_FEATURES else on_outer) * features[k, TURN] / features[k, EXTENT]
            row = UNSEEN if passed > 1.0 else COARSE
            if passed > 1.0 or (passed * SAMPLES > 1.0 and noted[COARSE, 0] < 0.0):
                noted[row, 0], noted[row, 1], noted[row, 2], noted[row, 3] = k, 1.0 / passed, h / (SAMPLES * passed), t
            if passed > 1.0:
                return MISSED + k
    return DONE


@kernel
def bearing_step(t, h, s, p, e):
    """Roll on by h, hold the inputs at their ends, and compute the outputs there."""
    behind = 0.0
    if e.cage_slip is None:
        on_inner = on_outer = fastest_turn(h, s.u, 0.0)
    else:
        last, ratio = s.x.size - 1, s.constants.cage_ratio
        before = s.x[last]
        status = slide(h, s, p, e)
        if status != DONE:
            return status
        behind, after = s.slipped[0], s.x[last]
        on_inner = max(fastest_turn(h, s.u, before), fastest_turn(h, s.u, after)) / (1.0 - ratio)
        on_outer = max(abs(before), abs(after)) / ratio
    status = check_passages(t, h, s, on_inner, on_outer)
    if status != DONE:
        return status
    s.counts[0] += 1
    s.initializing[0] = 0.0
    roll(h, s.x, s.u, behind, s.constants, e.ball_defect)
    hold_inputs(s.u, h)
    status = bearing_outputs(t + h, s, p, e)
    if e.skf_friction is not None and status == DONE:
        note_advice(t + h, s.sums, s.u[0, SPEED], s.y[e.oil_friction.y], e.friction, e.skf_friction, s.noted[ADVICE:])
    return status


@kernel
def bearing_outputs(t, s, p, e):
    """All outputs from the angles and the inputs.

    Returns DONE, OUT_OF_RANGE for a ring beyond the grooves or a ball beyond its largest load, or NOT_FINITE. While a
    master looks for the static position, which ends with the first outputs behind `bearing_start`, a load may be beyond it, for a
    step of Newton's method may go too far.
    """
    k, x, y, u, sums = s.constants, s.x, s.y, s.u[0], s.sums
    initializing = s.initializing[0] > 0.0
    s.initializing[0] = 0.0
    speed = u[SPEED]
    place(x, speed, k, s, e)
    contacts, inertia = present_contacts(u, s.contacts, e.thermal_growth), present_inertia(x, speed, k, e)
    if e.linearisation is not None and e.damping is not None:
        status = contact_forces(u[:5], contacts, s.balls, sums, s.stiffness, u[5:10], e.damping.factor, s.damping, inertia)
    elif e.linearisation is not None:
        status = contact_forces(u[:5], contacts, s.balls, sums, s.stiffness, None, None, None, inertia)
    elif e.damping is not None:
        status = contact_forces(u[:5], contacts, s.balls, sums, None, u[5:10], e.damping.factor, None, inertia)
    else:
        status = contact_forces(u[:5], contacts, s.balls, sums, None, None, None, None, inertia)
    if status != DONE:
        return status
    if sums[MAX_LOAD] > k.largest_load and not initializing:
        return OUT_OF_RANGE
    if e.published_levers is not None:
        sums[3] *= k.levers
        sums[4] *= k.levers
    for i in range(5):
        y[FORCE + i] = sums[i]
    y[LARGEST], y[NUMBER], y[RING], y[CAGE] = sums[MAX_LOAD], sums[LOADED], x[0], x[1]
    if e.film is not None:
        thickness = abs(speed) ** CENTRAL_EXPONENT
        y[e.film.y], y[e.film.y + 1] = k.inner_film * thickness, k.outer_film * thickness
    if e.linearisation is not None:
        linearise(u, y, k, s, initializing, e)
    if e.oil_friction is not None and not COLDEST <= u[e.oil_friction.u] <= HOTTEST:
        return NO_OIL
    if e.skf_friction is not None and not initializing and abs(sums[2]) > UPRIGHT * e.skf_friction.static_rating:
        s.message[0] = abs(sums[2])
        return UPRIGHT_LOAD
    if e.friction is not None:
        put_friction(y, u, sums, speed, p.pitch_diameter, e.friction, e.oil_friction, e.skf_friction)
    if e.ball_inertia is not None:
        put_inertia(y[e.ball_inertia.y :], s.balls, inertia)
    if e.cage_slip is not None:
        if u[e.cage_slip.u] < 0.0:
            return NO_FLUID
        put_slip(y[e.cage_slip.y :], x[x.size - 1], speed, k.cage_ratio, present_drive(u[e.cage_slip.u], s, p, e))
    if e.rating_life is not None:
        on_outer = s.balls[:, LOAD if e.ball_inertia is None else OUTER_LOAD]
        put_life(y, s.balls[:, LOAD], on_outer, speed, k, e.rating_life, e.life_factor)
    for i in range(y.size):
        if not math.isfinite(y[i]):
            return NOT_FINITE
    return DONE


@kernel
def put_inertia(y, balls, inertia):
    """The outputs of `ball_inertia`."""
    most = 0
    y[0], y[1] = inertia.force, 0.0
    for j in range(balls.shape[0]):
        y[1] = max(y[1], balls[j, OUTER_LOAD])
        if balls[j, LOAD] > balls[most, LOAD]:
            most = j
    y[2], y[3] = balls[most, INNER_ANGLE], balls[most, OUTER_ANGLE]


@kernel
def linearise(u, y, k, s, initializing, e):
    """The bearing as F = force - stiffness q - damping q' near the present motion: force, stiffness, damping into y."""
    first = e.linearisation.y + 5
    if initializing and s.sums[LOADED] < 1.5:
        s.stiffness[0, 0] += e.linearisation.idle_stiffness
        s.stiffness[1, 1] += e.linearisation.idle_stiffness
    for i in range(5):
        share = 1.0
        if e.published_levers is not None and i > 2:
            share = k.levers
        force = s.sums[i]
        for j in range(5):
            stiffness, damping = share * s.stiffness[i, j], share * s.damping[i, j]
            force += stiffness * u[j] + damping * u[5 + j]
            y[first + 5 * i + j] = stiffness
            y[first + 25 + 5 * i + j] = damping
        y[e.linearisation.y + i] = force


@kernel
def elastic_energy(s, e):
    """Energy of the contacts, J."""
    u = s.u[0]
    place(s.x, u[SPEED], s.constants, s, e)
    contacts, inertia = present_contacts(u, s.contacts, e.thermal_growth), present_inertia(s.x, u[SPEED], s.constants, e)
    contact_forces(u[:5], contacts, s.balls, s.sums, None, None, None, None, inertia)
    return s.sums[ENERGY]


KERNELS = Kernels(bearing_start, bearing_step, bearing_outputs)
