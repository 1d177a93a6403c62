"""The catalogue of hard cases: what every component has to stand, run, and how far each claim is from its limit."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....components.catalogue import CATALOGUE, component_class
from ....components.core.component import Component
from ....components.core.errors import BadInput, StepFailed, pick
from ....components.core.hard_cases import Claim, Finite, HardCase, InputSignal, Like, Refused, seen
from ...output import write_table
from ..journal import once


@dataclass(frozen=True)
class Verdict:
    """One claim of one case.

    case, text: its name, and what is hard in it.  reached, limit: how much of what was allowed; NaN for a refusal.
    margin: limit over reached, infinite where nothing was reached; of a refusal the factor between what is refused and what is
    accepted, NaN where no number says it.
    message: the message of a refusal or of what went wrong.
    """

    component: str
    case: str
    text: str
    claim: str
    reached: float
    limit: float
    margin: float
    holds: bool
    message: str = ""


@dataclass(frozen=True)
class HardCases:
    """Verdicts, in the order of the catalogue."""

    verdicts: tuple[Verdict, ...]

    @property
    def failed(self) -> tuple[Verdict, ...]:
        """What does not hold."""
        return tuple(v for v in self.verdicts if not v.holds)

    @property
    def summary(self) -> str:
        """How many there are, and how many do not hold."""
        cases = {(v.component, v.case) for v in self.verdicts}
        components = {v.component for v in self.verdicts}
        failed = f"{len(self.failed)} of them do not hold" if self.failed else "all hold"
        return f"{len(self.verdicts)} claims of {len(cases)} hard cases of {len(components)} components: {failed}"

    def save(self, directory: str | Path) -> Path:
        """Write stability.csv: one row for each claim."""
        header = ["component", "case", "claim", "reached", "limit", "margin, 1", "holds", "message"]
        return write_table(
            directory,
            "stability.csv",
            header,
            [(v.component, v.case, v.claim, v.reached, v.limit, v.margin, int(v.holds), v.message) for v in self.verdicts],
        )


def declared() -> dict[str, tuple[HardCase, ...]]:
    """Component -> hard cases, of all systems, in the order of the catalogue."""
    cases: dict[str, tuple[HardCase, ...]] = {}
    for system in sorted({module.partition(".")[0] for module in CATALOGUE.values()}):
        module = f"....components.{system}.hard_cases"
        if find_spec(module, __package__):
            for component, named in import_module(module, __package__).HARD_CASES.items():
                cases[component] = tuple(replace(case, name=name) for name, case in named.items())
    unknown = cases.keys() - CATALOGUE.keys()
    assert not unknown, f"hard cases of components that are not in the catalogue: {unknown}"
    return {name: cases.get(name, ()) for name in CATALOGUE}


def hard_cases(components: Iterable[str] = (), *, progress: bool = False) -> HardCases:
    """Run the cases of the components given, or of all. Raises `BadInput` for a component that is not in the catalogue."""
    from ...run.progress import tracked

    cases = declared()
    chosen = list(components) or list(cases)
    for name in chosen:
        pick(name, cases, "--hard-cases", "a component of the catalogue")
    tasks = tracked([(name, case) for name in chosen for case in cases[name]], "hard cases", progress)
    return HardCases(
        tuple(
            verdict
            for name, case in tasks
            for verdict in once("hard case", (component_class(name), case.name), partial(verdicts, name, case), Verdict)
        )
    )


def verdicts(name: str, case: HardCase) -> list[Verdict]:
    """Run one case of a component of the catalogue: one verdict for each of its claims."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is scarcely resolved, and overflows of plain Python: hard on purpose
        return _verdicts(name, case)


def _verdicts(name: str, case: HardCase) -> list[Verdict]:
    if isinstance(case.holds, Refused):
        return [_refusal(name, case, case.holds)]
    component, rows, others = None, [], {}
    try:
        component = _initial_component(name, case, {})
        rows = _run(component, case, case.holds)
        others = {k: _end(name, case, claim) for k, claim in enumerate(case.holds) if isinstance(claim, Like)}
    except (BadInput, StepFailed) as error:
        why = math.nan, False, str(error)
        return [Verdict(name, case.name, case.text, claim.label, math.nan, claim.limit, *why) for claim in case.holds]
    times = np.array([t for t, *_ in rows])
    verdicts = []
    for k, claim in enumerate(case.holds):
        seen_by_it = [values[k] for _, values in rows]
        reached = claim.reached(component, times, np.array([seen_by_it[-1], others[k]] if k in others else seen_by_it))
        margin = claim.limit / reached if reached > 0.0 else math.inf if reached == 0.0 else math.nan
        holds = reached <= claim.limit
        verdicts.append(Verdict(name, case.name, case.text, claim.label, reached, claim.limit, margin, holds))
    return verdicts


def _end(name: str, case: HardCase, claim: Like) -> np.ndarray:
    """What the claim looks at, at the end of its other run."""
    other = replace(case, **claim.instead)
    component = _initial_component(name, other, {})
    return _run(component, other, [claim if claim.mirror is None else replace(claim, of=claim.mirror)])[-1][1][0]


def _initial_component(name: str, case: HardCase, instead: Mapping[str, Any]) -> Component:
    """The component of a case at its start, with some parameters and inputs of other values."""
    component = component_class(name)(case.effects)
    for variable, value in {**case.parameters, **case.inputs, **instead}.items():
        component.set(variable, value.start if isinstance(value, InputSignal) else value)
    component.initialize(0.0)
    return component


def _run(component: Component, case: HardCase, claims: Iterable[Claim]) -> list[tuple[float, list[np.ndarray]]]:
    """(time, what each claim looks at) at the start and after every step."""
    nominal = np.array([component.variables[n].nominal for n in component.outputs])

    def row() -> tuple[float, list[np.ndarray]]:
        return component.t, [component.y / nominal if isinstance(c, Finite) else seen(component, c.of) for c in claims]

    rows = [row()]
    for k in range(case.steps):
        _advance(component, case, k)
        rows.append(row())
    return rows


def _advance(component: Component, case: HardCase, k: int) -> None:
    """The k-th macro step; `StepFailed` also where a number in the component is not finite after it."""
    t, h = k * case.run[1], case.run[1]
    for column, name in enumerate(component.inputs):
        course = case.inputs.get(name)
        if not isinstance(course, InputSignal):
            continue
        if not course.smooth:
            component.u[:, column] = course.at(t), 0.0, 0.0
            continue
        a, b, c = (course.at(t + share * h) for share in (0.0, 0.5, 1.0))
        component.u[:, column] = a, (-3.0 * a + 4.0 * b - c) / h, 2.0 * (a - 2.0 * b + c) / h**2
    component.step(t, h)
    if not (np.isfinite(component.x).all() and np.isfinite(component.y).all()):
        raise StepFailed(component.name, component.t, "a number that is not finite, which the component does not report")


def _refusal(name: str, case: HardCase, refused: Refused) -> Verdict:
    message, when = "nothing is refused", ""
    component = None
    try:
        when = "construction"
        component_class(name)(case.effects, case.parameters)
        when = "initialize"
        component = _initial_component(name, case, {})
        when = "step"
        for k in range(case.steps):
            state = component.save()
            try:
                _advance(component, case, k)
            except StepFailed:
                component.restore(state)
                assert component.save() == state, f"{name}: {case.name}: the state before the failed step does not come back"
                raise
    except (BadInput, StepFailed) as error:
        message = str(error)
    holds = when == refused.when and refused.words in message
    margin = math.nan
    if not holds:
        message = f"at {when}: {message}"
    if refused.accepted:
        other, problem = _accepted(name, case, refused.accepted, when)
        margin, holds = other, holds and not problem
        message = f"{message}; and what should be accepted: {problem}" if problem else message
    return Verdict(name, case.name, case.text, refused.label, math.nan, math.nan, margin, holds, message)


def _accepted(name: str, case: HardCase, instead: Mapping[str, Any], when: str) -> tuple[float, str]:
    """The largest factor between a value refused and one accepted, and what is wrong with the latter."""
    try:
        component = _initial_component(name, case, instead)
        for k in range(case.steps if when == "step" else 1):
            _advance(component, replace(case, inputs={**case.inputs, **instead}), k)
    except (BadInput, StepFailed) as error:
        return math.nan, str(error)
    factors = [math.nan]
    for variable, value in instead.items():
        given = case.inputs.get(variable, case.parameters.get(variable, component.variables[variable].start))
        with suppress(TypeError, ZeroDivisionError):
            factor = abs(given / value)
            factors.append(max(factor, 1.0 / factor))
    return float(np.nanmax(factors)) if len(factors) > 1 else math.nan, ""
