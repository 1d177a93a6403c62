"""What is to be known of a component, as data: from its declarations, for the command line and for the documentation.

`component_page(name)` gives a `ComponentPage`: plain text, numbers and tuples, nothing of a format of output; `to_json` makes it
plain data. Whoever shows components (`cosimo show`, the pages of the documentation) renders this and reads no declarations.
"""

from __future__ import annotations

import inspect
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from math import isfinite
from textwrap import dedent
from typing import Any

from ...components.catalogue import CATALOGUE, component_class
from ...components.core.component import Component, Effect
from ...components.core.errors import BadInput
from ...components.core.variables import Causality, Variable, gathered
from ..kept import Kept
from ..run.dependence import depends_on
from ..scene.drawing import Drawing, sketch
from ..scene.files import read_file, scene_files
from .studies.full_model import with_required
from .studies.hard_cases import declared


@dataclass(frozen=True)
class Passage:
    """A part of a docstring. kind: "text", "equations" (lines as they stand, without their indentation) or "source"."""

    kind: str
    text: str


@dataclass(frozen=True)
class VariableRow:
    """A declared variable. name: with the effect that it belongs to; an array, of `size` elements, has one row.

    default: None of outputs.  low, high: None where there is no limit.  sources: "preset (provenance)" of the published sets
    that give a parameter the value which is its default.
    """

    name: str
    causality: str
    unit: str
    default: float | int | str | tuple[float, ...] | None
    low: float | None
    high: float | None
    choices: tuple[str, ...]
    size: int
    text: str
    sources: tuple[str, ...]

    @property
    def limits(self) -> str:
        """The values that it takes, as ">= 0, <= 1" or as a list of names."""
        limits = [f"{sign} {value:g}" for sign, value in ((">=", self.low), ("<=", self.high)) if value is not None]
        return ", ".join(self.choices or limits)


@dataclass(frozen=True)
class EffectRow:
    """An effect. text: its docstring.  explicit_only: no study adds it.  variables: names of those that it adds.

    states: how many numbers of state it adds, beside those of the effects that it needs; None where that is not counted, or
    where it can only be with other parameters.
    """

    name: str
    text: str
    needs: tuple[str, ...]
    excludes: tuple[str, ...]
    explicit_only: bool
    variables: tuple[str, ...]
    states: int | None


@dataclass(frozen=True)
class PresetRow:
    """A published set of parameters. provenance: "verbatim", "unconfirmed", "inferred" or "computed"."""

    name: str
    source: str
    provenance: str
    effects: tuple[str, ...]
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class Port:
    """Signals that go to one partner together: a declared port, the other signals of an effect, or "" all others."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class HardCaseRow:
    """A case at the limits of the model. holds: what has to hold there."""

    name: str
    text: str
    holds: tuple[str, ...]


@dataclass(frozen=True)
class ComponentPage:
    """A component. name: as a scene has it.  text: passages of its docstring.  states: numbers of state without effects, or
    None where they are not counted.  scenes: shipped scenes that use it, by name, with their titles."""

    name: str
    title: str
    system: str
    text: tuple[Passage, ...]
    variables: tuple[VariableRow, ...]
    effects: tuple[EffectRow, ...]
    presets: tuple[PresetRow, ...]
    ports: tuple[Port, ...]
    hard_cases: tuple[HardCaseRow, ...]
    scenes: Mapping[str, str]
    states: int | None
    counters: tuple[str, ...]
    step: float
    stop_time: float

    def sketch(self) -> Drawing:
        """A box with the signals that are always there, as SVG."""
        inputs, outputs = (
            [v.name for v in self.variables if v.causality == c.value and "." not in v.name]
            for c in (Causality.INPUT, Causality.OUTPUT)
        )
        return sketch(self.title, self.name.rpartition(":")[2], inputs, outputs)

    def to_json(self) -> dict[str, Any]:
        """Plain data: dictionaries, lists, texts and numbers."""
        return json.loads(json.dumps(asdict(self)))


def component_page(name: str, *, count_states: bool = True) -> ComponentPage:
    """The page of a component of the catalogue, or of "module:Class"; raises `BadInput` with the near names.

    `count_states`: initialize it with each of its effects, in a process without the compiler (a second). Many: `component_pages`.
    """
    return component_pages([name], count_states=count_states)[0]


def component_pages(names: Sequence[str] = tuple(CATALOGUE), *, count_states: bool = True) -> list[ComponentPage]:
    """Pages of several components; all of the catalogue without names."""
    classes = {name: component_class(name, "component") for name in names}
    states = states_of(names) if count_states else {}
    return [_page(name, cls, states.get(name, {})) for name, cls in classes.items()]


def _page(name: str, cls: type[Component], states: Mapping[str, int | None]) -> ComponentPage:
    variables = [(v, v.name) for v in cls.own_variables]
    variables += [(v, f"{e}.{v.name}") for e, effect in cls.effects.items() for v in effect.variables]
    return ComponentPage(
        name,
        cls.title,
        cls.system,
        tuple(passages(inspect.getdoc(cls) or "")),
        tuple(_variable(v, full, cls) for v, full in variables),
        tuple(_effect(e, effect, states.get(e)) for e, effect in cls.effects.items()),
        tuple(PresetRow(n, p.source, p.provenance, p.effects, p.parameters) for n, p in cls.presets.items()),
        tuple(_ports({full: v.causality for v, full in variables}, cls)),
        tuple(HardCaseRow(c.name, c.text, _claims(c.holds)) for c in declared().get(name, ())),
        {scene: title for scene, (title, used) in _scenes().items() if name in used},
        states.get(""),
        cls.counters,
        cls.default_step,
        cls.default_stop,
    )


def _variable(variable: Variable, name: str, cls: type[Component]) -> VariableRow:
    output = variable.causality is Causality.OUTPUT
    sources = [
        f"{preset} ({p.provenance})"
        for preset, p in cls.presets.items()
        if name in p.parameters and not variable.size and p.parameters[name] == variable.start
    ]
    low, high = (value if isfinite(value) else None for value in (variable.low, variable.high))
    return VariableRow(
        name,
        variable.causality.value,
        variable.unit,
        None if output else variable.start,
        low,
        high,
        variable.choices,
        variable.size,
        variable.text,
        tuple(sources),
    )


def _effect(name: str, effect: type[Effect], states: int | None) -> EffectRow:
    return EffectRow(
        name,
        inspect.getdoc(effect) or "",
        effect.requires,
        effect.excludes,
        effect.explicit_only,
        tuple(f"{name}.{v.name}" for v in effect.variables),
        states,
    )


def _ports(signals: Mapping[str, Causality], cls: type[Component]) -> Iterator[Port]:
    ends = [name for name, causality in signals.items() if causality is not Causality.PARAMETER]
    for port, members in gathered(ends, cls.ports, cls.port_members).items():
        inputs, outputs = (tuple(n for n in members.values() if signals[n] is c) for c in (Causality.INPUT, Causality.OUTPUT))
        yield Port(port, inputs, outputs)


def _claims(holds: Any) -> tuple[str, ...]:
    return tuple(claim.label for claim in holds) if isinstance(holds, Sequence) else (holds.label,)


def passages(docstring: str) -> Iterator[Passage]:
    """Parts of a docstring that has been cleaned of its indentation: paragraphs, and equations, which are indented blocks."""
    for block in docstring.split("\n\n"):
        lines = block.splitlines()
        if lines and all(line.startswith("    ") for line in lines):
            yield Passage("equations", dedent(block))
            continue
        source = next((k for k, line in enumerate(lines) if line.startswith(("Source:", "Sources:"))), len(lines))
        for kind, some in (("text", lines[:source]), ("source", lines[source:])):
            if some:
                yield Passage(kind, " ".join(some) if kind == "text" else " ".join(some).partition(":")[2].strip())


@cache
def _scenes() -> dict[str, tuple[str, frozenset[str]]]:
    """Shipped scene -> its title, and the components of its units and of the scenes inside it."""
    data = {name: read_file(path)[0] for name, path in scene_files().items()}

    def used(name: str) -> frozenset[str]:
        units = data[name]["units"].values()
        inside = [used(unit["scene"]) for unit in units if unit.get("scene") in data]
        return frozenset(unit["component"] for unit in units if "component" in unit).union(*inside)

    return {name: (str(scene.get("title", "")), used(name)) for name, scene in data.items()}


def states_of(names: Sequence[str]) -> dict[str, dict[str, int | None]]:
    """Component -> {"": numbers of state without effects, effect: how many it adds to those of the effects that it needs}.

    Counted in a process without the compiler, which would take seconds over each combination, and kept by the component's code.
    None: it starts with other parameters only.
    """
    kept = {name: Kept("states", depends_on("states", component_class(name, "component"))) for name in names}
    counts = {name: one.read() for name, one in kept.items()}
    if missing := [name for name, count in counts.items() if count is None]:
        counts |= _counted_apart(missing)
        for name in missing:
            kept[name].write(counts[name])
    return counts


def _counted_apart(names: Sequence[str]) -> dict[str, dict[str, int | None]]:
    command = [sys.executable, "-c", f"from {__name__} import count_states; count_states()"]
    parent = os.pathsep.join(path or os.curdir for path in sys.path)
    done = subprocess.run(
        command,
        input=json.dumps(list(names)),
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": parent},
    )
    if done.returncode:
        reason = done.stderr.strip().rpartition("\n")[2]
        raise BadInput("component", ", ".join(names), "components that can be initialized", reason)
    return json.loads(done.stdout.rpartition("\n")[2])


def count_states() -> None:
    """Names of components as JSON on standard input; counts of their states on standard output. For `states_of`."""
    counts = {}
    for name in json.load(sys.stdin):
        cls = component_class(name, "component")
        bare = _states(cls, ())
        counts[name] = {"": bare}
        for effect in cls.effects:
            needed = with_required(cls, effect)
            more, without = _states(cls, needed), _states(cls, [e for e in needed if e != effect])
            counts[name][effect] = None if more is None or without is None else more - without
    print("\n" + json.dumps(counts), end="")


def _states(cls: type[Component], effects: Sequence[str]) -> int | None:
    try:
        component = cls(effects)
        component.initialize(0.0)
    except Exception:  # of parameters that do not go with the effects, in plain Python: any
        return None
    return int(component.x.size)
