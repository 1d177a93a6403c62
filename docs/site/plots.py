"""Runs at the start of each notebook of the site: a Plotly figure is shown with the site's one copy of the library.

Plotly's own output has a MIME type that documentation pages do not show, or a copy of the library in each figure.
"""

from __future__ import annotations

from html import escape
from typing import Any

SCRIPT = "../_static/plotly.min.js"  # from a page in a folder


def _show(figure: Any) -> None:
    from IPython.display import HTML, display

    html = figure.to_html(
        full_html=False,
        include_plotlyjs=SCRIPT,
        include_mathjax=False,
        config={"displaylogo": False},
        default_height=figure.layout.height or 420,
    )
    display(HTML(f'<div class="plot" role="group" aria-label="{escape(_name(figure), quote=True)}">{html}</div>'))


def _name(figure: Any) -> str:
    """What is drawn over what, from the titles of the axes."""
    layout = figure.to_dict()["layout"]
    x, y = (
        [a.get("title", {}).get("text", "") for k, a in sorted(layout.items()) if k.startswith(f"{axis}axis")] for axis in "xy"
    )
    return f"Figure: {', '.join(filter(None, y)) or 'curves'} over {', '.join(filter(None, x)) or 'time'}"


def _register() -> None:
    from IPython import get_ipython

    formatter = get_ipython().display_formatter.ipython_display_formatter  # asked first; Plotly's own would be taken otherwise
    formatter.for_type_by_name("plotly.graph_objs._figure", "Figure", _show)


_register()
