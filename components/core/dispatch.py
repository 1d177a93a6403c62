"""How Numba comes to the machine code of a kernel: what only kernels call has nothing of what Python would need to call it.

The function that takes a kernel's arguments out of Python objects is a sixth of what a kernel costs to compile, and most kernels
are called by kernels alone.
"""

from __future__ import annotations

from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature


class KernelDispatcher(CPUDispatcher):
    """Compiles for Python where Python calls first, else for kernels; a second time where Python calls after all."""

    _for_kernels = False  # whether a kernel asks for the machine code

    def get_call_template(self, args, kws):
        """A kernel that calls this one is being compiled."""
        before, self._for_kernels = self._for_kernels, True
        try:
            return super().get_call_template(args, kws)
        finally:
            self._for_kernels = before

    def compile(self, sig):
        args = tuple(normalize_signature(sig)[0])
        known = self.overloads.get(args)
        if known is not None and not self._for_kernels and not callable_from_python(known):
            del self.overloads[args]
        self.targetoptions["no_cpython_wrapper"] = self._cache.for_kernels = self._for_kernels
        return super().compile(sig)

    def add_overload(self, cres):
        if callable_from_python(cres):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = cres  # not in the table that Python's calls are looked up in


def callable_from_python(compiled) -> bool:
    """Whether machine code has a function that takes its arguments out of Python objects."""
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cpython_wrapper_name) != 0
