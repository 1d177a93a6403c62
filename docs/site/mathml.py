"""Formulas as MathML, which browsers draw themselves: no script, no fonts, no other host."""

from __future__ import annotations

from html import escape
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError


def _mathml(node: nodes.Element, display: str) -> str:
    try:
        return convert(node.astext(), display=display)
    except Exception as error:
        raise ExtensionError(f"formula {node.astext()!r}: expected LaTeX that becomes MathML; {error}") from error


def visit_math(self: Any, node: nodes.Element) -> None:
    """A formula within a line."""
    self.body.append(f'<span class="formula">{_mathml(node, "inline")}</span>')
    raise nodes.SkipNode


def visit_displaymath(self: Any, node: nodes.Element) -> None:
    """A formula of its own, with its number if it has one."""
    number = f'<span class="eqno">({node["number"]})</span>' if node.get("number") else ""
    anchors = "".join(f'<span id="{escape(i)}"></span>' for i in node.get("ids", ()))
    self.body.append(f'<div class="formula">{anchors}{number}{_mathml(node, "block")}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Offer the renderer "mathml"."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
