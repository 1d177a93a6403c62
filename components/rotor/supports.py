"""Supports that hold the shaft to the ground: two of numbers, or any number from a table, two by two and over the speed.

    f = -K(Omega) (x, y) - C(Omega) (x', y'),    K = [[kxx, kxy], [kyx, kyy]]

K and C follow the speed of rotation, as tables of bearings and seals in synchronous whirl give them. A coefficient is linear
between two rows of a support; beyond its rows there is none. Source: Friswell, Penny, Garvey & Lees, Dynamics of Rotating
Machines (2010), section 5.5, for the two by two matrices. Names of the columns are those of the program ROSS.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..core.columns import Columns, table_of
from ..core.component import Effect
from ..core.errors import BadInput
from ..core.kernels import kernel
from ..core.variables import parameter, text
from .model import HALF

STIFFNESSES, DAMPINGS = ("kxx", "kxy", "kyx", "kyy"), ("cxx", "cxy", "cyx", "cyy")
COEFFICIENTS = (*STIFFNESSES, *DAMPINGS)
UNITS = {"speed": "rad/s", **dict.fromkeys(STIFFNESSES, "N/m"), **dict.fromkeys(DAMPINGS, "N.s/m")}
LIKE = {"kyy": "kxx", "cyy": "cxx"}  # a column that is not there is another's, else 0
NODE, LEVER, FIRST = 0, 1, 2  # of a row of `s.supports`: first degree of freedom, lever, first of the eight coefficients


class LinearSupports(Effect):
    """Two places where springs and dampers hold the shaft to the ground; values of the rotor of the defaults."""

    explicit_only = True
    read_by = ("initialize",)
    either_in = ("initialize",)

    position = parameter((0.0, 1.5), "m", "place of a support on the shaft", size=2, low=0.0)
    stiffness_x = parameter(1e6, "N/m", "stiffness along x", size=2, low=0.0)
    stiffness_y = parameter(1e6, "N/m", "stiffness along y", size=2, low=0.0)
    damping_x = parameter(0.0, "N.s/m", "damping along x", size=2, low=0.0)
    damping_y = parameter(0.0, "N.s/m", "damping along y", size=2, low=0.0)


class SupportTable(Effect):
    """Supports with stiffness and damping from a CSV table: any number, coupled in x and y, constant or over the speed.

    Columns: `position`, `kxx`, `kxy`, `kyx`, `kyy`, `cxx`, `cxy`, `cyx`, `cyy`, and `speed` (or `frequency`), such as `speed [rpm]`.
    `kyy` and `cyy` are `kxx` and `cxx` where there is no such column, the others 0. The rows of one position are one support:
    a single row holds at all speeds, several are speeds that rise, between which the coefficients are linear.
    """

    explicit_only = True
    excludes = ("linear_supports",)
    read_by = ("initialize",)

    table = text(
        "position [m],speed [rad/s],kxx [N/m],kyy [N/m],cxx [N.s/m]\n0,0,1e6,1e6,100\n0,1000,1e6,2e6,100\n1.5,0,1e6,1e6,100\n",
        "supports as a CSV table; a scene may name its file",
    )


def supports_of(table_text: str, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Supports of a table: (n, 9) speed in rad/s and the numbers of `COEFFICIENTS`; (m, 3) position in m, first row and how many.

    Raises `BadInput`, with the line, for unknown and missing columns, empty cells, and speeds of a support that do not rise.
    """
    table = table_of(table_text, where)
    speed = "speed" if table.place("frequency") is None else "frequency"
    table.only(("position", speed, *COEFFICIENTS), ", ".join(("position", "speed", *COEFFICIENTS)))
    if not table.rows:
        raise BadInput(where, "no row", "a row for each support")
    place = np.round(_numbers(table, "position", "m"), 9)  # "300 mm" and "0.3 m" in cells are one support
    rows = np.zeros((place.size, 1 + len(COEFFICIENTS)))
    for k, name in enumerate((speed, *COEFFICIENTS)):
        name = name if table.place(name) is not None or name in ("kxx", "cxx") else LIKE.get(name, name)
        if table.place(name) is not None or name in ("kxx", "cxx"):
            rows[:, k] = _numbers(table, name, UNITS["speed" if name == speed else name])
    order = list(dict.fromkeys(place))
    spans = np.array([[p, 0.0, (place == p).sum()] for p in order])
    spans[1:, 1] = np.cumsum(spans[:-1, 2])
    for p in order:
        mine = np.flatnonzero(place == p)
        for a, b in pairwise(mine):
            if not rows[b, 0] > rows[a, 0]:
                raise BadInput(
                    f"{where}, line {table.rows[b][0]}",
                    f"{speed} {rows[b, 0]:g} rad/s behind {rows[a, 0]:g} rad/s of the support at {p:g} m",
                    "one row for each support, or speeds that rise",
                )
    return rows[np.argsort([order.index(p) for p in place], kind="stable")], spans


def _numbers(table: Columns, name: str, unit: str) -> np.ndarray:
    values = table.numbers(name, unit, asked=True)
    if np.isnan(values).any():
        raise BadInput(
            f"{table.where}, line {table.rows[int(np.argmax(np.isnan(values)))][0]}",
            f"no number of {name!r}",
            "a number in each row",
        )
    return values


@kernel
def beyond_rows(speed, s):
    """Whether a support of the table has rows over the speed that do not reach this one, rad/s."""
    for i in range(s.spans.shape[0]):
        first, count = int(s.spans[i, 1]), int(s.spans[i, 2])
        if count > 1 and not s.support_rows[first, 0] <= speed <= s.support_rows[first + count - 1, 0]:
            s.refused[0] = speed
            return True
    return False


@kernel
def follow_speed(speed, s):
    """The coefficients of the table's supports at a speed, rad/s, into `s.supports`."""
    for i in range(s.spans.shape[0]):
        row, last, share = int(s.spans[i, 1]), int(s.spans[i, 1] + s.spans[i, 2]) - 1, 0.0
        if last > row:
            while row < last - 1 and s.support_rows[row + 1, 0] <= speed:
                row += 1
            share = (speed - s.support_rows[row, 0]) / (s.support_rows[row + 1, 0] - s.support_rows[row, 0])
            last = row + 1
        for k in range(8):
            low = s.support_rows[row, 1 + k]
            s.supports[i, FIRST + k] = low + share * (s.support_rows[last, 1 + k] - low)


@kernel
def hold_shaft(held, s):
    """The two supports of `LinearSupports`, its values, into `s.supports`; their places are known."""
    for k in range(2):
        s.supports[k, FIRST], s.supports[k, FIRST + 3] = held.stiffness_x[k], held.stiffness_y[k]
        s.supports[k, FIRST + 4], s.supports[k, FIRST + 7] = held.damping_x[k], held.damping_y[k]


@kernel
def add_supports(supports, stiffness_share, damping_share, band):
    """Add shares of the supports' stiffness and damping to a band."""
    for i in range(supports.shape[0]):
        j = int(supports[i, NODE])
        for row in range(2):
            for column in range(2):
                k = FIRST + 2 * row + column
                band[j + row, HALF + column - row] += stiffness_share * supports[i, k] + damping_share * supports[i, k + 4]


@kernel
def support_force(support, row, q, v):
    """What a support, (10,), takes from the shaft along x (row 0) or y (1), N: the opposite of its force on the shaft."""
    j, k = int(support[NODE]), FIRST + 2 * row
    return support[k] * q[j] + support[k + 1] * q[j + 1] + support[k + 4] * v[j] + support[k + 5] * v[j + 1]
