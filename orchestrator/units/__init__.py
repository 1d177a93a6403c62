"""Kinds of units behind one protocol, and how a scene's entry becomes one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...components.core.errors import BadInput
from ..settings import UnitSettings
from .interface import WITHOUT_END, Interface, Simulator, Span

if TYPE_CHECKING:
    from .native import NativeFmu


def describe(name: str, settings: UnitSettings) -> Interface:
    """Names, units of measure and capabilities of a unit, without starting it; `BadInput` for what does not fit."""
    if settings.fmu:
        from .fmu import describe_fmu

        return describe_fmu(name, settings)
    from .component import describe_component

    return describe_component(name, settings)


def open_unit(
    name: str, settings: UnitSettings, *, in_process: bool, native: NativeFmu | None = None, span: Span = WITHOUT_END
) -> Simulator:
    """A running unit. Components of the catalogue run as FMUs unless `in_process`; the results are bit-identical. Tables of signals
    always run in this process: a step of theirs ends before a jump, and the master lets it happen, which FMI has no call for.

    `native`: the native FMU of a component, which is run instead.  span: what FMUs are told of the run.
    """
    if settings.time_limit is not None and settings.isolation == "none":
        raise BadInput(
            f"units.{name}.time_limit", f"{settings.time_limit:g} s without isolation", 'isolation = "process" as well'
        )
    if settings.isolation != "none":
        from .process import WorkerSimulator

        return WorkerSimulator(name, settings, in_process=in_process, native=native, span=span)
    if native is not None and not settings.signals:
        from .native import open_native

        return open_native(name, settings, native, span)
    if settings.fmu or not (in_process or ":" in settings.component or settings.signals):
        from .fmu import open_fmu

        return open_fmu(name, settings, span)
    from .component import ComponentSimulator, make

    return ComponentSimulator(name, make(name, settings))


__all__ = ["Interface", "Simulator", "Span", "describe", "open_unit"]
