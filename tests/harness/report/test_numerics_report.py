"""How a run was computed is told by its numbers, and what a scene does not use is absent."""

import json
import re
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.report import numerics
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, read_scene
from cosimo.tests.engine.algorithms.bonded import BOND, bonded
from cosimo.tests.support import two_masses

MILNE = {"method": "milne", "relative": 1e-3, "absolute": 1e-3}


def block(result, kind, title):
    return next(b for b in numerics.blocks(result) if b.kind == kind and b.title == title)


def facts(result):
    return dict(block(result, "facts", "Solver statistics").rows)


def alone(**master):
    return read_scene(
        {"stop_time": 0.1, "units": {"a": {"component": "cosimo.tests.support:Mass"}}, "master": {"step": 0.01, **master}}
    )


def test_a_scene_that_uses_none_of_it_has_none_of_it(tmp_path):
    result = run(alone(), in_process=True)
    assert numerics.blocks(result) == []
    html = report.for_run(result, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    assert "How it was computed" not in html
    assert "Recorded signals" in html


def test_controlled_steps_are_drawn_with_their_true_lengths():
    scene = read_scene(two_masses(degree=1, step=1e-3) | {"master": {"step": 1e-3, "control": MILNE}})
    result = run(scene, in_process=True)
    counts = result.info.counters.stepping
    assert counts.rejected > 0
    figure = block(result, "figure", "Length of the macro steps")
    go.Figure(figure.figure)
    trace = figure.figure["data"][0]
    starts, lengths = np.array(trace["x"][::2]), np.array(trace["y"][::2])
    assert lengths.size == counts.accepted  # of this many steps nothing is thinned
    assert lengths.sum() == pytest.approx(1e3 * scene.stop_time, rel=1e-4)  # five digits each
    assert starts[1:] == pytest.approx(1e-3 * np.cumsum(lengths)[:-1], abs=1e-4)
    for text in (figure.caption, facts(result)["macro steps"]):
        assert f"{counts.rejected} rejected" in text
        assert str(counts.accepted) in text


def test_where_not_every_step_is_recorded_no_length_is_made_up():
    scene = two_masses(degree=1) | {"master": {"step": 1e-3, "control": MILNE}, "record": {"interval": 0.1}}
    blocks = numerics.blocks(run(read_scene(scene), in_process=True))
    assert not [b for b in blocks if b.kind == "figure"]
    assert any("record.interval" in p for b in blocks if b.kind == "text" for p in b.paragraphs)


def test_located_events_are_counted_and_named():
    scene = bonded("Link", "jacobi", 0.1, 1, events=["a.x_out"])
    result = run(read_scene(scene), in_process=True)
    changes = int(np.count_nonzero(np.diff(np.sign(result["a.x_out"][result["a.x_out"] != 0.0]))))
    assert changes > 0
    assert facts(result)["events"] == f"{changes} steps ended at one; located: a.x_out"
    assert f"of which {changes} ended at an event." in block(result, "figure", "Length of the macro steps").caption


@pytest.mark.parametrize("correction", [False, True])
def test_energy_account_has_the_numbers_of_the_run(correction):
    result = run(read_scene(bonded("Link", "jacobi", 0.1, 0, energy_correction=correction)), in_process=True)
    table = block(result, "cells", "Energy account")
    ((bond, exchanged, created, residual),) = table.rows
    given = result.info.energy[BOND]
    assert bond == BOND
    assert float(exchanged) == pytest.approx(given.exchanged, rel=1e-3)
    assert float(created.replace("−", "-")) == pytest.approx(given.created, rel=1e-3)
    share = 100.0 * given.created / given.exchanged
    assert float(residual.replace("−", "-").removesuffix(" %")) == pytest.approx(share, rel=0.06)
    assert ("is returned" in table.caption) == correction


def test_iterations_are_told_a_step_with_the_worst_residual():
    settings = {"tolerance": 1e-9, "max_iterations": 30}
    master = {"algorithm": "iterative", "step": 1e-2, "iteration": settings}
    result = run(read_scene(two_masses() | {"master": master}), in_process=True)
    text, count = facts(result)["iterations"], result.info.counters.master["iterations"]
    assert text.startswith(f"{count} in 100 steps, {count / 100:.3g} a step")
    assert "at most 1e-09" in text
    hasty = {"tolerance": 1e-9, "max_iterations": 2, "not_converged": "warn"}
    result = run(read_scene(two_masses() | {"master": master | {"step": 0.1, "iteration": hasty}}), in_process=True)
    counters = result.info.counters.master
    assert counters["unconverged_steps"] > 0
    assert facts(result)["iterations"].endswith(
        f"{counters['unconverged_steps']} steps did not converge, worst residual {counters['worst_miss']:.2g}"
    )


def test_initial_values_and_checkpoints_and_the_resumption_are_facts(tmp_path):
    scene = read_scene(two_masses())
    first = run(scene, in_process=True, checkpoint_every=0.4, checkpoint_to=tmp_path / "checkpoint")
    found = facts(first)
    (group,) = first.info.initial_values
    assert found["initial values of " + ", ".join(group.units)].startswith(f"converged in {group.sweeps} sweeps")
    assert found["checkpoints"] == "every 0.4 s to checkpoint: 2 written, the last at 0.8 s"
    assert "resumed" not in found
    again = run(scene, in_process=True, resume=tmp_path / "checkpoint")
    assert facts(again)["resumed"].startswith("at 0.8 s")
    assert "checkpoints" not in facts(again)


def test_algebraic_loops_are_facts():
    made = {"points": 3, "evaluations": 6, "jacobians": 1, "residual": 1.5e-14}
    result = run(read_scene(two_masses()), in_process=True)
    result.info.counters.master["algebraic_loops"] = {"a.y -> b.u": made}
    assert facts(result)["algebraic loop of a.y -> b.u"] == (
        "solved at 3 instants with 6 evaluations and 1 Jacobian; largest residual 1.5e-14 of a signal's size"
    )


def test_warnings_and_remarks_are_shown_apart(tmp_path):
    scene = read_scene(two_masses())
    object.__setattr__(scene, "_remarks", ("a remark",))
    result = run(scene, in_process=True)
    result = replace(result, info=replace(result.info, warnings=(*result.info.warnings, "the warning")))
    html = report.for_run(result, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    assert re.search(r'class="text note"><p>a remark</p></div>', html)
    warned = re.search(r'class="text warning">(.*?)</div>', html, re.DOTALL)
    assert warned
    assert "<p>The warning.</p>" in warned[1]


def test_lead_tells_of_controlled_steps():
    result = run(read_scene(two_masses(degree=1) | {"master": {"step": 1e-3, "control": MILNE}}), in_process=True)
    assert report.generic.run_line(result).startswith("gauss-seidel with controlled steps (milne), ")
    json.dumps([b.figure for b in numerics.blocks(result) if b.kind == "figure"], allow_nan=False)
