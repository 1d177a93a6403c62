"""What `initial_state` of a component does, as a function that fills the state in the block.

It returns a new array, `np.array([a, b, ...])`, whose elements may be collected in a list before. Which elements there are is
fixed at build, so each becomes an assignment to a cell of `x`. Then the state at the start follows from the inputs and the
parameters that an instance has, and not from those of the build.
"""

from __future__ import annotations

import ast
from typing import Any

from .hooks import Method
from .syntax import is_name, load


class InitialState(Method):
    """`initial_state` of an `OdeComponent`; a form of it that is not translated is refused with its line."""

    leading = ("_t",)  # the entry's argument

    def __init__(self, *arguments: Any):
        super().__init__(*arguments)
        self.gives_value, self.may_fail = False, True
        self.lists: dict[str, list[Any]] = {}  # lists of elements by name
        self.states: set[str] = set()  # names of the array that is returned
        self.elements = self.depth = 0

    def statements(self, node: Any) -> list[Any]:
        if isinstance(node, ast.Return):
            return [*self.filled(node.value, node), ast.copy_location(ast.Return(ast.Constant(0)), node)]
        if isinstance(node, ast.For | ast.While) or (isinstance(node, ast.If) and self.decided(node.test) is None):
            self.depth += 1
            translated = super().statements(node)
            self.depth -= 1
            return translated
        if isinstance(node, ast.Expr) and isinstance(getattr(node.value, "func", None), ast.Attribute):
            call: Any = node.value
            if call.func.attr == "append" and is_name(call.func.value, self.lists):
                return self.extended(call.func.value.id, ast.List(call.args, ast.Load()), node)
        if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name) and node.target.id in self.lists:
            return self.extended(node.target.id, node.value, node)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if self.is_list(node.value):
                self.lists[name] = []
                return self.extended(name, node.value, node)
            if self.is_array(node.value):
                self.states.add(name)
                return [*self.filled(node.value, node), ast.copy_location(ast.Assign(node.targets, self.x(node)), node)]
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Subscript) and isinstance(node.value, ast.List):
            return self.slice_filled(node)
        return super().statements(node)

    def x(self, node: Any) -> Any:
        """The view of the state."""
        return self.visit(ast.copy_location(ast.Attribute(load("self"), "x", ast.Load()), node))

    def is_list(self, value: Any) -> bool:
        if isinstance(value, ast.BinOp):
            return self.is_list(value.left)
        return isinstance(value, ast.List) or is_name(value, self.lists)

    def is_array(self, value: Any) -> bool:
        function = getattr(value, "func", None)
        return isinstance(function, ast.Attribute) and is_name(function.value, ("np",)) and function.attr in ("array", "zeros")

    def extended(self, name: str, value: Any, node: Any) -> list[Any]:
        """Statements that compute more elements of a list."""
        if self.depth:
            raise self.refusal(node, "a list whose elements depend on a run")
        before, items = self.items(value, node)
        self.lists[name] = [*self.lists[name], *items]
        return before

    def items(self, value: Any, node: Any) -> tuple[list[Any], list[Any]]:
        """(statements that compute them, elements) of an expression that gives a list."""
        if is_name(value, self.lists):
            return [], self.lists[value.id]
        if isinstance(value, ast.IfExp) and (decided := self.decided(value.test)) is not None:
            return self.items(value.body if decided else value.orelse, node)
        if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Add):
            parts = [self.items(side, node) for side in (value.left, value.right)]
            return [s for before, _ in parts for s in before], [item for _, items in parts for item in items]
        if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Mult):
            before, items = self.items(value.left, node)
            return before, items * self.number(value.right, node)
        if self.is_array(value) and value.func.attr == "zeros":
            return [], [ast.Constant(0.0)] * self.number(value.args[0], node)
        if not isinstance(value, ast.List | ast.Tuple):
            raise self.refusal(node, "elements whose number is not seen")
        before, items = [], []
        for element in value.elts:
            if isinstance(element, ast.Starred):
                more, inner = self.items(element.value, node)
                before, items = before + more, items + inner
                continue
            self.elements += 1
            name = f"_element_{self.elements}"
            before.append(ast.copy_location(ast.Assign([ast.Name(name, ast.Store())], self.visit(element)), node))
            items.append(load(name))
        return before, items

    def number(self, value: Any, node: Any) -> int:
        """A whole number that is fixed at build."""
        names = {n.id for n in ast.walk(value) if isinstance(n, ast.Name)}
        if names <= {"self", *self.aliases, *self.function.__globals__}:
            code = compile(ast.fix_missing_locations(ast.Expression(value)), self.file, "eval")
            result = eval(code, dict(self.function.__globals__), {**self.aliases, "self": self.component})
            if isinstance(result, int):
                return result
        raise self.refusal(node, "a number of elements that is not fixed")

    def filled(self, value: Any, node: Any) -> list[Any]:
        """Statements that write a returned array into `x`."""
        if is_name(value, self.states):
            return []
        if not self.is_array(value):
            raise self.refusal(node, "a state that is not an array of its elements")
        before, items = self.items(value if value.func.attr == "zeros" else value.args[0], node)
        if len(items) != self.component.x.size:
            raise self.refusal(node, f"{len(items)} elements of a state that has {self.component.x.size}")
        return before + self.written(self.x(node) if items else None, range(len(items)), items, node)

    def slice_filled(self, node: ast.Assign) -> list[Any]:
        """`state[1:3] = [a, b]`, element by element."""
        target: Any = node.targets[0]
        if not (is_name(target.value, self.states) and isinstance(target.slice, ast.Slice) and target.slice.step is None):
            raise self.refusal(node, "a list that is assigned to a part of an array")
        ends = [0 if end is None else self.number(end, node) for end in (target.slice.lower, target.slice.upper)]
        before, items = self.items(node.value, node)
        if ends[1] - ends[0] != len(items):
            raise self.refusal(node, "a list of another length than the part that it is assigned to")
        return before + self.written(load(target.value.id), range(*ends), items, node)

    def written(self, array: Any, places: range, items: list[Any], node: Any) -> list[Any]:
        return [ast.copy_location(ast.Assign([ast.Subscript(array, ast.Constant(k), ast.Store())], item), node)
                for k, item in zip(places, items, strict=True)]
