"""Whatever exists is listed, and whatever is listed loads."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
from cosimo import components
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.component import Component
from cosimo.orchestrator import systems
from cosimo.orchestrator.engine.algorithms import Algorithm, class_of
from cosimo.orchestrator.harness.validation.reference import STANDINGS, load_table, table_files
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.settings.algorithms import ALGORITHMS
from cosimo.orchestrator.systems import SYSTEMS, cases, load_scene, read_scene
from cosimo.tests.support import two_masses

TABLES = sorted(table_files())


def all_modules(package):
    """Every module below a package, imported."""
    return [importlib.import_module(m.name) for m in pkgutil.walk_packages(package.__path__, package.__name__ + ".")]


def test_every_component_is_in_the_catalogue():
    """A concrete component has a title; bases of families have none."""
    written = {
        (name, module.__name__.removeprefix("cosimo.components."))
        for module in all_modules(components)
        if not module.__name__.startswith("cosimo.components.core.")
        for name, cls in vars(module).items()
        if inspect.isclass(cls) and issubclass(cls, Component) and cls.__module__ == module.__name__ and cls.title
    }
    assert written == set(CATALOGUE.items())


@pytest.mark.parametrize("name", CATALOGUE)
def test_catalogue_entries_load_under_their_own_name(name):
    cls = component_class(name)
    assert cls.__name__ == name
    assert cls.title
    assert cls.system


def test_every_function_that_measures_is_asked_for():
    """What a case's file names is there, and no module with a `measure` is without a case."""
    asked, written = set(), set()
    for system in SYSTEMS.values():
        folder = Path(systems.__file__).parent / system.name / "cases"
        for path in folder.glob("*.toml"):
            named = [q["measure"] for q in tomllib.loads(path.read_text(encoding="utf-8"))["questions"] if "measure" in q]
            for module, _, function in (name.partition(":") for name in named):
                found = import_module(f"{system.package}.cases.{module}")
                assert callable(getattr(found, function or "measure"))
                asked.add(found.__name__)
        modules = (import_module(f"{system.package}.cases.{'.'.join(p.relative_to(folder).with_suffix('').parts)}")
                   for p in folder.rglob("*.py") if p.name != "__init__.py")  # fmt: skip
        written |= {m.__name__ for m in modules if hasattr(m, "measure")}
    assert written <= asked


@pytest.mark.parametrize("name", cases())
def test_case_names_are_their_keys(name):
    assert cases()[name].name == name
    assert cases()[name].title


@pytest.mark.parametrize("name", sorted(scene_files()))
def test_every_shipped_scene_loads(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.title


def test_every_algorithm_is_reachable_from_a_scene():
    written = {
        cls
        for module in all_modules(importlib.import_module("cosimo.orchestrator.engine.algorithms"))
        for cls in vars(module).values()
        if inspect.isclass(cls) and issubclass(cls, Algorithm) and cls is not Algorithm
    }
    assert written == set(map(class_of, ALGORITHMS))
    for name in (n for n, of in ALGORITHMS.items() if not of.reduces_contacts):  # that needs a contact, as the scene below has
        assert read_scene(two_masses(name)).master.algorithm == name
    assert load_scene("en50318-2002-interface-model").master.algorithm == "interface-model"


@pytest.mark.parametrize("name", TABLES)
def test_every_row_of_every_table_has_standing_and_source(name):
    rows = load_table(name).rows
    assert rows
    assert [r.quantity for r in rows if r.standing not in STANDINGS or not r.source.strip()] == []


def test_every_preset_says_where_it_was_read():
    for name in CATALOGUE:
        for title, preset in component_class(name).presets.items():
            assert preset.provenance in STANDINGS, (name, title)
            assert preset.source.strip(), (name, title)
