"""How Numba compiles a kernel: with nothing in the machine code that the kernel does not need.

Fields of a NamedTuple argument that hold None are None before any branch is looked at. Numba prunes `if effect is not None` where
`effect` is an argument of type none, before types are inferred, and so never compiles the branch behind it. It does not do so
for `e.effect` of an argument `e`: the branch would stay, and its body would fail to be typed. Here every such access becomes the
constant None, and Numba's own pruning does the rest.

What only kernels call has no function that takes arguments out of Python objects: a sixth of what a kernel costs to compile.
Kernels that neither make arrays nor give any back count no references to them, which would be locked instructions at every call.
"""

from __future__ import annotations

from typing import Any

from numba.core import ir, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.errors import NumbaError
from numba.core.event import trigger_event
from numba.core.ir_utils import get_definition, guard
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NopythonTypeInference
from numba.core.untyped_passes import IRProcessing
from numba.extending import typeof_impl

from .garbage import seldom_collected
from .kept_kernels import Either
from .kernel_faults import typing_fault
from .kernel_library import ADDRESS, KERNELS, PYTHON, kernel_libraries


@typeof_impl.register(Either)
def _either(value, context):
    """Values, or None: `if e.effect is not None` is decided when the kernel runs."""
    return types.Optional(typeof_impl(value.values, context))


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


class KernelDispatcher(CPUDispatcher):
    """Compiles for Python where Python calls first, else for kernels; a second time where Python calls after all."""

    _cache: Any
    targetctx: Any
    _wanted = PYTHON  # who asks for the code
    _counts = False  # references to arrays

    def get_call_template(self, args, kws):
        """A kernel that calls this one is being compiled."""
        before, self._wanted = self._wanted, KERNELS
        try:
            return super().get_call_template(args, kws)
        finally:
            self._wanted = before

    @global_compiler_lock
    def compile(self, sig):
        """As Numba's; under its lock from the beginning, for the flags hold for one compilation."""
        args = tuple(normalize_signature(sig)[0])
        known = self.overloads.get(args)
        if known is not None and self._wanted == PYTHON and not callable_from_python(known):
            del self.overloads[args]
        self.targetoptions["no_cpython_wrapper"] = self._wanted != PYTHON
        self._cache.wanted = self._wanted
        self.targetoptions["_nrt"] = self._counts
        try:
            with seldom_collected(), kernel_libraries(self.targetctx.codegen()):
                return super().compile(sig)
        except NumbaError as error:
            if self._counts:
                raise typing_fault(error, args) from None
            self._counts = True  # what makes arrays cannot be compiled without
            self._compiler._failed_cache.clear()  # type: ignore[attr-defined]  # Numba does not try again what has failed
            if self._wanted != PYTHON:
                raise  # what calls it has failed, too, and tries again
        return self.compile(sig)

    def for_kernels(self, sig):
        """Machine code for a signature, which is called by address."""
        args = tuple(normalize_signature(sig)[0])
        if args not in self.overloads:
            before, self._wanted = self._wanted, ADDRESS
            try:
                self.compile(args)
            except NumbaError:
                self.compile(args)
            finally:
                self._wanted = before
        compiled: Any = self.overloads[args]
        if not compiled.library.finalized:
            details = {"dispatcher": self, "args": args, "return_type": compiled.signature.return_type}
            with trigger_event("numba:compile", data=details):  # who measures what compiling takes shall see it
                compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
            self._cache.save_overload(args, compiled)
        return compiled

    def add_overload(self, cres):
        if callable_from_python(cres):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = cres  # not in the table that Python's calls are looked up in


def callable_from_python(compiled) -> bool:
    """Whether machine code has a function that takes its arguments out of Python objects."""
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cpython_wrapper_name) != 0


OPTIONS: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "pipeline_class": KernelCompiler}
