"""Matrices of bones as databases have them: poses of the component come back, whatever the scanner's axes; wrong files are told."""

import math
import shutil

import numpy as np
import pytest
from cosimo.components.wrist.kinematics import OPENSIM_HALF, RULES, Axes, hand_rotation, row_rotation
from cosimo.orchestrator.systems.wrist import row_rules
from cosimo.orchestrator.systems.wrist.bone_poses import BONES, proximal_row, read_bones
from cosimo.orchestrator.systems.wrist.cases.paper_wrist import poses as paper_poses
from cosimo.orchestrator.systems.wrist.measured_axes import main
from scipy.spatial.transform import Rotation

GRID = [(a, b) for a in (-0.5, 0.4) for b in (-0.4, 0.5)] + [(0.3, -0.1), (-0.2, 0.1), (0.1, 0.3), (-0.3, -0.3)]
PLACES = {"cap": (0.0, 18.0, 0.0), "tpm": (0.0, 20.0, 15.0), "trq": (0.0, 10.0, -15.0), "pis": (-8.0, 11.0, -14.0)}  # mm


def wrist(model):
    """Rotations of row and hand by the quaternions of the component, as matrices."""
    axes = Axes(model, *((math.radians(18.0), math.radians(40.0)) if model == RULES else (0.0, 0.0)), 0.0)
    row = [row_rotation(a, b, axes) for a, b in GRID]
    hand = [hand_rotation(r, b, axes) for r, (_, b) in zip(row, GRID, strict=True)]
    return [Rotation.from_quat(np.roll(np.array(q), -1, axis=1)).as_matrix() for q in (row, hand)]


def write(folder, model=RULES, side="L", mirror=1.0):
    """A person's folder: axes of a scanner, a radius that moves with its forearm; mirror -1: as of the other hand."""
    rng = np.random.default_rng(3)
    own = Rotation.random(random_state=1).as_matrix() @ np.diag([1.0, 1.0, mirror])  # of the radius' axes, in the scanner
    info = folder / ("LeftInfo" if side == "L" else "RightInfo")
    info.mkdir(parents=True)
    origin = np.array([-50.0, 70.0, 20.0])
    x, y, z = -own[:, 1], own[:, 2], -mirror * own[:, 0]  # away from the hand, across, palm to back or reversed
    np.savetxt(info / f"1_RCS_{side}.dat", np.vstack([np.column_stack([x, y, z]), origin]))
    inertia = np.zeros((15, 5, 3))
    inertia[:, 0] = [origin + own @ np.array(PLACES.get(b, (0.0, 0.0, 0.0))) for b in BONES]
    np.savetxt(info / f"1_inertia_{side}.dat", inertia.reshape(75, 3))
    row, hand = wrist(model)
    for k in range(len(GRID)):
        forearm = Rotation.random(random_state=k).as_matrix()
        place = folder / f"{k + 1:02}{side}"
        place.mkdir()
        blocks = np.empty((15, 4, 3))
        for j, bone in enumerate(BONES):
            turn = {"rad": np.eye(3), "cap": hand[k], "ham": hand[k]}.get(bone, row[k])
            blocks[j, :3], blocks[j, 3] = forearm @ own @ turn @ own.T, rng.normal(size=3)
        np.savetxt(place / f"1_Motion{k + 1:02}{side}.dat", blocks.reshape(60, 3))
    return folder


def renamed(folder):
    """The folder with the names of the group's own files."""
    for path in folder.glob("??L"):
        path.rename(folder / f"S{path.name}")
    for path in folder.glob("S??L/*"):
        path.rename(path.with_name(f"Motion15L{path.stem[-3:]}.dat"))
    (folder / "LeftInfo").rename(folder / "S15L")
    (folder / "S15L" / "1_RCS_L.dat").rename(folder / "S15L" / "AnatCoordSys.dat")
    (folder / "S15L" / "1_inertia_L.dat").rename(folder / "S15L" / "inertia15L.dat")
    return folder


@pytest.mark.parametrize(("mirror", "named"), [(1.0, lambda folder: folder), (-1.0, renamed)])
def test_bones_turn_as_they_were_written(tmp_path, mirror, named):
    bones = read_bones(named(write(tmp_path / "1", mirror=mirror)))
    row, hand = wrist(RULES)
    np.testing.assert_allclose(proximal_row(bones).as_matrix(), row, atol=1e-12)
    np.testing.assert_allclose(bones["cap"].as_matrix(), hand, atol=1e-12)


def test_figures_tell_one_axis_from_equal_shares(tmp_path, monkeypatch):
    """The rules leave nothing; halves leave as much as the control, which they are, and have axes at right angles."""
    monkeypatch.setattr(row_rules, "MOST", 2)
    ruled = row_rules.figures(read_bones(write(tmp_path / "rules")))
    assert max(ruled[f] for f in ("left.sca", "carried.left", "apart", "halves.error", "error")) < 1e-5
    assert ruled["halves.control"] > 5.0
    assert min(ruled["toward.radial"], ruled["toward.ulnar"], ruled["per.deviation"]) > 0.1
    bones = read_bones(write(tmp_path / "halves", OPENSIM_HALF))
    row, hand = proximal_row(bones), bones["cap"]
    assert row_rules.left_about_one_axis(row) == pytest.approx(
        row_rules.left_about_one_axis(Rotation.from_rotvec(0.5 * hand.as_rotvec()))
    )
    by, _ = row_rules.per_posture(hand.as_euler("ZXY")[:, :2], row.as_rotvec())
    assert row_rules.apart(by) == pytest.approx(90.0, abs=5.0)
    np.testing.assert_allclose(by[:, [2, 0]], 0.5 * np.eye(2), atol=0.05)
    names = paper_poses.read_table(paper_poses.FILE).texts("figure")
    assert names == list(ruled)


def refused(given, told, capsys):
    with pytest.raises(SystemExit) as ended:
        main(given)
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_a_folder_ends_as_settings_and_a_wrong_one_in_a_message(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(row_rules, "MOST", 2)
    folder = write(tmp_path / "1")
    main([str(folder)])
    assert "wrist.morphology.distal_tilt=0.698" in capsys.readouterr().out
    write(tmp_path / "2")
    (folder / "01R").mkdir()
    (folder / "01R" / "1_Motion01R.dat").write_text("")
    for given, told in (([str(folder)], "--side"), ([str(folder), "--side", "R"], "RightInfo"), ([str(tmp_path)], "01L/")):
        refused(given, told, capsys)
    path = tmp_path / "2" / "03L" / "1_Motion03L.dat"
    text = path.read_text()
    for wrong, told in ((text[:-30], "60 lines"), (text.replace(text.split()[0], "2.0", 1), "no rotation"), ("x", "60 lines")):
        path.write_text(wrong)
        refused([str(tmp_path / "2")], told, capsys)
    numbers = np.array(text.split(), float).reshape(15, 4, 3)
    numbers[BONES.index("lun")] = numbers[0]
    np.savetxt(path, numbers.reshape(60, 3))
    refused([str(tmp_path / "2")], "lun at rest on the radius", capsys)
    for k in range(3, 9):
        shutil.rmtree(tmp_path / "2" / f"{k:02}L")
    refused([str(tmp_path / "2")], "2 postures", capsys)
