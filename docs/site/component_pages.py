"""A page for each component, from its declarations: signals, equations, variables, effects, sources, accuracy, hard cases."""

from __future__ import annotations

import inspect
import math
from collections.abc import Sequence
from typing import Any

import equations
import machines
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.component import Component
from cosimo.components.core.events import EventComponent
from cosimo.components.core.high_order import SmoothComponent
from cosimo.components.core.integrators import OdeComponent
from cosimo.components.core.sampled import SampledComponent
from cosimo.components.core.stateless import StatelessComponent
from cosimo.orchestrator.harness.component_page import ComponentPage, Passage, VariableRow, component_pages
from cosimo.orchestrator.systems import SYSTEMS
from prose import code, docstring, formula, joined, plain, table, verbatim
from sketch import sketch

METHODS = (  # the first class that a component is one of
    (StatelessComponent, "No state: outputs are functions of inputs and time, and nothing is integrated."),
    (SampledComponent, "Sampled: its state changes at whole multiples of its period only."),
    (EventComponent, "Runge-Kutta of fourth order with a fixed internal step; changes of mode are located within the step."),
    (SmoothComponent, "Runge-Kutta of fourth order with a fixed internal step, or of eighth order with the effect `high_order`."),
    (OdeComponent, "Runge-Kutta of fourth order with a fixed internal step."),
    (Component, "An integration scheme of its own; the text above and the parameters below describe it."),
)
NUMERICAL = ("substep", "tolerance", "element", "method", "spectral_radius", "period", "cells", "quadrature", "interpolation")


def pages() -> dict[str, str]:
    """File name -> Markdown, of all components and of their index."""
    made = {page.name: page for page in component_pages()}
    return {"index": _index(list(made.values())), **{name: _page(page) for name, page in made.items()}}


def _index(made: Sequence[ComponentPage]) -> str:
    """All components, by system; those without a system of their own in front."""
    rows = []
    for name, title in [("", "Used by several systems"), *((s.name, s.title) for s in SYSTEMS.values())]:
        of_system = [p for p in made if (p.system == name if name else p.system not in SYSTEMS)]
        head = f"## [{title}](../../systems/{name}.md)" if name else f"## {title}"
        listed = [
            (f"[`{p.name}`]({p.name}.md)", plain(p.title), "" if p.states is None else p.states, len(p.effects))
            for p in of_system
        ]
        rows += [head, table(("component", "what it is", "states without effects", "effects"), listed)] if of_system else []
    toctree = "\n".join(["```{toctree}", ":hidden:", "", *sorted(CATALOGUE), "```"])
    text = (
        f"{len(made)} components, each an FMU, a class in Python and a unit of a scene. Their pages are written from the "
        "declarations in the source, like `cosimo show NAME`."
    )
    return joined("# Components", text, *rows, toctree)


def _page(page: ComponentPage) -> str:
    cls = component_class(page.name)
    symbols = equations.symbols_of(" ".join(passage.text for passage in page.text if passage.kind == "equations"))
    system = SYSTEMS.get(page.system)
    place = cls.__module__.removeprefix("cosimo.").replace(".", "/") + ".py"
    used = f"system [{system.title}](../../systems/{page.system}.md)." if system else "used by several systems."
    units = {v.name: v.unit for v in page.variables}
    drawing = sketch(page.name, [(p.name, p.inputs, p.outputs) for p in page.ports], units)
    machine = machines.of_component(page.name, "machine")
    return joined(
        f"# {page.name}: {page.title}",
        f"`{place}`, {used}",
        f'```{{raw}} html\n<div class="sketch">{machine}</div>\n```' if machine else "",
        "## Equations",
        *(_passage(passage, symbols) for passage in page.text),
        _background(cls, symbols),
        "## Signals",
        f'```{{raw}} html\n<div class="sketch">{drawing}</div>\n```',
        "Inputs on the left, outputs on the right, with their units; those below a name in italics are that effect's or port's.",
        "## Parameters",
        _variables(page, "parameter"),
        _section("## Inputs", _variables(page, "input")),
        _section("## Outputs", _variables(page, "output")),
        _section("## Effects", _effects(page)),
        _section("## Published sets and their provenance", _presets(page)),
        "## Accuracy",
        _accuracy(page, cls),
        _section("## Hard cases", _hard_cases(page)),
        _section(
            "## Scenes that use it",
            table(
                ("scene", "what it shows"),
                [(f"[`{name}`](../scenes/{name}.md)", plain(title)) for name, title in page.scenes.items()],
            ),
        ),
        "## Use it",
        _use(page),
    )


def _section(heading: str, body: str) -> str:
    return joined(heading, body).rstrip() if body else ""


def _passage(passage: Passage, symbols: set[str]) -> str:
    if passage.kind == "equations":
        return formula(passage.text)
    return ("Source: " + plain(passage.text)) if passage.kind == "source" else plain(passage.text, symbols)


def _background(cls: type[Component], symbols: set[str]) -> str:
    """What the module says, behind its first line."""
    text = inspect.getdoc(inspect.getmodule(cls)) or ""
    rest = text.partition("\n\n")[2]
    return _section("### Model and its limits", docstring(rest, symbols)) if rest else ""


def _variables(page: ComponentPage, causality: str) -> str:
    rows = [v for v in page.variables if v.causality == causality]
    if causality == "output":
        return table(("name", "unit", "meaning"), [(_name(v), code(v.unit), plain(v.text)) for v in rows])
    cells = [(_name(v), code(v.unit), _default(v), code(v.limits), plain(v.text), plain("; ".join(v.sources))) for v in rows]
    wide = any(cell[-1] for cell in cells)
    header = ("name", "unit", "default", "limits", "meaning", "default is that of")[: 6 if wide else 5]
    return table(header, [cell[: len(header)] for cell in cells])


def _name(variable: VariableRow) -> str:
    return code(variable.name + (f"[1..{variable.size}]" if variable.size else ""))


def _default(variable: VariableRow) -> str:
    value = variable.default
    if isinstance(value, tuple):
        return ", ".join(map(_number, value[:6])) + (", ..." if len(value) > 6 else "")
    return _number(value)


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _effects(page: ComponentPage) -> str:
    """What each adds. An effect that is off is absent."""
    rows = [
        (
            code(e.name),
            plain(e.text, set()),
            "" if e.states is None else e.states,
            len(e.variables),
            ", ".join(map(code, e.needs)),
            ", ".join(map(code, e.excludes)),
            "yes" if e.explicit_only else "",
        )
        for e in page.effects
    ]
    return table(("effect", "what it is", "states", "variables", "needs", "excludes", "only by name"), rows)


def _presets(page: ComponentPage) -> str:
    return table(
        ("preset", "provenance", "source", "effects"),
        [(code(p.name), p.provenance, plain(p.source), ", ".join(map(code, p.effects))) for p in page.presets],
    )


def _accuracy(page: ComponentPage, cls: type[Component]) -> str:
    method = next(text for base, text in METHODS if issubclass(cls, base))
    rows = [
        (code(v.name), _default(v), code(v.unit), plain(v.text))
        for v in page.variables
        if v.causality == "parameter" and v.name.rpartition(".")[2] in NUMERICAL
    ]
    work = f"It counts {', '.join(name.replace('_', ' ') for name in page.counters)}." if page.counters else ""
    measure = (
        ""
        if issubclass(cls, StatelessComponent | SampledComponent)
        else f"`cosimo accuracy {page.name} -o out` measures its error over its internal step, beside SciPy's methods where "
        "these can solve the same equations."
    )
    return joined(method, table(("parameter", "default", "unit", "meaning"), rows), _stable_step(cls), work, measure).rstrip()


def _stable_step(cls: type[Component]) -> str:
    """The largest stable internal step with the defaults; nothing of a component that has no limit or other needs."""
    component = cls()
    try:
        component.initialize(0.0)
        step = component.stable_step()
    except Exception:  # defaults that make no model: presets or a partner do
        return ""
    return f"Largest stable internal step with the defaults: {step:.3g} s." if math.isfinite(step) else ""


def _hard_cases(page: ComponentPage) -> str:
    rows = [(plain(c.name), plain(c.text, set()), plain("; ".join(c.holds))) for c in page.hard_cases]
    if not rows:
        return ""
    command = f"`cosimo stability --hard-cases {page.name} -o out` runs them and gives the distance of each claim from its limit."
    return joined(table(("case", "what is hard", "what has to hold"), rows), command)


def _use(page: ComponentPage) -> str:
    return verbatim(f"cosimo show {page.name}             # the same as text\ncosimo build {page.name} -o fmus    # an FMU")
