"""What `_step` and `_outputs` of a component do, as functions over its block.

The hooks of a component are plain methods around its kernels: they read attributes that initialization has left, count, and
call. Their source is read, and each becomes a function of the same statements in which an attribute of `self` is a view of the
block, a method is a function of the same kind, `self._check(status)` hands a failure on and `raise` returns a number that
stands for its message. Conditions that depend on what is fixed at build, such as the effects that are on, are decided here. What
is left is compiled like a kernel. Nothing is run to see what it does, so nothing that a run did not show can be missed.

A statement that cannot be translated is refused with its file and line.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
import types
from collections.abc import Callable
from operator import itemgetter
from typing import Any, cast

import numpy as np

from ...components.core.errors import BadInput
from .block import Block, Unsupported
from .syntax import drop_unread, is_declared_arguments, is_self, text_of

FIRST_RAISED = 100  # status of the first `raise` statement; smaller ones are those of kernels


class Hooks:
    """Functions generated from the methods of an initialized component; `clone` gives a kernel its native form."""

    def __init__(self, component: Any, block: Block, clone: Callable[[Any], Any], compiled: Callable[[Any], Any],
                 helpers: dict[str, Any]):
        self.component, self.block, self.clone, self.compiled = component, block, clone, compiled
        self.helpers = helpers
        self.assigned = assigned_in_run(type(component))
        self.messages: list[str] = []  # of status FIRST_RAISED + position
        self._done: dict[Any, tuple[str, Method]] = {}
        self._functions: dict[str, Any] = {}
        self._identity: list[Any] = []

    @property
    def identity(self) -> tuple[Any, ...]:
        """What the machine code of the functions generated so far follows from: their text, with all places in the block, and
        the kernels and types that they name. Values of the component are no part of it."""
        return (type(self.component), *self._identity)

    def entry(self, name: str, kind: type[Method] | None = None) -> Any:
        """The compiled function of the method `name`: its arguments, then the address of the block."""
        owner, function = self.find(name)
        return self._functions[self.method(owner, function, kind)[0]]

    def find(self, name: str, after: type | None = None) -> tuple[type, Any]:
        """(class, function) of a method, searched behind the class `after`, as `super()` does."""
        mro = type(self.component).__mro__
        for cls in mro[mro.index(after) + 1 :] if after is not None else mro:
            if name in vars(cls):
                return cls, vars(cls)[name]
        raise Unsupported(f"method {name} that no class has")

    def method(self, owner: type, function: Any, kind: type[Method] | None = None) -> tuple[str, Method]:
        """(name, translation) of a method, translated at the first call, in the way of `kind`."""
        if function not in self._done:
            name = f"_{owner.__name__}_{function.__name__}_{len(self._done)}"
            entry = self._done[function] = (name, (kind or Method)(self, owner, function))
            self._functions[name] = self.compiled(entry[1].translated(name))
        return self._done[function]

    def function_named(self, name: str) -> Any:
        """A generated function, for those that call it."""
        return self._functions[name]


class Method(ast.NodeTransformer):
    """One method; its statements are rewritten in place."""

    leading: tuple[str, ...] = ()  # arguments in front of the method's own

    def __init__(self, hooks: Hooks, owner: type, function: Any):
        self.hooks, self.owner, self.function = hooks, owner, function
        self.component, self.block = hooks.component, hooks.block
        self.file = inspect.getsourcefile(function) or ""
        lines, self.first = inspect.getsourcelines(function)
        self.tree = cast(Any, ast.parse(textwrap.dedent("".join(lines))).body[0])
        ast.increment_lineno(self.tree, self.first - 1)
        self.names: dict[str, Any] = {}
        self.locals: dict[str, str] = {}  # attribute -> local variable that holds its view
        self.prologue: list[str] = []
        self.aliases: dict[str, Any] = {}  # local variables that are items of an attribute, and nothing else
        nodes = [n for statement in self.tree.body for n in ast.walk(statement)]
        self.stored = [n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
        self.gives_value = any(isinstance(n, ast.Return) and n.value is not None for n in nodes)
        # `_step` and what has no value return a status, and may fail
        self.may_fail = not self.gives_value or function.__name__ == "_step"

    def translated(self, name: str) -> types.FunctionType:
        arguments = self.tree.args
        if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.defaults:
            raise self.refusal(self.tree, "arguments other than plain ones")
        body = self.tree.body
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]
        body = self.sequence(body)
        drop_unread(body)
        if not self.gives_value:
            body.append(ast.Return(ast.Constant(0)))
        head = ast.parse("\n".join(["_F = _view_c(_pointer_float64(_address), _CELLS)",
                                    "_I = _view_c(_pointer_int64(_address), _CELLS)", *self.prologue])).body
        parameters = ", ".join([*self.leading, *(a.arg for a in arguments.args[1:]), "_address"])
        tree: Any = ast.parse(f"def {name}({parameters}):\n    pass")
        tree.body[0].body = head + body
        nodes: list[Any] = [tree.body[0], *(n for h in head for n in ast.walk(h))]
        for node in nodes:
            if hasattr(node, "lineno"):
                node.lineno = node.end_lineno = self.first
        ast.fix_missing_locations(tree)
        scope = {**self.function.__globals__, **self.hooks.helpers, **self.names, "_CELLS": 1 << 40}
        for used in {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}:
            value, package = scope.get(used), self.function.__module__.partition(".")[0]
            plain = isinstance(value, types.FunctionType) and str(value.__module__).partition(".")[0] == package
            if used not in self.hooks._functions and (hasattr(value, "py_func") or plain):
                scope[used] = self.hooks.clone(value)
        named = {used: value for used, value in self.names.items() if used not in self.hooks._functions}
        self.hooks._identity += [ast.unparse(tree), *sorted(named.items(), key=itemgetter(0))]
        exec(compile(tree, self.file, "exec"), scope)
        return scope[name]

    def refusal(self, node: Any, what: str) -> BadInput:
        line = getattr(node, "lineno", self.first)
        return BadInput(type(self.component).__name__, f"{self.owner.__name__}.{self.function.__name__} has {what} "
                        f"({self.file}, line {line})", "attributes, arithmetic and calls of kernels, which have a native form",
                        "Move what stands there into a kernel, or build without --native.")

    # -- statements --------------------------------------------------------------------------------------------------
    def sequence(self, nodes: list[Any]) -> list[Any]:
        """Translated statements, up to the first that leaves in any case."""
        translated: list[Any] = []
        for node in nodes:
            translated += self.statements(node)
            if translated and isinstance(translated[-1], ast.Return):
                break
        return translated

    def statements(self, node: Any) -> list[Any]:
        """The statements that stand for one."""
        if isinstance(node, ast.If):
            decided = self.decided(node.test)
            if decided is not None:
                return self.sequence(node.body if decided else node.orelse)
            before: list[Any] = []
            if isinstance(node.test, ast.Compare) and isinstance(node.test.left, ast.NamedExpr):  # which Numba cannot type
                named = node.test.left
                before = [ast.copy_location(ast.Assign([named.target], self.visit(named.value)), node)]
                node.test.left = ast.Name(named.target.id, ast.Load())
            node.test = self.visit(node.test)
            node.body = self.sequence(node.body) or [ast.Pass()]
            node.orelse = self.sequence(node.orelse)
            return [*before, node]
        if isinstance(node, ast.For | ast.While):
            for field, value in ast.iter_fields(node):
                if field not in ("body", "orelse") and isinstance(value, ast.AST):
                    setattr(node, field, self.visit(value))
            node.body = self.sequence(node.body) or [ast.Pass()]
            return [node]
        if isinstance(node, ast.Raise):
            return [self.failure(node)]
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            return self.call_statement(node)
        if isinstance(node, ast.AnnAssign):
            if node.value is None:
                return []
            node = ast.copy_location(ast.Assign([node.target], node.value), node)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
            value = self.attribute(node.value)
            if isinstance(value, tuple):
                return self.unpacked(node, node.targets[0].elts, len(value))
        if isinstance(node, ast.AugAssign) and isinstance(self.attribute(node.target), np.ndarray):
            return self.each_element(node)
        if isinstance(node, ast.Assign | ast.AugAssign | ast.Return | ast.Pass | ast.Expr):
            return [self.visit(node)]
        raise self.refusal(node, f"a statement of the kind {type(node).__name__}")

    def failure(self, node: ast.Raise) -> Any:
        if not self.may_fail:
            raise self.refusal(node, "raise in a method that returns a value")
        self.hooks.messages.append(text_of(node.exc))
        status = FIRST_RAISED + len(self.hooks.messages) - 1
        return ast.copy_location(ast.Return(ast.Constant(status)), node)

    def call_statement(self, node: Any) -> list[Any]:
        call, status = node.value, "_status"
        if isinstance(call.func, ast.Attribute) and is_self(call.func.value) and call.func.attr == "_check":
            value = self.visit(call.args[0])  # its message stands in the runtime's table of statuses
            can_fail = True
        else:
            value = self.visit(call)
            can_fail = isinstance(value, ast.Call) and getattr(value, "_procedure", False)
        if not can_fail:
            return [ast.copy_location(ast.Expr(value), node)]
        if not self.may_fail:
            raise self.refusal(node, "a call that may fail in a method that returns a value")
        store = ast.copy_location(ast.Assign([ast.Name(status, ast.Store())], value), node)
        test = ast.Compare(ast.Name(status, ast.Load()), [ast.NotEq()], [ast.Constant(0)])
        back = ast.If(test, [ast.Return(ast.Name(status, ast.Load()))], [])
        return [store, ast.copy_location(back, node)]

    def unpacked(self, node: ast.Assign, targets: list[Any], length: int) -> list[Any]:
        """`a, *_, b = self.items`, item by item, so that items which nothing reads can go."""
        assignments, skipped = [], length - len(targets)
        for k, target in enumerate(targets):
            if isinstance(target, ast.Starred):
                if not (isinstance(target.value, ast.Name) and target.value.id == "_"):
                    raise self.refusal(node, "a starred name")
                continue
            place = k if not any(isinstance(t, ast.Starred) for t in targets[:k]) else k + skipped
            if isinstance(target, ast.Name) and self.stored.count(target.id) == 1:
                self.aliases[target.id] = self.attribute(node.value)[place]
            assignments.append(ast.Assign([target], ast.Subscript(self.visit(node.value), ast.Constant(place), ast.Load())))
        return [ast.copy_location(statement, node) for statement in assignments]

    def each_element(self, node: Any) -> list[Any]:
        """`array += number`, element by element: an array expression would allocate."""
        array = self.attribute(node.target)
        if array.ndim != 1:
            raise self.refusal(node, "an operation on a whole array")
        whole = ast.copy_location(ast.Attribute(node.target.value, node.target.attr, ast.Load()), node)
        name, value = self.visit(whole).id, self.visit(node.value)
        target = ast.Subscript(ast.Name(name, ast.Load()), ast.Name("_j", ast.Load()), ast.Store())
        loop = ast.For(ast.Name("_j", ast.Store()), ast.Call(ast.Name("range", ast.Load()), [ast.Constant(array.size)], []),
                       [ast.AugAssign(target, node.op, value)], [])
        return [ast.copy_location(loop, node)]

    # -- what is fixed at build --------------------------------------------------------------------------------------
    def decided(self, test: Any) -> bool | None:
        """The value of a condition that nothing in a run can change, or None."""
        if isinstance(test, ast.BoolOp):
            parts, dominant = [self.decided(v) for v in test.values], isinstance(test.op, ast.Or)
            if dominant in parts:
                return dominant
            return None if None in parts else not dominant
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            inner = self.decided(test.operand)
            return None if inner is None else not inner
        presence = isinstance(test, ast.Compare) and isinstance(test.ops[0], ast.Is | ast.IsNot)
        for node in ast.walk(test):
            if isinstance(node, ast.Call | ast.NamedExpr):
                return None
            if isinstance(node, ast.Name) and node.id in self.aliases:
                if not (presence or fixed(self.aliases[node.id])):
                    return None
            elif isinstance(node, ast.Name) and node.id != "self" and node.id not in self.function.__globals__:
                return None
            if isinstance(node, ast.Attribute) and is_self(node.value):
                value = getattr(self.component, node.attr, None)
                if node.attr in ("t", "u", "y", "x") or node.attr in self.hooks.assigned or not (presence or fixed(value)):
                    return None
        if not any(is_self(n) or (isinstance(n, ast.Name) and n.id in self.aliases) for n in ast.walk(test)):
            return None
        expression = compile(ast.fix_missing_locations(ast.Expression(test)), self.file, "eval")
        return bool(eval(expression, dict(self.function.__globals__), {**self.aliases, "self": self.component}))

    # -- expressions -------------------------------------------------------------------------------------------------
    def attribute(self, node: Any) -> Any:
        """The value of an attribute of `self` or of its class, else None."""
        if is_declared_arguments(node):
            return self.block.declared
        if isinstance(node, ast.Attribute) and is_self(node.value):
            return getattr(self.component, node.attr, None)
        return None

    def visit_IfExp(self, node: ast.IfExp) -> Any:
        decided = self.decided(node.test)
        return self.generic_visit(node) if decided is None else self.visit(node.body if decided else node.orelse)

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        if not is_self(node.value):
            return self.generic_visit(node)
        name = node.attr
        declared = inspect.getattr_static(type(self.component), name, None)
        if isinstance(declared, property):
            owner, _ = self.hooks.find(name)
            return self.called(owner, declared.fget, [], node)
        if not hasattr(self.component, name):
            raise self.refusal(node, f"self.{name}, which the initialized component has not")
        value = getattr(self.component, name)
        if isinstance(node.ctx, ast.Store):
            if not isinstance(value, float) or name not in vars(self.component):
                raise self.refusal(node, f"an assignment to self.{name}, which is no number")
        elif hasattr(value, "py_func"):
            self.names[f"_kernel_{name}"] = value
            return ast.copy_location(ast.Name(f"_kernel_{name}", ast.Load()), node)
        if name == "t":
            return ast.copy_location(ast.parse("_F[0]", mode="eval").body, node)
        return self.viewed(name, value, self.component, node)

    def viewed(self, name: str, value: Any, owner: Any, node: Any) -> Any:
        """The item `name` of `owner` as an expression over the block; arrays and tuples get a local variable."""
        try:
            text = self.block.expression(value, owner, name, self.names)
        except Unsupported as what:
            raise self.refusal(node, f"self.{name}, {what},") from None
        context = getattr(node, "ctx", ast.Load())
        if isinstance(value, np.ndarray | tuple):
            if name not in self.locals:
                self.locals[name] = f"_self_{name}"
                self.prologue.append(f"_self_{name} = {text}")
            return ast.copy_location(ast.Name(self.locals[name], context), node)
        new: Any = ast.parse(text, mode="eval").body
        if isinstance(context, ast.Store):
            new.ctx = ast.Store()
        return ast.copy_location(new, node)

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        if (isinstance(node.value, ast.Attribute) and is_self(node.value.value) and node.value.attr == "parameters"
                and isinstance(node.slice, ast.Constant)):
            return self.parameter(node, str(node.slice.value))
        return self.generic_visit(node)

    def parameter(self, node: Any, name: Any) -> Any:
        value = self.component.parameters.get(name)
        try:
            text = self.block.expression(value, self.component.parameters, name, self.names)
        except Unsupported as what:
            raise self.refusal(node, f"parameter {name!r}, {what},") from None
        return ast.copy_location(ast.parse(text, mode="eval").body, node)

    def visit_Call(self, node: ast.Call) -> Any:
        function = node.func
        if is_declared_arguments(node):
            return self.viewed("declared", self.block.declared, self.block, node)
        if isinstance(function, ast.Attribute):
            base = function.value
            if isinstance(base, ast.Call) and isinstance(base.func, ast.Name) and base.func.id == "super":
                return self.called(*self.hooks.find(function.attr, self.owner), node.args, node)
            if is_self(base):
                declared = inspect.getattr_static(type(self.component), function.attr, None)
                first = node.args[0] if node.args else None
                if function.attr == "get" and isinstance(first, ast.Constant) and first.value in self.component.parameters:
                    return self.parameter(node, str(first.value))
                if isinstance(declared, types.FunctionType):
                    return self.called(*self.hooks.find(function.attr), node.args, node)
        return self.generic_visit(node)

    def called(self, owner: type, function: Any, arguments: list[Any], node: Any) -> Any:
        """A call of another method: a function of its own, with the block's address as the last argument."""
        name, method = self.hooks.method(owner, function)
        if name not in self.hooks._functions:
            raise self.refusal(node, "a method that calls itself")
        self.names[name] = self.hooks.function_named(name)
        call = ast.Call(ast.Name(name, ast.Load()), [*map(self.visit, arguments), ast.Name("_address", ast.Load())], [])
        call._procedure = not method.gives_value  # type: ignore[attr-defined]
        return ast.copy_location(call, node)


def fixed(value: Any) -> bool:
    """Whether a value can change only by being replaced as a whole."""
    if isinstance(value, tuple):
        return all(map(fixed, value))
    return not isinstance(value, np.ndarray)


def assigned_in_run(cls: type) -> set[str]:
    """Attributes that the hooks of a run set, or methods that they call."""
    names: set[str] = set()
    seen, todo = set(), ["_start", "_step", "_outputs", "initial_state"]
    while todo:
        name = todo.pop()
        seen.add(name)
        for function in [vars(base).get(name) for base in cls.__mro__]:
            if isinstance(function, types.FunctionType):
                tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
                nodes = [n for n in ast.walk(tree) if isinstance(n, ast.Attribute)]
                names |= {n.attr for n in nodes if isinstance(n.ctx, ast.Store)}
                todo += [n.attr for n in nodes if n.attr not in seen and n.attr not in todo]
    return names
