"""A table over time, whose columns are outputs: a component that is made of it when a scene is read."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np

from ....components.core.component import TABLES, Component
from ....components.core.errors import BadInput
from ....components.core.signals import KNOWN, LOOKED_AT
from ....components.core.variables import Variable
from ...settings.units import TABLE_KEYS
from ..interface import Interface
from ..signal_files import SUFFIXES, read_signals
from .component import ComponentKind
from .kind import UnitKind

MISSED = 0.01  # of a signal's deviation, rms: what steps may miss of it without a warning


class SignalsKind(ComponentKind):
    """A table of signals. It always runs in this process: a step of it ends before a jump, and the master lets the jump happen,
    which FMI has no call for."""

    key = "signals"
    is_file = True
    suffixes = SUFFIXES
    has_native_form = False
    label = UnitKind.label

    def opened_as(self, in_process: bool) -> str:
        return "component"

    def prepared(self, entry: Mapping[str, Any]) -> Mapping[str, Any]:
        for key in ("component", "fmu"):
            if (other := entry.get(key)) and not str(other).startswith(TABLES):
                raise BadInput(self.where, f"{key} and signals exclude each other", "", "Remove one.")
        parameters = entry.get("parameters", {})
        if isinstance(parameters, Mapping):
            parameters = {**{key: entry[key] for key in TABLE_KEYS if entry.get(key) is not None}, **parameters}
        others = {key: value for key, value in entry.items() if key not in TABLE_KEYS}
        table = read_signals(self.value, f"{self.where}.signals")
        return {**others, "component": table.__name__, "parameters": parameters}

    @cached_property
    def component_class(self) -> type[Component] | None:  # type: ignore[override]
        """None of a result's table that is gone, or is another by now."""
        with suppress(BadInput):
            self._read_for_a_result()
        return KNOWN.get(self.settings.component)

    @property
    def variables(self) -> Mapping[str, Variable]:
        """None of a table that is gone."""
        return self.component_class.variables if self.component_class else {}

    def _read_for_a_result(self) -> None:
        """The table of the scene of a stored result, which this process has not read; raises `BadInput` where it is another now."""
        if self.settings.component in KNOWN:
            return
        if read_signals(self.value, f"{self.where}.signals").__name__ != self.settings.component:
            raise BadInput(self.where, f"{self.value}, which has changed since the run", "the table that the run has read")

    def describe(self, name: str) -> Interface:
        self._read_for_a_result()
        return super().describe(name)

    @property
    def holds(self) -> bool:  # type: ignore[override]
        return self.settings.parameters.get("interpolation") == "hold"

    @property
    def repeats(self) -> bool:  # type: ignore[override]
        return self.settings.parameters.get("outside") == "repeat"

    def jump_times(self, begin: float, end: float) -> list[float]:
        return self._table.jump_times(self.settings.parameters, begin, end)

    @property
    def _table(self) -> Any:
        return self.component_class

    def missed(self, step: float) -> str:
        """Of a table whose rows lie closer than the macro steps, where straight lines from step to step miss something of them."""
        if self.holds:
            return ""
        rows = self._table.table[:LOOKED_AT]
        times = rows[:, 0]
        spacing = float(np.median(np.diff(times))) if len(rows) > 1 else step
        if not 0.0 < spacing < 0.999 * step:
            return ""
        ends = np.arange(times[0], times[-1] + step, step)
        at_jumps = np.floor((times[1:][np.diff(times) == 0.0] - times[0]) / step)
        smooth = ~np.isin(np.floor((times - times[0]) / step), at_jumps)
        shares = {}
        for column, values in zip(self._table.columns(), rows[:, 1:].T, strict=True):
            chords = np.interp(times, ends, np.interp(ends, times, values))
            if (deviation := float(np.std(values))) > 0.0:
                shares[column] = float(np.sqrt(np.mean(np.where(smooth, values - chords, 0.0) ** 2))) / deviation
        if not shares or (share := max(shares.values())) <= MISSED:
            return ""
        return (
            f"{step / spacing:.3g} rows in a macro step of {step:g} s. Between the ends of its steps the scene goes by "
            f"straight lines, which miss {100.0 * share:.2g} % of the deviation of {max(shares, key=shares.__getitem__)}. "
            f"Reduce master.step, at most to {spacing:.3g} s"
        )

    def refuse_run(self, begin: float, end: float, scene: str) -> None:
        """Of which the table covers only a part, unless it goes on there."""
        given = self.settings.parameters
        if given.get("outside", "refuse") != "refuse":
            return
        first, last = (float(t) + float(given.get("start", 0.0)) for t in self._table.table[[0, -1], 0])
        doubt = 1e-12 * max(abs(end), abs(begin))
        if begin < first - doubt or end > last + doubt:
            raise BadInput(
                f"{scene}: {self.where}",
                f"a run from {begin:.9g} to {end:.9g} s",
                f"a run within {os.path.basename(self.value)}, {first:.9g} to {last:.9g} s",
                'Change stop_time or start, or write outside = "hold" or "repeat".',
            )
