"""What tests of reports look at: figures, tables and curves by name, and whether a figure can be drawn."""

import json
import re

import numpy as np
import plotly.graph_objects as go
from cosimo.orchestrator.harness.charts.style import SAMPLES


def figures(blocks):
    """Title -> figure of the blocks of a report that are figures."""
    return {b.title: b.figure for b in blocks if b.kind == "figure"}


def tables(blocks):
    """Title -> block of the blocks of a report that are tables."""
    return {b.title: b for b in blocks if b.kind == "cells"}


def drawn(figure, name):
    """The curves of a figure with this name."""
    return [t for t in figure["data"] if t.get("name") == name]


def numbers(values):
    """Values of a curve, (n,), NaN in its gaps."""
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def assert_valid_with_units(figure, unit):
    """Plotly and JSON take the figure, as it stands in a page, and the title of every axis that has one matches `unit`."""
    figure = {**figure, "data": [{k: v for k, v in trace.items() if k != SAMPLES} for trace in figure["data"]]}
    go.Figure(figure)  # raises for properties Plotly does not know
    json.dumps(figure, allow_nan=False)
    for key, axis in figure["layout"].items():
        if re.fullmatch(r"[xy]axis\d*", key) and axis["title"]["text"]:
            assert unit.search(axis["title"]["text"]), axis["title"]["text"]
