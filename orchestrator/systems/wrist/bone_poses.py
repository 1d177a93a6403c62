"""Poses of carpal bones as databases of wrists have them: a folder of a person, a matrix for each bone and posture.

The digital database of wrist bones of Brown University (Moore, Crisco and others 2007; read with its program WristVisualizer) has
for a person 66582:

    01L/66582_Motion01L.dat         a posture: 15 bones in the order of `BONES`, four lines of three numbers each, the rows of a
                                    rotation matrix R and a translation t, mm; a point x of the neutral posture goes to R x + t
    LeftInfo/66582_RCS_L.dat        rows of a matrix whose columns are the radius' x (along the forearm), y (across) and z (from
                                    the palm to the back of the hand, or reversed), and the origin
    LeftInfo/66582_inertia_L.dat    five lines a bone: centroid, moments of inertia, three lines of axes

The same lines are found with the names of the group's own folders, S01L/Motion15L01L.dat, S15L/AnatCoordSys.dat and
S15L/inertia15L.dat, where 15L is the neutral posture.

A left wrist may be mirrored there or not. So the signs of the axes are taken from the centroids:
the capitate is farther along than the radius, the trapezium lies radially of the triquetrum, the pisiform towards the palm.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.columns import decoded
from ....components.core.errors import BadInput
from ....components.core.files import read_bytes

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

BONES = ("rad", "uln", "sca", "lun", "trq", "pis", "tpd", "tpm", "cap", "ham", "mc1", "mc2", "mc3", "mc4", "mc5")
ROW = ("sca", "lun", "trq")
USED = (*ROW, "cap", "ham")
SIDES = {"L": "Left", "R": "Right"}
STILL = 1e-6  # bones that were not registered have the matrix of the radius
SQUARE = 1e-3  # largest deviation of a matrix from a rotation; files have six decimals


def read_bones(folder: Path, side: str = "") -> dict[str, Rotation]:
    """Rotations of `USED` from the neutral posture against the radius, K each, in the axes of the radius that `kinematics` has.

    side: "L" or "R", where the folder has both. Raises `BadInput` for folders and files that are no such database.
    """
    from scipy.spatial.transform import Rotation

    own = f"S[0-9][0-9][{side or 'LR'}]/Motion[0-9][0-9][LR][0-9][0-9][LR].dat"
    motions = sorted(folder.glob(f"[0-9][0-9][{side or 'LR'}]/*_Motion[0-9][0-9][LR].dat")) or sorted(folder.glob(own))
    sides = {path.parent.name[-1] for path in motions}
    if len(sides) != 1:
        actual = "postures of both sides" if sides else "no files such as 01L/66582_Motion01L.dat or S01L/Motion15L01L.dat"
        raise BadInput(
            str(folder), actual, "a person's folder of one side", "Give the side with --side L or --side R." if sides else ""
        )
    (one,), (person, neutral) = sides, motions[0].stem.split("Motion")
    info, names = folder / f"{SIDES[one]}Info", (f"{person}RCS_{one}.dat", f"{person}inertia_{one}.dat")
    if not person:
        info, names = folder / f"S{neutral[:3]}", ("AnatCoordSys.dat", f"inertia{neutral[:3]}.dat")
    radius, inertia = (_lines(info / name, n) for name, n in zip(names, (4, 75), strict=True))
    _check(radius[:3], info)
    places = dict(zip(BONES, inertia[::5] @ radius[:3], strict=True))
    apart = np.array([places["cap"] - places["rad"], places["tpm"] - places["trq"], places["pis"] - places["trq"]])
    if list(np.abs(apart).argmax(axis=1)) != [0, 1, 2]:
        raise BadInput(
            str(info), "bones that do not lie along the axes of the radius", "x along the forearm, y across, z through the palm"
        )
    distal, radial, palmar = radius[:3].T * np.sign(apart.diagonal())[:, None]
    frame = np.column_stack([-palmar, distal, radial])  # a reflection, too, makes rotations of rotations
    turned = {bone: np.empty((len(motions), 3, 3)) for bone in USED}
    for k, path in enumerate(motions):
        blocks = _lines(path, 60).reshape(15, 4, 3)[:, :3]
        for bone in USED:
            matrix = blocks[0].T @ blocks[BONES.index(bone)]
            _check(matrix, path, bone)
            if np.abs(matrix - np.eye(3)).max() < STILL:
                raise BadInput(
                    str(path), f"{bone} at rest on the radius", "a posture of registered bones", "Leave out the neutral one."
                )
            turned[bone][k] = frame.T @ matrix @ frame
    return {bone: Rotation.from_matrix(matrices) for bone, matrices in turned.items()}


def proximal_row(bones: Mapping[str, Rotation]) -> Rotation:
    """Mean rotation of scaphoid, lunate and triquetrum in each posture."""
    together = type(bones["cap"]).concatenate
    return together([together([bones[b][k] for b in ROW]).mean() for k in range(len(bones["cap"]))])


def _lines(path: Path, count: int) -> np.ndarray:
    """The numbers of a file, (count, 3)."""
    text = decoded(read_bytes(path, "poses"), str(path))
    try:
        return np.array(text.split(), float).reshape(count, 3)
    except ValueError:
        raise BadInput(str(path), "another content", f"{count} lines of three numbers") from None


def _check(matrix: np.ndarray, where: Path, bone: str = "the radius' axes") -> None:
    if not np.abs(matrix @ matrix.T - np.eye(3)).max() < SQUARE or np.linalg.det(matrix) < 0.0:
        raise BadInput(str(where), f"a matrix of {bone} that is no rotation", "rows of a rotation matrix")
