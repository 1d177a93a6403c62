"""Columns that an answer needs: refused before the first run where no run has them, behind it where only a run can tell."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

from ....components.core.errors import BadInput, nearest
from ...run.key_results import STATISTICS
from ...scene.scene import Scene
from ...settings.plan import KeepSettings, PlanSettings
from ...settings.study import wanted
from ..studies.quantities import quantities_of
from .measures import Task


def is_quantity(name: str) -> bool:
    """Whether it is the name of a quantity that is a number, "unit.output, kind"."""
    if "," in name:
        with suppress(BadInput):
            return wanted(name).kind != "time history"
    return False


def as_column(name: str) -> str:
    """A quantity as the columns of a sweep have it; other names as they are."""
    return str(wanted(name)) if is_quantity(name) else name


def column_name(names: Iterable[str], name: str, where: str, others: Iterable[str] = ()) -> str:
    """A quantity as the columns of a sweep have it; raises `BadInput` with near names, `others` among them."""
    key, names = as_column(name), list(names)
    if key not in names:
        raise BadInput(
            where,
            repr(name),
            'a figure of summary.json, "unit.output, kind", or what an own function gives',
            nearest(name, [*names, *others]),
        )
    return key


def check_columns(task: Task, names: Iterable[str], where: str) -> bool:
    """Refuse, before the first run, columns that no run of a task has. Whether all are known: figures of a system, and numbers of
    a function of one's own, are known from the first run on."""
    scene, all_known = task.scene(), True
    known = [q.name for q in quantities_of(scene) if q.kind != "time history"] if scene.study.quantities else []
    statistics = [f"{'.'.join(end)}, {kind}" for end in scene.coupling.signals for kind in STATISTICS]
    known += statistics if task.keep.statistics else []
    for name in names:
        figure = ", " not in name and task.summarize is not None and bool(scene.analysis.system)
        if as_column(name) not in known and (figure or task.keep.functions):
            all_known = False
        else:
            column_name(known, name, where, statistics)
    return all_known


def keep_for(names: Iterable[str], keep: KeepSettings) -> KeepSettings:
    """What must be kept of a run for columns of these names, and no more."""
    quantities = [n for n in names if is_quantity(n)]
    return KeepSettings(
        statistics=False,
        summary=any(n not in quantities for n in names),
        quantities=tuple(dict.fromkeys([*keep.quantities, *quantities])),
        functions=keep.functions,
    )


def for_columns(
    scene: Scene, settings: PlanSettings, quantities: Sequence[str], answer: str, others: Iterable[str] = ()
) -> tuple[list[str], PlanSettings]:
    """(the columns that an answer is about, the plan that keeps no more than they and its limits need).

    By default the numbers, not the time histories, of the plan and of [study], and `others`. Raises `BadInput` without any.
    """
    own = [q for q in [*settings.keep.quantities, *scene.study.quantities] if is_quantity(q)]
    names = list(quantities) or list(dict.fromkeys([*own, *others]))
    if not names:
        raise BadInput(answer, "no quantity", "one or more", 'Give --quantity "unit.output, maximum".')
    return names, settings.model_copy(update={"keep": keep_for([*names, *settings.limits], settings.keep)})
