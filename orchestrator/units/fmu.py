"""Any FMU of FMI 2.0 or 3.0 as a unit: which class a scene's entry needs, and with what values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .description import read
from .fmu_interface import describe_fmu
from .values import checked_values

if TYPE_CHECKING:
    from ..settings import UnitSettings
    from .fmu_simulator import FmuSimulator


def open_fmu(name: str, settings: UnitSettings) -> FmuSimulator:
    """The running FMU of a scene's entry; a component of the catalogue is built first if the cache has no FMU of it."""
    where = f"units.{name}"
    if settings.fmu:
        description = read(settings.fmu, f"{where}.fmu").chosen(settings, where).sized(settings.parameters, where)
        given: dict[str, Any] = {f"effects.{e}": True for e in settings.effects}
        given |= checked_values(description, settings, where)
        if description.exchange:
            from .model_exchange_versions import Fmi2ModelExchange, Fmi3ModelExchange

            exchange = Fmi3ModelExchange if description.fmi3 else Fmi2ModelExchange
            return exchange(name, description, given, settings.tolerance, settings.solver or "CVode")
        return _class(description)(name, description, given, settings.tolerance)
    from ...fmus.build import built
    from .component import make

    component = make(name, settings)
    starts = dict(zip(component.inputs, component.u[0].tolist(), strict=True))
    given = {f"effects.{e}": e in component.on for e in component.effects} | component.parameters | starts
    description = read(str(built(settings.component)), where)
    return _class(description)(name, description, given, None, component)


def _class(description: Any) -> type[FmuSimulator]:
    if description.fmi3:
        from .fmi3 import Fmi3CoSimulation

        return Fmi3CoSimulation
    from .fmi2 import Fmi2CoSimulation

    return Fmi2CoSimulation


__all__ = ["describe_fmu", "open_fmu"]
