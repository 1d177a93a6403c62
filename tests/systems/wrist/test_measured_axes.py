"""Axes from poses of bones: the kinematics of the component give them back, noise their errors, other motions a residual."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.wrist.kinematics import OPENSIM_HALF, RULES, Axes, hand_rotation, row_rotation
from cosimo.orchestrator.systems.wrist.fitted_axes import fit_axes
from cosimo.orchestrator.systems.wrist.measured_axes import COLUMNS, main
from scipy.spatial.transform import Rotation

GRID = [(a, b) for a in (-0.6, -0.2, 0.3, 0.7) for b in (-0.5, 0.1, 0.6)]


def poses(first=20.0, second=38.0, model=RULES):
    """Rotation vectors of row and hand, by the quaternions of the component."""
    axes = Axes(model, math.radians(first), math.radians(second), 0.0)
    row = [row_rotation(a, b, axes) for a, b in GRID]
    both = row, [hand_rotation(r, b, axes) for r, (_, b) in zip(row, GRID, strict=True)]
    return [Rotation.from_quat(np.roll(np.array(q), -1, axis=1)).as_rotvec() for q in both]


@pytest.mark.parametrize("tilts", [(20.0, 38.0), (5.0, 60.0), (30.0, -10.0)])
@pytest.mark.parametrize("free", [False, True])
def test_the_axes_of_the_model_are_found(tilts, free):
    found = fit_axes(*poses(*tilts), free)
    assert np.degrees(found.tilts) == pytest.approx(tilts, abs=1e-6)
    assert max(found.left) < 1e-9
    np.testing.assert_allclose(found.angles, GRID, atol=1e-8)


def test_errors_of_the_tilts_are_those_of_noise():
    rng = np.random.default_rng(4)
    clean = poses()
    off = []
    for _ in range(12):
        found = fit_axes(*(p + rng.normal(scale=0.02, size=p.shape) for p in clean))
        off.append((np.array(found.tilts) - np.radians([20.0, 38.0])) / found.errors)
    assert 0.65 < np.std(off) < 1.4
    assert math.degrees(0.02) < math.degrees(found.left[1]) < 2.0 * math.degrees(0.02)


def test_rows_that_share_all_motion_by_halves_have_no_such_axes():
    assert math.degrees(fit_axes(*poses(model=OPENSIM_HALF)).left[0]) > 3.0


def test_an_axis_that_leans_is_seen_by_the_free_fit():
    lean = Rotation.from_rotvec([0.15, 0.0, 0.0])
    row, hand = ((lean * Rotation.from_rotvec(p) * lean.inv()).as_rotvec() for p in poses())
    stiff, free = fit_axes(row, hand), fit_axes(row, hand, free=True)
    assert max(free.left) < 1e-9 < min(stiff.left)
    assert free.leans[0] == pytest.approx(
        math.asin(-0.0 + lean.apply([math.sin(0.349066), 0.0, math.cos(0.349066)])[1]), abs=1e-5
    )


def test_what_does_not_determine_axes_is_refused(tmp_path, capsys):
    row, hand = poses()
    with pytest.raises(BadInput, match="3 postures"):
        fit_axes(row[:3], hand[:3])
    with pytest.raises(BadInput, match="rows that turn over"):
        fit_axes(0.01 * row, hand)
    file = tmp_path / "poses.csv"
    file.write_text("proximal_x\n0\n")
    with pytest.raises(SystemExit) as ended:
        main([str(file)])
    assert ended.value.code == 2
    assert "proximal_" in capsys.readouterr().err


def test_a_file_in_degrees_ends_as_settings(tmp_path, capsys):
    table = np.degrees(np.hstack(poses()))
    file = tmp_path / "poses.csv"
    file.write_text(";".join(f"{c} [deg]" for c in COLUMNS) + "\n" + "\n".join(";".join(f"{v:.9f}" for v in r) for r in table))
    main([str(file)])
    printed = capsys.readouterr().out
    assert "proximal axis: tilt 20.00" in printed
    assert f"wrist.morphology.distal_tilt={math.radians(38.0):.6f}" in printed
