"""A scene as an environment of Gymnasium: actions are inputs that nothing drives, observations are outputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any

import gymnasium
import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ...components.core.measure import is_quantity, number_in
from ..scene.names import declared, elements, variable_of
from ..scene.scene import Scene
from ..scene.written_units import scaled_names
from ..session.session import Session

Names = Sequence[str] | Mapping[str, tuple[Any, Any]]  # with or without (low, high)
Reward = Callable[[np.ndarray, np.ndarray], float]  # of observation and action
Condition = Callable[[np.ndarray], bool]  # of an observation


class SceneEnvironment(gymnasium.Env[Any, Any]):
    """A scene that an agent acts in. One step of it is `steps` macro steps with a held action.

    actions, observations: names, in the order of the arrays.  session: the scene, a `Session`. An episode is truncated at
    the scene's stop_time, and where a step fails: `info["failure"]` has the reason then.
    """

    def __init__(
        self,
        scene: Scene,
        actions: Names,
        observations: Names,
        reward: Reward,
        *,
        terminated: Condition | None = None,
        start: Mapping[str, Any] | None = None,
        steps: int = 1,
    ):
        """As `cosimo.gym`; raises `BadInput`."""
        if type(steps) is not int or steps < 1:
            raise BadInput("gym: steps", repr(steps), "a whole number of macro steps, 1 at least")
        self._where, self._scene, self._steps = f"environment of {scene.name}", scene, steps
        self._reward, self._terminated = reward, terminated
        self.actions, self._of_actions, box = self._box(actions, "actions")
        self.action_space, self._low, self._high = box, box.low, box.high
        self.observations, self._of_observations, self.observation_space = self._box(observations, "observations")
        self._start, self._of_start, _ = self._box(start or {}, "start")
        self._ranges = [value if isinstance(value, tuple) else (value, value) for value in (start or {}).values()]
        self._read = tuple(self.observations)
        self.session = Session(scene)
        self._seeded = bool(self.session.seeds)
        self._resumes = not (start or self._seeded) and all(i.saves_state for i in scene.coupling.interfaces.values())
        self._state: Any = None
        self._last = np.zeros(len(self.observations))

    def _box(self, names: Names, key: str) -> tuple[tuple[str, ...], np.ndarray, gymnasium.spaces.Box]:
        """(names as the scene has them, (2, n) factors and offsets from their units, the space); raises `BadInput`."""
        where, scene = f"{self._where}: {key}", self._scene
        sources = {link.target: ".".join(link.source) for link in (*scene.coupling.links, *scene.coupling.texts)}
        known, scales = scaled_names(scene, names, where)
        low, high = np.full(len(known), -inf), np.full(len(known), inf)
        for k, (name, text) in enumerate(zip(known, names, strict=True)):
            unit, variable = variable_of(scene, name, self._where)
            interface = scene.coupling.interfaces[unit]
            if key == "actions" and variable not in interface.inputs:
                raise BadInput(where, repr(name), "an input that nothing drives", "Parameters are varied by start.")
            if key != "observations" and (source := sources.get((unit, variable))):
                raise BadInput(where, repr(name), "an input that nothing drives", f"It is connected to {source}.")
            if key == "start" and variable in interface.outputs:
                raise BadInput(where, repr(name), "a parameter, or an input that nothing drives", "It is an output.")
            if key == "observations" and variable not in interface.outputs:
                remedy = "Of an array each element is one." if elements(interface.outputs, variable) else ""
                raise BadInput(where, repr(name), "an output that is a number", remedy)
            of = declared(scene, unit).get(variable)
            ends = (getattr(of, "low", -inf), getattr(of, "high", inf))
            low[k], high[k] = sorted((np.array(ends) - scales[1, k]) / scales[0, k])
            if isinstance(names, Mapping) and key != "start":
                given = names[text]
                if not isinstance(given, tuple | list) or len(given) != 2:
                    raise BadInput(where, f"{given!r} of {name}", "(low, high)")
                low[k], high[k] = (self._number(value, text, name, scales[:, k]) for value in given)
            if key == "start":
                continue
            if not low[k] < high[k] or (key == "actions" and not np.isfinite([low[k], high[k]]).all()):
                expected = "low < high, both finite" if key == "actions" else "low < high"
                raise BadInput(f"{where}: {name}", f"{low[k]:g} to {high[k]:g}", expected, f'As in {{"{name}": (-1.0, 1.0)}}.')
        return known, scales, gymnasium.spaces.Box(low, high, dtype=np.float64)

    def _number(self, value: Any, text: str, name: str, scale: np.ndarray) -> float:
        """A limit in the unit behind its name; a text has its own."""
        if not is_quantity(value):
            return float(value)
        unit, variable = variable_of(self._scene, name, self._where)
        of = declared(self._scene, unit)[variable]
        return float((number_in(value, of.unit, f"{self._where}: {text}") - scale[1]) / scale[0])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin anew, with values drawn for `start`, and new seeds for the random parts of the scene.

        options: values for names of `start`, instead of drawn ones.
        """
        super().reset(seed=seed)
        if unknown := set(options or {}) - set(self._start):
            raise BadInput(
                f"{self._where}: options", ", ".join(sorted(unknown)), f"names of start: {', '.join(self._start) or 'none'}"
            )
        session = self.session
        if self._state is not None:
            session.restore(self._state)
        else:
            session.reset(seed=int(self.np_random.integers(2**31)) if self._seeded else None)
            for name, (low, high), factor, offset in zip(self._start, self._ranges, *self._of_start, strict=True):
                drawn = low if low == high or isinstance(low, str) else self.np_random.uniform(low, high)
                given = (options or {}).get(name, drawn)
                session[name] = given if isinstance(given, str) else factor * given + offset
            session.initialize()
            self._state = session.save() if self._resumes else None
        return self._observe(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Hold an action, clipped to its space, over `steps` macro steps: (observation, reward, terminated, truncated, info)."""
        session = self.session
        held = np.minimum(np.maximum(np.asarray(action, dtype=float), self._low), self._high)
        info: dict[str, Any] = {}
        try:
            for name, value in zip(self.actions, (held * self._of_actions[0] + self._of_actions[1]).tolist(), strict=True):
                session[name] = value
            session.step(self._steps)
            self._last = self._observe()
        except StepFailed as error:
            info["failure"] = str(error)
        observation = self._last.copy()
        over = bool(self._terminated(observation)) if self._terminated is not None else False
        return observation, float(self._reward(observation, held)), over, session.done or bool(info), info

    def _observe(self) -> np.ndarray:
        self._last = (self.session.values(self._read) - self._of_observations[1]) / self._of_observations[0]
        return self._last.copy()

    def close(self) -> None:
        """Close the units."""
        self.session.close()
