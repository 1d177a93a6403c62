"""The system that `docs/new-system.md` adds: its files, and what it writes into the shared lists."""

from __future__ import annotations

import re

from cosimo.tests.architecture.test_sources import ROOT

BLOCK = re.compile(r"^`([\w./-]+)`:\n\n```\w+\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILES = dict(BLOCK.findall((ROOT / "docs" / "new-system.md").read_text(encoding="utf-8")))
# file -> (before, after): the shared files that know of a system
LISTS = {
    "components/catalogue.py": (
        '    "Pantograph": "railway.pantograph",\n',
        '    "Pantograph": "railway.pantograph",\n    "DuffingOscillator": "duffing.oscillator",\n',
    ),
    "orchestrator/systems/__init__.py": ('"pipe_robot", "wrist")', '"pipe_robot", "wrist", "duffing")'),
}
