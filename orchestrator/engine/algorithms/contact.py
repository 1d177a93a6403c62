"""A contact as a unit: the law as an output, and for the interface model the force over a whole macro step.

All algorithms can step a scene with contacts. For the interface model `predict` integrates the reduced bodies over the coming step,
with the other forces on them extrapolated, and `correct` does so again with the leader's answer. The other forces are estimated from
the motion of the bodies under the known impulses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from ....components.core.reduced import LAWS, force_in_series, reduced_step
from ...settings import ContactSettings
from ...settings.scene import SideSettings
from ...units.interface import PortValues, Simulator
from ...verified_file import packed, unpacked
from ..coupling.contacts import PARTS, SIDES
from .polynomials import end_of, extrapolation

AGAIN = 3  # times the end of a step is corrected for a compliance, which moves the force by a fraction each time


class Line(NamedTuple):
    """A force over a macro step: value + slope * s, N."""

    value: float
    slope: float


def line(impulse: float, moment: float, h: float) -> Line:
    """The line with the same integral and the same first moment ∫s F ds, so that impulse and distance moved are preserved."""
    slope = 12.0 / h**3 * (moment - 0.5 * h * impulse)
    return Line(impulse / h - 0.5 * h * slope, slope)


class Forces:
    """The last samples of a force, as `extrapolation` takes them."""

    def __init__(self, degree: int):
        self.degree = degree
        self.set_samples(0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def set_samples(self, count: int, present: float, before: float, earlier: float, h1: float, h2: float) -> None:
        """`count` samples, N, and the times between them, s."""
        self.count, self.present, self.before, self.earlier, self.h1, self.h2 = count, present, before, earlier, h1, h2

    def __iter__(self) -> Iterator[float]:
        return iter((self.count, self.present, self.before, self.earlier, self.h1, self.h2))

    def push(self, force: float, h: float) -> None:
        """Add a sample that lies h behind the newest one."""
        self.set_samples(min(self.count + 1, self.degree + 1), force, self.present, self.before, h, self.h1)


class Side:
    """One body: its reduced model, what is known of the other forces on it, and the force it gets."""

    def __init__(self, settings: SideSettings, sign: float, degree: int):
        self.settings, self.sign = settings, sign
        self.inverse_mass = 1.0 / settings.inertia if settings.inertia else 0.0
        self.mobility = 1.0 / settings.impedance if settings.impedance else 0.0
        self.weight: float = settings.inertia or settings.impedance or 0.0
        self.by_acceleration = settings.acceleration is not None
        self.others = Forces(degree if settings.degree is None else settings.degree)  # at instants, or means of steps
        self.parts = [0.0, 0.0, 0.0, 0.0]  # position, velocity, acceleration, compliance
        self.before = 0.0  # position (impedance) or velocity (inertia) when the step began
        self.impulse = 0.0  # N s, that the body has got over the step, of F
        self.line = Line(0.0, 0.0)
        self.owed_motion = 0.0  # m and m/s, where the body will be once it has got what is owed to it
        self.owed_velocity = 0.0

    def set_parts(self, values: PortValues, picks: Sequence[int]) -> None:
        """What the body gives now; picks: where among the contact's inputs, -1 for a part that it does not give."""
        self.parts = [values[k] if k >= 0 else 0.0 for k in picks]

    def balance_quantity(self, force: float) -> float:
        """What the balance of a step goes by: velocity of a body with inertia, else position, with the compliance pressed in."""
        return self.parts[1] if self.inverse_mass else self.parts[0] + self.sign * self.parts[3] * force

    def mean(self, force: float, h: float) -> float:
        """Mean of the other forces over the step that the body has made, N."""
        return (self.weight * (self.balance_quantity(force) - self.before) - self.sign * self.impulse) / h

    def at_rest(self, force: float) -> float:
        """The other forces at an instant, as far as they are known without a step."""
        acceleration = self.parts[2] if self.by_acceleration else 0.0
        velocity = self.parts[1] if self.mobility else 0.0
        return self.weight * (acceleration + velocity) - self.sign * force

    def polynomial(self, force: float, h: float) -> tuple[float, float, float]:
        """The other forces over the coming step; h: length of the last one, 0 before the first."""
        if not self.others.count:
            return self.at_rest(force), 0.0, 0.0
        a, b, c = extrapolation(*self.others)
        back = 0.0 if self.by_acceleration else 0.5 * h  # a mean stands for the middle of its step
        return a + back * (b + back * c), b + 2.0 * back * c, c

    def answered(self, force: float, h: float, last: float) -> tuple[float, float, float]:
        """The other forces over the step that the body has just made; h, last: its length and that of the step before."""
        if self.by_acceleration:
            present = self.others.present
            fed = self.line.value + h * self.line.slope
            return present, (self.weight * self.parts[2] - self.sign * fed - present) / h, 0.0
        mean = self.mean(force, h)
        slope = (mean - self.others.present) / (0.5 * (h + last)) if self.others.count else 0.0
        return mean - 0.5 * h * slope, slope, 0.0

    def save(self) -> list[Any]:
        """Everything a repeated step depends on, as plain numbers."""
        return [list(self.others), self.parts, self.before, self.impulse, list(self.line), self.owed_motion, self.owed_velocity]

    def restore(self, state: list[Any]) -> None:
        """Take back what `save` gave."""
        others, self.parts, self.before, self.impulse, force, self.owed_motion, self.owed_velocity = state
        self.others.set_samples(*others)
        self.line = Line(*force)


class ContactSimulator(Simulator):
    """A contact as a unit; see the module."""

    kind = "contact"

    def __init__(self, contact: ContactSettings, degree: int):
        """degree: of the polynomials of the other forces, where a side has no degree of its own."""
        self.name, self.settings = contact.name, contact
        self.sides = (Side(contact.first, -1.0, degree), Side(contact.second, 1.0, degree))
        self.leader = None if contact.leader is None else SIDES.index(contact.leader)
        self._law = (LAWS.index(contact.law), contact.stiffness, contact.damping)
        self._outputs: tuple[str, ...] = ()
        self._picks: list[list[int]] = []
        self.force = self.indentation = 0.0
        self.last = self.before_last = 0.0  # s, lengths of the last two steps
        self.owed = 0.0  # N s, what the leader has missed in the last step
        self.steps = 0

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        names = list(inputs)
        self._picks = [[names.index(n) if (n := f"{label}_{part}") in names else -1 for part in PARTS] for label in SIDES]
        self._outputs = tuple(outputs)

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        return lambda: [getattr(self, n) for n in names]

    def get(self) -> PortValues:
        return [getattr(self, n) for n in self._outputs]

    def initialize(self, t: float, values: PortValues) -> None:
        self.last = self.owed = 0.0
        self.steps = 0
        for side in self.sides:
            side.others.count, side.owed_motion, side.owed_velocity = 0, 0.0, 0.0
        self.update(values)

    def restart(self) -> None:
        """After a jump the past of the other forces tells nothing any more."""
        self.last = 0.0
        for side in self.sides:
            side.others.count = 0

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        none = [0.0] * len(values)
        rows = zip(values, none if slopes is None else slopes, none if quadratic is None else quadratic, strict=True)
        self._set_parts([end_of(v, s, c, 2, h) for v, s, c in rows])

    def step(self, t: float, h: float) -> None:
        """The force at the end of the step; only the interface model has more to ask."""
        self._press()
        self.steps += 1

    def update(self, values: PortValues) -> None:
        self._set_parts(values)
        self._press()

    def _set_parts(self, values: PortValues) -> None:
        for side, picks in zip(self.sides, self._picks, strict=True):
            side.set_parts(values, picks)

    def _press(self) -> None:
        first, second = self.sides
        gap = first.parts[0] + first.owed_motion - second.parts[0] - second.owed_motion - self.settings.clearance
        rate = first.parts[1] + first.owed_velocity - second.parts[1] - second.owed_velocity
        self.indentation = gap
        self.force = force_in_series(*self._law, gap, rate, first.parts[3] + second.parts[3])

    def predict(self, values: PortValues, h: float) -> None:
        """Lines of force for both bodies over the coming step of length h; `values`: inputs at its beginning.

        Accelerations among them have followed the force since it was computed.
        """
        self._set_parts(values)
        last, force = self.last, self.force
        for side in self.sides:
            if side.by_acceleration:
                side.others.push(side.at_rest(force), last)
            elif last:
                side.others.push(side.mean(force, last), 0.5 * (last + self.before_last))
        self._start = [
            (side.parts[0] + side.owed_motion + side.sign * side.parts[3] * force, side.parts[1] + side.owed_velocity)
            for side in self.sides
        ]
        self._others = [side.polynomial(force, last) for side in self.sides]
        impulse, moment, self._end = self._reduced(h)
        self._expected = impulse, moment
        for k, side in enumerate(self.sides):
            owed = self.owed if k == self.leader else 0.0
            side.before, side.impulse = side.balance_quantity(force), impulse + owed
            side.line = line(impulse + owed, moment + 0.5 * h * owed, h)
            side.owed_motion = side.owed_velocity = 0.0
        self.before_last, self.last, self.owed = last, h, 0.0
        self.steps += 1

    def correct(self, values: PortValues) -> None:
        """A new line for the follower, from what the leader has reached at the end of the step; `values`: of all inputs.

        What the leader has got too little goes into the next step; till then it counts as if it had moved by it.
        """
        assert self.leader is not None
        h, leader, follower = self.last, self.sides[self.leader], self.sides[1 - self.leader]
        leader.set_parts(values, self._picks[self.leader])
        force = self._end
        for _ in range(AGAIN if leader.parts[3] else 1):
            self._others[self.leader] = leader.answered(force, h, self.before_last)
            impulse, moment, force = self._reduced(h)
        follower.line, follower.impulse = line(impulse, moment, h), impulse
        self.owed = missed = impulse - self._expected[0]
        missed_moment = h * missed - (moment - self._expected[1])
        leader.owed_motion = leader.sign * (missed * leader.mobility + missed_moment * leader.inverse_mass)
        leader.owed_velocity = leader.sign * missed * leader.inverse_mass

    def _reduced(self, h: float) -> tuple[float, float, float]:
        first, second = self.sides
        return reduced_step(
            h,
            *self._law,
            self.settings.clearance,
            *self._start[0],
            *self._start[1],
            first.inverse_mass,
            first.mobility,
            second.inverse_mass,
            second.mobility,
            *self._others[0],
            *self._others[1],
        )

    def save(self, reuse: Any = None) -> list[Any]:
        return [self.force, self.indentation, self.last, self.before_last, self.owed, self.steps, *(s.save() for s in self.sides)]

    def restore(self, state: list[Any]) -> None:
        self.force, self.indentation, self.last, self.before_last, self.owed, self.steps, *sides = state
        for side, saved in zip(self.sides, sides, strict=True):
            side.restore(saved)

    def pack(self, state: list[Any]) -> bytes:
        return packed(state)

    def unpack(self, content: bytes) -> list[Any]:
        return unpacked(content)

    def parameters(self) -> dict[str, Any]:
        given = self.settings.model_dump(exclude_none=True)
        sides = {f"{label}.{key}": value for label in SIDES for key, value in given.pop(label).items()}
        return given | sides

    def work(self) -> dict[str, int]:
        return {"steps": self.steps}
