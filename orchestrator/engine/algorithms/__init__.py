"""Master algorithms by the name a scene calls them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...settings import SceneSettings
from ...units import Unit
from ..coupling import Coupling, Endpoint
from .gauss_seidel import GaussSeidel
from .interface_model import InterfaceModel
from .iterative import Iterative
from .jacobi import Jacobi
from .master import Master

ALGORITHMS: dict[str, type[Master]] = {"jacobi": Jacobi, "gauss-seidel": GaussSeidel, "iterative": Iterative,
                                      "interface-model": InterfaceModel}

__all__ = ["ALGORITHMS", "Master", "master_of"]


def master_of(scene: SceneSettings, units: Mapping[str, Unit], coupling: Coupling, watched: Sequence[Endpoint] = ()) -> Master:
    """The master that a scene asks for, with its resolved coupling; `watched`: outputs to read in every step in any case."""
    given = scene.master
    own: dict[str, Any] = {"iteration": given.iteration} if given.algorithm == "iterative" else {}
    return ALGORITHMS[given.algorithm](
        units, coupling, watched, degree=given.extrapolation, feedthrough=given.feedthrough, order=given.order,
        smoothing=given.smoothing, moving_places=given.moving_places, end=scene.stop_time, **own,
    )
