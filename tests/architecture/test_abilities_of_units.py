"""What a unit may offer stands in `units/interface.py`: nobody looks for an attribute of a unit, or adds one from outside."""

from __future__ import annotations

import ast

import pytest
from cosimo.orchestrator.units.interface import Simulator
from cosimo.tests.architecture.test_imports import ROOT, modules

LOOKS = ("hasattr", "getattr", "setattr")


def is_unit(node: ast.expr) -> bool:
    """Whether an expression is a started unit, by the names that the tree has for one: `unit`, `node.unit`, `self.units[name]`."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "get":
        return is_units(node.func.value)
    if isinstance(node, ast.Subscript):
        return is_units(node.value)
    name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
    return name.lstrip("_") in ("unit", "simulator", "fmu")


def is_units(node: ast.expr) -> bool:
    return ast.unparse(node).rpartition(".")[2].lstrip("_") in ("units", "simulators")


def looks(source: str) -> list[str]:
    """Calls in a module that look for an attribute of a unit."""
    calls = [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name) and n.args]
    return [ast.unparse(n) for n in calls if n.func.id in LOOKS and is_unit(n.args[0])]  # type: ignore[attr-defined]


def test_a_look_is_seen():
    wrong = 'hasattr(unit, "a"), getattr(node.unit, "b", None), getattr(self.units.get(n), "c", 0), getattr(units[n], "d")'
    assert len(looks(wrong)) == 4
    assert looks('getattr(scene.master, "step"), hasattr(os, "getuid"), getattr(self, name)') == []


def test_nobody_looks_for_an_ability_of_a_unit():
    found = {p.relative_to(ROOT).as_posix(): there for p in modules("orchestrator") if (there := looks(p.read_text("utf-8")))}
    assert found == {}


@pytest.mark.parametrize("module", ["units.component", "units.fmi2", "units.fmi3", "units.model_exchange", "units.process"])
def test_units_offer_nothing_under_a_name_that_the_interface_has_not(module):
    """A public method of a unit is one of the interface, or of the few that its own module's callers know by its class."""
    path = ROOT / "orchestrator" / f"{module.replace('.', '/')}.py"
    known = set(dir(Simulator)) | set(Simulator.__annotations__)
    classes = [n for n in ast.parse(path.read_text("utf-8")).body if isinstance(n, ast.ClassDef)]
    of_units = [c for c in classes if any("Simul" in ast.unparse(b) or "Exchange" in ast.unparse(b) for b in c.bases)]
    assert of_units
    public = {f.name for c in of_units for f in c.body if isinstance(f, ast.FunctionDef) and not f.name.startswith("_")}
    assert public - known <= {"begin_steps", "count", "hold_anew"}  # of `SteppedFmu`; of FMI 2 to itself
