"""Frames of tables: which figures of a run the numbers of a standard are about, for its owner to fill in.

No number of a standard is here. Chapters after the public contents list of IEC 63453:2025, which are those of EN 50318:2018 as
remembered; points after Commission Regulation (EU) No 1301/2014 with its amendments, where that text names them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...harness.summary import SummaryRow

OUTPUT = "chapter 9, output; ranges of the reference model: chapter 11"


class Frame(NamedTuple):
    """title: what the owner has at hand. places: figure of a pantograph, without its name -> where its number stands."""

    title: str
    places: dict[str, str]


def _of_simulation(title: str) -> Frame:
    figures = ("mean", "std", "std_0_5", "std_5_20", "max", "min", "height_range_mm", "uplift_mm", "loss_filtered")
    return Frame(title, dict.fromkeys(figures, OUTPUT))


FRAMES = {
    "iec63453": _of_simulation("IEC 63453:2025"),
    "en50318": _of_simulation("EN 50318:2018 with A1:2022"),
    "tsi-ene": Frame(
        "Regulation (EU) No 1301/2014 (TSI ENE) with 2018/868 and 2019/776",
        {
            "mean": "point 4.2.11, mean contact force, and EN 50367",
            "std": "point 4.2.12, standard deviation at most a share of the mean",
            "uplift_mm": "point 4.2.12, space for the uplift of the steady arm",
            "arcing": "point 4.2.12, share of arcing",
            "longest_arc_ms": "point 4.2.12, which arcs count",
        },
    ),
}


def framed(name: str, rows: Sequence[SummaryRow]) -> tuple[str, list[tuple[SummaryRow, str]]]:
    """(title of a standard, figures of a run that its numbers are about, with where these stand). name: of `FRAMES`."""
    frame = FRAMES[name]
    return frame.title, [(row, place) for row in rows if (place := frame.places.get(row.name.rpartition(".")[2]))]
