"""A component of a scene as a native FMU, which was built for its effects, parameters and initial inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .component import make
from .description import Description, read
from .fmi2 import Fmi2CoSimulation
from .interface import PortValues, Span

if TYPE_CHECKING:
    from ...components.core.component import Component
    from ..settings import UnitSettings


@dataclass(frozen=True)
class NativeFmu:
    """The file, and the inputs at which the initial state in it was computed."""

    path: str
    starts: Mapping[str, float]


class NativeSimulator(Fmi2CoSimulation):
    """A native FMU of a component; it begins with the inputs of its build, whatever others an initialization tries first."""

    kind = "native FMU"

    def __init__(self, name: str, description: Description, fmu: NativeFmu, component: Component, span: Span):
        self._starts = fmu.starts
        super().__init__(name, description, {}, None, component, span)
        self._constants = dict(component.parameters)

    def initialize(self, t: float, values: PortValues) -> None:
        starts: PortValues = [self._starts[n] for n in self._input_names]
        super().initialize(t, np.array(starts) if isinstance(values, np.ndarray) else starts)

    def parameters(self) -> dict[str, Any]:
        return self._constants


def open_native(name: str, settings: UnitSettings, fmu: NativeFmu, span: Span) -> NativeSimulator:
    """The running unit of a component whose FMU is built."""
    return NativeSimulator(name, read(fmu.path, f"units.{name}"), fmu, make(name, settings), span)
