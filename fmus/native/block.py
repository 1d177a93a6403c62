"""One block of memory for all that a component's kernels read and write.

The block consists of cells of eight bytes. First come the time, `u`, `y`, `x` and the counters, what `save` and `restore` of a
component keep, and the parameters of the instance. Behind them lies what the kernels are handed besides: workspace, parameters,
and what was computed of them at initialization. Arrays are laid out by the memory they are views of, so that views of one stay
views of one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

CELL = 8  # bytes
TIME = 0  # the cell that holds the time
DTYPES = ("float64", "int64", "int32", "uint64", "bool")


class Unsupported(Exception):
    """A value or an expression that has no form in the block or in machine code; the text says which."""


class Block:
    """Layout of an initialized component; `cells` grows as values are placed."""

    def __init__(self, component: Any):
        self.component, self.declared = component, component._declared_arguments()
        self.cells = 1
        self._roots: list[tuple[np.ndarray, int]] = []
        self._scalars: dict[Any, tuple[int, Any]] = {}
        self._kept: list[Any] = []  # keys are identities: what they belong to has to stay alive
        self.u = self.place(component.u) // CELL
        self.y = self.place(component.y) // CELL
        self.x = self.place(component.x) // CELL
        self.counts = self.place(component.counts) // CELL
        numbers = [name for name, value in component.parameters.items() if isinstance(value, float)]
        self.parameters = {name: self.cells + k for k, name in enumerate(numbers)}
        self.cells += len(numbers)
        self.saved = self.cells  # number of cells that a saved state holds

    def place(self, array: np.ndarray) -> int:
        """Offset of an array in bytes."""
        root = array
        while isinstance(root.base, np.ndarray):
            root = root.base
        offset = next((at for known, at in self._roots if known is root), None)
        if offset is None:
            offset = CELL * self.cells
            self.cells += max(1, -(-root.nbytes // CELL))
            self._roots.append((root, offset))
        return offset + array.__array_interface__["data"][0] - root.__array_interface__["data"][0]

    def scalar(self, owner: Any, key: Any, value: Any) -> int:
        """Cell of the number `key` of `owner`, the same one whichever function reads it."""
        place = (id(owner), key)
        if place not in self._scalars:
            self._kept.append(owner)
            self._scalars[place] = (self.cells, value)
            self.cells += 1
        return self._scalars[place][0]

    def counterparts(self, other: Any) -> dict[int, Any]:
        """What of another component, of this configuration, corresponds to the owners of the block's values, by identity.

        Raises `Unsupported` where the other one is built up differently.
        """
        pairs: dict[int, Any] = {}

        def pair(own: Any, its: Any) -> None:
            if id(own) in pairs or isinstance(own, bool | int | float | str | type(None)):
                return
            pairs[id(own)] = its
            if type(own) is not type(its) or getattr(own, "shape", 0) != getattr(its, "shape", 0):
                raise Unsupported("another structure")
            if isinstance(own, np.ndarray) and isinstance(own.base, np.ndarray):
                pair(own.base, its.base)
            if isinstance(own, tuple | list):
                if len(own) != len(its):
                    raise Unsupported("another length")
                for mine, theirs in zip(own, its, strict=True):
                    pair(mine, theirs)

        pairs[id(self.component)] = other
        for name, value in vars(self.component).items():
            pair(value, vars(other)[name])
        pair(self.declared, other._declared_arguments())
        return pairs

    def image(self, of: Mapping[int, Any] | None = None) -> np.ndarray:
        """What the block holds at present, (cells,) float64; integers and Booleans in their own form.

        `of`: the counterparts of another component, whose block is given.
        """
        of = of or {}
        component = of.get(id(self.component), self.component)
        cells = np.zeros(self.cells)
        cells[TIME] = component.t
        for name, cell in self.parameters.items():
            cells[cell] = component.parameters[name]
        raw, integers = cells.view(np.uint8), cells.view(np.int64)
        for root, offset in self._roots:
            data = np.frombuffer(of.get(id(root), root).tobytes("A"), np.uint8)
            raw[offset : offset + data.size] = data
        for (owner, key), (cell, value) in self._scalars.items():
            if owner in of:
                its = of[owner]
                value = getattr(its, key) if isinstance(key, str) and its is component else its[key]
            if isinstance(value, bool | np.bool_ | int | np.integer):
                integers[cell] = int(value)
            else:
                cells[cell] = value
        return cells

    # -- a value as an expression over the block ---------------------------------------------------------------------
    def expression(self, value: Any, owner: Any, key: Any, names: dict[str, Any]) -> str:
        """Python text that gives `value`, the item `key` of `owner`; what the text refers to is added to `names`.

        The text uses `_F` and `_I`, the block as float64 and as int64, and `_address`.
        """
        if value is None:
            return "None"
        if isinstance(value, bool | np.bool_):
            return f"(_I[{self.scalar(owner, key, value)}] != 0)"
        if isinstance(value, int | np.integer):
            return f"_I[{self.scalar(owner, key, value)}]"
        if isinstance(value, float | np.floating):
            return f"_F[{self.scalar(owner, key, value)}]"
        if isinstance(value, np.ndarray):
            return self._view(value)
        if isinstance(value, tuple):
            self._kept.append(value)
            items = [self.expression(v, value, k, names) for k, v in enumerate(value)]
            if not hasattr(value, "_fields"):
                return "(" + "".join(item + ", " for item in items) + ")"
            name = f"_T{type(value).__name__}"
            names[name] = type(value)
            return f"{name}({', '.join(items)})"
        raise Unsupported(f"a {type(value).__name__}")

    def _view(self, array: np.ndarray) -> str:
        if array.dtype.name not in DTYPES:
            raise Unsupported(f"an array of {array.dtype}")
        if not (array.flags.c_contiguous or array.flags.f_contiguous):
            raise Unsupported(f"an array whose elements do not follow one another, shape {array.shape}")
        order = "c" if array.flags.c_contiguous else "f"
        shape = str(array.shape[0]) if array.ndim == 1 else str(array.shape)
        return f"_view_{order}(_pointer_{array.dtype.name}(_address + {self.place(array)}), {shape})"
