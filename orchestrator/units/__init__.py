"""Units behind one protocol, and how a scene's entry becomes one; what an entry may be: `kinds`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...components.core.errors import BadInput
from ..settings import UnitSettings
from .interface import WITHOUT_END, Interface, Simulator, Span
from .kinds import kind_of

if TYPE_CHECKING:
    from .native import NativeFmu


def describe(name: str, settings: UnitSettings) -> Interface:
    """Names, units of measure and capabilities of a unit, without starting it; `BadInput` for what does not fit."""
    return kind_of(settings, f"units.{name}").describe(name)


def open_unit(
    name: str, settings: UnitSettings, *, in_process: bool, native: NativeFmu | None = None, span: Span = WITHOUT_END
) -> Simulator:
    """A running unit. Components of the catalogue run as FMUs unless `in_process`; the results are bit-identical.

    `native`: the native FMU of a component, which is run instead.  span: what FMUs are told of the run.
    """
    kind = kind_of(settings, f"units.{name}").made_ready()
    if settings.time_limit is not None and not (kind.in_worker or kind.once):
        raise BadInput(
            f"{kind.where}.time_limit", f"{settings.time_limit:g} s without isolation", 'isolation = "process" as well'
        )
    if kind.in_worker:
        from .process import WorkerSimulator

        return WorkerSimulator(name, kind, in_process=in_process, native=native, span=span)
    if native is not None:
        from .native import open_native

        return open_native(name, settings, native, span)
    return kind.open(name, in_process, span)


__all__ = ["Interface", "Simulator", "Span", "describe", "open_unit"]
