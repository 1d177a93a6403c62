"""The whole case of docs/own-cases.md, as it stands there."""

from __future__ import annotations

import re

from cosimo.orchestrator.systems import validate
from cosimo.tests.architecture.test_sources import ROOT

PAGE = (ROOT / "docs" / "own-cases.md").read_text(encoding="utf-8")
FILES = re.findall(r"^`([\w.]+)`:\n\n```\w+\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_the_case_of_the_page_passes_and_draws_its_chart(tmp_path):
    assert [name for name, _ in FILES] == ["period.toml", "period.csv", "period.py"]
    for name, text in FILES:
        (tmp_path / name).write_text(text, encoding="utf-8")
    (case,) = validate([str(tmp_path / "period.toml")], tmp_path / "out", in_process=True)
    assert case.outcome == "passed", case
    (chart,) = case.findings.charts
    assert chart.title == "Free oscillation, with a period of 0.641 s on the softer spring"
    assert [s.name for s in chart.panels[0].series] == ["100 N/m", "400 N/m", "closed form, 100 N/m"]
    run, _, closed = chart.panels[0].series
    assert max(abs(run.y - closed.y)) < 1.0  # mm, of a swing of 75
