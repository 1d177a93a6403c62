"""Integrators for FMUs without one: CVode from the SUNDIALS libraries FMPy ships, and the methods of SciPy's solve_ivp.

Both go step by step and end a step where an event indicator changes between positive and not positive, on the far side of
the change. Multistep methods (CVode, BDF, LSODA) use past steps: after a restart they are of first order, and many restarts cost far
more accuracy than their tolerance says. They therefore continue across macro steps wherever nothing jumps. One-step methods lose only
the length of their step at a restart; it is kept.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

import numpy as np

METHODS = ("CVode", "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
DONE, AGAIN, FAILED = 0, 1, -1  # what an equation answers: fine, not here but perhaps nearer by, no more at all
BDF, ONE_STEP, ROOT, WARNING = 2, 2, 2, 99  # of CVode
SINGLE = 0  # no MPI communicator
CLOSE = 100.0 * np.finfo(float).eps  # relative to time and step: how near an event is looked for, as near as CVode does

Equation = Callable[[float, int, int], int]  # time, address of the states, address for the result


class SolverFailed(RuntimeError):
    """The integrator cannot go on; the message says why."""


class Solver(Protocol):
    """Integrates x' = f(t, x); `address`: of the states reached."""

    address: int
    multistep: bool  # accuracy lives from the past: go on after a step rather than `restart`
    step_size: float | None  # s, all that a restarted one-step method goes on from; None: not known yet

    def restart(self, t: float, x: np.ndarray) -> None:
        """Begin anew at t with the states x, (n,)."""

    def advance(self, goal: float) -> tuple[float, bool]:
        """One step towards `goal` and not beyond: (time reached, whether an indicator changed there)."""

    def tolerate(self, absolute: np.ndarray) -> None:
        """Absolute tolerances of the states, (n,), from the next `restart` on."""

    def close(self) -> None:
        """Give back memory of the library."""


def make_solver(method: str, states: int, indicators: int, f: Equation, g: Equation, relative: float) -> Solver:
    """The integrator of a method in `METHODS`; without states it has one of its own that stays 0."""
    return Cvode(states, indicators, f, g, relative) if method == "CVode" else Scipy(method, states, indicators, f, g, relative)


class Cvode:
    """Backward differentiation of order 1 to 5 with a dense Jacobian from differences."""

    multistep = True
    step_size: float | None = None

    def __init__(self, states: int, indicators: int, f: Equation, g: Equation, relative: float):
        from fmpy.sundials import libraries

        self._libraries, self._relative = libraries, relative
        self._error_text = ""
        n, pointer, real = max(states, 1), ctypes.c_void_p, ctypes.c_double
        data = self._function("core", "N_VGetArrayPointer", pointer, pointer)

        def derivatives(t: float, x: int, dx: int, _: Any) -> int:
            if not states:
                (real * 1).from_address(data(dx))[0] = 0.0
                return DONE
            return f(t, data(x), data(dx))

        def roots(t: float, x: int, z: int, _: Any) -> int:
            return g(t, data(x), z)

        def error(_line: int, _function: bytes, _file: bytes, message: bytes, *_: Any) -> None:
            self._error_text = (message or b"").decode(errors="replace").strip()

        # kept here as long as the library may call them
        self._derivatives = ctypes.CFUNCTYPE(ctypes.c_int, real, pointer, pointer, pointer)(derivatives)
        self._roots = ctypes.CFUNCTYPE(ctypes.c_int, real, pointer, pointer, pointer)(roots)
        self._error = ctypes.CFUNCTYPE(None, ctypes.c_int, *[ctypes.c_char_p] * 3, ctypes.c_int, pointer, pointer)(error)

        self._context = pointer()
        self._call("core", "SUNContext_Create", ctypes.c_int(SINGLE), ctypes.pointer(self._context))
        self._call("core", "SUNContext_ClearErrHandlers", self._context)
        self._call("core", "SUNContext_PushErrHandler", self._context, self._error, pointer())
        vector = self._function("nvecserial", "N_VNew_Serial", pointer, ctypes.c_int64, pointer)
        self._x, self._absolute = (pointer(vector(n, self._context)) for _ in range(2))
        self.address = data(self._x)
        self._states, self._tolerances = (
            np.ctypeslib.as_array((real * n).from_address(data(v))) for v in (self._x, self._absolute)
        )
        self._states[:], self._tolerances[:] = 0.0, 1.0
        make = self._function("sunmatrixdense", "SUNDenseMatrix", pointer, ctypes.c_int64, ctypes.c_int64, pointer)
        self._matrix = pointer(make(n, n, self._context))
        self._linear = pointer(
            self._function("sunlinsoldense", "SUNLinSol_Dense", pointer, *[pointer] * 3)(self._x, self._matrix, self._context)
        )
        self._memory = pointer(self._function("cvode", "CVodeCreate", pointer, ctypes.c_int, pointer)(BDF, self._context))
        self._call("cvode", "CVodeInit", self._memory, self._derivatives, real(0.0), self._x)
        self._call("cvode", "CVodeSVtolerances", self._memory, real(relative), self._absolute)
        self._call("cvode", "CVodeSetLinearSolver", self._memory, self._linear, self._matrix)
        if indicators:
            self._call("cvode", "CVodeRootInit", self._memory, ctypes.c_int(indicators), self._roots)
            self._call("cvode", "CVodeSetNoInactiveRootWarn", self._memory)
        self._restart = self._function("cvode", "CVodeReInit", ctypes.c_int, pointer, real, pointer)
        self._stop = self._function("cvode", "CVodeSetStopTime", ctypes.c_int, pointer, real)
        self._advance = self._function("cvode", "CVode", ctypes.c_int, pointer, real, pointer, pointer, ctypes.c_int)
        self._reached = real()

    def _function(self, library: str, name: str, result: Any, *types: Any) -> Callable[..., Any]:
        """A C function under argument types of our own: indexing the library gives a new object each time."""
        function = getattr(self._libraries, f"sundials_{library}")[name]
        function.argtypes, function.restype = types, result
        return function

    def _call(self, library: str, name: str, *arguments: Any) -> None:
        self._check(self._function(library, name, ctypes.c_int, *(type(a) for a in arguments))(*arguments))

    def _check(self, status: int) -> None:
        if status < 0:
            raise SolverFailed(self._error_text or f"CVode returned {status}")

    def tolerate(self, absolute: np.ndarray) -> None:
        if absolute.size:
            self._tolerances[:] = absolute
        self._call("cvode", "CVodeSVtolerances", self._memory, ctypes.c_double(self._relative), self._absolute)

    def restart(self, t: float, x: np.ndarray) -> None:
        self._states[: x.size] = x
        self._check(self._restart(self._memory, t, self._x))

    def advance(self, goal: float) -> tuple[float, bool]:
        self._check(self._stop(self._memory, goal))
        status = self._advance(self._memory, goal, self._x, ctypes.addressof(self._reached), ONE_STEP)
        self._check(status)
        return self._reached.value, status == ROOT

    def close(self) -> None:
        for library, name, place in (
            ("cvode", "CVodeFree", self._memory),
            ("core", "SUNLinSolFree", self._linear),
            ("core", "SUNMatDestroy", self._matrix),
            ("core", "N_VDestroy", self._absolute),
            ("core", "N_VDestroy", self._x),
            ("core", "SUNContext_Free", self._context),
        ):
            if place.value:
                by_address = name in ("CVodeFree", "SUNContext_Free")  # these set it to NULL
                self._function(library, name, None, ctypes.c_void_p)(ctypes.addressof(place) if by_address else place)
                place.value = None


class Scipy:
    """A method of SciPy's solve_ivp; events are found by bisection on its own interpolation of a step."""

    def __init__(self, method: str, states: int, indicators: int, f: Equation, g: Equation, relative: float):
        import scipy.integrate

        self._method = getattr(scipy.integrate, method)
        self.multistep, self._keeps_step = method in ("BDF", "LSODA"), method != "LSODA"
        self.step_size: float | None = None
        self._n, self._relative, self._g = states, relative, g
        self._solver: Any = None
        self._z = np.zeros(indicators)
        self._tolerances = np.ones(max(states, 1))
        self._equation = f
        self._place(np.zeros(max(states, 1)))

    def _place(self, x: np.ndarray) -> None:
        self._x = np.ascontiguousarray(x, dtype=float)  # kept: its address is handed out
        self.address = self._x.ctypes.data

    def _f(self, t: float, x: np.ndarray) -> np.ndarray:
        dx = np.zeros(x.size)
        if self._n:
            states = np.ascontiguousarray(x, dtype=float)
            if self._equation(t, states.ctypes.data, dx.ctypes.data) != DONE:
                raise SolverFailed("no derivatives there")
        return dx

    def _signs(self, t: float, x: np.ndarray) -> np.ndarray:
        states = np.ascontiguousarray(x, dtype=float)
        if self._z.size and self._g(t, states.ctypes.data, self._z.ctypes.data) != DONE:
            raise SolverFailed("no event indicators there")
        return self._z > 0.0

    def tolerate(self, absolute: np.ndarray) -> None:
        if absolute.size:
            self._tolerances = absolute.copy()

    def restart(self, t: float, x: np.ndarray) -> None:
        self._place(x if self._n else np.zeros(1))
        self._t = t
        self._solver = None
        self._before = self._signs(t, self._x)

    def advance(self, goal: float) -> tuple[float, bool]:
        solver, before = self._heading_for(goal), self._t
        wished = solver.h_abs if self._keeps_step else 0.0
        reason = solver.step()
        if solver.status == "failed":
            raise SolverFailed(reason or "the step became too small")
        self._t = float(solver.t)
        if self._keeps_step:  # a step that the goal has cut says nothing against the one that was wished
            self.step_size = float(max(solver.h_abs, wished if wished > goal - before else 0.0))
        self._place(solver.y.copy())
        crossed = bool(self._z.size) and bool((self._signs(self._t, self._x) != self._before).any())
        if crossed:
            self._t = self._locate(before, self._t, solver.dense_output())
        return self._t, crossed

    def _heading_for(self, goal: float) -> Any:
        """SciPy's object, on its way to the goal."""
        if self._solver is not None and self._solver.t_bound != goal and self.multistep:
            self._solver.t_bound, self._solver.status = goal, "running"
            if hasattr(self._solver, "_lsoda_solver"):  # ODEPACK's own place for the end, which SciPy sets at the start only
                self._solver._lsoda_solver._integrator.rwork[0] = goal
        elif self._solver is None or self._solver.t_bound != goal:
            first = min(self.step_size, goal - self._t) if self.step_size else None
            self._solver = self._method(
                self._f, self._t, self._x.copy(), goal, rtol=self._relative, atol=self._tolerances, first_step=first
            )
        return self._solver

    def _locate(self, low: float, high: float, at: Callable[[float], np.ndarray]) -> float:
        """The far side of a change of indicators between two times, where `_x` is left."""
        near = CLOSE * (abs(high) + high - low)
        while high - low > near:
            middle = 0.5 * (low + high)
            x = at(middle)
            if (self._signs(middle, x) != self._before).any():
                high = middle
                self._place(x)
            else:
                low = middle
        return high

    def close(self) -> None:
        with suppress(AttributeError):
            del self._solver
