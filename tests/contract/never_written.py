"""Components as if their effects had never been written: kernels whose source has no branch of an effect any more."""

import ast
import inspect
import textwrap
from collections.abc import Callable
from typing import Any

from cosimo.components.core import integrators
from cosimo.components.core.integrators import OdeComponent, rk4
from cosimo.components.core.kernels import bind, kernel


class _Without(ast.NodeTransformer):
    """Takes out what stands behind `effect is not None`, and keeps what stands behind its opposite."""

    taken = 0

    def visit_If(self, node: ast.If) -> Any:
        self.generic_visit(node)
        present = _present(node.test)
        if present is None:
            return node
        self.taken += 1
        return (node.orelse if present else node.body) or None

    def visit_IfExp(self, node: ast.IfExp) -> Any:
        self.generic_visit(node)
        present = _present(node.test)
        if present is None:
            return node
        self.taken += 1
        return node.orelse if present else node.body


def _present(test: ast.expr) -> bool | None:
    """True for `effect is not None`, False for `effect is None`, None for other conditions; an effect is a name or `e.name`."""
    if not (
        isinstance(test, ast.Compare)
        and isinstance(test.left, ast.Name | ast.Attribute)
        and isinstance(test.comparators[0], ast.Constant)
        and test.comparators[0].value is None
    ):
        return None
    return isinstance(test.ops[0], ast.IsNot)


def python(function: Any) -> Callable[..., Any]:
    """The Python function of a kernel."""
    return getattr(function, "py_func", function)


def stripped(function: Any) -> tuple[Callable[..., Any], int]:
    """A kernel's Python function without the branches of effects, and how many there were."""
    function = python(function)
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    definition = tree.body[0]
    assert isinstance(definition, ast.FunctionDef)
    definition.decorator_list = []
    definition.name = f"{definition.name}_never_written"
    without = _Without()
    tree = ast.fix_missing_locations(without.visit(tree))
    # under its own file, so that its machine code can be kept like that of the kernel
    names: dict[str, Any] = {}
    exec(compile(tree, inspect.getfile(function), "exec"), function.__globals__, names)
    return names[definition.name], without.taken


def never_written(cls: type[OdeComponent]) -> type[OdeComponent]:
    """The component of the classic Runge-Kutta method with kernels of which the branches of all effects are gone."""
    kernels = cls.kernels
    assert python(kernels.step).__code__ is python(rk4).__code__, f"{cls.__name__} has a method of its own"
    bound = python(kernels.step).__globals__
    step = bind(
        integrators.rk4,
        f"never_written_{cls.__name__}",
        **{name: kernel(stripped(bound[name])[0]) for name in ("derivatives", "outputs")},
    )
    bare = type(
        cls.__name__,
        (cls,),
        {
            **{v.name: v for v in cls.own_variables},
            **cls.effects,
            "kernels": kernels._replace(step=step, outputs=kernel(stripped(kernels.outputs)[0])),
        },
    )
    bare.Values = cls.Values
    return bare
