"""Two contact wires under one head: how they share its force, and sections that overlap."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo.components.core.errors import nearest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.pantograph import Pantograph
from cosimo.components.railway.statics import elasticity
from cosimo.orchestrator.derivatives.gradient import alone
from cosimo.orchestrator.harness.half_answers import half_answers
from cosimo.orchestrator.harness.many.function import Function
from cosimo.orchestrator.harness.many.measures import Task, row_of_result
from cosimo.orchestrator.harness.summary import SummaryRow
from cosimo.orchestrator.harness.validation.curves import compare_curve
from cosimo.orchestrator.run.results import Result
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.scene.measured import Measured
from cosimo.orchestrator.settings.case import CurveSettings
from cosimo.orchestrator.settings.plan import KeepSettings
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import initialized

KC, F0 = 50e3, 120.0


def pantograph(first, second, effects=(), **parameters):
    return initialized(
        Pantograph(["contact_loss", "second_wire", *effects], {"frame_stiffness": 0.0} | parameters),
        {"wire_height": first, "second_wire.wire_height": second},
    )


@pytest.mark.known_answers(Pantograph="second_wire")
@pytest.mark.parametrize(
    ("first", "second", "shares"),
    [
        (0.0, 0.0, (60.0, 60.0)),
        (0.0, 1e-3, (85.0, 35.0)),  # k_c 1 mm = 50 N between them
        (1e-3, 0.0, (35.0, 85.0)),
        (0.0, 4e-3, (120.0, 0.0)),
        (4e-3, 0.0, (0.0, 120.0)),
        (0.0, 10.0, (120.0, 0.0)),
    ],
)
def test_wires_share_the_force_by_their_heights(first, second, shares):
    """F_1 + F_2 = F_0 and F_1 - F_2 = k_c (w_2 - w_1) where both touch; at rest, then after a hundred steps."""
    made = pantograph(first, second)
    for _ in range(2):
        assert made["contact_force"] == pytest.approx(shares[0], abs=1e-9)
        assert made["second_wire.contact_force"] == pytest.approx(shares[1], abs=1e-9)
        assert made["second_wire.total_force"] == pytest.approx(F0, abs=1e-9)
        for i in range(100):
            made.step(i * 1e-3, 1e-3)


def test_a_second_wire_out_of_reach_changes_no_bit():
    alone = Pantograph(["contact_loss"], {"frame_stiffness": 0.0})
    alone.initialize(0.0)
    beside = pantograph(0.0, 10.0)
    for i in range(200):
        for made in (alone, beside):
            made.set("wire_height", 0.01 * np.sin(0.05 * i))
            made.step(i * 1e-3, 1e-3)
    assert np.array_equal(alone.x, beside.x)


def test_two_wires_at_one_height_are_a_contact_of_twice_the_stiffness():
    two, stiff = pantograph(0.0, 0.0), Pantograph(["contact_loss"], {"frame_stiffness": 0.0, "contact_stiffness": 2.0 * KC})
    stiff.initialize(0.0)
    for i in range(300):
        height = 0.01 * np.sin(0.03 * i)
        two.set("wire_height", height)
        two.set("second_wire.wire_height", height)
        stiff.set("wire_height", height)
        for made in (two, stiff):
            made.step(i * 1e-3, 1e-3)
    assert two.x == pytest.approx(stiff.x, rel=1e-9, abs=1e-12)
    assert two["second_wire.total_force"] == pytest.approx(stiff["contact_force"], rel=1e-6)
    assert two.energy() == pytest.approx(stiff.energy(), rel=1e-9)


def overlap(effects=("dropper_slackening", "gravity_sag", "line_table", "second_wire")):
    settings = load_scene("overlap").units["catenary"]
    return initialized(
        Catenary(effects, {"line_table.table": settings.parameters["line_table.table"], "method": "implicit"}),
        {"contact_position": 380.0},
    )


def test_an_overlap_is_its_own_mirror_image():
    """Two sections that mirror one another about 380 m: statics of one wire here are those of the other there."""
    made = overlap()
    places = [341.7, 366.3, 380.0, 402.2]
    mirrored = [760.0 - x for x in places]
    assert elasticity(made.mesh, places, 100.0) == pytest.approx(elasticity(made.mesh, mirrored, 100.0, wire=1), rel=1e-6)
    n = made.mesh.position.size
    first, second = made.mesh.height[:n], made.mesh.height[n:]
    at = made.mesh.position
    both = (at > 242.0) & (at < 518.0)
    assert np.interp(760.0 - at[both], at, second) == pytest.approx(first[both], abs=1e-4)


def test_wires_of_an_overlap_move_by_themselves():
    """A force on one moves the other by nothing; where a wire is not, it is out of reach and takes no force."""
    made = overlap(("dropper_slackening", "gravity_sag", "line_table", "second_wire", "damping"))
    for i in range(60):
        made.u[0, made.input_positions(["contact_force"])] = 150.0
        made.step(i * 5e-3, 5e-3)
    N, W = made.mesh.mass.size, made.mesh.bending_gradient.size
    u = made.x[:N].reshape(-1, W)
    assert np.abs(u[:, 0]).max() > 0.02
    assert np.abs(u[:, 2:]).max() < 1e-12
    made.set("contact_position", 100.0)
    made.refresh()
    assert made["second_wire.wire_height[1]"] == pytest.approx(10.0, abs=1e-9)


@pytest.mark.full
def test_a_line_with_one_wire_has_the_second_out_of_reach():
    made = Catenary(["line_table", "second_wire"], {"method": "implicit", "element": 2.0})
    made.set("second_wire.contact_force[1]", 100.0)
    made.initialize(0.0)
    before = made.x.copy()
    made.step(0.0, 1e-3)
    assert [made[f"second_wire.wire_height[{k}]"] for k in (1, 8)] == [10.0, 10.0]
    assert np.abs(made.x[: made.mesh.mass.size] - before[: made.mesh.mass.size]).max() < 1e-15


@pytest.mark.full
def test_a_pantograph_passes_an_overlap_from_wire_to_wire():
    """It starts on the first, leaves on the second, and touches both over a span or more; it never loses contact."""

    result = finished(load_scene("overlap").with_changes({"record.snapshots": [], "record.snapshot_interval": None}))
    x, first = result["pantograph.contact_position"], result["pantograph.contact_force"]
    second = result["pantograph.second_wire.contact_force"]
    assert second[x < 330.0].max() == 0.0
    assert first[x > 430.0].max() == 0.0
    both = (first > 0.0) & (second > 0.0)
    assert 5.0 < np.count_nonzero(both) * 69.444 * 1e-3 < 60.0  # m of track
    assert (first + second)[x > 60.0].min() > 20.0


@pytest.fixture(scope="module")
def on_an_overlap():
    """A run of the scene as from a recorder: the second wire takes 30 N from 2 s on."""
    scene = load_scene("overlap").with_changes({"record.signals": ["pantograph.contact_force", "pantograph.contact_position"]})
    t = np.linspace(0.0, 4.0, 401)
    first, second = 100.0 + np.sin(t), np.where(t >= 2.0, 30.0, 0.0)
    columns = {"pantograph.contact_force": first, "pantograph.second_wire.total_force": first + second}
    return Result(scene, t, columns, {}, dict.fromkeys(columns, "N"), RunRecord(outcome="done"))


def test_a_recorded_part_brings_its_sum():
    scene = load_scene("overlap").with_changes({"record.signals": ["pantograph.contact_force"]})
    assert ("pantograph", "second_wire.total_force") in scene.coupling.signals
    assert ("pantograph", "second_wire.contact_force") not in scene.coupling.signals


@pytest.mark.parametrize(("since", "alone"), [(0.0, False), (1.0, True)])
def test_a_curve_of_one_wire_alone_is_warned(on_an_overlap, since, alone):
    """Where both wires carry in the compared stretch; not where the second one is not touched there."""
    x = since + np.linspace(0.0, 1.9, 20)
    curve = CurveSettings(signal="pantograph.contact_force", file="train.csv", source="train", tolerances={"mean": 0.1})
    run = replace(on_an_overlap, scene=on_an_overlap.scene.with_changes({"analysis.transient": 0.0}))
    told = compare_curve(curve, Measured(x, 100.0 + 0.0 * x), run).alone
    assert ("pantograph.second_wire.total_force (force on both wires)" in told) == alone
    whole = curve.model_copy(update={"signal": "pantograph.second_wire.total_force"})
    assert compare_curve(whole, Measured(x, 100.0 + 0.0 * x), run).alone == ""


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["pantograph.contact_force, maximum below 20 Hz"], ["pantograph.contact_force"]),
        (["pantograph.mean"], ["pantograph.mean (mean force, of one wire alone)"]),
        (["pantograph.contact_force, mean", "pantograph.second_wire.total_force, mean"], []),
        (["pantograph.contact_force, mean", "pantograph.second_wire.contact_force, mean"], []),
        (["pantograph.contact_force, mean", "pantograph.second_wire.total_force, maximum"], ["pantograph.contact_force"]),
        (["pantograph.both_wires.mean", "pantograph.contact_position, end"], []),
    ],
)
def test_a_figure_of_one_wire_alone_is_warned(on_an_overlap, names, told):
    figures = [
        SummaryRow("pantograph.both_wires.mean", 115.0, "N", "mean force"),
        SummaryRow("pantograph.mean", 100.0, "N", "mean force, of one wire alone", part=True),
    ]
    texts = half_answers(on_an_overlap, names, figures)
    assert [text.partition(" is only a part")[0] for text in texts] == told


def test_a_slope_and_a_function_of_one_wire_alone_are_warned(on_an_overlap):
    (text,) = alone(on_an_overlap, ["pantograph.contact_force, mean"])
    assert text.startswith("pantograph.contact_force is only a part: pantograph.second_wire.total_force (force on both wires)")
    assert (
        alone(on_an_overlap, ["pantograph.second_wire.total_force, mean", "pantograph.mean"]) == alone(on_an_overlap, None) == ()
    )
    scene = on_an_overlap.scene
    task = Task.of(scene, KeepSettings(), lambda result: (), ["pantograph.contact_force, mean"])
    row = row_of_result(on_an_overlap, replace(task, keep=KeepSettings(statistics=False, summary=False)))
    assert (row.outcome, row.reason) == ("done", text)
    function = object.__new__(Function)
    function._warned, function._columns = [], []
    with pytest.warns(UserWarning, match="is only a part"):
        function._learn([row, row])
    assert function._warned == [text]


def test_a_misspelt_sum_is_not_answered_with_a_part():
    known = ["pantograph.contact_force", "pantograph.second_wire.contact_force", "pantograph.second_wire.total_force"]
    assert nearest("pantograph.total_force", known) == "Did you mean 'pantograph.second_wire.total_force'?"


def test_the_force_of_both_strips_is_their_sum():
    made = Pantograph(["contact_loss", "two_strips"], {"frame_stiffness": 0.0})
    made.initialize(0.0)
    for i in range(50):
        made.set("two_strips.wire_height", 1e-3 * np.sin(0.1 * i))
        made.step(i * 1e-3, 1e-3)
    front, rear = made["contact_force"], made["two_strips.contact_force"]
    assert abs(front - rear) > 1.0
    assert made["two_strips.total_force"] == front + rear
