"""The variables of a native FMU: the same names and value references as those of the pythonfmu FMU, with what is fixed at build.

Effects are constants, and so are structural parameters. What belongs to an effect that is off has no
variable; its value references stay unused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ...components.core.contract import KernelComponent
from ..interface import Scalar, interface
from .instance import Places, image_of, reasons_of

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
    places: dict[str, tuple[int, float]] = {}
    n = len(component.inputs)
    for row, (form, factor) in enumerate((("{}", 1.0), ("der({})", 1.0), ("der({},2)", 0.5))):
        places |= {form.format(name): (at.u + row * n + i, factor) for i, name in enumerate(component.inputs)}
    places |= {name: (at.y + i, 1.0) for i, name in enumerate(component.outputs)}
    component_class: Any = type(component)
    return _with_sizes([_variable(s, component, at, places) for s in interface(component_class)])


def _variable(scalar: Scalar, component: KernelComponent, at: Places, places: dict[str, tuple[int, float]]) -> NativeVariable:
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
    if name not in places:
        return NativeVariable(scalar, "ABSENT")
    cell, factor = places[name]
    if scalar.causality == "output":
        return NativeVariable(scalar, "OUTPUT", cell)
    if scalar.order:
        return NativeVariable(scalar, "DERIVATIVE", cell, factor)
    return NativeVariable(replace(scalar, start=float(component[name])), "INPUT", cell)


def _with_sizes(variables: list[NativeVariable]) -> tuple[NativeVariable, ...]:
    """Elements `name[1]`, `name[2]` ... that follow one another are one array in FMI 3."""
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


def tables(component: KernelComponent, at: Places, variables: tuple[NativeVariable, ...], token: str) -> str:
    """model.c: what the runtime reads."""
    rows = [_row(v.scalar.name, TYPES[v.scalar.type], v) for v in variables]
    rows.append('{"time", REAL, CLOCK_TIME, 1, 0, 1.0, 0.0, 1.0, -INFINITY, INFINITY, 0}')
    reasons = [
        f"{{{status}, {quoted(text)}, {{{', '.join(map(str, cells)) or '0'}}}}}" for status, text, cells in reasons_of(component)
    ]
    cells = [f"{value:#x}u" for value in image_of(component).view("uint64").tolist()]
    numbers = {
        "variable_count": len(variables),
        "reason_count": len(reasons),
        "cells": at.cells,
        "saved": at.saved,
        "u": at.u,
        "u_size": component.u.size,
        "parameters": at.first_parameter,
        "parameters_size": at.saved - at.first_parameter,
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
            "const uint64_t model_image[] = {",
            *(", ".join(cells[k : k + 8]) + "," for k in range(0, len(cells), 8)),
            "};",
            f"const char model_token[] = {quoted(token)};",
            "const uint32_t " + ", ".join(f"model_{name} = {value}" for name, value in numbers.items()) + ";",
            "",
        ]
    )


def _row(name: str, kind: str, variable: NativeVariable) -> str:
    scalar, role = variable.scalar, variable.role
    text = quoted(str(scalar.start)) if role == "CONSTANT" and kind == "STRING" else "0"
    value = number(float(scalar.start)) if role in ("CONSTANT", "INPUT", "DERIVATIVE") and kind != "STRING" else "0.0"
    name = quoted(name) if role != "ABSENT" else "0"
    return (
        f"{{{name}, {kind}, {role}, {variable.size}, {variable.cell}, {number(variable.factor)}, "
        f"{value}, {number(scalar.nominal)}, {number(float(scalar.low))}, {number(float(scalar.high))}, {text}}}"
    )


def number(value: float) -> str:
    """A real number in C, every bit of it."""
    return f"{'-' if value < 0 else ''}INFINITY" if math.isinf(value) else value.hex()


def quoted(text: str) -> str:
    """A string literal of C."""
    return '"' + "".join(chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode()) + '"'
