"""A steady wind moves the contact wire to the side: a string between its supports, in closed form and by finite differences."""

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.orchestrator.harness.analysis.records import RecordedUnit
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.figures import figures
from cosimo.tests.scene_runs import finished
from cosimo.tests.systems.railway.made_up import made_up_run

LINE = """[[sections]]
contact_wire = { tension = 15e3, mass = 1.35 }
spans = [60, 60, 40, 60]
supports = [{ stagger = 0.2 }, { stagger = -0.2 }, { stagger = 0.2 }, { stagger = -0.2 }, { stagger = 0.2 }]
"""
TENSION, STAGGER = 15e3, 0.2


def sideways(places, *effects, **more):
    """Lateral positions of the contact wire at places, m."""
    values = {"line_table.table": LINE, "method": "implicit", "element": 2.0}
    catenary = Catenary(["line_table", "stagger", *effects], {**values, **more})
    catenary.set("contact_position", 30.0)
    catenary.initialize(0.0)
    found = []
    for x in places:
        catenary.set("contact_position", float(x))
        catenary.refresh()
        found.append(catenary["stagger.lateral_position"])
    return np.array(found)


def load(speed):
    """rho/2 C_D d U², N/m, of the declared wire."""
    return 0.5 * 1.225 * 0.0145 * speed * abs(speed)


@pytest.mark.known_answers(Catenary="blow_off")
@pytest.mark.parametrize("speed", [20.0, -33.0])
def test_the_wire_is_blown_off_as_a_string(speed):
    """By p L² / 8 T in the middle of a span, and everywhere as T y'' = -p by finite differences; supports hold."""
    x = np.arange(0.0, 220.5, 0.5)
    wind = sideways(x, "blow_off", **{"blow_off.speed": speed}) - sideways(x)
    assert wind[60] == pytest.approx(load(speed) * 60.0**2 / 8.0 / TENSION, rel=1e-12)
    inside = ~np.isin(x, [0.0, 60.0, 120.0, 160.0, 220.0])
    matrix = (2.0 * np.eye(x.size) - np.eye(x.size, k=1) - np.eye(x.size, k=-1)) * TENSION / 0.25
    solved = np.zeros(x.size)
    solved[inside] = np.linalg.solve(matrix[np.ix_(inside, inside)], np.full(inside.sum(), load(speed)))
    assert wind == pytest.approx(solved, abs=1e-12)


def test_the_largest_lateral_position_is_that_of_alternating_stagger():
    """p L² / 8 T + 2 b² T / (p L²), where the wind is strong enough for a largest one within the span."""
    p = load(38.0)
    assert p * 60.0**2 > 4.0 * STAGGER * TENSION
    x = np.linspace(0.001, 59.999, 400)
    expected = p * 60.0**2 / 8.0 / TENSION + 2.0 * STAGGER**2 * TENSION / (p * 60.0**2)
    assert sideways(x, "blow_off", **{"blow_off.speed": 38.0}).max() == pytest.approx(expected, abs=1e-5)


def test_a_wind_of_no_speed_changes_nothing_and_a_tenser_wire_moves_less():
    x, twice = [30.0, 75.0], LINE.replace("15e3", "30e3")
    assert (sideways(x, "blow_off", **{"blow_off.speed": 0.0}) == sideways(x)).all()
    tense = sideways(x, "blow_off", **{"line_table.table": twice}) - sideways(x)
    assert tense == pytest.approx(0.5 * (sideways(x, "blow_off") - sideways(x)), rel=1e-9)


@pytest.mark.full
def test_the_lateral_position_is_a_key_result_and_a_figure():
    """That of the string, with the tension that the wire has as built; neither where none was recorded."""
    scene = load_scene("line-as-built")
    result = finished(scene)
    tension = RecordedUnit(result, "catenary").component.form().layout.wires[0].tension
    assert 0.001 < abs(tension / 22e3 - 1.0) < 0.06
    p = load(scene.units["catenary"].parameters["blow_off.speed"])
    expected = 1e3 * (p * 65.0**2 / 8.0 / tension + 2.0 * STAGGER**2 * tension / (p * 65.0**2))
    rows = {row.name: row.value for row in result.summary}
    assert rows["pantograph.lateral_mm"] == pytest.approx(expected, abs=0.1)
    lateral = next(f for f in figures(result) if f.title.startswith("Lateral"))
    straight, wire = lateral.figure["data"]
    assert np.abs(straight["y"]) == pytest.approx([1e3 * STAGGER] * len(straight["x"]), abs=1.0)
    assert max(wire["y"]) == pytest.approx(expected, abs=0.5)
    assert not [f for f in figures(made_up_run()) if f.title.startswith("Lateral")]
