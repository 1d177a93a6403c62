"""What concerns bearings only: their stiffness and damping as a table for a rotor."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from ...components.core.errors import BadInput
from ..output import ensure_directory
from .common import group, print_table, print_written, status_spinner, warn
from .options import Output, listed, number_given, numbers_given, parameters_of

if TYPE_CHECKING:
    from ..systems.bearings.support_tables import SupportRow

SHORT = 0.5  # length over diameter up to which the film of a short bearing is usual
Load = Annotated[
    str, Option(metavar="X,Y[,Z]", help='Load on the shaft along x, y (upwards) and z, as in "0 N,-500 N". In N without a unit.')
]
Speeds = Annotated[str, Option(metavar="SPEED[,...]", help='Speeds, rising, as in "0 rpm,3000 rpm". In rad/s without a unit.')]
Position = Annotated[str, Option(help="Place of the support on the shaft, for the table, in m or with a unit.")]

bearings = group("bearings", "Stiffness and damping of bearings as a table for a rotor.")


@bearings.command()
def balls(
    load: Load,
    speeds: Speeds = "0 rpm",
    values: Annotated[
        list[str] | None,
        Option(
            "--set", metavar="PARAMETER=VALUE", help='Parameter of DeepGrooveBearing, such as balls=8 or ball_diameter="11.9 mm".'
        ),
    ] = None,
    effects: Annotated[
        str, Option(metavar="NAME[,...]", help="Effects of DeepGrooveBearing, for example film, which follows the speed.")
    ] = "damping",
    preset: Annotated[str, Option(help="Published parameters of DeepGrooveBearing, or file.csv:row.")] = "",
    position: Position = "0 m",
    output: Output = Path("bearing"),
) -> None:
    """Stiffness of a deep groove ball bearing under a load. Example: cosimo bearings balls --load 0,-500 --preset 6205 -o out

    The mean of the tangents at the static equilibrium as balls pass; the inner ring does not tilt. The balls have no inertia, so
    that nothing but a film follows the speed.
    """
    from ...components.bearings.deep_groove import DeepGrooveBearing
    from ..scene.data_sheets import names_a_file, sheet_parameters
    from ..systems.bearings.support_tables import ball_rows

    given: dict[str, Any] = {}
    on = listed("--effects", [effects] if effects else [])
    if names_a_file(preset):
        given, remarks = sheet_parameters(preset, DeepGrooveBearing, on)
        warn(remarks)
        preset = ""
    across = _load(load, 3)
    turning, place = _speeds(speeds), number_given(position, "m", "--position")
    with status_spinner("looking for equilibria"):
        rows = ball_rows(given | parameters_of(values), on, preset, across, turning)
    _deliver(rows, place, output)


@bearings.command()
def film(
    load: Load,
    speeds: Speeds,
    diameter: Annotated[str, Option(help="Diameter of the journal, in m or with a unit.")],
    length: Annotated[str, Option(help="Length of the bearing.")],
    clearance: Annotated[str, Option(help="Radial clearance.")],
    viscosity: Annotated[str, Option(help="Viscosity of the oil at its temperature in the film, in Pa.s or with a unit.")],
    position: Position = "0 m",
    output: Output = Path("bearing"),
) -> None:
    """Stiffness and damping of a short plain bearing, in closed form.

    The film is laminar, of one viscosity, and half of it is under pressure. Example: cosimo bearings film --load 0,-525 --speeds
    "1500 rpm" --diameter "100 mm" --length "30 mm" --clearance "0.1 mm" --viscosity 0.1 -o out
    """
    from ...components.bearings.short_bearing import ShortBearing
    from ..systems.bearings.support_tables import film_rows

    given = {"diameter": diameter, "length": length, "clearance": clearance}
    sizes = {name: number_given(text, "m", f"--{name}") for name, text in given.items()}
    bearing = ShortBearing(**sizes, viscosity=number_given(viscosity, "Pa.s", "--viscosity"))
    x, y, z = _load(load, 2)
    if z:
        raise BadInput("--load", repr(load), "a load across the shaft", "A plain bearing carries none along it.")
    rows = film_rows(bearing, (x, y), _speeds(speeds))
    if bearing.length > SHORT * bearing.diameter:
        warn([f"the bearing is {bearing.length / bearing.diameter:.2g} diameters long; a short film is usual up to {SHORT:g}"])
    _deliver(rows, number_given(position, "m", "--position"), output)


def _load(text: str, least: int) -> tuple[float, float, float]:
    parts = numbers_given(text, "N", "--load")
    if len(parts) not in (2, 3):
        raise BadInput("--load", repr(text), "numbers along x and y" + (" and z" if least == 3 else ""), "As in --load 0,-500.")
    x, y, z = [*parts, 0.0][:3]
    return x, y, z


def _speeds(text: str) -> list[float]:
    values = numbers_given(text, "rad/s", "--speeds")
    if any(b <= a for a, b in pairwise(values)):
        raise BadInput("--speeds", repr(text), "speeds that rise")
    return values


def _deliver(rows: Sequence[SupportRow], position: float, output: Path) -> None:
    from ..systems.bearings.support_tables import save

    ensure_directory(output)
    notes = tuple(rows[0].notes)
    print_table(
        "Supports",
        ("speed, rad/s", "kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy", *notes),
        [
            (row.speed, *map(float, (*row.stiffness.ravel(), *row.damping.ravel())), *(row.notes[name] for name in notes))
            for row in rows
        ],
    )
    print_written([save(rows, position, output)])
    print("next: --set rotor.effects.support_table=true --set rotor.support_table.table=" + str(output / "supports.csv"))
