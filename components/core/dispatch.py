"""How Numba comes to the machine code of a kernel, with nothing in it that the kernel does not need.

What only kernels call has no function that takes arguments out of Python objects: a sixth of what a kernel costs to compile.
Kernels that neither make arrays nor give any back count no references to them, which would be locked instructions at every call.
"""

from __future__ import annotations

from typing import Any

from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import NumbaError
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature


class KernelDispatcher(CPUDispatcher):
    """Compiles for Python where Python calls first, else for kernels; a second time where Python calls after all."""

    _cache: Any
    _for_kernels = False  # whether a kernel asks for the machine code
    _counts = False  # references to arrays

    def get_call_template(self, args, kws):
        """A kernel that calls this one is being compiled."""
        before, self._for_kernels = self._for_kernels, True
        try:
            return super().get_call_template(args, kws)
        finally:
            self._for_kernels = before

    @global_compiler_lock
    def compile(self, sig):
        """As Numba's; under its lock from the beginning, for the flags hold for one compilation."""
        args = tuple(normalize_signature(sig)[0])
        known = self.overloads.get(args)
        if known is not None and not self._for_kernels and not callable_from_python(known):
            del self.overloads[args]
        self.targetoptions["no_cpython_wrapper"] = self._cache.for_kernels = self._for_kernels
        self.targetoptions["_nrt"] = self._counts
        try:
            return super().compile(sig)
        except NumbaError:
            if self._counts:
                raise
            self._counts = True  # what makes arrays cannot be compiled without
            self._compiler._failed_cache.clear()  # type: ignore[attr-defined]  # Numba does not try again what has failed
            if self._for_kernels:
                raise  # what calls it has failed, too, and tries again
        return self.compile(sig)

    def for_kernels(self, sig):
        """Machine code for a signature, which is called by address."""
        args = tuple(normalize_signature(sig)[0])
        if args not in self.overloads:
            before, self._for_kernels = self._for_kernels, True
            try:
                self.compile(args)
            except NumbaError:
                if not self._counts:
                    raise
                self.compile(args)
            finally:
                self._for_kernels = before
        return self.overloads[args]

    def add_overload(self, cres):
        if callable_from_python(cres):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = cres  # not in the table that Python's calls are looked up in


def callable_from_python(compiled) -> bool:
    """Whether machine code has a function that takes its arguments out of Python objects."""
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cpython_wrapper_name) != 0
