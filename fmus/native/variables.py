"""The variables of a native FMU: the same names and value references as those of the pythonfmu FMU, with what is fixed at build.

Effects are constants, and so are structural parameters. What belongs to an effect that is off has no
variable; its value references stay unused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...components.core.contract import KernelComponent
from ..interface import Scalar, interface
from .instance import Model, Places

TYPES = {"Real": "REAL", "Integer": "INTEGER", "Boolean": "BOOLEAN", "String": "STRING"}


@dataclass(frozen=True)
class NativeVariable:
    """One variable; `cell` and `factor` say where an input or an output lies in the block."""

    scalar: Scalar
    role: str
    cell: int = 0
    factor: float = 1.0
    size: int = 1  # elements of the array that begins here; 0 inside of one


def native_variables(component: KernelComponent, at: Places) -> tuple[NativeVariable, ...]:
    """All variables in the order of their value references."""
    component_class: Any = type(component)
    return with_sizes([component_variable(s, component, at) for s in interface(component_class)])


def component_variable(scalar: Scalar, component: KernelComponent, at: Places) -> NativeVariable:
    """A variable of a component's FMU as it is in a native one."""
    name = scalar.name
    if scalar.causality == "parameter":
        if name.startswith("effects."):
            value: Any = name.partition(".")[2] in component.on
        elif name in component.parameters:
            value = component.parameters[name]
        else:
            return NativeVariable(scalar, "ABSENT")
        if name in at.settable:
            return NativeVariable(replace(scalar, start=value), "PARAMETER", at.settable[name])
        return NativeVariable(replace(scalar, causality="local", start=value, text=scalar.text + "; fixed at build"), "CONSTANT")
    if name not in at.variables:
        return NativeVariable(scalar, "ABSENT")
    cell, factor = at.variables[name]
    if scalar.causality == "output":
        return NativeVariable(scalar, "OUTPUT", cell)
    if scalar.order:
        return NativeVariable(scalar, "DERIVATIVE", cell, factor)
    return NativeVariable(replace(scalar, start=float(component[name])), "INPUT", cell)


def with_sizes(variables: list[NativeVariable]) -> tuple[NativeVariable, ...]:
    """The variables with their sizes: elements `name[1]`, `name[2]` ... that follow one another are one array in FMI 3."""
    merged: list[NativeVariable] = []
    first = 0
    for k, variable in enumerate(variables):
        base, bracket, _ = variable.scalar.name.partition("[")
        of_array = bool(bracket) and variable.scalar.name.endswith("]")
        before = variables[first]
        if k and of_array and before.role == variable.role and before.scalar.name == f"{base}[1]":
            merged[first] = replace(merged[first], size=merged[first].size + 1)
            merged.append(replace(variable, size=0))
        else:
            first = k
            merged.append(variable)
    return tuple(merged)


def tables(model: Model, variables: tuple[NativeVariable, ...], token: str) -> str:
    """model.c: what the runtime reads."""
    rows = [_row(v.scalar.name, TYPES[v.scalar.type], v) for v in variables]
    rows.append('{"time", REAL, CLOCK_TIME, 1, 0, 1.0, 0.0, 1.0, -INFINITY, INFINITY, 0, 0}')
    reasons = [f"{{{status}, {quoted(text)}, {{{', '.join(map(str, cells)) or '0'}}}}}" for status, text, cells in model.reasons]
    runs, cells = _runs(model.image)
    numbers = {
        "variable_count": len(variables),
        "reason_count": len(reasons),
        "cells": model.image.size,
        "run_count": len(runs),
        "saved": model.saved,
        "parameters": model.parameters[0],
        "parameters_size": model.parameters[1] - model.parameters[0],
        "given_count": len(model.given),
        "row": model.row,
    }
    return "\n".join(
        [
            '#include "native.h"',
            "#include <math.h>",
            "const Variable model_variables[] = {",
            ",\n".join(rows),
            "};",
            "const Reason model_reasons[] = {",
            ",\n".join(reasons),
            "};",
            "const Run model_runs[] = {" + ", ".join(f"{{{first}, {count}}}" for first, count in runs or [(0, 0)]) + "};",
            "const uint64_t model_values[] = {",
            *(", ".join(cells[k : k + 8]) + "," for k in range(0, len(cells), 8)),
            "};",
            "const uint32_t model_given[][2] = {" + ", ".join(f"{{{first}, {last}}}" for first, last in model.given) + "};",
            f"const char model_token[] = {quoted(token)};",
            f"const int32_t model_untouched = {model.untouched};",
            f"const bool model_whole = {int(model.whole)};",
            "const uint32_t " + ", ".join(f"model_{name} = {value}" for name, value in numbers.items()) + ";",
            model.code,
            "",
        ]
    )


def _runs(image: np.ndarray) -> tuple[list[tuple[int, int]], list[str]]:
    """What of a block is not zero: first cells and lengths of its runs, and the numbers of all runs."""
    filled = np.flatnonzero(image)
    starts = np.flatnonzero(np.diff(filled, prepend=-2) > 1)
    lengths = np.diff(starts, append=filled.size)
    values = [f"{value:#x}u" for value in image[filled].tolist()]
    return list(zip(filled[starts].tolist(), lengths.tolist(), strict=True)), values or ["0"]


def _row(name: str, kind: str, variable: NativeVariable) -> str:
    scalar, role = variable.scalar, variable.role
    text = quoted(str(scalar.start)) if role == "CONSTANT" and kind == "STRING" else "0"
    value = number(float(scalar.start)) if role in ("CONSTANT", "INPUT", "DERIVATIVE") and kind != "STRING" else "0.0"
    name = quoted(name) if role != "ABSENT" else "0"
    return (
        f"{{{name}, {kind}, {role}, {variable.size}, {variable.cell}, {number(variable.factor)}, "
        f"{value}, {number(scalar.nominal)}, {number(float(scalar.low))}, {number(float(scalar.high))}, {text}, {int(scalar.tunable)}}}"
    )


def number(value: float) -> str:
    """A real number in C, every bit of it."""
    return f"{'-' if value < 0 else ''}INFINITY" if math.isinf(value) else value.hex()


def quoted(text: str) -> str:
    """A string literal of C."""
    return '"' + "".join(chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode()) + '"'
