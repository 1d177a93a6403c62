"""Drawings of machines: one for each component and scene, readable on a telephone, by readers of screens, in every theme."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.tests.architecture.test_imports import ROOT

DRAWINGS = {path.stem: path for path in sorted((ROOT / "orchestrator/systems").glob("*/drawings/*.svg"))}
SVG = "{http://www.w3.org/2000/svg}"
LETTERS = 7.0  # px, width of one of a label, about


def stands_for(path):
    return ElementTree.parse(path).getroot().get("data-scenes", "").split()


def test_every_component_and_every_scene_has_a_drawing():
    missing = {name: component_class(name).system for name in CATALOGUE if name not in DRAWINGS}
    assert not missing, ", ".join(
        f"{name} has no drawing: add orchestrator/systems/{system}/drawings/{name}.svg" for name, system in missing.items()
    )
    shown = [scene for path in DRAWINGS.values() for scene in stands_for(path)]
    assert sorted(shown) == sorted(scene_files())
    assert DRAWINGS.keys() - set(CATALOGUE) <= set(scene_files())


@pytest.mark.parametrize("name", sorted(DRAWINGS))
def test_a_drawing_has_words_fits_a_telephone_and_takes_the_colour_of_the_page(name):
    root = ElementTree.fromstring(text := DRAWINGS[name].read_text(encoding="utf-8"))
    title, description = root.find(f"{SVG}title"), root.find(f"{SVG}desc")
    assert root.get("aria-labelledby") == f"{title.get('id')} {description.get('id')}" == "drawing-title drawing-text"
    assert title.text
    assert len(description.text) > 30
    width, height = float(root.get("width")), float(root.get("height"))
    assert width <= 360  # px: as large as it is, without being made smaller
    assert set(re.findall(r'(?:stroke|fill)="([^"]+)"', text)) <= {"none", "currentColor"}
    for label in root.iter(f"{SVG}text"):  # no letter beyond the edge
        wide = LETTERS * len("".join(label.itertext()))
        left = float(label.get("x")) - {"start": 0.0, "middle": 0.5, "end": 1.0}[label.get("text-anchor")] * wide
        assert left >= -3, "".join(label.itertext())
        assert left + wide <= width + 3, "".join(label.itertext())
        assert 0 <= float(label.get("y")) <= height
