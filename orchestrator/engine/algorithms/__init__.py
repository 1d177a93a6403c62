"""Master algorithms by the name a scene calls them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from ...settings import SceneSettings
from ...settings.algorithms import ALGORITHMS
from ...units import Simulator
from ..coupling import Coupling, Endpoint
from .master import Master

__all__ = ["Master", "class_of", "master_of"]


def class_of(algorithm: str) -> type[Master]:
    """The class of an algorithm."""
    module, _, name = ALGORITHMS[algorithm].place.partition(":")
    algorithm_class: type[Master] = getattr(import_module(f".{module}", __name__), name)
    return algorithm_class


def master_of(
    scene: SceneSettings, units: Mapping[str, Simulator], coupling: Coupling, watched: Sequence[Endpoint] = ()
) -> Master:
    """The master that a scene asks for, with its resolved coupling; `watched`: outputs to read in every step in any case."""
    given = scene.master
    own: dict[str, Any] = {"iteration": given.iteration} if given.abilities.iterates else {}
    return class_of(given.algorithm)(
        units,
        coupling,
        watched,
        degree=given.extrapolation,
        feedthrough=given.feedthrough,
        order=given.order,
        smoothing=given.smoothing,
        moving_places=given.moving_places,
        end=scene.stop_time,
        **own,
    )
