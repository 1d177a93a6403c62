"""FMUs for model exchange by version of FMI: functions that have other names or arguments in each."""

from __future__ import annotations

import ctypes
from math import inf
from typing import Any

from fmpy.fmi2 import FMU2Model, fmi2EventInfo
from fmpy.fmi3 import FMU3Model

from .fmi2 import Fmi2Simulator
from .fmi3 import Fmi3Simulator
from .fmu_simulator import DiscreteStates
from .model_exchange import ModelExchange


class Fmi2ModelExchange(ModelExchange, Fmi2Simulator):
    """Of FMI 2.0."""

    fmpy_class = FMU2Model

    def _sizes(self) -> tuple[int, int]:
        model = self.description.model
        return len(model.derivatives), int(model.numberOfEventIndicators or 0)

    def _update_states(self) -> DiscreteStates:
        info = fmi2EventInfo()
        self._call("NewDiscreteStates", ctypes.pointer(info))
        return DiscreteStates(
            bool(info.newDiscreteStatesNeeded),
            bool(info.terminateSimulation),
            bool(info.nominalsOfContinuousStatesChanged),
            info.nextEventTime if info.nextEventTimeDefined else inf,
        )


class Fmi3ModelExchange(ModelExchange, Fmi3Simulator):
    """Of FMI 3.0: the numbers of states and indicators may follow from structural parameters."""

    truth_value = ctypes.c_bool
    derivatives_function = "GetContinuousStateDerivatives"

    def _instantiate(self) -> Any:
        fmu = FMU3Model(
            instanceName=self.name,
            guid=self.description.model.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self._interface().modelIdentifier,
        )
        fmu.instantiate(loggingOn=True, logMessage=self._logged)
        return fmu

    def _sizes(self) -> tuple[int, int]:
        sizes = (ctypes.c_size_t(), ctypes.c_size_t())
        for name, size in zip(("ContinuousStates", "EventIndicators"), sizes, strict=True):
            self._call(f"GetNumberOf{name}", ctypes.pointer(size))
        return sizes[0].value, sizes[1].value
