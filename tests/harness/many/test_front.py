"""Fronts of several aims against a closed form; the same for any number of workers, and kept."""

import csv

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.front import still_growing, unbeaten
from cosimo.orchestrator.harness.report import answers
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.harness.many.points import formula
from cosimo.tests.harness.many.test_searches import OSCILLATOR, STIFF

VARY = {"f.a": {"low": -4.0, "high": 4.0}, "f.b": {"low": -4.0, "high": 4.0}}
FRONT = {
    "vary": VARY,
    "minimise": ["f.parabola, end", "f.total, end"],
    "constraints": {"f.total, end": {"low": 1.0}},
    "evaluations": 600,
    "population": 30,
    "seed": 1,
}


@pytest.mark.full
def test_a_front_is_that_of_the_closed_form(tmp_path):
    """Of (a - 1)² + (b - 2)² and a + b >= 1: (3 - s)² / 2 over the sum s, from 1 to 3 (Lagrange). Below (3, 2) lies an area of
    8/3."""
    pytest.importorskip("pymoo")
    scene = read_scene(formula())
    answer = design(scene, FRONT, tmp_path)
    parabola, total = np.array([answer.steps[k].quantities for k in answer.front]).T
    assert (np.diff(parabola) > 0.0).all()
    assert (np.diff(total) < 0.0).all()
    assert total.min() >= 1.0 - 1e-6
    assert (parabola >= 0.5 * (3.0 - total) ** 2 - 1e-9).all()
    inside = (parabola < 2.0) & (total < 3.0)
    edges = np.append(parabola[inside], 2.0)
    area = float(np.sum(np.diff(edges) * (3.0 - total[inside])))
    assert 0.9 * 8.0 / 3.0 < area <= 8.0 / 3.0
    again = design(scene, FRONT, tmp_path)
    assert (again.computed, again.steps, again.front) == (0, answer.steps, answer.front)
    with answer.save(tmp_path).open() as file:
        assert [k for k, row in enumerate(csv.DictReader(file)) if row["front"] == "yes"] == sorted(answer.front)
    page = answers.for_design(answer, scene, tmp_path).read_text()
    assert f"{len(answer.front)} of 600 runs make the front" in page
    assert "parcoords" in page


def test_a_front_does_not_depend_on_the_number_of_workers():
    pytest.importorskip("pymoo")
    few = STIFF | {"maximise": "mass.base_velocity_x, maximum", "evaluations": 24, "population": 8}
    one, two = (design(OSCILLATOR, few, jobs=jobs) for jobs in (1, 2))
    assert one.steps == two.steps
    assert one.front == two.front


def test_points_that_none_beats():
    """By hand: (2, 2) is beaten by (1, 2), (3, 1) by none; of two equal points the first counts."""
    values = np.array([[2.0, 2.0], [1.0, 2.0], [3.0, 1.0], [1.0, 2.0], [0.5, 9.0]])
    assert unbeaten(values).tolist() == [4, 1, 2]
    assert unbeaten(np.zeros((0, 2))).tolist() == []


def test_a_front_that_still_grows_is_named():
    pytest.importorskip("pymoo")
    values = np.array([[0.0, 1.0], [1.0, 0.0], [0.5, 0.5], [0.1, 0.1]])
    # below (1, 1): a quarter with the third point, 0.81 with the fourth
    assert "added 69 %" in still_growing(values, np.array([0, 1, 2, 19]), 20)
    assert still_growing(values, np.array([0, 1, 2, 3]), 20) == ""


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"minimise": ["f.total, end", "f.total, end"]}, "each aim once"),
        ({"starts": 3}, "starts"),
        ({"method": "COBYQA"}, "'NSGA-II'"),
        ({"minimise": "f.total, end", "constraints": {}}, "population"),
        ({"minimise": "f.total, end", "method": "NSGA-II"}, "one"),
    ],
)
def test_bad_fronts_are_one_message(settings, named):
    with pytest.raises(BadInput, match=named):
        design(read_scene(formula()), FRONT | settings)
