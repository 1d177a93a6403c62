"""Which parameters matter: Sobol's indices and Morris' elementary effects, by SALib, with their confidence intervals.

Sobol: S1 the share of a quantity's variance due to a parameter alone, ST the share due to it and all its
interactions (Saltelli 2010, Jansen 1999, as SALib has them). Morris: mean of the absolute elementary effects mu*, the change of a
quantity per range of a parameter, and their standard deviation sigma, large for nonlinear effects and interactions. A block with a
failed run is omitted and counted.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput
from ...output import write_table
from ...scene.scene import Scene
from ...settings.plan import PlanSettings
from ..sweep import AnswerOptions, Sweep, sweep
from .columns import column_name, for_columns
from .plan import SMALLEST, plan_settings
from .repetition import blurred

METHODS = ("sobol", "morris")
LEVELS = 4  # of Morris' grid
MARGIN = 0.01  # Morris: of the probability at either end, where quantiles may be infinite
WITHIN = 1.0 - 2.0 * MARGIN  # what is left, by which steps of its grid are shorter than SALib takes them for
CONFIDENCE = 0.95
RESAMPLES = 500  # of the bootstrap
FEWEST_BLOCKS = 8


@dataclass(frozen=True)
class Index:
    """Of a quantity and a parameter. first, total: Sobol's S1 and ST, or Morris' mu* and sigma; *_half: half of their 95 %
    intervals, NaN for sigma."""

    quantity: str
    parameter: str
    first: float
    first_half: float
    total: float
    total_half: float


@dataclass(frozen=True)
class Sensitivity:
    """Indices of every quantity over every parameter. blocks: that were complete, of how many.  constant: quantities that no
    parameter changes, which have no indices."""

    method: str
    indices: tuple[Index, ...]
    sweep: Sweep
    blocks: int
    planned: int
    constant: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, str]:
        """What `first` and `total` are."""
        return ("S1", "ST") if self.method == "sobol" else ("mu*", "sigma")

    @property
    def messages(self) -> list[str]:
        """What a user should know."""
        texts = []
        if self.blocks < self.planned:
            texts.append(
                f"{self.planned - self.blocks} of {self.planned} blocks of runs have a failed run and are left out; "
                "where runs fail for some values more than for others, the indices are of what is left"
            )
        if wide := [i for i in self.indices if self.method == "sobol" and i.total_half > 0.1]:
            texts.append(f"{len(wide)} of {len(self.indices)} total indices are known to ± 0.1 or worse: take more samples")
        texts += [f"{name} is the same everywhere" for name in self.constant]
        varying = {i.quantity: float(np.nanstd(self.sweep.measures[i.quantity])) for i in self.indices}
        texts += blurred(self.sweep.repeated, varying)
        return texts + self.sweep.doubts

    def __repr__(self) -> str:
        """A line a quantity: the index of each parameter with its interactions, ST or mu*, the largest first."""
        index = {(i.quantity, i.parameter): i.total if self.method == "sobol" else i.first for i in self.indices}
        lines = [f"<Sensitivity of {self.sweep.scene.name}: {'ST' if self.method == 'sobol' else 'mu*'} of each parameter>"]
        for quantity in dict.fromkeys(i.quantity for i in self.indices):
            of = sorted(((v, p) for (q, p), v in index.items() if q == quantity), reverse=True)
            lines.append(f"{quantity}: {', '.join(f'{p} {v:.3g}' for v, p in of)}")
        return "\n".join([*lines, *self.messages])

    def save(self, directory: str | Path) -> Path:
        """Write sensitivity.csv."""
        first, total = self.columns
        header = ["quantity", "parameter", first, f"{first} ± (95 %)", total, f"{total} ± (95 %)"]
        rows = [(i.quantity, i.parameter, i.first, i.first_half, i.total, i.total_half) for i in self.indices]
        return write_table(directory, "sensitivity.csv", header, rows)


def sensitivity(
    scene: Scene,
    plan: PlanSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None = None,
    *,
    quantities: Sequence[str] = (),
    method: str = "sobol",
    samples: int = 128,
    **how: Unpack[AnswerOptions],
) -> Sensitivity:
    """Indices of quantities over what the plan varies; `samples` blocks of d + 2 runs (Sobol) or d + 1 (Morris).

    `quantities`: columns of a sweep, by default those of the plan or of the scene's [study]. The plan's own method and number of
    points do not count. `how`: as of a sweep. Raises `BadInput`, also for correlated parameters, of which shares of the variance
    mean nothing.
    """
    if find_spec("SALib") is None:
        raise BadInput("sensitivity", "no SALib", "an installed SALib", "pip install cosimo[many]")
    settings = plan_settings(plan, scene=scene, sampled=False)
    if method not in METHODS or samples < FEWEST_BLOCKS:
        raise BadInput("sensitivity", f"method {method!r}, {samples} samples", f"{' or '.join(METHODS)}, {FEWEST_BLOCKS} or more")
    if settings.correlation:
        raise BadInput("sensitivity", "correlated parameters", "independent ones", "Remove correlation from the plan.")
    if settings.table or len(settings.vary) < 2:
        raise BadInput(
            "sensitivity", "a table of points" if settings.table else f"{len(settings.vary)} parameter", "two or more in [vary]"
        )
    names, chosen = for_columns(scene, settings, quantities, "sensitivity")
    problem = {"num_vars": len(settings.vary), "names": list(settings.vary), "bounds": [[0.0, 1.0]] * len(settings.vary)}
    cube = sample(problem, method, samples, settings.seed)
    runs = sweep(scene, chosen, directory, columns=names, cube=np.clip(cube, SMALLEST, 1.0 - SMALLEST), **how)
    indices: list[Index] = []
    constant: list[str] = []
    blocks = 0
    if runs.stopped is None:
        for name in names:
            key = column_name(runs.measures, name, "sensitivity")
            rows, blocks = analyse(problem, method, cube, runs.measures[key], settings.seed)
            if rows is None:
                constant.append(key)
            else:
                indices += [Index(key, p, *row) for p, row in zip(settings.vary, rows.tolist(), strict=True)]
    return Sensitivity(method, tuple(indices), runs, blocks, samples, tuple(constant))


def sample(problem: Mapping[str, Any], method: str, samples: int, seed: int) -> np.ndarray:
    """(samples * block, d) points of the unit cube; those of Morris' grid are at least MARGIN from its faces."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # n is no power of two
        if method == "sobol":
            from SALib.sample import sobol

            return np.asarray(sobol.sample(dict(problem), samples, calc_second_order=False, seed=seed))
        from SALib.sample import morris

        return MARGIN + WITHIN * np.asarray(morris.sample(dict(problem), samples, num_levels=LEVELS, seed=seed))


def analyse(
    problem: Mapping[str, Any], method: str, cube: np.ndarray, values: np.ndarray, seed: int
) -> tuple[np.ndarray | None, int]:
    """((d, 4) of first, half interval, total, half interval; complete blocks) of values (n,) at points (n, d).

    None where the values are all the same. Raises `BadInput` where too few blocks are complete.
    """
    d = int(problem["num_vars"])
    block = d + 2 if method == "sobol" else d + 1
    whole = np.isfinite(values.reshape(-1, block)).all(axis=1)
    if whole.sum() < FEWEST_BLOCKS:
        raise BadInput(
            "sensitivity",
            f"{int(whole.sum())} complete blocks of runs",
            f"{FEWEST_BLOCKS} or more",
            "Look at the outcomes in sweep.csv; take narrower ranges.",
        )
    kept = np.repeat(whole, block)
    y = np.asarray(values)[kept]
    if np.ptp(y) <= 1e-12 * np.abs(y).max():
        return None, int(whole.sum())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if method == "sobol":
            from SALib.analyze import sobol

            r = sobol.analyze(  # to which a seed of 0 is none
                dict(problem), y, calc_second_order=False, num_resamples=RESAMPLES, conf_level=CONFIDENCE, seed=seed or 1
            )
            rows = np.stack([r["S1"], r["S1_conf"], r["ST"], r["ST_conf"]], axis=1)
        else:
            from SALib.analyze import morris

            r = morris.analyze(
                dict(problem), cube[kept], y, num_resamples=RESAMPLES, conf_level=CONFIDENCE, num_levels=LEVELS, seed=seed
            )
            star, half, sigma = (np.asarray(r[key], dtype=float) for key in ("mu_star", "mu_star_conf", "sigma"))
            rows = np.stack([star, half, sigma, np.full(d, np.nan)], axis=1) / WITHIN
    return rows, int(whole.sum())
