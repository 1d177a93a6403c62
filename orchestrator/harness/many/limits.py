"""Rows of validation tables as limits of columns, and whether runs keep them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from ....components.core.errors import BadInput, pick
from ...scene.file_kinds import refuse_other
from ...scene.files import read_toml
from ...settings.answers import DesignSettings
from ...settings.plan import KeepSettings, LimitSettings, PlanSettings, RowsSettings
from ..validation.reference import (
    MISSING,
    Table,
    TableRow,
    functions,
    load_table,
    named_function,
    rows_of,
    table_files,
    table_rows,
)
from .columns import as_column, column_name

if TYPE_CHECKING:
    from ...scene.scene import Scene

S = TypeVar("S", PlanSettings, DesignSettings)
Limits = Mapping[str, LimitSettings]


def with_rows(
    settings: S, folder: Path = Path(), table: str = "", conditions: Sequence[str] = (), scene: Scene | None = None
) -> S:
    """A plan or a design with the rows of its table among its limits, and what gives their measures among what is kept.

    `folder`: of a table's file.  `table`, `conditions`: another table than that of the settings.  `scene`: of the runs, which says which
    conditions hold where none is given and the table can tell, and which objects each have the rows.  Raises `BadInput`.
    """
    wanted_rows = RowsSettings(table=table, conditions=tuple(conditions)) if table else settings.rows
    if conditions and not table:
        raise BadInput("--condition", ", ".join(map(repr, conditions)), "a table, too", "Give --limits TABLE.")
    if wanted_rows is None:
        return settings
    given = table_of(wanted_rows.table, Path() if table else folder)
    if scene is not None and given.scene_conditions and settings.vary and not wanted_rows.conditions:
        held = named_function(given.scene_conditions)(scene, settings.vary)
        wanted_rows = wanted_rows.model_copy(update={"conditions": tuple(held)})
    function = given.measures
    chosen = rows_under(given.rows, wanted_rows)
    if missing := [r.quantity for r in chosen if r.standing == MISSING]:
        raise BadInput(
            f"rows: table {wanted_rows.table}",
            f"{len(missing)} of {len(chosen)} rows without a range, such as {missing[0]!r}",
            "a range with its source in every row",
            "Fill in these rows, or remove them.",
        )
    field = "limits" if isinstance(settings, PlanSettings) else "constraints"
    own: Limits = getattr(settings, field)
    objects = named_function(given.objects)(scene) if scene is not None and given.objects else ()
    limits = {
        f"{n}{'.' if n else ''}{as_column(r.measure)}": _limit(r, n)
        for n in (objects if len(objects) > 1 else ("",))
        for r in chosen
    }
    if twice := sorted(limits.keys() & own.keys()):
        raise BadInput(
            field,
            f"{twice[0]!r}, which table {wanted_rows.table} has, too",
            "one range a column",
            f"Remove it from [{field}], or name other conditions of the table.",
        )
    quantities: list[str] = [] if function else [c for c in limits if "," in c]
    functions: list[str] = [function] if function else []
    kept: KeepSettings = settings.keep
    keep = kept.model_copy(
        update={
            "quantities": tuple(dict.fromkeys([*kept.quantities, *quantities])),
            "functions": tuple(dict.fromkeys([*kept.functions, *functions])),
        }
    )
    return settings.model_copy(update={field: {**own, **limits}, "keep": keep, "rows": None})


def check_limits(limits: Limits, units: Mapping[str, str]) -> None:
    """Refuse limits of columns that runs do not have, and those in another unit. units: by column; "" where it is not known."""
    for name, limit in limits.items():
        column_name(units, name, "limits")
        if limit.unit and units[name] not in ("", limit.unit):
            raise BadInput(f"limits: {name}", f"unit {limit.unit!r}", f"{units[name]!r}, which the column has")


def unconfirmed(limits: Limits) -> list[str]:
    """A sentence that names the limits whose ranges are quoted from memory; none without any."""
    names = [limit.quantity or name for name, limit in limits.items() if limit.standing == "unconfirmed"]
    return [f"unconfirmed ranges, which no run passes or fails by: {'; '.join(names)}"] if names else []


def _limit(row: TableRow, of: str = "") -> LimitSettings:
    where = ", ".join(filter(None, (of, row.condition)))
    words = f"{row.quantity} ({where})" if where else row.quantity
    return LimitSettings.model_validate(
        {
            "low": None if row.low is None else float(row.low),
            "quantity": words,
            "unit": row.unit,
            "high": None if row.high is None else float(row.high),
            "standing": row.standing,
            "source": row.source,
        }
    )


def table_of(name: str, folder: Path = Path()) -> Table:
    """A shipped table, or that of a user's TOML file with sources and rows. Raises `BadInput`."""
    if not name.endswith(".toml"):
        if name not in table_files():
            refuse_other(folder / name, "table")
        table = load_table(name)
        if not (table.measures or table.rules):
            raise BadInput(
                "rows: table",
                repr(name),
                "a table whose rows are of any run of a scene",
                f"The rows of {name} are of its case's own runs.",
            )
        return table
    if not (folder / name).is_file():
        raise BadInput("rows: table", repr(name), "the name of a shipped table, or a TOML file", f"There is no {folder / name}.")
    data = read_toml(folder / name, "table", "case")
    for key, kind in (("sources", Mapping), ("rows", list | str)):
        if not isinstance(data.get(key, {} if key == "sources" else None), kind) or (key == "rows" and not data[key]):
            raise BadInput(name, f"no {key!r}", "sources and rows, as in a case of one's own")
    given = rows_of(name, data, (folder / name).parent)
    rows = table_rows(name, [{"condition": "", **row} for row in given], data.get("sources", {}))
    return Table(name, str(data.get("title", name)), "", rows, (), **functions(data))


def rows_under(rows: Sequence[TableRow], settings: RowsSettings, unique: bool = True) -> list[TableRow]:
    """Rows of the conditions; unique: one of each measure, which is checked."""
    where, known = f"rows: table {settings.table}", list(dict.fromkeys(r.condition for r in rows))
    for condition in settings.conditions:
        pick(condition, known, where, "one of " + ", ".join(map(repr, known)), "condition")
    chosen = [r for r in rows if not settings.conditions or r.condition in settings.conditions]
    measures = [as_column(r.measure) for r in chosen] if unique else []
    for measure in measures:
        if measures.count(measure) > 1:
            clashing = [r.condition for r in chosen if as_column(r.measure) == measure]
            raise BadInput(
                where,
                f"{len(clashing)} ranges of {measure}, under {', '.join(map(repr, clashing))}",
                "conditions that hold together",
                'Give conditions = ["..."] or --condition "...".',
            )
    return chosen
