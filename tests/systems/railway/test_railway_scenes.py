"""What the coupled railway scenes must show: the table, its convergence, the effect of single effects, the wake."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter, uniform
from cosimo.orchestrator.harness.validation.case import compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.records import measured, passages, statistics
from cosimo.orchestrator.systems.railway.runs import at_speed
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import slope

EFFECTS = ["dropper_slackening", "gravity_sag", "damping"]


def reference_scene(speed=250.0, effects=EFFECTS, **changes):
    """EN 50318:2002 without pictures."""
    return at_speed(
        load_scene("en50318-2002"),
        speed,
        {
            "units.catenary.effects": effects,
            "record": {
                "signals": [
                    "pantograph.contact_force",
                    "pantograph.contact_position",
                    "catenary.wire_height",
                    "catenary.support_uplift",
                ]
            },
            **changes,
        },
    )


def force(result):
    """20 Hz-filtered force over spans 5 and 6 on a fixed grid of positions, N."""
    record = passages(result)[0].record
    rate, _, (position, contact) = uniform(record.time, record.position, record.force)
    return np.interp(np.linspace(240.0, 360.0, 1201), position, ButterworthFilter().apply(contact, rate))


def deviation(a, b):
    """rms difference over the standard deviation of b."""
    return float(np.sqrt(np.mean((a - b) ** 2)) / b.std())


@pytest.mark.first
@pytest.mark.parametrize("speed", [250.0, 300.0])
@pytest.mark.parametrize("halved", [False, True])
def test_all_cells_of_the_2002_table_hold_and_hold_with_element_and_step_halved(speed, halved):
    changes = {"catenary.element": 0.25, "catenary.substep": 5e-4, "master.step": 5e-4}
    result = finished(reference_scene(speed, **(changes if halved else {})))
    rows = compare(load_table("en50318-2002").under(f"{speed:g} km/h"), measured(statistics(result)))
    assert len(rows) == 8
    outside = [f"{r.reference.quantity}: {r.simulated:.4g}" for r in rows if not r.inside]
    assert not outside


@pytest.mark.full
def test_the_two_integrators_agree():
    """Explicit and implicit method share mesh and droppers, nothing of the time integration."""
    explicit = force(finished(reference_scene()))
    implicit = force(finished(reference_scene(**{"catenary.method": "implicit"})))
    assert deviation(implicit, explicit) < 0.02  # both are within 1.3 % of a converged run


@pytest.mark.full
def test_error_falls_at_second_order_or_better_in_the_element():
    """Macro step and substep small, so that the elements make the error."""

    def history(element, substep):
        small = {"master.step": 5e-4, "catenary.element": element, "catenary.substep": substep}
        return force(finished(reference_scene(**small)))

    elements = np.array([1.0, 0.7, 0.5])
    exact = history(0.25, 2.5e-4)
    errors = [deviation(history(e, 2.5e-4), exact) for e in elements]
    assert slope(elements, errors) > 1.9


@pytest.mark.full
def test_error_falls_at_second_order_in_the_macro_step():
    """Linear extrapolation, second order (an order more than held inputs would give); the reference has a tenth of the step."""
    steps = np.array([4e-3, 2e-3, 1e-3])
    fine = {"catenary.substep": 1e-3, "pantograph.substep": 1e-4}
    exact = force(finished(reference_scene(**fine, **{"master.step": 1e-4})))
    errors = [deviation(force(finished(reference_scene(**fine, **{"master.step": float(h)}))), exact) for h in steps]
    # below 2: at 1 ms the catenary's own substep is cut to the macro step of the reference, which leaves 0.2 %
    assert 1.5 < slope(steps, errors) < 2.2


@pytest.mark.full
@pytest.mark.parametrize(("speed", "low", "high"), [(250.0, 1.2, 1.7), (300.0, 1.3, 1.9)])
def test_slackening_takes_a_third_off_the_standard_deviation(speed, low, high):
    """Bilateral droppers raise it by 1.4 to 1.6 in an independent solver with a flat wire; the same wire is used here."""
    bilateral, slackening = (["damping"], ["dropper_slackening", "damping"])
    sigma = [force(finished(reference_scene(speed, effects))).std() for effects in (bilateral, slackening)]
    assert low < sigma[0] / sigma[1] < high


@pytest.mark.full
def test_sag_between_droppers_lowers_the_standard_deviation():
    """An independent solver finds 5 N less than with a flat wire."""
    flat, sagging = (statistics(finished(reference_scene(effects=e))).std for e in (["dropper_slackening", "damping"], EFFECTS))
    assert 3.0 < flat - sagging < 8.0


@pytest.mark.full
def test_the_wake_reaches_the_trailing_pantograph():
    """The leading one hardly feels the other; the trailing one meets a wire that swings already."""
    scene = load_scene("two-pantographs")
    both = finished(scene)
    leading, trailing = (statistics(both, pantograph=k) for k in (0, 1))
    assert passages(both)[0].pantograph == "leading"
    alone = finished(
        load_scene("en50318-2002").with_changes(
            {"stop_time": scene.stop_time, "catenary.spans": 12, "catenary.first_watched_support": 4, "analysis": scene.analysis}
        )
    )
    single = statistics(alone)
    assert leading.mean == pytest.approx(single.mean, rel=0.02)
    assert trailing.mean == pytest.approx(single.mean, rel=0.02)
    # 200 m ahead of the trailing pantograph the wire is hit 2.9 s earlier: its force is not that of a single one
    grid = np.linspace(300.0, 420.0, 1201)
    histories = []
    for result, k in ((both, 1), (alone, 0)):
        record = passages(result)[k].record
        rate = 1.0 / (record.time[1] - record.time[0])
        histories.append(np.interp(grid, record.position, ButterworthFilter().apply(record.force, rate)))
    assert deviation(*histories) > 0.15


@pytest.mark.full
def test_four_pantographs_have_statistics_of_their_own():
    """Foremost first; the wire's mean lift is that of one pantograph, the scatter grows from the first to the last."""
    result = finished(load_scene("four-pantographs"))
    assert [p.pantograph for p in passages(result)] == ["first", "second", "third", "fourth"]
    each = [statistics(result, pantograph=k) for k in range(4)]
    assert np.ptp([s.mean for s in each]) < 0.02 * each[0].mean
    assert each[1].std > 1.1 * each[0].std
    assert each[3].std > 1.1 * each[1].std


@pytest.mark.full
def test_two_strips_are_judged_together_and_one_by_one():
    """The sum first; its mean is that of both, its scatter less than theirs together: each meets the wire at another place."""
    result = finished(load_scene("two-strips"))
    assert [p.pantograph for p in passages(result)] == ["pantograph.both_strips", "pantograph", "pantograph.two_strips"]
    assert [p.part for p in passages(result)] == ["", "one strip alone", "one strip alone"]
    names = [row.name for row in result.summary]
    assert "pantograph.both_strips.arcs" in names
    assert "pantograph.arcs" not in names  # the other strip carries the current
    both, front, rear = (statistics(result, pantograph=k) for k in range(3))
    assert both.mean == pytest.approx(front.mean + rear.mean, rel=2e-3)  # their windows are 0.58 m apart
    assert both.std < 0.9 * (front.std + rear.std)


def test_effects_that_are_off_leave_no_trace_in_a_result():
    result = finished(reference_scene())
    assert not any("." in name.partition(".")[2] for name in result.columns)
    assert set(result.info.effects["catenary"].on) == set(EFFECTS)
    assert "moving_window" in result.info.effects["catenary"].off
    assert not any(name.startswith("moving_window") for name in result.info.units["catenary"].parameters)
