"""Figures and tables of friction-wheel drives carry what the made-up signals hold: moves, rest, energies, limits of friction."""

import math
import re

import numpy as np
import pytest
from cosimo.orchestrator.systems import SYSTEMS
from cosimo.orchestrator.systems.friction_drive.records import at_rest, drives, energies, moves, standing
from cosimo.tests.harness.figures import assert_valid_with_units, drawn, figures, numbers, tables
from cosimo.tests.systems.friction_drive.drive_runs import AT, RATE, STEP, TURN, drive_run

pytestmark = pytest.mark.full

UNIT = re.compile(r", (mm|mm/s|µm|degrees|s|rpm|V|A|N\.m|N|1|W)$")


def test_every_figure_is_valid_and_every_axis_has_its_unit():
    shown = figures(SYSTEMS["friction_drive"].figures(drive_run(starts=3)))
    assert list(shown) == ["Way of the sleeve", "While the set point stands", "Wheels and motors", "Contacts",
                           "Tractions in the plane of contact"]  # fmt: skip
    for figure in shown.values():
        assert_valid_with_units(figure, UNIT)


def test_moves_have_their_times_and_errors():
    drive = drives(drive_run())[0]
    feed, rotation = moves(drive)
    assert (feed.axis, feed.begin, feed.lasts, feed.way) == ("feed", pytest.approx(AT), 0.0, STEP)
    assert feed.settling_time == pytest.approx(math.log(STEP / 1e-4) / RATE, abs=1e-5)  # between two rows
    assert feed.overshoot == 0.0
    assert feed.left == pytest.approx(0.0, abs=1e-12)
    assert (rotation.axis, rotation.begin, rotation.lasts) == ("rotation", pytest.approx(0.2), pytest.approx(0.3))
    assert rotation.left == pytest.approx(0.02 * TURN)
    assert rotation.settling_time == pytest.approx(0.3)  # 8 mrad behind are within the band of 10: from the end of the ramp on
    assert moves(drive, {"feed": 1e-4, "rotation": 5e-3})[1].settling_time is None


def test_an_overshoot_that_stays_is_not_converged():
    feed = moves(drives(drive_run(overshoot=0.1))[0])[0]
    assert feed.overshoot == pytest.approx(0.1 * STEP, rel=1e-6)
    assert feed.settling_time is None
    (row, _) = tables(SYSTEMS["friction_drive"].figures(drive_run(overshoot=0.1)))["Moves"].rows
    assert row[-1] == "not"
    wide = drive_run({"feed_band": 3e-3, "rotation_band": 0.1}, overshoot=0.1)
    assert [r[-1] == "not" for r in tables(SYSTEMS["friction_drive"].figures(wide))["Moves"].rows] == [False, False]


@pytest.mark.parametrize("starts", [0, 1, 4])
def test_rest_and_what_breaks_loose_are_counted(starts):
    result = drive_run(starts=starts)
    (drive,) = drives(result)
    assert standing(drive) == pytest.approx(0.5, abs=1e-3)
    assert result.time[at_rest(drive)] == pytest.approx(0.801)
    rows = {r[1]: r for r in tables(SYSTEMS["friction_drive"].figures(result))["Rest"].rows}
    assert rows["first shaft"][3] == str(starts)
    assert float(rows["second shaft"][2]) == pytest.approx(60.0, abs=0.2)
    caption = next(b.caption for b in SYSTEMS["friction_drive"].figures(result) if b.title == "While the set point stands")
    assert ("hunts" in caption) == (starts > 1)


def test_energies_are_the_integrals():
    found = energies(drives(drive_run())[0])
    powers = {"motors": 3.0, "wheels": 0.25, "contacts": 0.05, "sleeve": 0.2}
    assert found == pytest.approx({name: 1.999 * watts for name, watts in powers.items()})


def test_tractions_stand_beside_the_limits_of_their_law():
    exact = figures(SYSTEMS["friction_drive"].figures(drive_run()))["Tractions in the plane of contact"]
    for name, level in (("kinetic friction", 6.0), ("static friction", 7.2)):
        circle = drawn(exact, name)[0]
        assert np.hypot(numbers(circle["x"]), numbers(circle["y"])) == pytest.approx(np.full(181, level), rel=1e-4)
    smooth = figures(SYSTEMS["friction_drive"].figures(drive_run(law=("smoothed_slip",))))["Tractions in the plane of contact"]
    assert drawn(smooth, "kinetic friction")
    assert not drawn(smooth, "static friction")
    creeping = figures(SYSTEMS["friction_drive"].figures(drive_run(law=())))
    assert not drawn(creeping["Tractions in the plane of contact"], "kinetic friction")
    titles = [a["title"]["text"] for k, a in creeping["Contacts"]["layout"].items() if k.startswith("yaxis")]
    assert "traction, N" in titles


def test_a_drive_without_a_controller_has_no_set_point():
    shown = SYSTEMS["friction_drive"].figures(drive_run(controller=False))
    assert "Moves" not in tables(shown)
    assert not drawn(figures(shown)["Way of the sleeve"], "set point")
    assert "While the set point stands" not in figures(shown)


def test_a_run_without_a_drive_has_no_figures():
    result = drive_run()
    del result.columns["wheels.feed"]
    assert SYSTEMS["friction_drive"].figures(result) == []
