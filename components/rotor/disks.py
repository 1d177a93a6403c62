"""Rigid disks on a shaft: four of numbers, or any number from a table."""

from __future__ import annotations

import numpy as np

from ..core.columns import table_of
from ..core.component import Effect
from ..core.errors import BadInput, counted, nearest
from ..core.variables import parameter, text
from .elements import Disk, solid_disk

MAX_DISKS = 4
STEEL = 7810.0  # kg/m³
NO_DISK = Disk(0.0, 0.0, 0.0)
DEFAULT_DISKS = (solid_disk(0.28, 0.05, 0.07, STEEL), solid_disk(0.35, 0.05, 0.07, STEEL), NO_DISK, NO_DISK)
COLUMNS = {("position",): "m", ("mass", "m"): "kg", ("polar_inertia", "Ip"): "kg.m2", ("diametral_inertia", "Id", "It"): "kg.m2"}


class Disks(Effect):
    """Rigid disks on the shaft; a disk of mass and inertia 0 is none. `elements.solid_disk` gives the numbers of a size."""

    explicit_only = True
    read_by = ("initialize",)
    either_in = ("initialize",)

    position = parameter((0.5, 1.0, 0.0, 0.0), "m", "place of a disk on the shaft", size=MAX_DISKS, low=0.0)
    mass = parameter(tuple(d.mass for d in DEFAULT_DISKS), "kg", "mass of a disk", size=MAX_DISKS, low=0.0)
    polar_inertia = parameter(
        tuple(d.polar_inertia for d in DEFAULT_DISKS), "kg.m2", "inertia about the shaft's axis", size=MAX_DISKS, low=0.0
    )
    diametral_inertia = parameter(
        tuple(d.diametral_inertia for d in DEFAULT_DISKS), "kg.m2", "inertia about a diameter", size=MAX_DISKS, low=0.0
    )


class DiskTable(Effect):
    """Disks from a CSV table, a row for each: impellers, wheels, halves of couplings, as many as there are.

    Columns: `position`, `mass` (or `m`), `polar_inertia` (or `Ip`), `diametral_inertia` (or `Id`), such as `mass [kg]`. The rows may
    stand in any order; the first four are those that `unbalance` counts.
    """

    requires = ("disks",)
    replaces = ("disks.position", "disks.mass", "disks.polar_inertia", "disks.diametral_inertia")
    explicit_only = True
    read_by = ("initialize",)
    either_in = ("initialize",)

    table = text(
        "position [m],mass [kg],Ip [kg.m2],Id [kg.m2]\n0.5,32.59,0.3296,0.1781\n1.0,51.53,0.8052,0.4237\n",
        "disks as a CSV table; a scene may name its file",
    )


def disks_of(table_text: str, where: str) -> np.ndarray:
    """(n, 4) position, mass, polar and diametral inertia of the disks of a table.

    Raises `BadInput`, with the line, for unknown and missing columns, empty cells, negative numbers, and rows without any inertia.
    """
    table = table_of(table_text, where)
    table.only([name for names in COLUMNS for name in names], ", ".join(names[0] for names in COLUMNS))
    if not table.rows:
        raise BadInput(where, "no row", "a row for each disk")
    rows = np.zeros((len(table.rows), len(COLUMNS)))
    for k, (names, unit) in enumerate(COLUMNS.items()):
        there = [name for name in names if table.place(name) is not None]
        if len(there) != 1:
            raise BadInput(where, f"{counted(len(there), 'column')} of {names[0]}", "one", nearest(names[0], table.names))
        rows[:, k] = table.numbers(there[0], unit, asked=True)
    for (line, _), row in zip(table.rows, rows, strict=True):
        if not (np.all(row >= 0.0) and row[1:].sum() > 0.0):
            numbers = f"a disk at {row[0]:g} m with {row[1]:g} kg, Ip {row[2]:g} and Id {row[3]:g} kg.m2"
            raise BadInput(f"{where}, line {line}", numbers, "numbers of 0 or more in all columns, and a mass or an inertia")
    return rows
