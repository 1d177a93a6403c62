"""Machine code of kernels, made where something asks for an address.

Numba makes machine code of every function that it compiles, and links what the function calls in LLVM's language, optimized once
more at every level. Most kernels are called by kernels only: here their code is optimized and translated within those that
Python, or an entry of a component, calls. That is a quarter of what a component costs to compile. The cache has them in LLVM's
language.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import lookup_environment

ENVIRONMENT = "_ZN08NumbaEnv"  # how the variables begin that have the address of a function's environment
LINKED = "linked"  # what is kept of a library without machine code

PYTHON, ADDRESS, KERNELS = (
    "python",
    "address",
    "kernels",
)  # who asks for code: Python, an entry by its address, kernels that call it


class KernelLibrary(JITCodeLibrary):
    """Numba's library of a function, with machine code from the time on that an address is asked for."""

    _linked = False
    _taken = b""  # machine code from the cache
    _codegen: Any

    @property
    def finalized(self) -> bool:
        """Whether there is machine code."""
        return self._finalized

    @property
    def codegen(self):
        """Numba sets the environment of a function as soon as the function is compiled: `finalize` does where there is none."""
        return self._codegen if self._finalized else _WithoutMachineCode()

    @property
    def has_dynamic_globals(self) -> bool:
        """Whether the code refers to memory of this process, and cannot be kept. Some of what does is optimized away."""
        self.link()
        if self._dynamic_globals:
            self._ensure_finalized()
        return bool(self._dynamic_globals)

    def add_linking_library(self, library) -> None:
        """What this library calls; linked when the library is needed."""
        if not isinstance(library, KernelLibrary):
            library._ensure_finalized()
        self._reload_init.update(library._reload_init)  # what is done again where the code comes from the cache
        self._linking_libraries.append(library)

    def link(self) -> None:
        """Put what the function calls into the library; once."""
        if self._linked or self._finalized:
            return
        self._linked = True
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._linking_libraries.clear()
        self._finalize_dynamic_globals()

    def finalize(self) -> None:
        """Optimize, and make machine code."""
        self.link()
        self._dynamic_globals.clear()
        self._shared_module = None  # from now on the optimized one, which is smaller
        super().finalize()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name) if variable.name.startswith(ENVIRONMENT) else None
            if environment is not None:
                self._codegen.set_env(variable.name, environment)

    def _get_module_for_linking(self):
        if self._finalized:
            return super()._get_module_for_linking()
        if self._shared_module is None:
            self.link()
            module = self._final_module.clone()
            for function in module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"
            self._shared_module = module
        return self._shared_module

    def get_pointer_to_function(self, name: str) -> int:
        """The address of a function of this library; 0 where it has none of this name."""
        if not self._finalized:
            try:
                self._final_module.get_function(name)
            except NameError:
                return 0
        with global_compiler_lock:
            return super().get_pointer_to_function(name)

    def _get_compiled_object(self):
        return self._taken or super()._get_compiled_object()

    def serialize_using_object_code(self):
        """What the cache keeps: machine code, or constants to look into, and LLVM's language."""
        if self._finalized:
            return super().serialize_using_object_code()
        self.link()
        constants = "\n".join(map(str, self._final_module.global_variables)).encode()
        return self.name, LINKED, (constants, self._final_module.as_bitcode())

    @classmethod
    def _unserialize(cls, codegen, state):
        name, kind, (compiled, code) = state
        if kind != LINKED:
            library = super()._unserialize(codegen, state)
            library._taken = compiled  # Numba forgets it once it is in memory
            return library
        library = codegen.create_library(name)
        library.enable_object_caching()
        library._final_module = llvm.parse_bitcode(code)
        library._linked = True
        return library


class _WithoutMachineCode:
    """In the place of what makes machine code."""

    def set_env(self, name, environment) -> None:
        """Set by `KernelLibrary.finalize`."""


@contextmanager
def kernel_libraries(codegen: Any) -> Iterator[None]:
    """What Numba compiles or loads meanwhile has libraries of this kind; under its lock."""
    before = codegen._library_class
    codegen._library_class = KernelLibrary
    try:
        yield
    finally:
        codegen._library_class = before
