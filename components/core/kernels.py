"""Compiled kernels: one source that Numba compiles where it is installed and plain Python runs where it is not.

A kernel allocates nothing and raises nothing. It gets state, inputs, outputs, workspace, parameters `p` and effects `e`, and
returns one of the status integers below. `p` is a NamedTuple; so is `e`, with a field for each effect of the component: a
NamedTuple of its values, or None where it is off. A branch `if e.effect is not None` is decided at compile time (see
`compiler`), so that an effect that is off is not in the machine code.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from threading import RLock
from typing import Any
from zlib import crc32

from .compiled_here import compiles

COMPILED = compiles()  # else plain Python: an FMU's host may lack Numba, and NUMBA_DISABLE_JIT=1 waits for no compiler
LOADING = RLock()
# told that the compiler will be loaded (False) and that it is (True)
# one list of the process, for its FMUs are packages of their own
WHEN_LOADED: list[Callable[[bool], None]] = vars(sys).setdefault("_cosimo_when_loaded", [])

DONE, NOT_FINITE, NOT_CONVERGED, OUT_OF_RANGE, STEP_TOO_LONG = range(5)
RAISED = 99  # an error inside a kernel that is no status, such as an index out of range
OWN = 100  # the first status that a component may give a meaning of its own, see `contract.Refusal`
REASONS = {
    NOT_FINITE: ("the state is not finite", "Reduce the macro step, or the component's substep"),
    NOT_CONVERGED: ("the iteration inside the step did not converge", "Reduce the component's substep"),
    OUT_OF_RANGE: ("an input left the range of the model", "Check the inputs, or shorten the run"),
    STEP_TOO_LONG: ("the macro step is too long for what happens within it", "Reduce the macro step"),
}


class Kernel:
    """A function that is machine code from the first call on.

    The compiler takes longer to load than what a run finds in the cache: it is loaded where something is not found there.
    """

    def __init__(self, function: Callable[..., Any], files: tuple[str, ...]):
        update_wrapper(self, function)
        self.py_func, self.files, self.forceinline = function, files, False
        self.hits = 0  # how often its machine code was found without the compiler

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's compiler of this function."""
        with LOADING:
            for tell in WHEN_LOADED:
                tell(False)
            from .kernel_cache import dispatcher_of

            while WHEN_LOADED:
                WHEN_LOADED.pop()(True)
            dispatcher = dispatcher_of(self.py_func, self.files, self.forceinline)
        return dispatcher

    @property
    def _numba_type_(self) -> Any:  # by which a kernel that calls this one is typed
        return self.dispatcher._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            return getattr(self.py_func, name)
        if name == "parts":  # of templates, see `bind`
            raise AttributeError(name)
        return getattr(self.dispatcher, name)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.dispatcher(*arguments, **named)


def kernel(function, *files: str):
    """Compile `function` on first use and keep the machine code on disk, by the contents of its file, `files` and imports."""
    return Kernel(function, (function.__code__.co_filename, *files)) if COMPILED else function


def inlined(kernel):
    """A kernel whose instructions stand wherever a kernel calls it: nothing is handed on.

    Of an array that a call hands on seven numbers are copied, and of a component's memory all the arrays.
    """
    if COMPILED:
        kernel.forceinline = True
    return kernel


def inlined_kernel(function):
    """A `kernel` that is `inlined`, for functions that each derivative calls."""
    return inlined(kernel(function))


def bind(template, module: str, **names):
    """A kernel made from `template` with some of its global names replaced, cached under `module`'s name.

    Numba never finds a cached kernel that takes another kernel as an argument; one that calls it as a global it does.
    Templates that the template calls stand in its attribute `parts`, and are bound with it.
    """
    for part in getattr(template, "parts", ()):
        names[part] = bind(template.__globals__[part], module, **names)
    qualname = f"{template.__name__}_{module.replace('.', '_')}"
    bound = types.FunctionType(template.__code__, {**template.__globals__, **names}, qualname)
    bound.__qualname__, bound.__module__, bound.__doc__ = qualname, template.__module__, template.__doc__
    files = {getattr(f, "py_func", f).__code__.co_filename for f in names.values()}
    return kernel(bound, *sorted(files))


def kernel_tuple(cls: type) -> type:
    """Class decorator for every NamedTuple that a kernel is given.

    Numba recognises a NamedTuple's type by the class's bare name, its fields' names and types. Classes that agree in
    those, such as one component's in two FMUs of one process, are confused for one another, and every call then leaves
    the fast path (300 us instead of 10 were measured). Here the name is made unique by module and place.
    """
    place = crc32(f"{cls.__module__}.{cls.__qualname__}".encode())  # short: Numba looks at every letter at every call
    cls.__name__ = f"{cls.__qualname__.replace('.', '_')}_{place:08x}"
    return cls


@cache
def in_python(kernel: Any) -> Callable[..., Any]:
    """The Python function of a kernel, for numbers that are needed a few times, outside of runs, and do not pay for the compiler.

    What it calls is Python, too: a kernel that Python calls loads the compiler.
    """
    if not isinstance(kernel, Kernel):
        return kernel
    function = kernel.py_func
    names = {n: v for n in function.__code__.co_names if isinstance(v := function.__globals__.get(n), Kernel) and v is not kernel}
    if not names:
        return function
    own = {**function.__globals__, **{name: in_python(called) for name, called in names.items()}}
    return types.FunctionType(function.__code__, own, function.__name__, function.__defaults__, function.__closure__)


@kernel
def hold_inputs(u, h):
    """End of a step of length h: inputs keep the value they have reached, their slopes are used up; u: (3, m)."""
    for j in range(u.shape[1]):
        u[0, j] += h * (u[1, j] + h * u[2, j])
        u[1, j] = 0.0
        u[2, j] = 0.0


def compiled_from_cache(*kernels) -> tuple[int, int]:
    """(hits, misses) of the on-disk cache, summed over `kernels`; (0, 0) without Numba."""
    some = [k for k in kernels if isinstance(k, Kernel)]
    stats = [k.dispatcher.stats for k in some if "dispatcher" in vars(k)]
    hits = sum(k.hits for k in some) + sum(s.cache_hits.total() for s in stats)
    return hits, sum(s.cache_misses.total() for s in stats)
