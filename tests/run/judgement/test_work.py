"""Which repetitions a run gets is decided by counted work: no clock, no load and no packaging changes it."""

import sys
from dataclasses import replace

import cosimo
import pytest
from cosimo.orchestrator.harness.validation.case import Case
from cosimo.orchestrator.harness.validation.questions import Evidence, Options, Question
from cosimo.orchestrator.harness.validation.reference import Row, TableRow
from cosimo.orchestrator.harness.validation.repeated import find
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.judgement.advice import advise
from cosimo.orchestrator.judgement.dry_run import first_part, lines
from cosimo.orchestrator.run import work
from cosimo.orchestrator.run.run import run as run_once
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.systems.many import sweep
from cosimo.tests.support import two_masses

CLOCKS = ("perf_counter", "process_time")
SCENE = read_scene(two_masses("jacobi", 1e-2, 0))


def slower(monkeypatch, factor):
    """All clocks of the product run so many times as fast, as on a slower or a busier machine."""
    modules = [module for name, module in sys.modules.items() if name.startswith("cosimo.orchestrator")]
    patched = 0
    for module in modules:
        for name in (name for name in CLOCKS if hasattr(module, name)):
            monkeypatch.setattr(module, name, _times(getattr(module, name), factor))
            patched += 1
    assert patched > 8


def _times(clock, factor):
    return lambda: factor * clock()


def answer(scene):
    """What was repeated of a run, a dry run, a case and a sweep."""
    run = cosimo.run(scene, in_process=True).info.verification
    advice = advise(scene, in_process=True)
    kinds = [line.partition(" half")[0] for line in lines(scene, scene.coupling, advice, in_process=True)]

    def measured(runs):
        end = runs.run(scene).end
        return Evidence(rows=(Row(TableRow("x", "x", "", "s", 0.0, 1e9, "computed", "none", ""), end),))

    case = find(Case("c", "A case", "It shows.", (Question(measured, in_process=True),)), Options())
    points = sweep(scene, {"vary": {"a.k": [1.0, 2.0, 3.0, 4.0, 5.0]}}).repeated
    first = "not run" in first_part(scene, advice)[0]
    return run.how, run.runs, run.why, kinds[-1], case.unverified, points.points, first


@pytest.mark.parametrize(("allowed", "how"), [(0.9, ("windows", 2)), (5.0, ("whole", 2)), (9.0, ("whole", 3))])
def test_no_clock_changes_what_is_repeated(allowed, how, monkeypatch):
    counted = run_once(SCENE, in_process=True).info.counters.work
    monkeypatch.setattr(work, "BUDGET", allowed * counted)
    as_it_is = answer(SCENE)
    assert as_it_is[:2] == how
    assert ("windows" in as_it_is[3]) == bool(as_it_is[4]) == (allowed < 2.0)
    assert len(as_it_is[5]) == max(int(allowed / 2.0), 1)
    for factor in (20.0, 0.05):
        with monkeypatch.context() as clocks:
            slower(clocks, factor)
            assert answer(SCENE) == as_it_is


@pytest.mark.parametrize("name", ["lumped-catenary", "friction-drive-step"])
def test_the_work_of_the_first_part_tells_that_of_the_whole(name):
    """So a run of FMUs, which count nothing, is repeated as one in process is."""
    scene = load_scene(name)
    counted = run_once(scene, in_process=True).info.counters.work
    assert verification.work_of(scene, None) == pytest.approx(counted, rel=0.02)
    assert advise(scene, in_process=True).work * scene.duration / scene.master.step == pytest.approx(counted, rel=0.1)


def test_fmus_count_no_work_of_their_own():
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 0.1})
    made = cosimo.run(scene)
    assert made.info.counters.work is None
    assert made.info.verification.how == "whole"


def test_a_resumed_run_counts_as_the_whole(tmp_path):
    options = {"in_process": True, "checkpoint_every": 0.5, "checkpoint_to": tmp_path / "checkpoint"}
    whole = run_once(SCENE, **options).info.counters.work
    rest = run_once(SCENE, in_process=True, resume=tmp_path / "checkpoint").info.counters.work
    assert rest == whole


def test_questions_that_run_nothing_are_asked_once():
    asked = []

    def measured(runs):
        asked.append(runs)
        return Evidence(rows=(Row(TableRow("x", "x", "", "s", 0.0, 1e9, "computed", "none", ""), 1.0),))

    found = find(Case("c", "A case", "It shows.", (Question(measured),)), Options())
    assert len(asked) == 1
    assert found.rows[0].why == "unchanged"


def test_the_readmes_first_command_has_errors_on_a_slow_machine(monkeypatch):
    from cosimo.orchestrator.systems import cases

    slower(monkeypatch, 100.0)
    found = find(replace(cases()["en50318-2002"], studies=()), Options(in_process=True))
    assert found.unverified == ""
    assert sum(row.error > 0.0 for row in found.rows) > 10
    deviation = next(row for row in found.rows if row.reference.measure == "std")
    assert 0.0 < deviation.error < 0.5
