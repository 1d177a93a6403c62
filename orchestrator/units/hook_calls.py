"""The kernel calls that a hook of a component consists of, for code that makes them without Python.

`_step` and `_outputs` of most components hand arrays and numbers to kernels and do nothing else. Their source is read, so that
nothing has to be declared twice: names, attributes and arithmetic on what stays the same over a run are evaluated, the calls of
kernels are noted. A hook with anything else in it, such as a look at an element of an array, a statement `raise` or an attribute
that is set, is one with Python in its step.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
import types
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...components.core.component import Component
from ...components.core.kernels import kernel

PURE = ("abs", "float", "int", "len", "max", "min", "ceil", "floor", "sqrt")
PLAIN = (ast.Name, ast.Attribute, ast.Constant, ast.Subscript, ast.Slice, ast.Tuple, ast.Set, ast.Starred, ast.Call, ast.BinOp,
         ast.UnaryOp, ast.Compare, ast.BoolOp, ast.IfExp, ast.expr_context, ast.operator, ast.unaryop, ast.cmpop, ast.boolop)
OF_ARRAYS = ("size", "shape", "ndim")


class Symbol(Enum):
    """What is known at each step only: its beginning and its end, s."""

    TIME = "t"
    END = "t + h"


class KernelCall(NamedTuple):
    """One call; `Symbol`s among the arguments. `checked`: a result other than DONE ends the hook."""

    kernel: Any
    arguments: tuple[Any, ...]
    checked: bool


class PythonInHook(Exception):
    """A hook is more than calls of kernels; the text says what it has."""


@kernel
def count_one(counts):
    """`counts += 1`."""
    for j in range(counts.size):
        counts[j] += 1


def step_calls(component: Component, h: float) -> list[KernelCall]:
    """The calls that a step of length h, s, of an initialized component is; raises `PythonInHook`."""
    return _calls(component, "_step", (Symbol.TIME, h), (Component.step,))


def output_calls(component: Component) -> list[KernelCall]:
    """The calls that bring its outputs up to date; raises `PythonInHook`."""
    return _calls(component, "_outputs", (Symbol.TIME,), (Component.refresh,))


def _calls(component: Component, hook: str, arguments: tuple[Any, ...], around: tuple[Any, ...]) -> list[KernelCall]:
    for function in around:
        if getattr(type(component), function.__name__) is not function:
            raise PythonInHook(f"{function.__name__} of its own")
    reader = _Reader(component)
    try:
        reader.run(*_find(type(component), hook), arguments, wanted=True)
    except Exception as error:  # no source to be read, or an expression that cannot be evaluated before a step
        raise error if isinstance(error, PythonInHook) else PythonInHook(f"{hook}: {error}") from None
    return reader.calls


def _find(cls: type, name: str, after: type | None = None) -> tuple[type, Any]:
    mro = cls.__mro__
    for base in mro[mro.index(after) + 1 :] if after is not None else mro:
        if isinstance(vars(base).get(name), types.FunctionType):
            return base, vars(base)[name]
    raise PythonInHook(f"{name}, which is no plain method")


@lru_cache(maxsize=1024)
def _body(function: Any) -> tuple[list[str], list[ast.stmt]]:
    definition: Any = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise PythonInHook("a function of no name")
    return [a.arg for a in definition.args.args], definition.body


@lru_cache(maxsize=1024)
def _assigned(cls: type) -> frozenset[str]:
    """Attributes that the hooks set, or methods that they call: at the next step they may be others."""
    names: set[str] = set()
    todo, seen = ["_step", "_outputs"], set()
    while todo:
        seen.add(name := todo.pop())
        for function in [vars(base).get(name) for base in cls.__mro__]:
            if isinstance(function, types.FunctionType):
                for node in [n for line in _body(function)[1] for n in ast.walk(line) if isinstance(n, ast.Attribute)]:
                    names |= {node.attr} if isinstance(node.ctx, ast.Store) else set()
                    todo += [node.attr] if node.attr not in seen else []
    return frozenset(names | {"t"})


class _Reader:
    """Walks through hooks of one component and notes what they call."""

    def __init__(self, component: Component):
        self.component, self.calls = component, list[KernelCall]()
        cls: Any = type(component)
        self._changing = _assigned(cls)

    def run(self, owner: type, function: Any, arguments: tuple[Any, ...], *, wanted: bool) -> None:
        """Note the calls of a method; `wanted`: what it returns is a status."""
        names, body = _body(function)
        foreign = set(function.__code__.co_freevars) - {"__class__"}  # what belongs to another function may change
        if names[:1] != ["self"] or foreign or function.__defaults__ or len(names) != len(arguments) + 1:
            raise PythonInHook(f"{function.__name__}, which is no plain method")
        scope = {**vars(builtins), **function.__globals__, **dict(zip(names, (self.component, *arguments), strict=True))}
        self._sequence(body, scope, owner, wanted)

    def _sequence(self, body: list[ast.stmt], scope: dict[str, Any], owner: type, wanted: bool) -> bool:
        """Note the calls of statements; tells whether one of them leaves the method."""
        for node in body:
            if isinstance(node, ast.If):
                if self._sequence(node.body if self._value(node.test, scope) else node.orelse, scope, owner, wanted):
                    return True
            elif isinstance(node, ast.Return):
                if isinstance(node.value, ast.Call):
                    self._call(node.value, scope, owner, wanted)
                elif node.value is not None and self._value(node.value, scope) != 0:
                    raise PythonInHook("a status that no kernel returns")
                return True
            elif isinstance(node, ast.Assign) and all(isinstance(n, (ast.Name, ast.Tuple)) for n in node.targets):
                self._assign(node.targets[0], self._value(node.value, scope), scope)
            elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
                call = node.value
                checked = isinstance(call.func, ast.Attribute) and call.func.attr == "_check" and _is_self(call.func.value)
                inner = call.args[0] if checked else call
                if not isinstance(inner, ast.Call):
                    raise PythonInHook(ast.unparse(node))
                self._call(inner, scope, owner, checked)
            elif isinstance(node, ast.AugAssign) and ast.unparse(node) in ("self.counts += 1", "self.counts[0] += 1"):
                counts = self.component.counts
                whole = isinstance(node.target, ast.Attribute)
                self.calls.append(KernelCall(count_one, (counts if whole else counts[:1],), False))
            elif not (isinstance(node, ast.Pass) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))):
                raise PythonInHook(ast.unparse(node).partition("\n")[0])
        return False

    def _assign(self, target: Any, value: Any, scope: dict[str, Any]) -> None:
        if isinstance(target, ast.Name):
            scope[target.id] = value
        elif all(isinstance(t, ast.Name) for t in target.elts) and isinstance(value, tuple) and len(value) == len(target.elts):
            scope.update(zip((t.id for t in target.elts), value, strict=True))
        else:
            raise PythonInHook(ast.unparse(target))

    def _call(self, node: ast.Call, scope: dict[str, Any], owner: type, checked: bool) -> None:
        if node.keywords:
            raise PythonInHook(ast.unparse(node))
        arguments: list[Any] = []
        for argument in node.args:
            if isinstance(argument, ast.Starred):
                arguments += self._value(argument.value, scope)
            else:
                arguments.append(self._value(argument, scope))
        function = node.func
        if isinstance(function, ast.Attribute) and _text(function.value) in ("self", "super()"):
            after = None if _is_self(function.value) else owner
            self.run(*_find(type(self.component), function.attr, after), tuple(arguments), wanted=checked)
            return
        called = self._value(function, scope)
        if not hasattr(called, "py_func"):
            raise PythonInHook(f"{ast.unparse(function)}, which is no kernel")
        self.calls.append(KernelCall(called, tuple(arguments), checked))

    def _value(self, node: ast.expr, scope: dict[str, Any]) -> Any:
        """The value of an expression that is the same at every step, or a symbol."""
        if isinstance(node, ast.Name) and isinstance(scope.get(node.id), Symbol):
            return scope[node.id]
        if isinstance(node, ast.BinOp) and _text(node) == "t + h" and scope.get("t") is Symbol.TIME:
            return Symbol.END
        for part in _parts(node):
            self._allow(part, scope)
        return _evaluated(node, scope)

    def _allow(self, node: ast.AST, scope: dict[str, Any]) -> None:
        """Refuses what may be another at the next step, or is no view of a component's array."""
        fits = isinstance(node, PLAIN)
        if isinstance(node, ast.Name):
            fits = not isinstance(scope.get(node.id), Symbol)
        elif isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            fits = _is_self(node) or (name in PURE and not any(map(_is_self, ast.walk(node.func))))
        elif isinstance(node, ast.Attribute) and _is_self(node.value):
            fits = node.attr not in self._changing
        elif isinstance(node, ast.Attribute | ast.Subscript) and isinstance(base := _evaluated(node.value, scope), np.ndarray):
            if isinstance(node, ast.Attribute):
                fits = node.attr in OF_ARRAYS
            else:
                part = _evaluated(node, scope)
                fits = isinstance(part, np.ndarray) and (part.size == 0 or np.shares_memory(part, base))
        elif isinstance(node, ast.BinOp | ast.UnaryOp | ast.BoolOp | ast.IfExp | ast.Compare):
            operands = [n for n in ast.iter_child_nodes(node) if isinstance(n, ast.expr)]
            identity = isinstance(node, ast.Compare) and all(isinstance(op, ast.Is | ast.IsNot) for op in node.ops)
            fits = identity or not any(isinstance(_evaluated(n, scope), np.ndarray) for n in operands)
        if not fits:
            raise PythonInHook(ast.unparse(node))


def _is_self(node: Any) -> bool:
    """Whether a node is `self` or `type(self)`."""
    return isinstance(node, ast.Name | ast.Call) and _text(node) in ("self", "type(self)")


@lru_cache(maxsize=4096)  # hooks of many components are one source, which is read for each of them
def _text(node: ast.AST) -> str:
    return ast.unparse(node)


@lru_cache(maxsize=4096)
def _parts(node: ast.AST) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(node))


@lru_cache(maxsize=4096)
def _code(node: ast.expr) -> types.CodeType:
    return compile(ast.fix_missing_locations(ast.Expression(node)), "<hook>", "eval")


def _evaluated(node: ast.expr, scope: dict[str, Any]) -> Any:
    return eval(_code(node), scope)
