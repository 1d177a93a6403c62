"""Axes of a person's wrist from measured poses of its bones, with what they leave.

python -m cosimo.orchestrator.systems.wrist.measured_axes poses.csv
python -m cosimo.orchestrator.systems.wrist.measured_axes 66582 --side L

A row of the file is a posture: rotations of a bone of the proximal row and of the hand (capitate) from the neutral posture, as rotation
vectors (helical axis times angle) in the axes of the radius that `kinematics` has: x deviates, y is the long axis, z flexes. Or it
is a person's folder of matrices, see `bone_poses`: then the row is the mean of its three bones, and `row_rules` adds its figures.
Axes are fitted as `fitted_axes` says, once across the forearm, as the model `Wrist` has them, once with any directions.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ....components.core.columns import read_table
from ....components.core.errors import BadInput
from .bone_poses import proximal_row, read_bones
from .fitted_axes import fit_axes
from .row_rules import figures

COLUMNS = tuple(f"{bone}_{axis}" for bone in ("proximal", "hand") for axis in "xyz")


def main(arguments: Sequence[str] | None = None) -> None:
    """Of a CSV file or a person's folder: tilts with errors, what is left, settings of a `Wrist`. Exit code 2 for others."""
    parser = argparse.ArgumentParser(prog="python -m cosimo.orchestrator.systems.wrist.measured_axes", description=__doc__)
    parser.add_argument(
        "file", type=Path, help="CSV with the columns " + ", ".join(COLUMNS) + "; or a person's folder of matrices"
    )
    parser.add_argument("--side", choices=("L", "R"), default="", help="of a folder with both sides")
    given = parser.parse_args(arguments)
    further: dict[str, float] = {}
    try:
        if given.file.is_dir():
            bones = read_bones(given.file, given.side)
            further = figures(bones)
            poses = np.hstack([proximal_row(bones).as_rotvec(), bones["cap"].as_rotvec()])
        else:
            table = read_table(given.file)
            poses = np.column_stack([table.numbers(name, "rad") for name in COLUMNS])
            poses = poses[np.isfinite(poses).all(axis=1)]
        axes, wide = (fit_axes(poses[:, :3], poses[:, 3:], free) for free in (False, True))
    except BadInput as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    for name, k in (("proximal", 0), ("distal", 1)):
        tilt, scatter, lean = (math.degrees(v) for v in (axes.tilts[k], axes.errors[k], wide.leans[k]))
        print(f"{name} axis: tilt {tilt:.2f} ± {scatter:.2f} degrees; free, it leans {lean:.2f} degrees along the forearm")
    row, hand = (math.degrees(v) for v in axes.left)
    print(f"left of {len(poses)} postures: {row:.3g} degrees of the proximal bone, {hand:.3g} of the hand (rms);")
    print(f"most in posture {axes.worst[0]}, {math.degrees(axes.worst[1]):.3g} degrees; with free axes", end=" ")
    print(" and ".join(f"{math.degrees(v):.3g}" for v in wide.left))
    tilts = zip(("proximal", "distal"), axes.tilts, strict=True)
    for figure, value in further.items():
        print(f"{figure},{value:.4g}")
    print(" ".join(f"--set wrist.morphology.{name}_tilt={tilt:.6f}" for name, tilt in tilts))


if __name__ == "__main__":
    main()
