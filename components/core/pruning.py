"""Passes of Numba's compiler: fields of a NamedTuple argument that hold None are None before any branch is looked at.

Numba prunes `if effect is not None` where `effect` is an argument of type none, before types are inferred, and so never compiles
what stands behind it. It does not do so for `e.effect` of an argument `e`: the branch would stay, and its body would fail to be
typed. Here every such access becomes the constant None, and Numba's own pruning does the rest.
"""

from __future__ import annotations

from numba.core import ir, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.errors import NumbaError
from numba.core.ir_utils import get_definition, guard
from numba.core.typed_passes import NopythonTypeInference
from numba.core.untyped_passes import IRProcessing


@register_pass(mutates_CFG=False, analysis_only=False)
class AbsentFields(FunctionPass):
    """`e.effect` becomes None where the argument `e` is a NamedTuple whose field `effect` is of type none."""

    _name = "cosimo_absent_fields"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state) -> bool:
        function, changed = state.func_ir, False
        for block in function.blocks.values():
            for statement in block.body:
                if isinstance(statement, ir.Assign) and _absent(function, statement.value, state.args):
                    constant = ir.Const(None, statement.loc)
                    definitions = function._definitions[statement.target.name]
                    definitions[:] = [constant if d is statement.value else d for d in definitions]
                    statement.value, changed = constant, True
        return changed


def _absent(function, value, arguments) -> bool:
    if not (isinstance(value, ir.Expr) and value.op == "getattr"):
        return False
    owner = guard(get_definition, function, value.value)
    kind = arguments[owner.index] if isinstance(owner, ir.Arg) else None
    if not isinstance(kind, types.NamedTuple | types.NamedUniTuple) or value.attr not in kind.fields:
        return False
    return isinstance(kind.types[kind.fields.index(value.attr)], types.NoneType)


@register_pass(mutates_CFG=False, analysis_only=True)
class CountedResult(FunctionPass):
    """Refuses to compile a kernel that gives arrays to Python without counting who holds them."""

    _name = "cosimo_counted_result"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state) -> bool:
        if not (state.flags.nrt or state.flags.no_cpython_wrapper or _of_numbers(state.return_type)):
            raise NumbaError(f"{state.func_id.func_name} gives {state.return_type} to Python")
        return False


def _of_numbers(kind) -> bool:
    if isinstance(kind, types.BaseTuple):
        return all(map(_of_numbers, kind))  # type: ignore[call-overload, arg-type]
    return isinstance(types.unliteral(kind), types.Number | types.Boolean | types.NoneType)


class KernelCompiler(CompilerBase):
    """Numba's compiler with the passes above."""

    def define_pipelines(self):
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(AbsentFields, IRProcessing)
        passes.add_pass_after(CountedResult, NopythonTypeInference)
        passes.finalize()
        return [passes]
