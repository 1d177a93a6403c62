"""Steps that follow what happens in them: step control, events between the units, and steps that are repeated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ....components.core.errors import StepFailed
from ...settings import ControlSettings, SceneSettings
from ...units.interface import SimulationEnded
from ...units.kinds import kinds_of
from ..algorithms import Master
from ..algorithms.energy import EnergyAccount
from ..algorithms.node import Node
from ..algorithms.step_control import Controller, Doubling, Milne, StepErrorEstimate
from ..coupling import Coupling
from ..coupling.graph import Endpoint, is_discrete
from .clock import Clock
from .discontinuities import jump_times
from .faults import edges
from .loop import Action, Observer, Steppable, Stepping, Stops, lengths

RESOLUTION = 1_000_000  # part of master.step that events are located to: what the rest of a step moves is below its error
SHORT = 1000  # parts of a step: what is shorter is nothing to extrapolate from
SMALLEST = 1000  # part of master.step that is the smallest step, if the scene gives none
TRIALS = 40  # of the end of a step, after which the bracket is halved; for a smooth signal ten are enough


class Crossings:
    """Watches signals for changes of sign, and finds the first instant behind one.

    A signal that is 0 has the sign it had before; one that starts at 0 has none yet. Truth values change sign about 1/2. Of
    two changes within one step nothing is seen.
    """

    def __init__(self, master: Master, ends: Sequence[Endpoint], coupling: Coupling):
        self._signals, self._places = master.signals, [master.positions[end] for end in ends]
        self._levels = [0.5 if is_discrete(coupling.interfaces[u].outputs[n]) else 0.0 for u, n in ends]
        self.signs = [0.0] * len(ends)
        self.start = [0.0] * len(ends)

    def values(self) -> list[float]:
        """The signals now, from where they change their sign."""
        return [self._signals[k] - level for k, level in zip(self._places, self._levels, strict=True)]

    def start_step(self) -> None:
        """A new step starts here."""
        self.start = self.values()
        self.signs = [
            sign if value == 0.0 else (1.0 if value > 0.0 else -1.0) for sign, value in zip(self.signs, self.start, strict=True)
        ]

    def changed(self) -> bool:
        """Whether a signal has another sign than when the step started."""
        return any(sign * value < 0.0 for sign, value in zip(self.signs, self.values(), strict=True))

    def first(self, tick: int, ahead: int, resolution: int, step: Callable[[int], None]) -> tuple[int, int]:
        """Ticks before and behind the first change in a step that has been made from `tick` to `ahead`.

        `step(tick)` makes the step again, to another end; the last such call is for the tick behind the change. The two are not
        more than `resolution` apart. Regula falsi, Illinois variant (Dowell, Jarratt, BIT 11, 1971).
        """
        low, high, before, behind, at, trials = tick, ahead, self.start, self.values(), ahead, 0
        lighter = [1.0, 1.0]  # weights of the values at the two ends
        while high - low > resolution:
            shares = [
                lighter[0] * a / (lighter[0] * a - lighter[1] * b)
                for sign, a, b in zip(self.signs, before, behind, strict=True)
                if sign * b < 0.0
            ]
            guess = low + round(min(shares) * (high - low)) if trials < TRIALS else (low + high) // 2
            margin = min(resolution, (high - low) // 2)
            was, at, trials = at, min(max(guess, low + margin), high - margin), trials + 1
            step(at)
            if self.changed():
                lighter = [lighter[0] / 2.0 if was == high else 1.0, 1.0]
                high, behind = at, self.values()
            else:
                lighter = [1.0, lighter[1] / 2.0 if was == low else 1.0]
                low, before = at, self.values()
        if at != high:
            step(high)
        return low, high


class AdaptiveStepping(Stepping):
    """Steps that follow what happens in them: their error, events, and failures.

    With `control`, each step is as long as the controller wishes, its error is what `estimate` says, and `stride` is the first
    one; without, steps are as in `Stepping`. Where all units can go back (`rollback`), a step whose error is above 1, or which
    a unit could not complete, is repeated, shorter; else the next one is shorter, and a failure ends the run. An event ends its
    step: one of `crossings` where its signal has just changed its sign, to `resolution` ticks; one of the units `early`, which
    tell their own, at the next tick. Without `rollback` a step with an event of a unit is left as it is. Behind an event
    inputs are extrapolated from what they are then. The last step ends where a unit ends the simulation.
    """

    def __init__(
        self,
        master: Steppable,
        clock: Clock,
        stride: int,
        end: int,
        stops: Stops | None = None,
        *,
        restarts: Sequence[Action] = (),
        control: Controller | None = None,
        estimate: StepErrorEstimate | None = None,
        crossings: Crossings | None = None,
        early: Sequence[Node] = (),
        resolution: int = 1,
        rollback: bool = True,
    ):
        super().__init__(master, clock, stride, end, stops)
        self.control, self._estimate, self._crossings, self._early = control, estimate, crossings, early
        self._restarts, self._resolution, self._rollback = restarts, resolution, rollback
        self.rewinds = rollback
        self._saved: Any = None
        self.counts = dict.fromkeys(("accepted", "rejected", "failed", "inaccurate", "events", "restores"), 0)
        self._behind_event = False  # the tick is no multiple of the stride, because an event ended the last step
        self.shortest, self.longest = end, 0  # ticks of the steps that were kept, but for those that a stop or an event has cut

    def look_ahead(self) -> None:
        """No step is known before it is taken."""

    def _advance(self, stop: int, observers: Sequence[Observer], most: int) -> int:
        """One step that is kept."""
        control = self.control
        if self._rollback:
            self._saved = self.master.save(self._saved)
        if self._crossings is not None:
            self._crossings.start_step()
        ends: int | None = None  # ticks from here to where a unit ends the simulation
        failed: StepFailed | None = None
        while True:
            length = ends or self._length(stop)
            try:
                reached, event, error, order = self._attempt(self.tick + length)
            except SimulationEnded as end:
                if not self._rollback:
                    raise
                ends = min(self.clock.not_before(end.time) - self.tick, length - 1)
                if ends < 1:
                    self._back()
                    raise
            except StepFailed as failure:
                if control is None or not self._rollback:
                    raise
                if length <= control.unit:
                    raise StepFailed(
                        failure.unit,
                        failure.time,
                        f"{failure.reason}; so did shorter steps, down to {self.clock.seconds(length):g} s",
                        failure.remedy,
                    ) from failure
                self.counts["failed"] += 1
                control.fail(length)
                failed = failure
            else:
                taken = reached - self.tick
                if control is None or error <= 1.0 or not self._rollback or taken <= control.unit:
                    break
                self.counts["rejected"] += 1
                control.reject(taken, error, order)
            try:
                self._back()
            except StepFailed as gone:  # its worker process has ended, say: what it failed of is the news
                raise failed or gone from None
        self.tick = reached
        self.counts["accepted"] += 1
        if control is not None:
            self.counts["inaccurate"] += error > 1.0
            if taken == control.length:
                self.shortest, self.longest = min(self.shortest, taken), max(self.longest, taken)
            if order:
                control.accept(taken, error, order)
        self.counts["events"] += event
        short = self._behind_event and SHORT * taken < self.stride
        if event or short:  # over a step as short as that, a chord shows the rounding of its ends
            for restart in self._restarts:
                restart()
        self._behind_event = event and self.tick % self.stride > 0
        return 1

    def _length(self, stop: int) -> int:
        """Ticks of the next step, if nothing happens in it."""
        distance = stop - self.tick
        if self.control is None and self._behind_event:  # the grid of times that were asked for goes on
            return min(self.stride - self.tick % self.stride, distance)
        if self.control is None:
            return next(lengths(self.tick, stop, self.stride, stop == self.end))[0]
        length, unit = self.control.length, self.control.unit
        if distance <= length:
            return distance
        return max(distance // 2 // unit, 1) * unit if distance < 2 * length else length

    def _attempt(self, ahead: int) -> tuple[int, bool, float, int]:
        """A step to a tick, or to the first event before it: (tick reached, whether by an event, error, its order).

        The order is 0 where no error was measured: nothing follows for the next step.
        """
        self._step(ahead)
        event, before, crossings = False, ahead, self._crossings
        while times := [at for node in self._early if (at := node.event) is not None]:
            event, first = True, max(self.clock.not_before(min(times)), self.tick + 1)
            before = first - 1
            if first >= ahead or not self._rollback:
                break
            ahead, event = first, False
            self._again(ahead)
        if crossings is not None and crossings.changed():
            (before, ahead), event = crossings.first(self.tick, ahead, self._resolution, self._again), True
        error, order = 0.0, 0
        if self._estimate is not None and not event:
            error, order = self._estimate.measure(lambda: self._halves(ahead))
            if crossings is not None and crossings.changed():  # in the halves only
                (_, ahead), event = crossings.first(self.tick, ahead, self._resolution, self._again), True
        elif self._estimate is not None and self._rollback and before > self.tick:
            self._again(before)  # what jumps at the event is no error
            error, order = self._estimate.measure(lambda: self._halves(before))
            self._again(ahead)
        return ahead, event, error, order

    def _step(self, ahead: int) -> None:
        h = self.clock.seconds(ahead - self.tick)
        if self._estimate is not None:
            self._estimate.prepare(h)
        self.master.step(self.clock.time(self.tick), h)

    def _back(self) -> None:
        self.counts["restores"] += 1
        self.master.restore(self._saved)

    def _again(self, ahead: int) -> None:
        """The step from where it started, to another end."""
        self._back()
        self._step(ahead)

    def _halves(self, ahead: int) -> None:
        """The step from where it started, in two halves; a single tick stays whole."""
        tick, seconds, time = self.tick, self.clock.seconds, self.clock.time
        middle = tick + (ahead - tick) // 2
        self._back()
        if middle > tick:
            self.master.step(time(tick), seconds(middle - tick))
        self.master.step(time(middle), seconds(ahead - middle))

    def report(self) -> dict[str, Any]:
        """Counters of the steps, for run.json."""
        seconds = self.clock.seconds
        return self.counts | ({"shortest": seconds(self.shortest), "longest": seconds(self.longest)} if self.longest else {})

    def state(self) -> dict[str, Any]:
        control, crossings = self.control, self._crossings
        return {
            "counts": dict(self.counts),
            "range": [self.shortest, self.longest],
            "signs": list(crossings.signs) if crossings else [],
            "control": control.state() if control else {},
            "behind_event": self._behind_event,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        self.counts, (self.shortest, self.longest) = dict(state["counts"]), state["range"]
        self._behind_event = state["behind_event"]
        if self._crossings is not None:
            self._crossings.signs = list(state["signs"])
        if self.control is not None:
            self.control.set_state(state["control"])

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far."""
        beyond, control = self.counts["inaccurate"], self.control
        if control is None or not beyond:
            return []
        smallest = (
            f"with the smallest step, {self.clock.seconds(control.unit):g} s, too"
            if self._rollback
            else "and were not repeated, because not all units save their state"
        )
        return [f"{beyond} of {self.counts['accepted']} steps had errors above what master.control allows, {smallest}"]


def clock_for(scene: SceneSettings, coupling: Coupling) -> Clock:
    """The clock of a scene: its ticks divide its steps and times, and are as small as step control and events need them."""
    control, step = scene.master.control, scene.master.step
    smallest = [control.min_step] if control is not None and control.min_step is not None else []
    ends = [scene.stop_time, *edges(scene.faults, scene.start_time), *jump_times(scene)]
    clock = Clock.dividing(step, *(abs(end) for end in ends if end), *smallest, start=scene.start_time)
    if scene.master.events or any(i.may_return_early for i in coupling.interfaces.values()):
        clock = clock.finer(-(-RESOLUTION // clock.ticks(step)))
    if control is not None:
        clock = clock.finer(2 if smallest else 2 * SMALLEST)
    return clock


def stepping_of(
    scene: SceneSettings, coupling: Coupling, master: Master, account: EnergyAccount | None, clock: Clock, stops: Stops
) -> Stepping:
    """The stepping that a scene asks for: equal steps, in batches if possible, where nothing in them has to be watched."""
    given, steppable = scene.master, account or master
    if account is not None:  # what happens at a stop makes outputs jump
        stops = {tick: [*acts, account.restart] for tick, acts in stops.items()}
    stride, end = clock.ticks(given.step), clock.tick(scene.stop_time)
    early = [node for node in master.nodes if coupling.interfaces[node.unit.name].may_return_early]
    if given.control is None and not given.events and not early:
        # whether components keep their state where it belongs is known of those of the catalogue only
        trusted = {name for name, kind in kinds_of(scene.units).items() if kind.of_catalogue}
        batches = master if (account or master).in_batches else None
        return Stepping(steppable, clock, stride, end, stops, batches=batches, trusted=trusted)
    restarts = [node.restart for node in master.nodes if node.sources] + ([account.restart] if account is not None else [])
    control = estimate = None
    if given.control is not None:
        smallest, longest = given.control.min_step, given.control.max_step
        control = Controller(
            stride, clock.ticks(smallest) if smallest else stride // SMALLEST, end if longest is None else clock.ticks(longest)
        )
        estimate = _estimate(given.control, coupling, master)
    crossings = Crossings(master, coupling.events, coupling) if coupling.events else None
    rollback = all(interface.saves_state for interface in coupling.interfaces.values())
    return AdaptiveStepping(
        steppable,
        clock,
        stride,
        end,
        stops,
        restarts=restarts,
        control=control,
        estimate=estimate,
        crossings=crossings,
        early=early,
        resolution=max(stride // RESOLUTION, 1),
        rollback=rollback,
    )


def _estimate(settings: ControlSettings, coupling: Coupling, master: Master) -> StepErrorEstimate:
    if settings.method == "doubling":
        return Doubling(master, coupling, settings)
    return Milne(master, coupling, settings)
