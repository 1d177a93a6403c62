"""What an import brings along: the package and its command line start without the libraries that only some commands need."""

from __future__ import annotations

import subprocess
import sys

import pytest
from cosimo.orchestrator.systems import SYSTEMS

HEAVY = {
    "numpy",
    "scipy",
    "numba",
    "pandas",
    "xarray",
    "pyarrow",
    "plotly",
    "jinja2",
    "pydantic",
    "fmpy",
    "pythonfmu",
    "lxml",
    "matplotlib",
    "rich",
}


def imported(*arguments: str) -> set[str]:
    """Names of all modules that a new process imports, from the log of `python -X importtime`."""
    done = subprocess.run([sys.executable, "-X", "importtime", *arguments], capture_output=True, text=True, check=True)
    lines = [line for line in done.stderr.splitlines() if line.startswith("import time:")]
    assert len(lines) > 10, done.stderr
    return {line.rpartition("|")[2].strip() for line in lines}


@pytest.mark.parametrize(
    "arguments", [("-c", "import cosimo"), ("-m", "cosimo.orchestrator.cli", "--help")], ids=["import cosimo", "cosimo --help"]
)
def test_nothing_heavy_is_imported(arguments):
    """The seconds are in tests/benchmarks/test_start_speed.py."""
    modules = imported(*arguments)
    assert "cosimo" in modules
    assert {name.split(".")[0] for name in modules} & HEAVY == set()


def test_importing_the_package_imports_none_of_its_parts():
    parts = {name for name in imported("-c", "import cosimo") if name.startswith("cosimo.")}
    assert not [name for name in parts if name.split(".")[1] in {"components", "fmus", "orchestrator", "tests"}]


def test_no_part_of_a_run_or_of_its_summary_imports_scipy_before_it_calls_it():
    """Numba looks whether SciPy is there, which loads its root and nothing of its parts."""
    summaries = [f"{system.package}.summary" for system in SYSTEMS.values() if system.module("summary")]
    modules = imported("-c", f"import cosimo.orchestrator.run, {', '.join(summaries)}")
    assert "cosimo.orchestrator.systems.wrist.summary" in modules
    parts = {name for name in modules if name.startswith("scipy.") and not name.split(".")[1].startswith("_")}
    assert parts <= {"scipy.version"}
