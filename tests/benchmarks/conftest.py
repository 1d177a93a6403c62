"""Tables of docs/speed.md: benchmarks tell rows, which are printed, and with `--write-page` written to the page.

    pytest -n 0 tests/benchmarks --write-page

A table of the page stands between `<!-- measured: NAME -->` and `<!-- end -->`. It is replaced as a whole where a benchmark of this
session told rows of it; other tables stay. The line below a table says version, machine, day and what else the machine had to do.
"""

import os
import platform
import re
from datetime import date
from pathlib import Path

import pytest
from cosimo.fmus.versions import version

PAGE = Path(__file__).parents[2] / "docs" / "speed.md"
TABLES = pytest.StashKey["Tables"]()


def machine() -> str:
    """Processor, cores, Python, and the processes that wanted a core when the session began."""
    try:
        processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8")).group(1)
    except (OSError, AttributeError):
        processor = platform.processor() or platform.machine()
    load = f", load {os.getloadavg()[0]:.1f} before" if hasattr(os, "getloadavg") else ""
    return f"{processor}, {os.cpu_count()} cores, Python {platform.python_version()}{load}"


class Tables:
    """Rows by table, in the order in which they were told; one that is told again gets more columns."""

    def __init__(self):
        self.machine = machine()
        self.rows: dict[str, dict[str, dict[str, str]]] = {}

    def __call__(self, table: str, label: str, **columns: object) -> None:
        """A row: its label, and by heading its cells. Numbers get three significant digits.

        `_` in a heading is a space, and the letter mu, which Python makes of the sign for micro in a name, is that sign.
        """
        cells = {name.replace("_", " ").replace("\u03bc", "\u00b5"): _cell(value) for name, value in columns.items()}
        self.rows.setdefault(table, {}).setdefault(label, {}).update(cells)
        print(f"\n  {table}: {label}: " + ", ".join(f"{name} {cell}" for name, cell in cells.items()), end="")

    def target(self, label: str, measured: float, wanted: float, unit: str, least: bool = False) -> None:
        """A row of the table of targets: a quantity that is to be at most, or at least, what is wanted."""
        met = measured >= wanted if least else measured <= wanted
        bound = f"{'at least' if least else 'at most'} {_cell(wanted)} {unit}"
        self("targets", label, wanted=bound, measured=f"{_cell(measured)} {unit}", met="yes" if met else "**no**")

    def written(self, page: str) -> str:
        """The page with all tables of this session. Raises `KeyError` for a table that the page has no place for."""
        for name, rows in self.rows.items():
            place = re.compile(rf"(<!-- measured: {re.escape(name)} -->\n).*?(?=<!-- end -->)", re.DOTALL)
            if not place.search(page):
                raise KeyError(f"docs/speed.md has no table `{name}`")
            heads = list(dict.fromkeys(head for cells in rows.values() for head in cells))
            lines = [
                ["", *heads],
                ["---"] * (len(heads) + 1),
                *([label, *(c.get(h, "") for h in heads)] for label, c in rows.items()),
            ]
            table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
            told = f"Version {version('cosimo')}, {date.today().isoformat()}: {self.machine}."
            page = place.sub(lambda found, text=f"\n{table}\n\n{told}\n\n": found.group(1) + text, page)
        return page


def _cell(value: object) -> str:
    if not isinstance(value, float):
        return str(value)
    return f"{value:,.0f}".replace(",", " ") if abs(value) >= 1000.0 else f"{value:.3g}"


def pytest_addoption(parser):
    parser.addoption("--write-page", action="store_true", help="write the measured tables to docs/speed.md")


def pytest_configure(config):
    config.stash[TABLES] = Tables()


@pytest.fixture(scope="session")
def told(request):
    """Takes rows: `told(table, label, heading=cell, ...)`, and targets: `told.target(label, measured, wanted, unit)`."""
    return request.config.stash[TABLES]


def pytest_sessionfinish(session):
    tables = session.config.stash[TABLES]
    if session.config.getoption("--write-page") and tables.rows:
        PAGE.write_text(tables.written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
