"""The site's search knows texts of pages, not those of pictures: figures of tutorials, drawings, curves, live scenes."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.builders.html import StandaloneHTMLBuilder


class Builder(StandaloneHTMLBuilder):
    """HTML whose index of the search is made without raw HTML, which here is pictures only."""

    def index_page(self, pagename: str, doctree: nodes.document, title: str) -> None:
        """Hand a page without pictures to the index."""
        searched = doctree.deepcopy()
        for node in list(searched.findall(nodes.raw)):
            node.parent.remove(node)
        super().index_page(pagename, searched, title)


def setup(app: Any) -> dict[str, bool]:
    """Take the place of Sphinx's builder."""
    app.add_builder(Builder, override=True)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
