"""Writes docs/papers/index.md, all claims of all papers with their verdicts: `python docs/papers/overview.py`.

Verdicts are those of the last review, which `cosimo validate papers` compares with what it measures.
"""

from __future__ import annotations

from pathlib import Path

from cosimo.orchestrator.harness.validation.claims import CONSTRUCTION, MEANINGS
from cosimo.orchestrator.harness.validation.reference import Table, load_table
from cosimo.orchestrator.systems import cases, papers

HERE = Path(__file__).resolve().parent
HEAD = """# The papers, claim by claim

Each system of this project is documented by a paper of which the abstract is public. This page lists what the abstracts
announce, in our words, and what a run here shows of it. "Model" claims are shown by equations, effects and tests,
"findings" by measured rows whose criteria were derived before the runs. No number is one of a paper's own tables.

`cosimo validate papers` runs all of them in some minutes, `cosimo validate paper-ball-bearing` one.

"""
FOOT = "\n" + "\n".join(f"- **{verdict}**: {meaning}." for verdict, meaning in MEANINGS.items()) + "\n"
CONSTRUCTED = """
## Rows by construction

{count} rows state an assumption or an input of the model, the definition of a measure, or one reference by another: no run can put
them outside their range, only a defect of the code can. They stand in reports with these words and support no claim.

| claim | row | rows |
|---|---|---|
"""


def text() -> str:
    """The whole page."""
    tables = {name: load_table(name) for name in papers()}
    tables = dict(sorted(tables.items(), key=lambda item: item[1].claims[0].number))
    return (
        HEAD + "\n".join(_section(name, table) for name, table in tables.items()) + FOOT + _counts(tables) + _constructed(tables)
    )


def _counts(tables: dict[str, Table]) -> str:
    """How many claims have which verdict."""
    verdicts = [claim.verdict for table in tables.values() for claim in table.claims]
    words = ", ".join(f"{verdicts.count(v)} {v}" for v in MEANINGS if v in verdicts)
    return f"\nOf {len(verdicts)} claims: {words}.\n"


def _constructed(tables: dict[str, Table]) -> str:
    """The rows that cannot fail, with their claims."""
    rows: dict[tuple[str, str], int] = {}
    for row in (row for table in tables.values() for row in table.rows if row.role == CONSTRUCTION):
        key = row.claim, row.quantity
        rows[key] = rows.get(key, 0) + 1
    lines = [f"| {claim} | {quantity} | {count} |" for (claim, quantity), count in rows.items()]
    return CONSTRUCTED.format(count=sum(rows.values())) + "\n".join(lines) + "\n"


def _section(name: str, table: Table) -> str:
    """One paper: its claims as a table."""
    page = name.removeprefix("paper-")
    lines = [
        f"## [{cases()[name].title}]({page}.md)",
        "",
        f"`cosimo validate {name}`",
        "",
        "| | the abstract announces | kind | verdict |",
        "|---|---|---|---|",
    ]
    lines += [f"| {c.number} | {c.announced} | {c.kind} | {c.verdict} |" for c in table.claims]
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    (HERE / "index.md").write_text(text(), encoding="utf-8")
