"""What holds for all tests, and the fixtures that several folders share."""

# ruff: noqa: E402
import gc
import os
import shutil
import signal
import sys
import tempfile
from collections import Counter
from functools import partial
from pathlib import Path

import cosimo

ROOT = Path(__file__).resolve().parents[1]
if (tested := Path(cosimo.__file__).resolve().parent) != ROOT:  # before anything of another tree is imported
    sys.exit(f"{ROOT}: these tests would test {tested}, expected the package in their own folder. Run pip install -e . in {ROOT}")

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.interrupts import STOPPING
from cosimo.tests.plain_python import keep_compliance_tables
from cosimo.tests.systems.railway.made_up import run  # noqa: F401
from cosimo.tests.units.foreign_fmu import foreign  # noqa: F401
from hypothesis import HealthCheck, settings

os.environ.pop("COLUMNS", None)  # of the terminal of whoever runs the tests: tables are whole
# The tests hold on a machine that is busy: none fails because an example took long.
settings.register_profile("busy machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy machine")

if not COMPILED:
    keep_compliance_tables()

# A worker has each file as a whole: started last, these would be waited for. The dearest first, see docs/development/tests.md.
LONG = (
    "test_plain_python.py",
    "test_as_shipped.py",
    "test_scene_fmu.py",
    "test_readme.py",
    "test_native_run.py",
    "test_native_bits.py",
    "test_wasm32.py",
    "test_processes.py",
    "test_site.py",
    "test_independent_accuracy.py",
)


def pytest_configure(config):
    """One thread for BLAS, signals that end a run, and byte code.

    Two processes share the cores. Threads of BLAS wait for one another by spinning: `expm` of a matrix of nine rows takes 2 ms of
    CPU and 10 ms in all, with one thread 16 us. Workers of xdist and processes that tests start inherit the variables.
    Tests that were started in the background or by `nohup` inherit ignored signals, which every run would respect.
    Where no byte code shall be written beside the sources, that of this session stands in a folder of its own: hundreds of processes
    would each compile the sources, which is two thirds of what a command like `cosimo list` takes.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", "") and "PYTHONPYCACHEPREFIX" not in os.environ:
        folder = os.environ["PYTHONPYCACHEPREFIX"] = tempfile.mkdtemp(prefix="cosimo-byte-code-")
        config.add_cleanup(partial(shutil.rmtree, folder, ignore_errors=True))
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    for number in STOPPING:
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)


def pytest_collection_modifyitems(config, items):
    """Long files first, where xdist keeps this order (`--no-loadscope-reorder`).

    Of all tests, those marked `interpreted` are left to the process of `test_plain_python.py`, but for the `full` ones, which
    the complete run compiles. Those marked `first(n)`, n = 1 if not given, keep n of their parameters in the short run.
    """
    items.sort(key=lambda item: LONG.index(item.path.name) if item.path.name in LONG else len(LONG))
    kept = Counter()
    for item in items:
        if (first := item.get_closest_marker("first")) and not item.get_closest_marker("full"):
            test = item.nodeid.partition("[")[0]
            kept[test] += 1
            if kept[test] > (first.args or (1,))[0]:
                item.add_marker(pytest.mark.full)
    whole = COMPILED and [Path(argument).name for argument in config.args] == ["tests"]
    elsewhere = [
        item
        for item in items
        if (COMPILED and item.get_closest_marker("uncompiled"))
        or (whole and item.get_closest_marker("interpreted") and not item.get_closest_marker("full"))
    ]
    config.hook.pytest_deselected(items=elsewhere)
    out = set(elsewhere)
    items[:] = [item for item in items if item not in out]


def pytest_terminal_summary(terminalreporter):
    """What was skipped, counted by its reason: nothing that a test needs is missing silently."""
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in terminalreporter.stats.get("skipped", ()))
    if reasons:
        terminalreporter.section("skipped, by reason")
        for reason, count in reasons.most_common():
            terminalreporter.line(f"{count:5d}  {reason}")


def pytest_collection_finish(session):
    """The compiler makes millions of small objects, and thousands of tests stay: garbage is sought in what is new, seldom."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
