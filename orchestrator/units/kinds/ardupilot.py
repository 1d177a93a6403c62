"""An autopilot in another process, which a run talks to over UDP."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput
from ..ardupilot import CHANNELS, MOTION, PATIENCE, ArduPilot, address_of
from ..interface import Interface, Signal, Simulator, Span
from .kind import UnitKind


class ArduPilotKind(UnitKind):
    """ArduPilot's software in the loop, by its JSON interface at an address of this machine."""

    key = "ardupilot"
    outside = "an autopilot in another process"
    once = "an autopilot flies once"

    def describe(self, name: str) -> Interface:
        address_of(self.value, f"{self.where}.ardupilot")
        if self.settings.parameters:
            given = ", ".join(self.settings.parameters)
            raise BadInput(f"{self.where}.parameters", given, "no parameters", "An autopilot has its own; set them there.")
        outputs = {f"command[{i}]": Signal(f"command[{i}]", "1", discrete=True) for i in range(1, CHANNELS + 1)}
        return Interface(
            title="ArduPilot, software in the loop",
            inputs={n: Signal(n, unit) for n, unit in MOTION.items()},
            outputs=outputs,
            effects={},
            saves_state=False,
            packs_state=False,
            arrays={"command": tuple(outputs)},
        )

    def open(self, name: str, in_process: bool, span: Span) -> Simulator:
        address = address_of(self.value, f"{self.where}.ardupilot")
        return ArduPilot(name, self.where, address, self.settings.time_limit or PATIENCE)

    def opened_as(self, in_process: bool) -> str:
        return "autopilot"

    @property
    def variables(self) -> Mapping[str, Signal]:
        return {n: Signal(n, unit) for n, unit in MOTION.items()}

    @property
    def parameters(self) -> Mapping[str, Any]:
        return {}

    def number_of(self, parameter: str, text: str) -> Any:
        return text

    def fmu_file(self) -> Path:
        raise BadInput(self.where, "an autopilot", "units that are FMUs or components", "It runs in a process of its own.")

    def fmu_values(self, name: str) -> dict[str, Any]:
        return {}
