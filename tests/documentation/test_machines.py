"""Drawings of machines: one for each component and scene, readable on a telephone, by readers of screens, in every theme."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.systems import SYSTEMS

MACHINES = {name: draw for s in SYSTEMS.values() if (m := s.module("machines")) for name, draw in m.MACHINES.items()}
SVG = "{http://www.w3.org/2000/svg}"
LETTERS = 7.0  # px, width of one of a label, about


def test_every_component_has_a_drawing_and_nothing_else_has():
    missing = {name: component_class(name).system for name in CATALOGUE if name not in MACHINES}
    assert not missing, ", ".join(
        f"{name} has no drawing: add MACHINES in orchestrator/systems/{system}/machines.py" for name, system in missing.items()
    )
    assert sorted(MACHINES) == sorted(CATALOGUE)


@pytest.mark.parametrize("name", sorted(MACHINES))
def test_a_drawing_has_words_fits_a_telephone_and_takes_the_colour_of_the_page(name):
    machine = MACHINES[name]()
    text = machine.svg("drawing")
    root = ElementTree.fromstring(text)
    title, description = root.find(f"{SVG}title"), root.find(f"{SVG}desc")
    assert root.get("aria-labelledby") == f"{title.get('id')} {description.get('id')}"
    assert title.text
    assert len(description.text) > 30
    assert machine.width <= 360  # px: as large as it is, without being made smaller
    assert set(re.findall(r'(?:stroke|fill)="([^"]+)"', text)) <= {"none", "currentColor"}
    for label in root.iter(f"{SVG}text"):  # no letter beyond the edge
        width = LETTERS * len("".join(label.itertext()))
        left = float(label.get("x")) - {"start": 0.0, "middle": 0.5, "end": 1.0}[label.get("text-anchor")] * width
        assert left >= -3, "".join(label.itertext())
        assert left + width <= machine.width + 3, "".join(label.itertext())
        assert 0 <= float(label.get("y")) <= machine.height
