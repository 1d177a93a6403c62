"""FMUs written in C: models that do what the Modelica Association's Reference FMUs do, compiled for FMI 2.0 and 3.0.

The headers of FMI come with FMPy, so that the compiler holds the functions against the standard's declarations.
"""

from __future__ import annotations

import atexit
import shutil
import zipfile
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp
from typing import NamedTuple

import fmpy
from cosimo.components.core.errors import StepFailed
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.units import describe, open_unit
from cosimo.tests.c_compiler import shared_library

SOURCES = Path(__file__).with_name("native")
HEADERS = Path(fmpy.__file__).parent / "c-code"
FMI2_TYPES = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration"}
STATE = {
    2: 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"',
    3: 'canGetAndSetFMUState="true" canSerializeFMUState="true"',
}
EVENTS = 'hasEventMode="true" mightReturnEarlyFromDoStep="true"'
SMALL = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


class V(NamedTuple):
    """A variable: its place among the model's, and its attributes as XML has them."""

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    start: str | None = None
    more: str = ""
    sizes: tuple[int, ...] = ()  # value references of an array's sizes
    depends: tuple[int, ...] = ()  # of an output: value references of what it depends on at once


TIME = V("time", 0, "Float64", "independent", "continuous")


def _both(name: str, reference: int, type_: str, start: str, more: str = "") -> list[V]:
    return [
        V(f"{name}_in", reference, type_, "input", "discrete", start, more),
        V(f"{name}_out", reference + 1, type_, "output", "discrete", None, more, (), (reference,)),
    ]


MODELS: dict[str, list[V]] = {
    "bouncing_ball": [
        V("h", 1, "Float64", "output", "continuous", "1", 'unit="m"'),
        V("v", 3, "Float64", "output", "continuous", "0", 'unit="m/s"'),
        V("g", 5, "Float64", "parameter", "fixed", "-9.81"),
        V("e", 6, "Float64", "parameter", "tunable", "0.7", 'min="0.5" max="1"'),
    ],
    "dahlquist": [V("x", 1, "Float64", "output", "continuous", "1"), V("k", 3, "Float64", "parameter", "fixed", "1")],
    "feedthrough": [
        V("Float64_fixed_parameter", 5, "Float64", "parameter", "fixed", "0"),
        V("Float64_tunable_parameter", 6, "Float64", "parameter", "tunable", "0"),
        V("Float64_continuous_input", 7, "Float64", "input", "continuous", "0", 'unit="m"'),
        V("Float64_continuous_output", 8, "Float64", "output", "continuous", None, 'declaredType="Length"', (), (7,)),
        V("Float64_discrete_input", 9, "Float64", "input", "discrete", "0"),
        V("Float64_discrete_output", 10, "Float64", "output", "discrete", None, "", (), (9,)),
        V("Float32_continuous_input", 1, "Float32", "input", "continuous", "0"),
        V("Float32_continuous_output", 2, "Float32", "output", "continuous", None, "", (), (1,)),
        *(v for k, name in enumerate(SMALL) for v in _both(name, 11 + 2 * k, name, "0")),
        *_both("Boolean", 27, "Boolean", "false"),
        *_both("String", 29, "String", "Set me!"),
        *_both("Binary", 31, "Binary", "666f6f"),
        *_both("Enumeration", 33, "Enumeration", "1", 'declaredType="Option"'),
    ],
    "integrator": [
        V("u", 1, "Float64", "input", "continuous", "0"),
        V("x", 2, "Float64", "output", "continuous"),
        V("z", 3, "Float64", "output", "continuous"),
    ],
    "resource": [V("y", 1, "Int32", "output", "discrete")],
    "stair": [V("counter", 1, "Int32", "output", "discrete")],
    "van_der_pol": [
        V("x0", 1, "Float64", "output", "continuous", "2"),
        V("x1", 3, "Float64", "output", "continuous", "0"),
        V("mu", 5, "Float64", "parameter", "fixed", "1"),
    ],
    "state_space": [
        *(V(name, k, "UInt64", "structuralParameter", "fixed", "3") for k, name in enumerate("mnr", 1)),
        V("A", 4, "Float64", "parameter", "fixed", "1 0 0 0 1 0 0 0 1", "", (2, 2)),
        V("B", 5, "Float64", "parameter", "fixed", "1 0 0 0 1 0 0 0 1", "", (2, 1)),
        V("C", 6, "Float64", "parameter", "fixed", "1 0 0 0 1 0 0 0 1", "", (3, 2)),
        V("D", 7, "Float64", "parameter", "fixed", "1 0 0 0 1 0 0 0 1", "", (3, 1)),
        V("x0", 8, "Float64", "parameter", "fixed", "0", "", (2,)),
        V("u", 9, "Float64", "input", "continuous", "1 2 3", "", (1,)),
        V("y", 10, "Float64", "output", "continuous", None, "", (3,), (9,)),
    ],
    "resetting": [
        *(V(n, k, "Float64", "parameter", "fixed", "1") for k, n in enumerate(("early", "late", "never", "limited"), 1)),
        V("sum", 5, "Float64", "output", "continuous"),
        V("whole", 6, "Int32", "parameter", "fixed", "1"),
        V("choice", 7, "Boolean", "parameter", "fixed", "false"),
        V("text", 8, "String", "parameter", "fixed", "start"),
    ],
    "told": [
        V("now", 11, "Float64", "output", "continuous"),
        *(V(n, k, "Float64", "output", "discrete") for k, n in enumerate(("start", "stop", "tolerance", "length", "sensor"), 1)),
        V("known_from", 6, "Float64", "parameter", "fixed", "-1e9"),
        V("longest", 7, "Float64", "parameter", "fixed", "1e9"),
        *(V(n, k, "Int32", "parameter", "fixed", "0") for k, n in enumerate(("chatty", "rounding", "writes"), 8)),
        V("third", 12, "Float64", "output", "discrete"),
        V("strict", 13, "Int32", "parameter", "fixed", "0"),
    ],
    "moody": [
        V("now", 6, "Float64", "output", "continuous"),
        V("tolerance", 7, "Float64", "output", "discrete"),
        *(
            V(n, k, "Float64", "parameter", "fixed", "1e9" if k < 4 else "0")
            for k, n in enumerate(("discard_at", "end_at", "early_at", "pause"), 1)
        ),
        V("exit_at", 8, "Float64", "parameter", "fixed", "1e9"),
        V("words", 9, "String", "output", "discrete"),
        V("mischief", 10, "Int32", "parameter", "fixed", "0"),
        V("restless", 5, "Boolean", "parameter", "fixed", "false"),
    ],
}
OPTIONS = {"one": 1, "two": 2, "far": 7}  # members of the enumeration
ITEMS = "".join(f'<Item name="{n}" value="{v}"/>' for n, v in OPTIONS.items())
UNITS = (
    '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit><Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit></UnitDefinitions>'
)


def description(model: str, fmi: int, flags: str) -> str:
    """The XML of a model; `flags` are attributes of its co-simulation interface."""
    return (_fmi2 if fmi == 2 else _fmi3)(model, flags)


def _attributes(v: V, start: bool = True) -> str:
    value = f' start="{v.start}"' if v.start is not None and start else ""
    return f"{value} {v.more}"


def _initial(v: V) -> str:
    return ' initial="exact"' if v.causality == "output" and v.start is not None else ""


def _fmi2(model: str, flags: str) -> str:
    variables = [v for v in MODELS[model] if v.type in FMI2_TYPES and v.causality != "independent"]
    index = {(v.reference, v.type): k for k, v in enumerate(variables, 1)}
    rows = "".join(
        f'<ScalarVariable name="{v.name}" valueReference="{v.reference}" causality="{v.causality}" variability="{v.variability}"'
        f"{_initial(v)}><{FMI2_TYPES[v.type]}{_attributes(v)}/></ScalarVariable>"
        for v in variables
    )
    unknowns = [
        f'<Unknown index="{k}" dependencies="{" ".join(str(index[r, v.type]) for r in v.depends)}"/>'
        for k, v in enumerate(variables, 1)
        if v.causality == "output"
    ]
    calculated = [u for u, v in zip(unknowns, (v for v in variables if v.causality == "output"), strict=True) if v.start is None]
    initial = f"<InitialUnknowns>{''.join(calculated)}</InitialUnknowns>" if calculated else ""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{{native}}">'
        f'<CoSimulation modelIdentifier="{model}" {flags}/>{UNITS}<TypeDefinitions>'
        '<SimpleType name="Length"><Real unit="m" nominal="5"/></SimpleType>'
        f'<SimpleType name="Option"><Enumeration>{ITEMS}</Enumeration></SimpleType></TypeDefinitions>'
        f"<ModelVariables>{rows}</ModelVariables><ModelStructure><Outputs>{''.join(unknowns)}</Outputs>{initial}"
        "</ModelStructure></fmiModelDescription>"
    )


def _fmi3(model: str, flags: str) -> str:
    variables = [TIME, *MODELS[model]]
    rows = ""
    for v in variables:
        inside = f'<Start value="{v.start}"/>' if v.type in ("String", "Binary") and v.start is not None else ""
        sizes = "".join(f'<Dimension valueReference="{r}"/>' for r in v.sizes)
        rows += (
            f'<{v.type} name="{v.name}" valueReference="{v.reference}" causality="{v.causality}" '
            f'variability="{v.variability}"{_initial(v)}{_attributes(v, not inside)}>{inside}{sizes}</{v.type}>'
        )
    outputs = [v for v in variables if v.causality == "output"]
    unknown = '<{} valueReference="{}" dependencies="{}"/>'
    structure = "".join(unknown.format("Output", v.reference, " ".join(map(str, v.depends))) for v in outputs)
    structure += "".join(
        unknown.format("InitialUnknown", v.reference, " ".join(map(str, v.depends))) for v in outputs if v.start is None
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="3.0" modelName="{model}" '
        f'instantiationToken="{{native}}"><CoSimulation modelIdentifier="{model}" {flags}/>{UNITS}<TypeDefinitions>'
        '<Float64Type name="Length" unit="m" nominal="5"/>'
        f'<EnumerationType name="Option">{ITEMS}</EnumerationType></TypeDefinitions>'
        f"<ModelVariables>{rows}</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


@lru_cache
def _folder() -> Path:
    path = Path(mkdtemp(prefix="native-fmus-"))
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


@lru_cache
def _library(model: str, fmi: int) -> Path:
    """The compiled library; the test is skipped where there is no compiler."""
    sources = [SOURCES / f"fmi{fmi}.c", SOURCES / f"absent{fmi}.c"]
    flags = ["-O1", f'-DMODEL="{model}.h"', f"-I{SOURCES}", f"-I{HEADERS}"]
    return shared_library(_folder() / f"{model}{fmi}.so", *flags, *sources, "-lm")


@lru_cache
def native_fmu(model: str, fmi: int, flags: str = "", *changes: tuple[str, str]) -> str:
    """Path of an FMU of a model. `changes`: texts in its description, and what to write instead."""
    flags = f'canHandleVariableCommunicationStepSize="true" {flags}' if "canHandle" not in flags else flags
    path = _folder() / f"{model}{fmi}-{abs(hash((flags, changes)))}.fmu"
    text, platform = description(model, fmi, flags), fmpy.platform if fmi == 2 else fmpy.platform_tuple
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("modelDescription.xml", text)
        file.write(_library(model, fmi), f"binaries/{platform}/{model}.so")
        file.writestr("resources/y.txt", "a")
    return str(path)


def started(
    model: str, fmi: int, flags: str = "", inputs: tuple[str, ...] = (), outputs: tuple[str, ...] | None = None, **parameters
):
    """A unit of a native FMU, initialized at the start values of its inputs; by default all outputs but texts are read."""
    settings = UnitSettings(fmu=native_fmu(model, fmi, flags), parameters=parameters)
    interface = describe("f", settings)
    numbers = tuple(n for n, s in interface.outputs.items() if not s.is_text)
    unit = open_unit("f", settings, in_process=False)
    unit.wire(inputs, numbers if outputs is None else outputs)
    try:
        unit.initialize(0.0, [interface.inputs[n].start for n in inputs])
        unit.start()
    except StepFailed:
        unit.close()
        raise
    return unit
