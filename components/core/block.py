"""One block of memory for all data of a component, and the functions that call its kernels on it.

A kernel of a component gets `s`, `p` and `e`, NamedTuples of views of the block (see `contract`). The block consists of cells of
eight bytes: the time, `u`, `y`, `x`, the counters, the parameters, and behind them what follows from the parameters, and
workspace. A number of `p` or `e`, and of a record of `s`, is one cell, an array as many as it has bytes for.

An entry is a function `int32 f(double t, double h, void *block)`, made from the layout alone: it loads the numbers, adds the
offsets of the arrays to the address of the block and calls the kernel, with the arguments that Numba flattens `s`, `p` and `e`
into. The same text serves this process, where the address of the kernel stands in the block, and a library, where it is a symbol.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from math import prod
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from .kernel_sources import private_folder
from .kernels import COMPILED, RAISED
from .store import digest_of, read_kept, write_kept

if COMPILED:
    import llvmlite.binding as llvm

    from .kept_kernels import LOCK, Either, machine, machine_code

CELL = 8  # bytes
LINE = 8  # cells of a line of the cache; an array of several lines begins with one
NOTHING: Mapping[str, Any] = MappingProxyType({})
TIME = 0  # the cell that holds the time
ENTRY = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_double, ctypes.c_double, ctypes.c_void_p)
ENTRIES = {"initialize": ("double %t",), "step": ("double %t", "double %h"), "outputs": ("double %t",)}  # what each hands on


class Entry(NamedTuple):
    """Addresses of an entry and of the kernel that it calls; the same for all blocks of one layout."""

    function: int
    kernel: int


class Leaf(NamedTuple):
    """A number, an array or a record of the block; kind: "f8", "i8", "array", "record" or "none", which takes no cell.

    Nor do those that say whether an effect is on, "flag", with 1 or 0 as cell, and stand for the values of one that is off, "absent".
    """

    kind: str
    cell: int = 0
    shape: tuple[int, ...] = ()
    itemsize: int = CELL


class Block:
    """The layout of `s`, `p` and `e`, and the memory itself, (cells,) float64.

    `s` holds arrays and records, whose contents are those that the block begins with.
    """

    def __init__(
        self,
        s: Any,
        p: Any,
        e: Any,
        entries: Mapping[str, tuple[str, ...]] = ENTRIES,
        constant: tuple[str, ...] = (),
        unread: Mapping[str, tuple[str, ...]] = NOTHING,
        either: Mapping[str, Mapping[str, Any]] = NOTHING,
    ):
        """entries: what each hands on besides the block.  constant: fields of `s` that nothing changes, which lie last.
        unread: of entries the fields of `e` that their kernels do not read, and get as None.
        either: of entries the fields of `e` that their kernels find on or off when they run, each with values of its form.
        """
        self.entries, self._constant, self._unread, self._either = entries, constant, unread, either
        self.cells, self._leaves = TIME + 1, dict[tuple[str | int, ...], Leaf]()
        first = [name for name in ("u", "y", "x", "counts") if name in s._fields]
        for name in first:
            self._place(("s", name), getattr(s, name))
            if name == "x":
                self.state_end = self.cells  # time, inputs, outputs, state: what a repeated step depends on
        self.parameters_at = self.cells
        self._place(("p",), p)
        self._place(("e",), e)
        self.saved = self.cells
        self.addresses_at = self.cells
        self.cells += len(entries)
        for name in s._fields:
            if name not in (*first, *constant):
                self._place(("s", name), getattr(s, name))
        changing = self.cells
        for name in constant:
            self._place(("s", name), getattr(s, name))
        room = np.zeros(self.cells + LINE)
        first_line = -(room.ctypes.data // CELL) % LINE
        self.memory = room[first_line : first_line + self.cells]
        self.address = self.memory.ctypes.data
        self._fields = s._fields
        self.s = type(s)(*(self._with_contents(("s", n), getattr(s, n)) for n in s._fields))
        self._initial = self.memory[:changing].copy()
        self._anew: dict[tuple[str, ...], list[slice]] = {}  # what begins anew, by what does not

    def _place(self, path: tuple[str | int, ...], value: Any) -> None:
        if isinstance(value, tuple):
            for name, item in zip(getattr(value, "_fields", range(len(value))), value, strict=True):
                self._place((*path, name), item)
        elif isinstance(value, np.ndarray):
            kind = "array" if value.shape or value.dtype.names is None else "record"
            if value.nbytes >= LINE * LINE * CELL:
                self.cells += -self.cells % LINE
            self._leaves[path] = Leaf(kind, self.cells, value.shape, value.itemsize)
            self.cells += max(1, -(-value.nbytes // CELL))
        elif value is None:
            self._leaves[path] = Leaf("none")
        else:
            self._leaves[path] = Leaf("f8" if isinstance(value, float) else "i8", self.cells)
            self.cells += 1

    def _with_contents(self, path: tuple[str | int, ...], value: Any) -> Any:
        if isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            return type(value)(*(self._with_contents((*path, n), v) for n, v in zip(names, value, strict=True)))
        if value is None:
            return None
        view = self.view(path, value.dtype)
        view[...] = value
        return view[()] if self._leaves[path].kind == "record" else view

    def view(self, path: tuple[str | int, ...], dtype: Any = np.float64) -> np.ndarray:
        """An array of the block."""
        leaf = self._leaves[path]
        size = prod(leaf.shape)
        first = CELL * leaf.cell
        return self.memory.view(np.uint8)[first : first + size * leaf.itemsize].view(dtype).reshape(leaf.shape)

    def ranges(self, name: str) -> list[tuple[int, int]]:
        """First cells and those behind the last of the arrays and records of a field of `s`."""
        leaves = [leaf for path, leaf in self._leaves.items() if path[:2] == ("s", name) and leaf.kind in ("array", "record")]
        return [(at.cell, at.cell + max(1, -(-int(np.prod(at.shape)) * at.itemsize // CELL))) for at in leaves]

    def cell(self, *path: str | int) -> int:
        """The first cell of the field at a path, such as ("p", "mass")."""
        return self._leaves[path].cell

    def name(self, cell: int) -> str:
        """Of a cell: the field that it belongs to, and its place in it, such as "x[3]"."""
        for path, leaf in self._leaves.items():
            size = max(1, prod(leaf.shape) * leaf.itemsize // CELL)
            if leaf.kind != "none" and leaf.cell <= cell < leaf.cell + size:
                return ".".join(map(str, path[1:])) + (f"[{cell - leaf.cell}]" if leaf.kind == "array" else "")
        return f"cell {cell}"

    def write(self, path: tuple[str | int, ...], value: Any) -> Any:
        """Put numbers where they belong; returns them as kernels get them, arrays as views."""
        if isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            items = [self.write((*path, name), item) for name, item in zip(names, value, strict=True)]
            return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
        leaf = self._leaves[path]
        if leaf.kind == "none":
            return None
        if leaf.kind == "array":
            view = self.view(path, value.dtype)
            view[...] = value
            return view
        (self.memory if leaf.kind == "f8" else self.memory.view(np.int64))[leaf.cell] = value
        return value

    @property
    def parameters(self) -> np.ndarray:
        """The cells of `p` and `e`."""
        return self.memory[self.parameters_at : self.saved]

    def stand(self, cells: np.ndarray, first: int = TIME) -> None:
        """From a cell on as the memory of another block of this layout, (cells,), but for the addresses of kernels."""
        for part in (slice(first, self.addresses_at), slice(self.addresses_at + len(self.entries), self.cells)):
            self.memory[part] = cells[part]

    def begin_anew(self, but: tuple[str, ...] = ()) -> None:
        """All as it was at the beginning, tables with their contents; inputs stay, and the arrays named in `but`."""
        if but not in self._anew:
            ends = [r for n in self._fields if n not in ("u", "y", *but, *self._constant) for r in self.ranges(n)]
            self._anew[but] = [slice(*r) for r in joined(ends)]
        for part in self._anew[but]:
            self.memory[part] = self._initial[part]

    def in_order(self, entry: str = "") -> Iterator[Leaf]:
        """The leaves in the order of a kernel's arguments `s`, `p`, `e`; entry: as that gives them to its kernel."""
        for name in self._fields:
            yield from (leaf for path, leaf in self._leaves.items() if path[:2] == ("s", name))
        yield from (leaf for path, leaf in self._leaves.items() if path[0] == "p")
        effects = dict[str, list[Leaf]]()
        for path, leaf in self._leaves.items():
            if path[0] == "e":
                effects.setdefault(str(path[1]), []).append(leaf)
        either = self._either.get(entry, {})
        for name, leaves in effects.items():
            if name in self._unread.get(entry, ()):
                yield Leaf("none")
            elif name not in either:
                yield from leaves
            else:
                off = leaves[0].kind == "none"
                yield from (Leaf("absent", shape=np.shape(value)) for value in either[name]) if off else leaves
                yield Leaf("flag", int(not off))

    def given(self, entry: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """What an entry gives to its kernel behind the times, of all `s`, `p` and `e`."""
        if not (unread := self._unread.get(entry, ())):
            return arguments
        *others, e = arguments
        return *others, e._replace(**dict.fromkeys(unread))

    def handed(self, entry: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """What decides on the types of what an entry gives: that, and of effects that may be on or off what they are when on."""
        given = self.given(entry, arguments)
        if not (either := self._either.get(entry)):
            return given
        *others, e = given
        return *others, e._replace(**{name: Either(values) for name, values in either.items()})

    def body(self, entry: str, kinds: Sequence[str], kernel: str = "") -> str:
        """The text of an entry's instructions. kinds: types of the kernel's arguments behind its times; kernel: its symbol."""
        return "\n".join(self._lines(entry, list(kinds), kernel))

    def _lines(self, entry: str, kinds: list[str], kernel: str) -> Iterator[str]:
        arguments = ["ptr %result", "ptr %raised", *self.entries[entry]]
        yield "%result = alloca i64\n%raised = alloca ptr\nstore i64 0, ptr %result"
        given = iter(kinds)
        for k, leaf in enumerate(self.in_order(entry)):
            if leaf.kind not in ("none", "flag", "absent"):
                yield f"%p{k} = getelementptr i64, ptr %block, i64 {leaf.cell}"
            if leaf.kind == "array":
                strides = [leaf.itemsize * int(np.prod(leaf.shape[i + 1 :])) for i in range(len(leaf.shape))]
                size = int(np.prod(leaf.shape))
                arguments += [
                    f"{next(given)} {value}" for value in ("null", "null", size, leaf.itemsize, f"%p{k}", *leaf.shape, *strides)
                ]
            elif leaf.kind == "record":
                arguments.append(f"{next(given)} %p{k}")
            elif leaf.kind == "flag":
                arguments.append(f"{next(given)} {leaf.cell}")
            elif leaf.kind == "absent":
                zeros = {"ptr": "null", "double": "0.0"}
                some = (next(given) for _ in range(5 + 2 * len(leaf.shape) if leaf.shape else 1))
                arguments += [f"{kind} {zeros.get(kind, '0')}" for kind in some]
            elif leaf.kind == "none":
                kind = next(given)
                arguments.append(f"{kind} {'null' if kind == 'ptr' else 0}")
            else:
                kind, load = next(given), "double" if leaf.kind == "f8" else "i64"
                yield f"%v{k} = load {load}, ptr %p{k}"
                if kind != load:
                    yield f"%w{k} = trunc i64 %v{k} to {kind}"
                arguments.append(f"{kind} %{'v' if kind == load else 'w'}{k}")
        if next(given, None) is not None:
            raise TypeError(f"{entry}: a kernel with more arguments than the block has")
        called = f'@"{kernel}"'
        if not kernel:
            cell = self.addresses_at + list(self.entries).index(entry)
            yield f"%place = getelementptr i64, ptr %block, i64 {cell}\n%called = load ptr, ptr %place"
            called = "%called"
        yield f"%failed = call i32 {called}({', '.join(arguments)})"
        yield "%fine = icmp eq i32 %failed, 0\n%wide = load i64, ptr %result\n%status = trunc i64 %wide to i32"
        yield f"%given = select i1 %fine, i32 %status, i32 {RAISED}\nret i32 %given"

    def wanted(self, name: str, kernel: Any, arguments: tuple[Any, ...]) -> tuple[Any, int, tuple[Any, ...]]:
        """What the machine code of an entry's kernel is made for: the kernel, the number of its times, the arguments behind them."""
        return kernel, len(self.entries[name]), self.handed(name, arguments)

    def entry(self, name: str, kernel: Any, arguments: tuple[Any, ...]) -> Entry:
        """An entry that calls a kernel, compiled for these arguments, behind its times, in this process."""
        address, kinds = machine_code(*self.wanted(name, kernel, arguments))
        return Entry(_function(self.body(name, kinds)), address)

    def take(self, name: str, entry: Entry) -> int:
        """The address of an entry of this layout, which finds its kernel in the block from now on."""
        self.memory.view(np.int64)[self.addresses_at + list(self.entries).index(name)] = entry.kernel
        return entry.function


def joined(ranges: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """Ranges of cells in their order; adjoining ranges are joined."""
    parts: list[tuple[int, int]] = []
    for first, end in sorted(ranges):
        if parts and parts[-1][1] == first:
            parts[-1] = parts[-1][0], end
        else:
            parts.append((first, end))
    return parts


def callable_of(address: int) -> Callable[[float, float, int], int]:
    """An entry for Python."""
    return ENTRY(address)


@lru_cache(maxsize=256)
def _function(body: str) -> int:
    """The address of a function with this body; kept on disk, for nothing in it depends on the process."""
    name = "entry_" + digest_of(f"{llvm.llvm_version_info} {llvm.get_default_triple()}\n{body}")
    folder = private_folder("entries")
    with LOCK:
        engine, added = _engine()
        if name not in added:  # by another thread
            code = None if folder is None else read_kept(folder / f"{name}.o")
            if code is None:
                text = f"define i32 @{name}(double %t, double %h, ptr %block) {{\n{body}\n}}"
                code = machine().emit_object(llvm.parse_assembly(text))
                if folder is not None:
                    write_kept(folder / f"{name}.o", code)
            engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            engine.finalize_object()
            added.add(name)
        return engine.get_function_address(name)


@lru_cache(maxsize=1)
def _engine() -> tuple[Any, set[str]]:
    """The owner of the machine code, as long as the process lives, and the names of the functions in it."""
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine()), set()
