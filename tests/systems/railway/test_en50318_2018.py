"""The three models of EN 50318:2018: their statics by a network of strings, their verdicts, the standing of their data."""

import pytest
from cosimo import component_class, load_scene
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems.railway.cases.en50318_2018 import AT_REST, CONTACT
from cosimo.orchestrator.systems.railway.cases.en50318_2018_data import DATA, model_data
from cosimo.tests.systems.railway.test_line import TWIN_WIRES, network

STITCHED, TWIN = "en50318-2018-ac-stitched", "en50318-2018-dc-simple"
PLACES = {
    STITCHED: {"e_support": 0.0, "e_first": 5.0, "e_clamp": 9.0, "e_greatest": 28.5, "e_midspan": 32.5},
    TWIN: {f"e_{x}": float(x) for x in (0, 4, 8, 22, 32)},
}
OTHER = {STITCHED: {"wires": ((27e3, 1.07), (21e3, 1.06)), "stitch": (9.0, 3500.0, 0.31)}, TWIN: TWIN_WIRES}


def solved(name):
    """Network of the scene's line, its rest, and the start of its sixth span, m."""
    text = load_scene(name).units["catenary"].parameters["line_table.table"]
    start = 5.0 * (65.0 if name == STITCHED else 64.0)
    net, found = network(text, [start + x for x in PLACES[name].values()], **OTHER[name])
    return net, net.solve(), found, start


@pytest.mark.first
@pytest.mark.parametrize("name", PLACES)
def test_the_table_has_the_numbers_of_the_network(name):
    """Elasticities, preloads, lengths and reaction; the middle of each range is what was printed, to four digits."""
    net, (rest, tension), found, start = solved(name)
    printed = {r.measure: 0.5 * (r.low + r.high) for r in load_table(name).under(AT_REST)}
    for measure, x in PLACES[name].items():
        at = "c", round(start + x, 6)
        loaded, _ = net.solve({at: 100.0})
        assert 10.0 * (loaded[at] - rest[at]) == pytest.approx(printed[measure], rel=4e-4)
    droppers = found.layout.droppers
    mine = [i for i, x in enumerate(droppers.position) if x > start and droppers.lower[i] == 0][:4]
    assert [found.length[i] for i in mine] == pytest.approx([printed[f"length_{k}"] for k in (1, 2, 3, 4)], rel=1e-4)
    names = ("preload_stitch", "preload") if name == STITCHED else ("preload_1", "preload_2", "preload_3")
    assert [tension[i] for i, _ in zip(mine, names, strict=False)] == pytest.approx([printed[n] for n in names], rel=1e-4)
    assert found.reaction[4] == pytest.approx(printed["reaction"], rel=1e-4)


def test_the_printed_shares_hold_a_head_under_both_wires():
    """With the share of the table both wires have the head at one height, each over a spring of the contact's stiffness."""
    net, _, _, start = solved(TWIN)
    printed = {r.measure: 0.5 * (r.low + r.high) for r in load_table(TWIN).under(AT_REST)}
    for x in (4.0, 8.0, 22.0):
        at, first = round(start + x, 6), 100.0 * printed[f"share_{x:g}"]
        z, _ = net.solve({("c", at): first, ("d", at): 100.0 - first})
        apart = z["c", at] - z["d", at] + (2.0 * first - 100.0) / CONTACT
        assert abs(apart) < 5e-3 * 0.6e-3  # m: four digits of the share are 5 mN, over less than 0.6 mm/N of both wires


@pytest.mark.parametrize("name", DATA)
def test_every_number_of_a_model_has_its_standing(name):
    unit = load_scene(name).units["catenary"]
    rows = model_data(name, component_class(unit.component)(unit.effects, unit.parameters, preset=unit.preset))
    assert len(rows) == len(DATA[name]) >= 13
    values = {row[0]: float(row[1]) for row in rows}
    assert next(v for n, v in values.items() if n.endswith("contact wire, tension") or n.startswith("each contact")) > 1e4
    assert {row[3] for row in rows} <= {"read", "unconfirmed", "inferred"}
    assert all(row[4] for row in rows)
