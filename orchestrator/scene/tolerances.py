"""Tolerances of a scene's parameters: standard deviations, with the correlations that the scene states; others are independent."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...components.core.errors import BadInput
from ...components.core.measure import number_in
from ..settings.names import names_in
from ..units.component import make
from .names import declared, place_of
from .written_units import tolerance_of

if TYPE_CHECKING:
    from .scene import Scene


class Tolerances(NamedTuple):
    """names: (n,) "unit.parameter".  values: of the parameters.  deviations: standard deviations, in the parameters' units.
    correlation: (n, n)."""

    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    correlation: np.ndarray

    @property
    def covariance(self) -> np.ndarray:
        """(n, n)."""
        return self.correlation * np.outer(self.deviations, self.deviations)


def tolerances_of(scene: Scene) -> Tolerances | None:
    """Those of a scene, None without any; raises `BadInput` for a share of 0, and for correlations that cannot be together."""
    values, deviations = {}, {}
    for unit, settings in scene.units.items():
        component = make(unit, settings) if settings.tolerances and unit in scene.component_classes else None
        for name, tolerance in settings.tolerances.items():
            start = component.get(name) if component is not None else declared(scene, unit)[name].start
            value = values[f"{unit}.{name}"] = float(settings.parameters.get(name, start) if component is None else start)
            where = f"{scene.name}: units.{unit}.tolerances.{name}"
            share = isinstance(tolerance, str)
            if share and not value:
                raise BadInput(where, f"{tolerance} of 0", "a tolerance in the unit of the parameter")
            deviations[f"{unit}.{name}"] = number_in(str(tolerance), "1", where) * abs(value) if share else float(tolerance)
    if not values:
        return None
    names = tuple(values)
    correlation = np.eye(len(names))
    for pair, r in scene.correlations.items():
        i, j = (names.index(name) for name in names_in(pair))
        correlation[i, j] = correlation[j, i] = r
    if np.linalg.eigvalsh(correlation)[0] < -1e-9:
        raise BadInput(
            f"{scene.name}: correlations", "a matrix that is not positive semidefinite", "correlations of one distribution"
        )
    return Tolerances(names, np.array(list(values.values())), np.array(list(deviations.values())), correlation)


def with_tolerances(scene: Scene, names: Sequence[str], covariance: np.ndarray) -> Scene:
    """The scene with the standard deviations and correlations (n, n) of some parameters, in the place of those that it has of them.

    Settings that no tolerance can be of, and deviations that are not finite, are left out.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        deviations = np.sqrt(np.diag(covariance))
        correlation = np.clip(covariance / np.outer(deviations, deviations), -1.0, 1.0)
    units: dict[str, dict[str, Any]] = {}
    known = []
    for k, name in enumerate(names):
        place = place_of(scene, name)
        if not place.parameter:
            continue
        with suppress(BadInput):
            tolerance_of(scene.kinds[place.unit], place.parameter, float(deviations[k]), name)
            units.setdefault(place.unit, dict(scene.units[place.unit].tolerances))[place.parameter] = float(deviations[k])
            known.append((f"{place.unit}.{place.parameter}", k))
    pairs = {  # of deviations that are 0 there is none
        f"{a}, {b}": float(r) for n, (a, i) in enumerate(known) for b, j in known[:n] if np.isfinite(r := correlation[i, j]) and r
    }
    others = {p: r for p, r in scene.correlations.items() if not {*names_in(p)} & {n for n, _ in known}}
    return scene.with_changes({**{f"units.{u}.tolerances": t for u, t in units.items()}, "correlations": others | pairs})
