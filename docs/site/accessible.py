"""Sphinx extension: what theme and markup leave out for readers with other means than a mouse and eyes, put into the pages written.

Each rule is one of axe-core, with which `tests/documentation/test_site.py` looks at pages.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

RULES = (
    (r'role="heading">', 'role="heading" aria-level="2">'),  # captions of the navigation
    (r'<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="All pages">'),
    (r'<aside class="toc-drawer', '<aside aria-label="On this page" class="toc-drawer'),
    (r'<th class="([^"]*)"><p></p></th>', r'<td class="\1"></td>'),  # a heading that names nothing
)
PARAMETERS = re.compile(r'<dl>\s*((?:<dd><em class="sig-param">.*?</dd>\s*)+)</dl>', re.DOTALL)  # a list without terms
ARTICLE = re.compile(r'(<article role="main"[^>]*>)')


def improve(text: str, search: bool = False) -> str:
    """The text of a page with these rules kept; search: it has no heading of its own."""
    for pattern, put in RULES:
        text = re.sub(pattern, put, text)
    text = PARAMETERS.sub(
        lambda match: f'<div class="parameters">{match[1].replace("<dd>", "<div>").replace("</dd>", "</div>")}</div>', text
    )
    return ARTICLE.sub(r"\1<h1>Search</h1>", text) if search else text


def improve_all(app: Any, exception: Exception | None) -> None:
    """All pages of a build that succeeded."""
    if exception is None and app.builder.format == "html":
        for path in Path(app.outdir).rglob("*.html"):
            text = path.read_text(encoding="utf-8")
            if (better := improve(text, path.name == "search.html")) != text:
                path.write_text(better, encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("build-finished", improve_all)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
