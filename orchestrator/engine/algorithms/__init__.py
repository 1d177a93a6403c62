"""Master algorithms by the name a scene calls them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...settings import SceneSettings
from ...units import Simulator
from ..coupling import Coupling, Endpoint
from .algorithm import Algorithm, class_of
from .master import Master

__all__ = ["Algorithm", "Master", "class_of", "master_of"]


def master_of(
    scene: SceneSettings, units: Mapping[str, Simulator], coupling: Coupling, watched: Sequence[Endpoint] = ()
) -> Master:
    """The master that a scene asks for, with its resolved coupling; `watched`: outputs to read in every step in any case."""
    return Master(units, coupling, scene.master, watched, scene.stop_time)
