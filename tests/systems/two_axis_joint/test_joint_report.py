"""Figures of two-axis joints carry what the made-up signals hold: sections, tracks, drifts, rest."""

import re

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.components.two_axis_joint.gimbal_equations import body_to_base
from cosimo.orchestrator.systems import SYSTEMS
from cosimo.orchestrator.systems.two_axis_joint.records import axis_direction, joints, poincare
from cosimo.tests.harness.figures import assert_valid_with_units, drawn, figures, numbers
from cosimo.tests.systems.two_axis_joint.joint_runs import chain_run, gimbal_run, three_frictions

pytestmark = pytest.mark.full

UNIT = re.compile(r", (degrees/s|degrees|s|m|1|J|kg·m²/s)$")


@pytest.mark.parametrize("example", [gimbal_run, chain_run, three_frictions])
def test_every_figure_is_valid_and_every_axis_has_its_unit(example):
    for figure in figures(SYSTEMS["two_axis_joint"].figures(example())).values():
        assert_valid_with_units(figure, UNIT)


def test_a_motion_that_keeps_its_energy_has_sections_and_drifts():
    assert list(figures(SYSTEMS["two_axis_joint"].figures(gimbal_run()))) == [
        "Motion", "Track of the axis", "Phase portraits", "Poincaré sections", "Energy and momentum",
    ]  # fmt: skip
    figure = figures(SYSTEMS["two_axis_joint"].figures(gimbal_run()))["Energy and momentum"]
    assert {figure["layout"][k]["title"]["text"] for k in ("yaxis", "yaxis2")} == {"drift of energy, 1", "drift of momentum, 1"}
    (energy,) = drawn(figure, "energy")
    assert numbers(energy["y"])[-1] == pytest.approx(-4e-11 * 39.995 / 2.0, rel=1e-3)


def test_sections_are_taken_where_the_other_axis_passes_zero():
    """2 t a multiple of 2 pi: the inner angle is 0.4 sin(3.7 k pi) there; 3.7 t: the outer one, at every rising passage."""
    result = gimbal_run()
    (record,) = joints(result)
    (_, inner), (_, outer) = poincare(result, record, 0.1)
    k = np.arange(1, 13)
    np.testing.assert_allclose(inner.angle, 0.4 * np.sin(3.7 * np.pi * k), atol=1e-6)
    np.testing.assert_allclose(inner.rate, 1.48 * np.cos(3.7 * np.pi * k), atol=1e-5)
    np.testing.assert_allclose(outer.angle, 4.0 * np.pi / 3.7 * np.arange(1, outer.angle.size + 1), rtol=1e-6)


def test_the_scenes_own_section_is_taken():
    result = gimbal_run({"section": {"angle": "body.outer_angle", "turns": 4.0}})
    (record,) = joints(result)
    (_, outer), (_, inner) = poincare(result, record, 0.1)
    np.testing.assert_allclose(outer.angle, 0.5 * np.pi * np.arange(1, outer.angle.size + 1), rtol=1e-9)
    np.testing.assert_allclose(inner.angle, 0.4 * np.sin(3.7 * 0.25 * np.pi * np.arange(1, inner.angle.size + 1)), atol=1e-6)
    with pytest.raises(BadInput, match="outer_angle"):
        SYSTEMS["two_axis_joint"].figures(gimbal_run({"section": {"angle": "body.outer_angel"}}))


@pytest.mark.parametrize("orientation", ["vertical", "horizontal"])
def test_the_track_is_the_components_own_axis(orientation):
    body = GimbalBody(["stick_friction"], {"axis_orientation": orientation})
    body.initialize(0.0)
    rng = np.random.default_rng(2)
    for alpha, beta in rng.uniform(-3.0, 3.0, (20, 2)):
        body.x[:2] = alpha, beta
        direction = axis_direction(np.array([alpha]), np.array([beta]), orientation)[:, 0]
        np.testing.assert_allclose(direction, body_to_base(0.0, 0.0, 1.0, body.x, body.arguments[1]), atol=1e-15)


def test_the_sphere_shows_its_near_and_its_far_side():
    """A cone about the vertical: from below all of it is near, from the side half of it."""
    result = gimbal_run()
    result.columns["body.inner_angle"] = np.full_like(result.time, 0.5)
    figure = figures(SYSTEMS["two_axis_joint"].figures(result))["Track of the axis"]
    below, side, _ = drawn(figure, "near side")
    assert np.hypot(numbers(below["x"]), numbers(below["y"])) == pytest.approx(np.sin(0.5), rel=1e-3)
    assert np.isfinite(numbers(side["x"])).mean() == pytest.approx(0.5, abs=0.05)
    assert numbers(side["y"])[np.isfinite(numbers(side["y"]))] == pytest.approx(-np.cos(0.5), rel=1e-3)


def test_what_dies_down_has_no_section_and_its_energy_is_shown_as_it_is():
    by_title = figures(SYSTEMS["two_axis_joint"].figures(chain_run()))
    assert list(by_title) == ["Motion", "Path of the tip", "Phase portraits", "Energy and momentum"]
    assert by_title["Energy and momentum"]["layout"]["yaxis"]["title"]["text"] == "energy, J"
    round_and_round = numbers(drawn(by_title["Phase portraits"], "motion")[1]["x"])
    assert np.nanmax(np.abs(round_and_round)) <= 180.0
    assert np.isnan(round_and_round).sum() == 10  # 60 rad: nine and a half turns, from 0 to 180 degrees first


def test_a_chain_without_losses_keeps_its_energy_and_with_gravity_not_its_momentum():
    assert joints(chain_run(effects=("gravity",)))[0].constant == {"energy"}
    assert joints(chain_run(effects=()))[0].constant == {"energy", "momentum"}
    assert joints(chain_run())[0].constant == frozenset()
    assert joints(gimbal_run(effects=("gravity",)))[0].constant == {"energy", "momentum"}
    assert joints(gimbal_run(effects=("gravity",), orientation="horizontal"))[0].constant == {"energy"}


def test_an_axis_that_only_rounding_moves_has_no_phase_portrait_and_no_section():
    result = gimbal_run(effects=["gravity"])
    for name in ("inner_angle", "inner_rate"):
        result.columns[f"body.{name}"] = 1e-17 * result.columns[f"body.{name}"]
    blocks = [b for b in SYSTEMS["two_axis_joint"].figures(result) if b.kind == "figure"]
    shown = next(b for b in blocks if b.title == "Phase portraits")
    assert "xaxis2" not in shown.figure["layout"]
    assert shown.caption.endswith("Not shown, as it does not move: inner axis.")
    assert "Poincaré sections" not in {b.title for b in blocks}


def test_several_joints_are_compared_and_what_stands_has_no_line_among_the_rates():
    by_title = figures(SYSTEMS["two_axis_joint"].figures(three_frictions()))
    figure = by_title["Motion"]
    assert [figure["layout"][f"yaxis{n}"]["title"]["text"] for n in ("", "2", "3", "4")] == [
        "outer axis, degrees", "inner axis, degrees", "rate of the outer axis, degrees/s", "rate of the inner axis, degrees/s",
    ]  # fmt: skip
    late = {n: numbers(drawn(figure, n)[2]["y"])[-50:] for n in ("exact", "creeping", "damped")}
    assert np.isnan(late["exact"]).all()
    assert late["creeping"] == pytest.approx(np.degrees(1e-5), rel=1e-3)
    assert np.isfinite(late["damped"]).all()
    assert [t for t in by_title if t.startswith("exact: ")] == ["exact: Phase portraits"]
