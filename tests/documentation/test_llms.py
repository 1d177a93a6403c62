"""llms.txt, which programs read first: its recipes are commands that the tests of the pages execute, its links are pages."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "llms.txt").read_text(encoding="utf-8")


def test_recipes_are_executed_with_the_pages():
    executed = [
        line.partition("  #")[0].strip()
        for page in DOCS.glob("*.md")
        for block in re.findall(r"```bash\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
        for line in block.splitlines()
    ]
    recipes = re.findall(r"^- .*: `(cosimo .*)`$", TEXT, re.MULTILINE)
    assert len(recipes) > 5
    assert [r for r in recipes if r not in executed] == []


def test_links_are_pages():
    links = re.findall(r"\]\((.*?)\.html\)", TEXT)
    assert [link for link in links if not (link.startswith("generated/") or (DOCS / f"{link}.md").is_file())] == []
