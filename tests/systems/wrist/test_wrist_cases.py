"""The wrist cases pass, and would not with other axes, another linkage, or the stiffness turned the other way."""

import math
from dataclasses import replace

import pytest
from cosimo.orchestrator.harness.validation.case import Options
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.wrist.cases import four_bar
from cosimo.orchestrator.systems.wrist.cases import rules as wrist_rules
from cosimo.orchestrator.systems.wrist.cases import stiffness as wrist_stiffness


def with_scenes(name, scenes):
    """The case with other scenes."""
    case = cases()[name]
    return replace(case, questions=(replace(case.questions[0], scenes=scenes),))


@pytest.mark.full
def test_an_axis_that_is_moved_by_a_degree_is_seen():
    """The signs stay, the angles of the rows and the roll do not."""

    def moved():
        scenes = wrist_rules.scenes()
        changes = {f"{unit}.morphology.distal_tilt": math.radians(46.0) for unit in wrist_rules.HELD}
        return scenes | {"held postures": scenes["held postures"].with_changes(changes)}

    case = with_scenes("wrist-rules", moved)
    inside = {r.reference.measure: r.inside for r in case.findings(Options(in_process=True)).rows}
    angles = [f"{u}.{n}" for u in ("flexion", "radial", "ulnar") for n in ("proximal_angle", "distal_angle", "roll")]
    assert not any(inside[m] for m in angles)
    assert all(inside[f"{u}.{row}_flexion"] for u in wrist_rules.HELD for row in ("proximal", "distal"))


def test_a_coupler_of_another_length_is_another_linkage(monkeypatch):
    monkeypatch.setitem(four_bar.CRANK_ROCKER, "coupler", 0.0501)
    inside = {r.reference.measure: r.inside for r in cases()["four-bar"].findings(Options(in_process=True)).rows}
    assert not any(inside[m] for m in ("rocker.low", "rocker.high", "transmission.low", "transmission.high"))
    assert inside["closure.equation"]
    assert inside["work.energy"]


@pytest.mark.full
def test_a_stiffness_that_is_turned_the_other_way_is_seen():
    """With the sign of the coupling the other way, the hand would be soft in radial flexion: 26.6 degrees on the wrong side."""

    def mirrored():
        return {
            name: scene.with_changes({f"{unit}.coupling_stiffness": -5.736 for unit in scene.units})
            for name, scene in wrist_stiffness.scenes().items()
        }

    case = with_scenes("wrist-stiffness", mirrored)
    inside = {r.reference.measure: r.inside for r in case.findings(Options(in_process=True)).rows}
    assert not inside["orientation.sign"]
    assert inside["orientation"]
