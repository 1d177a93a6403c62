"""What tolerances of parameters make of the figures of a run: to first order by derivatives, beside a few samples.

    s² = gᵀ C g     g = df/dp,  C: covariance of the parameters

(JCGM 100:2008, law of propagation of uncertainty, 5.1 and 5.2; from memory.) Samples of a normal distribution, in pairs on either side,
tell what first order leaves out. A scene without tolerances has nothing of this.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from math import ceil, inf, isfinite, nan
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ..run.key_results import KeyResults, key_results
from ..run.results import Result
from ..run.run_record import ParameterRecord, ParametersRecord, known
from ..run.thresholds import PARAMETER_SAMPLES, SECOND_ORDER
from ..scene.scene import Scene
from ..scene.tolerances import Tolerances

FIRST_ORDER = 8.0  # runs that eight exact derivatives take at most
MUCH = "they are much work: ask with --verify whole"
Again = Callable[[Scene, Mapping[str, Any]], tuple[Result | None, str]]


@dataclass(frozen=True)
class ParameterErrors:
    """why: why there are none, "" else.  deviations: of the parameters.  how: "exact" or "differences", and why.

    figures: name -> standard deviation, in its unit, NaN where it is not known.  rest: name -> what first order leaves out, as a
    share of it; empty without samples.  largest: name -> the parameter that matters most.  refused: name -> why it has no first
    order.  samples: that came to their end, of samples_asked.
    """

    why: str = ""
    deviations: Mapping[str, float] = field(default_factory=dict)
    how: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)
    rest: Mapping[str, float] = field(default_factory=dict)
    largest: Mapping[str, str] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)
    samples: int = 0
    samples_asked: int = 0

    @property
    def warnings(self) -> list[str]:
        """What a user should know of them."""
        if self.why:
            return [f"parameter errors are not known: {self.why}"]
        large = [name for name, share in self.rest.items() if share > SECOND_ORDER and name not in self.refused]
        texts = []
        if large:
            worst = max(large, key=self.rest.__getitem__)
            others = f" and {len(large) - 1} more" if len(large) > 1 else ""
            share = f"{100.0 * self.rest[worst]:.2g} % of it" if isfinite(self.rest[worst]) else "all of it"
            texts.append(
                f"the parameter error of {worst}{others} is not of first order alone: {self.samples} samples differ from it by "
                f"{share}. Run cosimo uncertainty"
            )
        for name, reason in list(self.refused.items())[:1]:
            more = f", and of {len(self.refused) - 1} more," if len(self.refused) > 1 else ""
            source = f"from {self.samples} samples" if self.samples else "not known"
            texts.append(f"the parameter error of {name}{more} is {source}: {reason}")
        if self.samples < self.samples_asked:
            texts.append(
                f"{self.samples_asked - self.samples} of {self.samples_asked} samples of the tolerances do not come to their end"
            )
        return texts

    @property
    def record(self) -> ParametersRecord:
        """As it is written."""
        figures = {
            name: ParameterRecord(
                error=known(error),
                rest=known(self.rest.get(name, nan)),
                largest=self.largest.get(name),
                why=self.refused.get(name, ""),
            )
            for name, error in self.figures.items()
        }
        return ParametersRecord(why=self.why, deviations=self.deviations, how=self.how, samples=self.samples, figures=figures)


def parameter_errors(result: Result, tolerances: Tolerances, allows: Callable[[float], bool], again: Again) -> ParameterErrors:
    """Of the figures of a run. allows: whether so many more runs may be made.  again: the run with changes, or None and why not.

    Raises `StepFailed` where a run with derivatives fails.
    """
    names, values = list(tolerances.names), key_results(result)
    if not values:
        return ParameterErrors("the run has no key results, which are those of a system in [analysis]")
    first = FIRST_ORDER * ceil(len(names) / 8)
    if not allows(first):
        return ParameterErrors(MUCH)
    slopes, how = _exact(result, tolerances)
    if slopes is None:
        first = 2.0 * len(names)
        if not allows(first):
            return ParameterErrors(MUCH)
        from ..derivatives.gradient import by_differences

        slopes = by_differences(result, key_results, dict(zip(names, tolerances.deviations.tolist(), strict=True)), halved=False)
    derivatives = np.array([[slopes[figure, name].derivative for name in names] for figure in values]).reshape(-1, len(names))
    refused = {f: s.how for f in values for n in names if not isfinite((s := slopes[f, n]).derivative)}
    errors = np.sqrt(np.maximum(np.einsum("fi,ij,fj->f", derivatives, tolerances.covariance, derivatives), 0.0))
    parts = np.abs(derivatives) * tolerances.deviations
    largest = {
        f: names[int(np.argmax(part))] for f, part in zip(values, parts, strict=True) if np.isfinite(part).all() and part.any()
    }
    moves, changes = _samples(result, values, tolerances, again) if allows(first + PARAMETER_SAMPLES) else (None, None)
    rest: dict[str, float] = {}
    if moves is not None and changes is not None and len(moves):
        beside = np.sqrt(np.mean((changes - moves @ derivatives.T) ** 2, axis=0))
        whole = np.sqrt(np.mean(changes**2, axis=0))
        for k, figure in enumerate(values):
            rest[figure] = float(beside[k] / errors[k]) if errors[k] else inf if beside[k] > 1e-9 * abs(values[figure]) else 0.0
            if not rest[figure] <= 1.0:  # also where there is no first order
                errors[k] = whole[k]
    return ParameterErrors(
        "",
        dict(zip(names, tolerances.deviations.tolist(), strict=True)),
        how,
        dict(zip(values, errors.tolist(), strict=True)),
        rest,
        largest,
        refused,
        0 if moves is None else len(moves),
        0 if moves is None else PARAMETER_SAMPLES,
    )


def _exact(result: Result, tolerances: Tolerances) -> tuple[Mapping[tuple[str, str], Any] | None, str]:
    """Derivatives of the figures and "exact"; None where the scene has none, and what is taken instead, with the reason."""
    names = tolerances.names
    try:
        from ..derivatives.gradient import slopes_of
        from ..derivatives.tangent_block import TangentBlock

        with ExitStack() as stack:
            block = TangentBlock(result.scene, stack)
            return slopes_of(result, block, key_results, names, {n: block.value(n) for n in names}), "exact"
    except (BadInput, ImportError) as error:
        return None, f"differences ({error})"


def _samples(result: Result, values: KeyResults, tolerances: Tolerances, again: Again) -> tuple[np.ndarray, np.ndarray]:
    """(moves (k, n) of the parameters, changes (k, f) of the figures), of those samples that come to their end."""
    power, basis = np.linalg.eigh(tolerances.covariance)
    half = np.random.default_rng(0).standard_normal((PARAMETER_SAMPLES // 2, len(tolerances.names)))
    moves = np.concatenate([half, -half]) @ (basis * np.sqrt(np.maximum(power, 0.0))).T
    runs = [again(result.scene, dict(zip(tolerances.names, (tolerances.values + m).tolist(), strict=True)))[0] for m in moves]
    samples = [key_results(run) if run is not None else KeyResults() for run in runs]
    changes = [sample.at(values) - values.at(values) for sample in samples if sample]
    return moves[[bool(sample) for sample in samples]], np.array(changes).reshape(-1, len(values))
