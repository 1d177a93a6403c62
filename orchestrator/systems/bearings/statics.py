"""Static equilibrium of a bearing for a case: found, or the case ends; a search that failed must not become a row or a curve."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ....components.bearings.deep_groove import DeepGrooveBearing
from ....components.bearings.loads import StaticLoads
from ....components.core.errors import StepFailed
from ....components.core.kernels import DONE, REASONS


def at_rest(bearing: DeepGrooveBearing, forces: np.ndarray, held: Collection[str] = ()) -> StaticLoads:
    """`DeepGrooveBearing.equilibrium`; raises `StepFailed` unless it was found within the model's range."""
    loads = bearing.equilibrium(forces, held)
    if loads.status != DONE:
        raise StepFailed(bearing.name, bearing.t, *REASONS[loads.status])
    return loads
