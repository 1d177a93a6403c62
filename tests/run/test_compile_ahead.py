"""Entries that a scene lacks are compiled by several processes; what they do not come to is compiled when it is asked for."""

import json
import subprocess
import sys
import threading

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.opened import compile_ahead as ahead
from cosimo.orchestrator.systems import load_scene

pytestmark = pytest.mark.skipif(not COMPILED, reason="nothing is compiled")

PROGRAM = """
import json, os, sys
from cosimo.components.core import kept_kernels
from cosimo.orchestrator.opened import compile_ahead as ahead
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.run.run_info import CompileTime
from cosimo.orchestrator.units.component import make

parent, log, compiled = os.getpid(), open(sys.argv[1], "a"), kept_kernels._compiled
ahead.WORTH, ahead._cores = 0.0, lambda: 2

def watched(kernel, *more):
    if sys.argv[2] == "dies" and os.getpid() != parent:
        os._exit(1)
    print(os.getpid() == parent, kernel.__name__, file=log, flush=True)
    return compiled(kernel, *more)

kept_kernels._compiled = watched
scene = load_scene("mass-on-spring")
with CompileTime() as compiling:
    left = 0
    if sys.argv[2] != "serial":
        wanted = ahead.wanted_by(scene, {})
        ahead.compile_ahead(wanted)
        left = sum(bool(kept_kernels.missing(*one)) for one in wanted)
try:
    os.waitpid(-1, os.WNOHANG)
    children = True
except ChildProcessError:
    children = False
rows = []
for name, unit in scene.units.items():
    component = make(name, unit)
    component.initialize(0.0)
    for k in range(20):
        component.step(0.01 * k, 0.01)
        rows.append(component.y.tolist())
print(json.dumps([left, children, compiling.seconds > 0.0, rows]))
"""


def started(tmp_path, monkeypatch, how):
    """Of a process with an empty cache what is left, whether children are, whether compiling took time, and rows of outputs; of
    each entry that was compiled whether the first process did it, and the kernel."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / how))
    log = tmp_path / f"{how}.txt"
    done = subprocess.run([sys.executable, "-c", PROGRAM, log, how], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in log.read_text().splitlines()]
    return json.loads(done.stdout), [(first == "True", kernel) for first, kernel in lines]


@pytest.mark.skipif(sys.platform != "linux", reason="nothing is forked")
def test_two_processes_compile_each_entry_once_and_the_same_bits_come_out(tmp_path, monkeypatch):
    (*state, rows), compiled = started(tmp_path, monkeypatch, "together")
    (*_, expected), alone = started(tmp_path, monkeypatch, "serial")
    assert state == [0, False, True]
    assert {first for first, _ in compiled} == {True, False}
    assert sorted(kernel for _, kernel in compiled) == sorted(kernel for _, kernel in alone)
    assert rows == expected


@pytest.mark.full
@pytest.mark.skipif(sys.platform != "linux", reason="nothing is forked")
def test_what_a_process_that_dies_leaves_is_compiled_when_it_is_asked_for(tmp_path, monkeypatch):
    (left, children, _, rows), compiled = started(tmp_path, monkeypatch, "dies")
    assert left
    assert not children
    assert all(first for first, _ in compiled)
    assert rows


def test_one_process_compiles_inside_of_workers_and_beside_other_threads(monkeypatch):
    assert ahead._cores() == 1  # these tests run in workers, or else
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    go = threading.Event()
    other = threading.Thread(target=go.wait)
    other.start()
    try:
        assert ahead._cores() == 1
    finally:
        go.set()
        other.join()


def test_the_longest_comes_first_and_entries_of_a_kernel_that_is_new_stay_together():
    scene = load_scene("en50318-2002")
    effects = {"units.catenary.effects": [*scene.units["catenary"].effects, "bending_stiffness"]}
    shipped, stiff = ahead.wanted_by(scene, {}), ahead.wanted_by(scene.with_changes(effects), {})
    jobs = [[kernel.__name__ for kernel, *_ in job] for job in ahead._jobs([*shipped, *stiff], [*shipped, *stiff[:2]])]
    assert jobs[0] == ["catenary_initialize"] * 2
    assert ["catenary_step"] * 2 in jobs
    jobs = [[kernel.__name__ for kernel, *_ in job] for job in ahead._jobs([*shipped, *stiff], [*shipped[1:], *stiff[:2]])]
    assert ["catenary_initialize"] in jobs
    assert ["catenary_step"] * 2 in jobs
