"""A session that somebody watches: what can be set, what has happened, and the error of what was seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from ....components.core.errors import BadInput, StepFailed
from ...run.comparison import differences, needs_third, signal_errors
from ...run.results import Result
from ...run.run_record import known
from ...scene.names import declared
from ...scene.scene import Scene
from ...scene.shorter_steps import shorter
from ...session.session import Session
from ...units.interface import Signal

POINTS = 200  # of a curve, for a request: the page draws no more
ROUNDED = 1e-6  # of a macro step, that instants which a page names are rounded by
CURVES = 6  # outputs that are drawn at first
Setting = float | str


class Move(NamedTuple):
    """An input that was set: when, s, which and to what."""

    time: float
    name: str
    value: Setting


class HeldScene:
    """A scene that is begun, moved and stepped by requests, one after the other and from one thread."""

    def __init__(self, scene: Scene):
        self._session, self._moves = Session(scene), list[Move]()
        self._starts = dict[str, Any]()  # inputs that were set before the start
        self.failure = ""

    # -- what it is ------------------------------------------------------------------------------------------------------
    def description(self) -> dict[str, Any]:
        """Title, times in s, and of each unit its inputs, parameters and outputs with units of measure and present values."""
        scene = self._session.scene
        return {
            "title": scene.title or scene.name,
            "start": scene.start_time,
            "stop": scene.stop_time,
            "step": scene.master.step,
            "shown": self._outputs()[:CURVES],
            "units": [self._unit(scene, name) for name in scene.units],
        }

    def _outputs(self) -> list[str]:
        scene = self._session.scene
        units = scene.coupling.interfaces.items()
        known = [f"{u}.{n}" for u, interface in units for n, s in interface.outputs.items() if not s.is_text]
        recorded = [name for name in scene.record.signals or () if name in known]
        return [*recorded, *(name for name in known if name not in recorded)]

    def _unit(self, scene: Scene, name: str) -> dict[str, Any]:
        interface = scene.coupling.interfaces[name]
        driven = {link.target for link in (*scene.coupling.links, *scene.coupling.texts)}
        free = [s for n, s in interface.inputs.items() if (name, n) not in driven and not s.is_text]
        parameters = []
        for variable, declaration in declared(scene, name).items():
            if variable in interface.inputs or variable in interface.outputs:
                continue
            try:
                value = self._session[f"{name}.{variable}"]
            except BadInput:  # of an effect that is off, or nothing that has a value before the start
                continue
            if isinstance(value, bool | float | int | str):
                parameters.append({"name": variable, "unit": declaration.unit, "value": value})
        return {
            "name": name,
            "title": interface.title,
            "inputs": [_input(s, self._session[f"{name}.{s.name}"]) for s in free],
            "parameters": parameters,
            "outputs": [{"name": n, "unit": s.unit} for n, s in interface.outputs.items() if not s.is_text],
        }

    # -- what is done with it --------------------------------------------------------------------------------------------
    def begin(self, values: Mapping[str, Setting]) -> dict[str, Any]:
        """Begin anew with start values of parameters and inputs. Raises `BadInput`, `StepFailed`."""
        self._session.reset()
        self._moves.clear()
        self.failure = ""
        inputs = {name: value for name, value in values.items() if self._is_input(name)}
        for name, value in values.items():
            self._session[name] = value
        self._starts = inputs
        self._session.initialize()
        self._session.record()
        return self.description()

    def _is_input(self, name: str) -> bool:
        unit, _, variable = name.partition(".")
        interfaces = self._session.scene.coupling.interfaces
        return unit in interfaces and variable in interfaces[unit].inputs

    def move(self, name: str, value: Setting) -> None:
        """Set an input that nothing drives, from this instant on. Raises `BadInput`, `StepFailed`."""
        self._session[name] = value
        self._moves.append(Move(self._session.time, name, value))

    def advance(self, to: float, names: Sequence[str]) -> dict[str, Any]:
        """Steps up to a time, s, or to the end: times and outputs at up to `POINTS` instants on the way, and whether it is over.

        A step that fails ends the way; the answer has its message.
        """
        session = self._session
        begin, end = session.time, min(to, session.scene.stop_time)
        count = max(min(POINTS, round((end - begin) / session.scene.master.step)), 1)
        times, rows = [], []
        try:
            for k in range(1, count + 1):
                target = begin + (end - begin) * k / count - ROUNDED * session.scene.master.step
                if session.done or target <= session.time:
                    continue
                session.until(target)
                times.append(session.time)
                rows.append([known(v) for v in session.values(names).tolist()] if names else [])
        except StepFailed as error:
            self.failure = str(error)
        return {"times": times, "rows": rows, "time": session.time, "done": session.done, "failure": self.failure}

    def present(self, names: Sequence[str]) -> dict[str, Any]:
        """The outputs at the present instant."""
        return {"times": [self._session.time], "rows": [self._session.values(names).tolist() if names else []]}

    def file(self, suffix: str) -> bytes:
        """All that was recorded, a row for each macro step, as a file of `Result.export`."""
        with TemporaryDirectory() as folder:
            return self._session.result().export(Path(folder) / f"signals{suffix}").read_bytes()

    # -- how far it can be trusted ---------------------------------------------------------------------------------------
    def errors(self) -> list[dict[str, Any]]:
        """Numerical errors of what was recorded so far: the same moves once more with half of every step, and a quarter if need be.

        A row for each signal: rms and largest error as shares of its standard deviation. Raises `BadInput` before a step,
        `StepFailed` where the finer run fails.
        """
        if self._session.time <= self._session.scene.start_time or self.failure:
            raise BadInput("errors", self.failure or "no step yet", "a run that has come further", "Run it, then ask again.")
        result, end = self._session.result(), self._session.time
        first = differences(result, half := self._again(2, end))
        second = differences(half, self._again(4, end)) if needs_third(first) else None
        return [
            {"name": name, "rms": known(one.rms), "largest": known(one.largest), "parted": one.parted}
            for name, one in signal_errors(first, second).items()
        ]

    def _again(self, parts: int, end: float) -> Result:
        scene = self._session.scene
        with Session(scene.with_changes(shorter(scene, parts))) as finer:
            for name, value in self._starts.items():
                finer[name] = value
            finer.initialize()
            finer.record()
            for time, name, value in self._moves:
                finer.until(time)
                finer[name] = value
            finer.until(end)
            return finer.result()

    def close(self) -> None:
        """Close the units."""
        self._session.close()


def _input(signal: Signal, value: Any) -> dict[str, Any]:
    return {"name": signal.name, "unit": signal.unit, "value": value, "kind": signal.kind, "nominal": signal.nominal}
