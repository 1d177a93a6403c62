"""A component is its declaration and three kernels over one block of memory.

    initialize(t, s, p, e) -> status        step(t, h, s, p, e) -> status        outputs(t, s, p, e) -> status

`s` is what a run changes and what follows from the parameters, arrays and records: inputs `u` (3, m), value, slope and half of the second
derivative over the coming step; outputs `y` (k,); state `x` (n,); `counts`; and what the component's `shapes` names. `p` are the
parameters, `e` the effects: of each its `Values`, or None where it is off. A status that is not `DONE` ends the initialization or
the step; `refusals` of the class lists those that the user can correct.

Parameters that are not structural are numbers in the block, and `initialize` computes what follows from them. They can be set wherever
the component runs. `shapes` sees the structural parameters and the effects that are on only.
"""

from __future__ import annotations

import re
from collections import namedtuple
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import reduce
from threading import Lock
from typing import Any, ClassVar, NamedTuple, get_type_hints

import numpy as np

from .block import ENTRIES, TIME, Block, Entry, callable_of
from .component import Component, _tuple_type
from .errors import BadInput
from .kernels import COMPILED, DONE, NOT_FINITE, RAISED, kernel_tuple
from .variables import Causality

STANDARD = ("u", "y", "x", "counts")  # fields of every `s`
LAID_OUT = (*STANDARD, "block", "arguments", "_structure")  # of an instance, from when one of them is asked for


IMAGES = 8  # memories that are held, of components whose initialization is long
_IMAGES: dict[tuple[Any, ...], np.ndarray] = {}
_LOCK = Lock()  # of the images: threads initialize instances of their own


class Kernels(NamedTuple):
    """The kernels of a component; `derivatives(t, x, u, dx, s, p, e)` where a smooth differential equation is all of it."""

    initialize: Callable[..., int]
    step: Callable[..., int]
    outputs: Callable[..., int]
    derivatives: Callable[..., None] | None = None


class Refusal(NamedTuple):
    """The message of a status by which `initialize` refuses parameters or inputs.

    The texts may name parameters, inputs, and elements and fields of `s` in braces, such as {substep}, {limits[1]} and
    {inertias.least}: their values; also attributes of the component that are texts.
    """

    actual: str
    expected: str
    remedy: str = ""


def contents_of(shape: Any) -> Any:
    """What a field of `s` begins with: see `KernelComponent.shapes`."""
    if isinstance(shape, type):
        kinds = [(name, np.int64 if kind is int else np.float64) for name, kind in get_type_hints(shape).items()]
        return np.zeros((), np.dtype((np.record, np.dtype(kinds, align=True))))
    return shape if isinstance(shape, np.ndarray) or shape is None or hasattr(shape, "_fields") else np.zeros(shape)


def filled(text: str, value: Callable[[str], str]) -> str:
    """A text of a refusal with `value` of each name in braces."""
    return re.sub(r"\{([^{}]+)\}", lambda match: value(match[1]), text)


class KernelComponent(Component):
    """Base of components that are kernels; a subclass gives `kernels` and, for what is in `s` besides the standard, `shapes`."""

    kernels: ClassVar[Kernels]
    refusals: ClassVar[Mapping[int, Refusal]] = {}  # by status; those of base classes are inherited
    # Arrays that follow from the parameters alone. An initialization for other inputs, and one of another instance, find them as
    # they are if the first of them says so, which is other than 0 then
    kept: ClassVar[tuple[str, ...]] = ()
    fixed_arrays: ClassVar[tuple[str, ...]] = ()  # arrays that come with their contents, which no kernel writes; perhaps large
    Memory: ClassVar[Any] = None  # NamedTuple of the arrays of `s`, for kernels
    known_entries: ClassVar[dict[tuple[Any, ...], Entry]]
    unread: ClassVar[Mapping[str, tuple[str, ...]]] = {}  # of each kernel the effects that it does not read
    block: Block | None
    _kept_of: tuple[Any, ...] = ()  # the values that the `kept` arrays in the block follow from

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.Memory, cls.known_entries = None, {}
        if not cls.Values._fields:  # Numba has no NamedTuple without a field
            cls.Values = _tuple_type(cls, "Values", ["none"])
        cls.refusals = {n: r for base in reversed(cls.__mro__) for n, r in vars(base).get("refusals", {}).items()}
        cls.unread = {k: tuple(n for n, effect in cls.effects.items() if k not in effect.read_by) for k in ENTRIES}
        if not cls.effects:
            cls.Present = _tuple_type(cls, "Present", ["none"])

    def shapes(self) -> dict[str, Any]:
        """The arrays of `s` besides inputs, outputs and counters: name -> shape, of zeros, or an array with its contents, or None.

        A class of annotated numbers is a record: a kernel reads and writes its numbers as `s.name.field`. `x` is the state. It depends on
        the structural parameters and the effects that are on; its names are always the same.
        """
        return {}

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        own = vars(self)
        self._outside: dict[str, Any] = {name: own.pop(name) for name in STANDARD}  # what memory begins with
        if any(hasattr(type(self), name) for name in LAID_OUT):  # a variable that is called so would answer instead
            self._stand_in_memory()

    def __getattr__(self, name: str) -> Any:
        """Memory is laid out when it is needed: many instances are only asked for parameters."""
        if name not in LAID_OUT or "_outside" not in vars(self):
            raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}", name=name, obj=self)
        self._stand_in_memory()
        return object.__getattribute__(self, name)

    def _stand_in_memory(self) -> None:
        vars(self).update(vars(self).pop("_outside"), block=None)
        self._lay_out_if_possible()

    def get(self, name: str) -> Any:
        """The value of a parameter, an input or an output."""
        if "_outside" in vars(self) and name in self._input_index:
            return float(self._outside["u"][0, self._input_index[name]])
        return super().get(name)

    __getitem__ = get

    def set(self, name: str, value: Any) -> None:
        """Set a parameter (before `initialize`, unless it is tunable) or the present value of an input, in the block, too."""
        super().set(name, value)
        if name in self.parameters and vars(self).get("block") is not None:
            if self._structure != self._present_structure():
                self._lay_out_if_possible()
            else:
                self._write_parameters()

    def stand(self, cells: np.ndarray) -> None:
        """Stand where another block of this layout does, whose cells are given: with its state and its parameters."""
        assert self.block is not None
        self.block.stand(cells)
        variables = type(self).variables
        for name, value in self.parameters.items():
            if isinstance(value, float) and not variables[name].structural:
                self.parameters[name] = float(cells[self.cell_of(name)])
        self._write_parameters()
        self._kept_of = ()  # arrays that have moved with the parameters are not what `initialize` makes of them

    def cell_of(self, name: str) -> int:
        """The cell of a parameter that is a number."""
        assert self.block is not None
        whole, bracket, index = name.partition("[")
        effect, dot, field = whole.partition(".")
        first = self.block.cell("e", effect, field) if dot else self.block.cell("p", whole)
        return first + (int(index.rstrip("]")) - 1 if bracket else 0)

    # -- memory ------------------------------------------------------------------------------------------------------
    def _present_structure(self) -> tuple[Any, ...]:
        variables = type(self).variables
        return tuple(value for name, value in self.parameters.items() if variables[name].structural)

    def _lay_out_if_possible(self) -> None:
        with suppress(BadInput, ArithmeticError, ValueError):  # initialization says what is wrong
            self._lay_out()

    def _lay_out(self) -> None:
        """Memory for the present structure; inputs are taken over."""
        cls = type(self)
        shapes = self.shapes()
        contents: dict[str, Any] = {n: np.zeros_like(getattr(self, n)) for n in ("u", "y")}
        contents |= {"x": np.zeros(0), "counts": np.zeros_like(self.counts)}
        contents |= {name: contents_of(shape) for name, shape in shapes.items()}
        if vars(cls).get("Memory") is None or cls.Memory._fields != tuple(contents):
            cls.Memory = self._memory_type(tuple(contents))
        p, e = self._parameters()
        self.block = block = Block(
            cls.Memory(**contents), p, e, constant=cls.fixed_arrays, unread=cls.unread, either=self._either()
        )
        self._structure, self._calls = self._present_structure(), dict[str, Any]()
        self._contents = hash(block.memory.tobytes()) if cls.kept else 0  # before inputs are there, of which nothing kept follows
        self._kept_of = ()
        block.s.u[...], block.s.y[...] = self.u, self.y
        self.u, self.y, self.x, self.counts = block.s.u, block.s.y, block.s.x, block.s.counts
        self._write_parameters()

    def _either(self) -> dict[str, dict[str, Any]]:
        """Of each kernel the effects that it finds on or off, each with values of its form; not those that cannot be on."""
        some = {n: effect for n, effect in type(self).effects.items() if set(effect.requires) <= set(self.on)}
        return {k: {n: effect.form() for n, effect in some.items() if k in effect.either_in} for k in ENTRIES}

    def _write_parameters(self) -> None:
        """The parameters into their cells; `arguments` are what kernels get."""
        assert self.block is not None
        p, e = self._parameters()
        self.arguments = (self.block.s, self.block.write(("p",), p), self.block.write(("e",), e))

    @classmethod
    def _memory_type(cls, fields: tuple[str, ...]) -> Any:
        values = namedtuple("Memory", fields)  # type: ignore[misc]
        values.__module__, values.__qualname__ = cls.__module__, f"{cls.__qualname__}.Memory"
        return kernel_tuple(values)

    def _parameters(self) -> tuple[Any, Any]:
        cls = type(self)
        values = [self._value(v) for v in cls.own_variables if v.causality is Causality.PARAMETER]
        return cls.Values(*(values or [None])), cls.Present(*(map(self._effect_values, cls.effects) if cls.effects else (None,)))

    # -- the run -----------------------------------------------------------------------------------------------------
    @property
    def layout_of_block(self) -> tuple[Any, ...]:
        """What the layout of the block follows from."""
        return type(self), self.on, self._structure

    def entry(self, name: str) -> int:
        """The address of the function `int32 f(double t, double h, void *block)` that calls a kernel: compiled, if need be."""
        assert self.block is not None
        known, key = type(self).known_entries, (name, self.layout_of_block)
        if key not in known:
            known[key] = self.block.entry(name, getattr(type(self).kernels, name), self.arguments)
        return self.block.take(name, known[key])

    def wanted(self) -> list[tuple[Any, int, tuple[Any, ...]]]:
        """Of each entry what its machine code is made for; none where the parameters are refused, or nothing is compiled."""
        if self.block is None or not COMPILED:
            return []
        return [self.block.wanted(name, getattr(type(self).kernels, name), self.arguments) for name in ENTRIES]

    def call(self, name: str, t: float, h: float = 0.0) -> int:
        """The status of a kernel for the present block."""
        assert self.block is not None
        if not COMPILED:
            times = (t, h) if name == "step" else (t,)
            try:
                return getattr(type(self).kernels, name)(*times, *self.block.given(name, self.arguments)) or DONE
            except (ValueError, OverflowError):  # Python's own functions refuse what machine code goes on with
                if np.isfinite(self.u).all():
                    raise
                return NOT_FINITE
        if name not in self._calls:
            self._calls[name] = callable_of(self.entry(name))
        return self._calls[name](t, h, self.block.address)

    def _prepare(self) -> Block:
        """The block with the present parameters, inputs and `kept` arrays; all else is zero."""
        if self.block is None or self._structure != self._present_structure():
            self._lay_out()
        assert self.block is not None
        block, kept = self.block, type(self).kept
        if kept and not (getattr(block.s, kept[0])[0] and self._kept_of == self._image_key()):
            self._kept_of = self._image_key()
            if (image := _IMAGES.get(self._kept_of)) is not None:
                block.stand(image, block.addresses_at)
            else:
                kept = ()
        block.begin_anew(kept)
        return block

    def _image_key(self) -> tuple[Any, ...]:
        """The values that the `kept` arrays follow from."""
        assert self.block is not None
        return type(self), self.on, self._structure, self._contents, self.block.parameters.tobytes()

    def _initialize(self, t: float) -> int:
        block = self._prepare()
        status = self.call("initialize", t)
        if status == DONE and type(self).kept and (key := self._image_key()) not in _IMAGES:
            with _LOCK:
                _IMAGES[key] = block.memory.copy()
                while len(_IMAGES) > IMAGES:
                    del _IMAGES[next(iter(_IMAGES))]
        if status == DONE and not np.isfinite(self.x).all():
            raise ArithmeticError("the initial state is not finite")
        return status

    def _step(self, t: float, h: float) -> int:
        return self.call("step", t, h)

    def _outputs(self, t: float) -> None:
        self._check(self.call("outputs", t))

    def _check(self, status: int) -> None:
        if status == DONE:
            return
        if status == RAISED:
            raise RuntimeError(f"a kernel of {self.name} has raised an exception")
        if refusal := type(self).refusals.get(status):
            raise BadInput(self.name, *(self._with_values(text) for text in refusal))
        super()._check(status)

    def _with_values(self, text: str) -> str:
        """A text of a refusal with the present values."""
        inputs = dict(zip(self.inputs, self.u[0].tolist(), strict=True))

        def value(name: str) -> str:
            if isinstance(text := getattr(self, name, None), str):
                return text
            if name in self.parameters or name in inputs:
                number = self.parameters.get(name, inputs.get(name))
            else:
                array, _, index = name.partition("[")
                of = reduce(getattr, array.split("."), self.arguments[0])
                number = float(of.flat[int(index.rstrip("]") or 0)])
            return f"{number:.6g}" if isinstance(number, float) else f"{number}"

        return filled(text, value)

    def of_initialization(self, name: str, index: int) -> float:
        """An element of an array of `s` as `initialize` computes it for the present parameters and inputs.

        The component stays as it is. A refusal is none here.
        """
        if self.block is None or self._structure != self._present_structure():
            self._lay_out()
        assert self.block is not None
        if COMPILED:
            self.entry("initialize")  # its address stands in the block, too
        before = self.block.memory.copy(), self._kept_of
        self._prepare()
        try:
            self.call("initialize", self.t)
            return float(getattr(self.arguments[0], name).flat[index])
        finally:
            self.block.memory[:], self._kept_of = before

    def save(self) -> bytes:
        """Everything a repeated step depends on; `restore` gives back every bit."""
        assert self.block is not None
        self.block.memory[TIME] = self.t
        return self.block.memory[: self.block.state_end].tobytes()

    def restore(self, state: bytes) -> None:
        """Take back a state of `save`, of this instance or of one with the same effects and parameters."""
        values = np.frombuffer(state)
        if self.block is None or values.size != self.block.state_end:
            size = 1 + self.u.size + self.y.size + self.x.size if self.block is None else self.block.state_end
            raise BadInput(self.name, f"a state of {values.size} numbers", f"{size} numbers")
        self.block.memory[: values.size] = values
        self.t = float(values[TIME])
