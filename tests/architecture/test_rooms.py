"""What each part of the tree may know: the engine stays general, the harness has no system's name in it."""

from __future__ import annotations

import ast
import re

import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.systems import NAMES, SYSTEMS
from cosimo.tests.architecture.test_imports import ROOT, dotted, modules, relative_imports

SEVERAL = 13  # names of classes that mean more than one thing
OTHER_WORDS = {"bearings", "rotor"}  # also words of mechanics, which texts on spectra need


def test_the_engine_knows_no_component_no_system_and_no_page():
    wanted = {i for p in modules("orchestrator/engine") for i in relative_imports(p)}
    assert {i for i in wanted if i.startswith("components.") and not i.startswith("components.core")} == set()
    assert {i for i in wanted if i.startswith(("orchestrator.harness", "orchestrator.systems", "orchestrator.cli"))} == set()


@pytest.mark.parametrize("folder", ["engine", "units", "settings", "harness"])
def test_no_system_and_no_component_is_named(folder):
    """In code; an example in a docstring may name one."""
    names = {*(NAMES if folder != "harness" else set(NAMES) - OTHER_WORDS), *CATALOGUE}
    quoted = re.compile(r"[\"'](" + "|".join(sorted(names)) + r")[\"'.]")
    found = {}
    for path in modules(f"orchestrator/{folder}"):
        code = re.sub(r'"""(.|\n)*?"""', "", path.read_text(encoding="utf-8"))
        if named := set(quoted.findall(code)):
            found[dotted(path)] = named
    assert found == {}


@pytest.mark.parametrize("name", NAMES)
def test_a_system_has_folders_of_its_name(name):
    assert SYSTEMS[name].name == name
    for folder in (
        f"components/{name}",
        f"orchestrator/systems/{name}/cases",
        f"orchestrator/systems/{name}/scenes",
        f"tests/systems/{name}",
    ):
        assert (ROOT / folder).is_dir(), folder
    assert (ROOT / f"orchestrator/systems/{name}/figures.py").is_file() or (
        ROOT / f"orchestrator/systems/{name}/figures"
    ).is_dir()


def test_few_names_of_classes_stand_for_several_things():
    """A reader who meets a name knows which it is; what a single system calls its own is no matter here."""
    places: dict[str, list[str]] = {}
    for path in modules("orchestrator"):
        name = dotted(path)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_") and not name.startswith("orchestrator.systems"):
                places.setdefault(node.name, []).append(name)
    several = {name: there for name, there in places.items() if len(there) > 1}
    assert several.keys().isdisjoint({"Row", "Rows", "Comparison", "Limit", "Stability", "State", "Recorded"})
    assert len(several) <= SEVERAL, several
