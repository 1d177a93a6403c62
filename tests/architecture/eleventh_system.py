"""The system that `docs/new-system.md` adds: its files, what it writes into the shared lists, and the commands, in their order."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from cosimo.tests.architecture.test_sources import ROOT

PAGE = (ROOT / "docs" / "new-system.md").read_text(encoding="utf-8")
FILE = re.compile(r"^`([\w./-]+)`:\n\n```\w+\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMANDS = re.compile(r"^```text\n((?:(?:cosimo|pytest) .*\n)+)```$", re.MULTILINE)
# file -> (pattern, what stands behind it) ...: the shared files that know of a system, whatever stands last in them
LISTS = {
    "components/catalogue.py": [(r"(?s)\nCATALOGUE = \{.*?(?=\n\})", '\n    "DuffingOscillator": "duffing.oscillator",')],
    "orchestrator/systems/__init__.py": [(r"\nNAMES = \([^)]*?(?=,?\s*\))", ', "duffing"')],
    "README.md": [
        (
            r"(\n\| \[\w+\]\(docs/systems/[^\n]*)+",
            "\n| [duffing](docs/systems/duffing.md) | spring | `duffing-free` | closed form |",
        )
    ],
    "docs/index.md": [
        (r"(\n- \[[^\n]*\]\(systems/[^\n]*)+", "\n- [Duffing oscillator](systems/duffing.md): a mass on a spring that stiffens"),
        (r"(\nsystems/\w+)+", "\nsystems/duffing"),
    ],
    "docs/validation.md": [
        (r"\n\| case \|[^\n]*(\n\|[^\n]*)+", "\n| `duffing-free` | frequency of an oscillator | closed form |")
    ],
}


def steps() -> list[tuple[str, str]]:
    """What the page does, from top to bottom: (name of a file, its text), (name of a list, "") or ("", command)."""
    places = [(m.start(), m[1], m[2]) for m in FILE.finditer(PAGE)]
    places += [(PAGE.index(f"`{name}`"), name, "") for name in LISTS]  # where the page says it first
    places += [(m.start() + k, "", line) for m in COMMANDS.finditer(PAGE) for k, line in enumerate(m[1].splitlines())]
    return [(name, text) for _, name, text in sorted(places)]


def write(root: Path, name: str, text: str) -> None:
    """A step of the page that is a file or the line of a list, in the tree below `root`."""
    path = root / name
    if name in LISTS:
        text = path.read_text(encoding="utf-8")
        for pattern, line in LISTS[name]:
            text, count = re.subn(pattern, lambda found, line=line: found[0] + line, text)
            assert count == 1, (name, pattern)
    else:
        assert not path.exists(), name
        path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def arguments(command: str) -> list[str]:
    """Those of Python for a command of the page."""
    name, *others = shlex.split(command)
    return ["-m", {"cosimo": "cosimo.orchestrator.cli"}.get(name, name), *others]
