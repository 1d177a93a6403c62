"""What a unit is, a component, an FMU or a table, is asked of its kind: few files of the tree look for themselves."""

from __future__ import annotations

import ast

from cosimo.orchestrator.units.kinds import KEYS, UNIT_KINDS
from cosimo.tests.architecture.test_imports import ROOT, modules

FOLDER = ROOT / "orchestrator" / "units" / "kinds"
SIMULATORS = {"ComponentSimulator", "FmuSimulator", "NativeSimulator", "WorkerSimulator"}
OPENED = {"self", "layout", "open_scene", "memory"}  # whose units are started ones, or rows of a table
MOST = 5  # files outside of the folder


def of_units(node: ast.expr) -> bool:
    """Whether an expression is the table of units of a scene: `scene.units`, or a view of it."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in ("items", "values"):
        return of_units(node.func.value)
    if isinstance(node, ast.Call) and node.args and ast.unparse(node.func) in ("sorted", "list"):
        return of_units(node.args[0])
    return isinstance(node, ast.Attribute) and node.attr == "units" and ast.unparse(node.value).rpartition(".")[2] not in OPENED


def a_unit(node: ast.expr) -> bool:
    """Whether an expression is the settings of one unit: `scene.units[name]`, `scene.units.get(name)`."""
    if isinstance(node, ast.Subscript):
        return of_units(node.value)
    get = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "get"
    return get and of_units(node.func.value)  # type: ignore[attr-defined]


def named(tree: ast.AST) -> set[str]:
    """Names that stand for settings of a unit somewhere in a function."""
    names = {
        n.arg
        for n in ast.walk(tree)
        if isinstance(n, ast.arg) and n.annotation is not None and ast.unparse(n.annotation).strip("'\"") == "UnitSettings"
    }
    for node in ast.walk(tree):
        target, value = None, None
        if isinstance(node, ast.For | ast.comprehension) and of_units(node.iter):
            target = node.target.elts[-1] if isinstance(node.target, ast.Tuple) else node.target
        elif isinstance(node, ast.Assign | ast.NamedExpr):
            target, value = (node.targets[0] if isinstance(node, ast.Assign) else node.target), node.value
        if isinstance(target, ast.Name) and (value is None or a_unit(value)):
            names.add(target.id)
    return names


def asks(source: str) -> list[str]:
    """The expressions of a module that look at what a unit is."""
    found = []
    for function in (n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.FunctionDef)):
        settings = named(function)
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute) and node.attr in (*KEYS, "isolation"):
                if a_unit(node.value) or (isinstance(node.value, ast.Name) and node.value.id in settings):
                    found.append(ast.unparse(node))
            elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass"):
                found += [ast.unparse(node)] * any(isinstance(n, ast.Name) and n.id in SIMULATORS for n in ast.walk(node.args[1]))
    return found


def test_the_ways_to_look_are_seen():
    wrong = """
def f(scene, settings: UnitSettings):
    if scene.units["a"].fmu or any(u.isolation != "none" for u in scene.units.values()):
        unit = scene.units.get("b")
        return unit.component, isinstance(x, ComponentSimulator), settings.signals
    for name, one in sorted(scene.units.items()):
        one.fmu
"""
    assert len(asks(wrong)) == 6
    assert asks("def f(scene, result):\n    return result.signals, scene.record.signals, scene.kinds['a'].component_class") == []


def test_few_files_ask_what_a_unit_is():
    found = {}
    for path in modules("orchestrator"):
        if path.parent != FOLDER and (there := asks(path.read_text(encoding="utf-8"))):
            found[path.relative_to(ROOT).as_posix()] = there
    assert len(found) <= MOST, found


def test_a_kind_is_a_module_and_a_line():
    assert len({kind.__module__ for kind in UNIT_KINDS}) == len(UNIT_KINDS)
    assert all(kind.key in KEYS and kind.__doc__ for kind in UNIT_KINDS)
