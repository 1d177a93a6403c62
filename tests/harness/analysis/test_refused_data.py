"""What the analysis of signals cannot use is refused, in words: (call, words)."""

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.orchestrator.harness.analysis.fatigue import Endurance, rainflow
from cosimo.orchestrator.harness.analysis.least_squares import fit
from cosimo.orchestrator.harness.analysis.lyapunov import lyapunov_spectrum
from cosimo.orchestrator.harness.analysis.recurrence import embed, quantify, recurrence_matrix
from cosimo.orchestrator.harness.analysis.sections import section
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
from cosimo.orchestrator.harness.analysis.spectra import follow, unwrapped
from cosimo.tests.support import Mass

T = np.arange(0.0, 20.0, 2e-3)
TURN = 2.0 * np.pi
ONES = np.eye(4, dtype=bool)
REFUSED = [
    (lambda: rainflow([0.0, float("nan"), 1.0]), "finite signal"),
    (lambda: Endurance(100.0, 2e6, 5.0, ultimate=50.0), "ultimate stress"),
    (lambda: fit(lambda p: p[:1], {"a": 0.0, "b": 0.0}, {"a": (-1.0, 1.0), "b": (-1.0, 1.0)}), "1 residuals for 2 parameters"),
    (lambda: fit(lambda p: p, {"a": 2.0}, {"a": (-1.0, 1.0)}), "fit: a"),
    (lambda: fit(lambda p: p * np.nan, {"a": 0.0}, {"a": (-1.0, 1.0)}), "not finite"),
    *(
        (lambda given=given: lyapunov_spectrum(Mass(), *given[:2], interval=0.1, intervals=given[2]), "Lyapunov")
        for given in (((0,), (1.0, 1.0), 3), ((0,), (0.0,), 3), ((), (), 3), ((0,), (1.0,), 0))
    ),
    (lambda: recurrence_matrix(np.zeros((5, 1)), 0.0), None),
    (lambda: recurrence_matrix(np.zeros((5, 1)), 1.0, "manhattan"), None),
    (lambda: recurrence_matrix(np.full((5, 1), np.nan), 1.0), None),
    (lambda: quantify(np.triu(np.ones((4, 4), dtype=bool))), None),
    (lambda: quantify(ONES, theiler=4), None),
    (lambda: quantify(ONES, shortest=1), None),
    (lambda: embed(np.zeros(4), 3, 2), None),
    (lambda: section(np.sin(T), TURN, T), "turns back"),
    (lambda: section(1000.0 * T, TURN, T), "Record more often"),
    (lambda: ButterworthFilter(20.0, 5, True), "even for zero phase"),
    (lambda: ButterworthFilter(20.0).apply(np.zeros(100), 40.0), "less than 20 Hz"),
    (lambda: unwrapped((3.0 * np.arange(100)) % TURN), "Record more often"),
    (lambda: follow(T[:100], 125.0 * T[:100], T[:100]), "order tracking"),
]


@pytest.mark.parametrize(("call", "words"), REFUSED)
def test_data_that_cannot_be_used_are_refused(call, words):
    with pytest.raises(BadInput, match=words):
        call()
