"""A session as an estimate of a real system, which what its sensors show takes on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ...components.core.errors import BadInput
from ..scene.names import displaced

if TYPE_CHECKING:
    from ..estimation.filtered_scene import PlanLike
    from ..estimation.live import Live, Present


class Estimating:
    """The part of a session that is about estimates; `self` is a `Session`, which knows this module and not the other way round."""

    _live: Live | None = None  # where the session is one

    def estimate(self: Any, plan: PlanLike) -> Present:
        """From now on the session is an estimate of the real system, which `assimilate` takes on. It begins at the scene's start.

        plan: a TOML file, or the same as plain data, as of `cosimo.estimate`; files of measurements and `smooth` do not count.
        Raises `BadInput` for a session that has made steps, and for what has no derivatives.
        """
        from ..estimation.live import Live

        if self._initialized and self._stepping.tick:
            raise BadInput(
                f"{self._where}: estimate", f"t = {self.time:.9g} s", "the scene's start", "reset() goes back to there."
            )
        if not self._initialized:
            self.initialize()
        self._live = Live(self._scene_anew, plan, self._known_inputs, self._stack)
        return self._at_estimate(self._live.present())

    def assimilate(self: Any, t: float, values: Mapping[str, float | str]) -> Present:
        """Take what sensors show at t, s: name -> number in SI, or a text with its unit, NaN for a gap; and go on to there.

        The session stands then at the mean of the estimate, at the last macro step that ends at t, or before it by the longest `delay` of
        the plan: outputs, states and estimated parameters are read from it, and steps that it makes are a prediction, which the next
        measurements take back. Inputs that were set are known to act from then on. All signals of an instant are one call. Raises
        `BadInput`, and `StepFailed` where the scene cannot go on from an estimate.
        """
        self._started("assimilate()")
        if self._live is None:
            raise BadInput(f"{self._where}: assimilate", "a session without a plan", "estimate(plan) before")
        if t > self.scene.stop_time:
            raise BadInput(f"{self._where}: assimilate", f"{t:.9g} s", f"a time up to stop_time = {self.scene.stop_time:g} s")
        return self._at_estimate(self._live.assimilate(t, values, self._known_inputs))

    def _refuse_estimated(self: Any, what: str) -> None:
        if self._live is not None:
            raise BadInput(
                f"{self._where}: {what}",
                "a session that estimates",
                "one without estimate(plan)",
                "What is learnt from measurements is no part of a state; reset() goes back to the scene.",
            )

    @property
    def _known_inputs(self: Any) -> dict[str, float]:
        """Numbers that were set by hand, by name."""
        return {".".join(end): value for end, value in self._inputs.items() if isinstance(value, float)}

    def _at_estimate(self: Any, now: Present) -> Present:
        """Let the session stand where the estimate does."""
        assert self._live is not None
        self._live.give(self._master)
        clock, self._unseen = self._stepping.clock, False
        self._stepping.tick = min(round((now.time - self.scene.start_time) / clock.seconds(1)), self._stepping.end)
        numbers = {}
        for parameter in now.parameters:
            unit, name = parameter.name.split(".", 1)
            if name in self.scene.coupling.interfaces[unit].inputs:
                self._inputs[unit, name] = parameter.value
            else:
                numbers[parameter.name] = parameter.value
        self._open_scene.scene = displaced(self.scene, numbers)
        if self._course.account is not None:
            self._course.account.restart()
        for observe in self._observers:
            observe(self._stepping.tick, self.time)
        return now
