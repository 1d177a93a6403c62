"""Key results as numbers by name: what holds for those that a run does not have."""

from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.run.key_results import KeyResults, key_results, known_results


class Refusing:
    @property
    def summary(self):
        raise BadInput("summary", "nothing", "a run")


def test_the_first_number_of_a_name_stays():
    figures = KeyResults.of([("a", 1, "m"), ("b", 2.0, "s"), ("a", 3.0, "N")])
    assert (figures, figures.units) == ({"a": 1.0, "b": 2.0}, {"a": "m", "b": "s"})


def test_a_figure_that_a_run_does_not_have_is_nan_and_never_left_out_but_where_that_is_asked_for():
    one, other = KeyResults({"a": 1.0, "b": 2.0, "c": np.inf}), KeyResults({"a": 1.5, "c": 0.0, "d": 4.0})
    np.testing.assert_array_equal(one.at(["d", "b"]), [np.nan, 2.0])
    np.testing.assert_equal(one.gaps(other), {"a": 0.5, "b": np.nan, "c": np.inf})
    assert one.finite_gaps(other) == {"a": 0.5}


def test_a_run_without_figures_is_refused_or_has_none():
    run = SimpleNamespace(summary=[SimpleNamespace(name="a", value=1.0, unit="m")])
    assert key_results(run) == known_results(run) == {"a": 1.0}
    with pytest.raises(BadInput):
        key_results(Refusing())
    assert known_results(Refusing()) == {}
