"""Compound catenaries: an auxiliary wire between messenger and contact wire, against strings assembled apart and closed forms."""

import csv
from importlib.resources import files

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.catenary_effects import PROFILE
from cosimo.components.railway.contact import wire_height
from cosimo.components.railway.line.dropper_table import with_droppers
from cosimo.components.railway.line.form import find_form
from cosimo.components.railway.line.later import line_at
from cosimo.components.railway.line.table import read_line
from cosimo.components.railway.statics import Statics, elasticity
from cosimo.components.railway.stiffness import stiffness_of_wires
from cosimo.orchestrator import systems
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.figures.passage import passage_figure
from cosimo.orchestrator.systems.railway.line import save, svg, text_drawing
from cosimo.orchestrator.systems.railway.records import passages
from cosimo.tests.scene_runs import finished
from cosimo.tests.systems.railway.network import G, Network
from scipy.linalg import eigh

CONTACT, AUXILIARY, MESSENGER = (14.7e3, 1.511), (14.7e3, 1.375), (24.5e3, 1.45)  # N, kg/m
COMPOUND = """
[[sections]]
contact_wire = { tension = 14.7e3, mass = 1.511 }
auxiliary = { tension = 14.7e3, mass = 1.375, height = 0.15 }
messenger = { tension = 24.5e3, mass = 1.45 }
main_droppers = { first = 5.0, gap = 10.0, stiffness = 200e3, mass = 0.1, contact_clamp = 0.195, messenger_clamp = 0.2 }
droppers = { first = 2.5, gap = 5.0, stiffness = 150e3, contact_clamp = 0.165, messenger_clamp = 0.18 }
support = { system_height = 1.5, stiffness = 500e3 }
spans = [50, 50, 50]
"""
SIMPLE = COMPOUND.replace("auxiliary =", "# auxiliary =").replace("main_droppers =", "# main_droppers =")
UNEVEN = COMPOUND.replace("50, 50, 50", "50, { length = 45, main_positions = [5, 20, 27.5, 40] }, 55").replace(
    "system_height = 1.5", "system_height = 1.5, contact_height = 5.0"
)
EFFECTS = ("dropper_slackening", "gravity_sag", "line_table")


def parameters():
    return Catenary()._declared_arguments()[0]


def catenary(text, effects=EFFECTS, place=75.0, force=0.0, **values):
    made = Catenary(effects, {"line_table.table": text, "first_watched_support": 0, "substep": 2.5e-4} | values)
    made.set("contact_position", place)
    made.set("contact_force", force)
    made.initialize(0.0)
    return made


def network(form, places=(), contact=CONTACT):
    """A compound line of cut droppers as strings; places: extra points of the contact wire."""
    net, d, x = Network(), form.layout.droppers, form.layout.supports
    main = d.lower != 0
    net.wire("c", [x[0], x[-1], *d.position[~main], *places], contact[0], G * contact[1])
    net.wire("a", [x[0], x[-1], *d.position], AUXILIARY[0], G * AUXILIARY[1])
    net.wire("m", [*x, *d.position[main]], MESSENGER[0], G * MESSENGER[1])
    for i, p in enumerate(d.position):
        ends = (("a", round(p, 6)), ("m", round(p, 6))) if main[i] else (("c", round(p, 6)), ("a", round(p, 6)))
        weights = G * np.array([d.mass_below[i], d.mass_above[i]])
        net.droppers.append((*ends, d.stiffness[i], form.cut_length[i], weights))
    for end in (0, -1):
        net.fixed |= {("c", x[end]): 0.0, ("a", x[end]): 0.15, ("m", x[end]): 1.5}
    net.springs = [(("m", s), 500e3, rest) for s, rest in zip(x[1:-1], form.rest_height, strict=True)]
    return net


@pytest.mark.interpreted
@pytest.mark.parametrize("text", [COMPOUND, UNEVEN])
def test_both_rows_of_droppers_bring_the_wires_where_they_were_to_be(text):
    """Dropper lengths and both tensions, against strings; mesh and form finding agree."""
    form = find_form(read_line(text), parameters())
    heights, tension = network(form).solve()
    d = form.layout.droppers
    assert tension == pytest.approx(form.preload, rel=1e-6)
    lower = [heights["c" if low == 0 else "a", round(p, 6)] for p, low in zip(d.position, d.lower, strict=True)]
    assert lower == pytest.approx(d.height, abs=1e-8)
    assert [heights["m", p] for p in form.support] == pytest.approx([1.5, 1.5], abs=1e-8)
    assert catenary(text).mesh.preload == pytest.approx(form.preload, rel=1e-9)


@pytest.mark.interpreted
def test_weights_and_lengths_are_those_of_statics():
    """A dropper carries its share of all below it; the messenger hangs by the moment of its loads over its tension."""
    form = find_form(read_line(COMPOUND), parameters())
    d = form.layout.droppers
    inside = (d.position > 50.0) & (d.position < 100.0)
    main = d.lower != 0
    small = G * (CONTACT[1] * 5.0 + 0.165)
    assert form.preload[inside & ~main] == pytest.approx(small, rel=1e-9)
    load = 2.0 * (small + G * 0.18) + G * (AUXILIARY[1] * 10.0 + 0.195 + 0.05)
    assert form.preload[inside & main] == pytest.approx(load, rel=1e-9)
    point, at = load + G * (0.2 + 0.05), np.array([5.0, 15.0, 25.0, 35.0, 45.0])
    moment = [
        0.5 * G * MESSENGER[1] * x * (50.0 - x) + sum(point * min(x, a) * (50.0 - max(x, a)) / 50.0 for a in at) for x in at
    ]
    assert form.length[inside & main] == pytest.approx(1.35 - np.array(moment) / MESSENGER[0], abs=1e-9)


@pytest.mark.known_answers(Catenary="line_table")
def test_elasticity_is_that_of_the_network():
    """Under 100 N, and under 800 N, where droppers of the contact wire are slack: then nothing pushes the auxiliary wire."""
    form = find_form(read_line(UNEVEN), parameters())
    mesh = catenary(UNEVEN, element=0.1).mesh
    slack = Statics(mesh).under([(70.0, 800.0)], True)[1] == 0.0
    assert set(form.layout.droppers.lower[slack]) == {0}
    for force, places in ((100.0, [50.0, 60.0, 72.5]), (800.0, [70.0])):
        net = network(form, places)
        rest, _ = net.solve()
        expected = [(net.solve({("c", p): force})[0]["c", p] - rest["c", p]) / force for p in places]
        assert elasticity(mesh, places, force) == pytest.approx(expected, rel=4e-3)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_droppers_of_both_rows_slacken_and_give_no_energy(method):
    """2 kN downwards taken away at once, as by falling ice: the wires fly up, and some droppers of either row are slack for a while."""
    made = catenary(COMPOUND, force=-2000.0, element=1.0, method=method)
    start, mesh = made.energy(), made.mesh
    made.set("contact_force", 0.0)
    slack, rows, energy = set(), mesh.lower % 3, []
    for k in range(150):
        made.step(2e-3 * k, 2e-3)
        q = made.motion[0]
        pull = mesh.preload + mesh.dropper_stiffness * (q[mesh.upper] - q[mesh.lower])
        slack |= set(rows[pull < 0.0].tolist())
        energy.append(made.energy())
    assert slack == {0, 2}
    assert energy == pytest.approx(np.full(150, start), rel=1e-3)


def matrices(mesh):
    """Stiffness and mass of the model with taut droppers, dense."""
    N, band = mesh.mass.size, stiffness_of_wires(mesh, 3)
    K = np.zeros((N, N))
    for k in range(band.shape[1]):
        K[np.arange(N - k), np.arange(k, N)] += band[: N - k, k]
    K = np.triu(K) + np.triu(K, 1).T
    for a, b, s in zip(mesh.lower, mesh.upper, mesh.dropper_stiffness, strict=True):
        K[[a, b], [a, b]] += s
        K[[a, b], [b, a]] -= s
    free = np.isfinite(mesh.mass)
    return (K + np.diag(mesh.ground))[np.ix_(free, free)], np.diag(mesh.mass[free])


def test_three_wires_on_many_droppers_swing_as_one_string():
    """First frequency of a span between anchors: sqrt(sum of T / sum of m) / 2 L; the highest one is below the limit of the step."""
    text = COMPOUND.replace("50, 50, 50", "50")
    for old, new in (
        ("mass = 0.1, ", "mass = 0.0, "),
        ("= 0.195", "= 0.0"),
        ("= 0.2 ", "= 0.0 "),
        ("= 0.165", "= 0.0"),
        ("= 0.18 ", "= 0.0 "),
    ):
        text = text.replace(old, new)
    made = catenary(text.replace("gap = 10.0", "gap = 1.0").replace("gap = 5.0", "gap = 1.0"), place=25.0, element=0.5)
    omega2 = eigh(*matrices(made.mesh), eigvals_only=True)
    T, m = (sum(wire[k] for wire in (CONTACT, AUXILIARY, MESSENGER)) for k in (0, 1))
    assert np.sqrt(omega2[0]) / 2.0 / np.pi == pytest.approx(np.sqrt(T / m) / 100.0, rel=2e-3)
    assert 0.93 < made.stable_step() / (2.0 / np.sqrt(omega2[-1])) < 1.0


def test_a_released_line_moves_as_the_modes_of_strings_assembled_apart():
    """150 N taken away at once: elements of 0.25 m with masses between lumped and consistent, exact in time, droppers taut."""
    L, n = 0.25, 201
    K, M = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 3 * n))
    for wire, (T, m) in enumerate((CONTACT, AUXILIARY, MESSENGER)):
        for i in range(n - 1):
            j = [3 * i + wire, 3 * (i + 1) + wire]
            K[np.ix_(j, j)] += T / L * np.array([[1.0, -1.0], [-1.0, 1.0]])
            M[np.ix_(j, j)] += m * L / 12.0 * np.array([[5.0, 1.0], [1.0, 5.0]])
    text = COMPOUND.replace("50, 50, 50", "50")
    d = find_form(read_line(text), parameters()).layout.droppers
    for k, (x, low) in enumerate(zip(d.position, d.lower, strict=True)):
        a = 3 * round(x / L) + (0 if low == 0 else 1)  # contact wire, auxiliary wire, messenger
        b = a + 1
        K[[a, b], [a, b]] += d.stiffness[k]
        K[[a, b], [b, a]] -= d.stiffness[k]
        M[a, a] += d.mass_below[k]
        M[b, b] += d.mass_above[k]
    free, at = slice(3, 3 * n - 3), 3 * round(20.0 / L) - 3
    omega2, modes = eigh(K[free, free], M[free, free])
    start = 150.0 * modes[at] / omega2
    times, heights = 2e-3 * np.arange(1, 151), []
    made = catenary(text, ("line_table",), 20.0, 150.0, element=0.25)
    made.set("contact_force", 0.0)
    for t in times:
        made.step(t - 2e-3, 2e-3)
        heights.append(made["wire_height"])
    expected = modes[at] @ (start[:, None] * np.cos(np.sqrt(omega2)[:, None] * times))
    assert np.std(heights - expected) < 0.01 * np.std(expected)


@pytest.mark.interpreted
@pytest.mark.parametrize("change", [0.0, 20.0])
def test_worn_and_warm_lines_keep_their_cut_lengths(change):
    """A fifth of the contact wire gone, and an auxiliary wire between anchors: strain and shape are those of a network of strings."""
    text = COMPOUND.replace("height = 0.15", "height = 0.15, fixed = true, axial_stiffness = 18e6")
    new = find_form(read_line(text), parameters())
    line, later = line_at(read_line(text), parameters(), change, 0.2)
    kept = []
    for form, contact, tension in (
        (new, CONTACT[1], AUXILIARY[0]),
        (later, 0.8 * CONTACT[1], line.sections[0].auxiliary.tension),
    ):
        net = network(new, contact=(CONTACT[0], contact))
        net.segments = [(a, b, tension if a[0] == "a" else T, *rest) for a, b, T, *rest in net.segments]
        net.springs, net.fixed = [], net.fixed | {("m", s): 1.5 for s in (50.0, 100.0)}
        heights, pull = net.solve()
        assert pull == pytest.approx(form.preload, rel=1e-5)
        x = np.array(sorted(p for wire, p in heights if wire == "a"))
        rise, L = np.diff([heights["a", p] for p in x]), np.diff(x)
        excess = np.sum(0.5 * rise**2 / L + (G * AUXILIARY[1]) ** 2 * L**3 / (24.0 * tension**2)) / 150.0
        kept.append(tension / 18e6 - excess)
    assert kept[1] - kept[0] == pytest.approx(-1.7e-5 * change, abs=1e-9)


@pytest.mark.interpreted
def test_droppers_as_a_table_are_read_back(tmp_path):
    """By heights, by cut lengths, and mixed at one place; a contact wire's dropper on the messenger is refused."""
    line = read_line(UNEVEN)
    form = find_form(line, parameters())
    text = save(form, "compound", tmp_path)[0].read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert {(row["contact wire"], row["hangs from"]) for row in rows} == {("1", "auxiliary"), ("", "messenger")}
    assert find_form(with_droppers(line, text, "mine"), parameters()).preload == pytest.approx(form.preload, rel=1e-9)
    for cut in (lambda row: True, lambda row: row["contact wire"] == "", lambda row: row["contact wire"] != ""):
        lines = [",".join("" if k == "height [m]" and cut(row) else v for k, v in row.items()) for row in rows]
        again = find_form(with_droppers(line, "\n".join([",".join(rows[0]), *lines]), "mine"), parameters())
        assert again.preload == pytest.approx(form.preload, rel=1e-6)
        assert again.layout.droppers.height == pytest.approx(form.layout.droppers.height, abs=1e-8)
    with pytest.raises(BadInput, match=r"hangs from 'messenger'.*auxiliary"):
        find_form(with_droppers(line, text.replace(",auxiliary,", ",messenger,"), "mine"), parameters())


@pytest.mark.interpreted
def test_three_wires_of_the_shipped_line_are_drawn():
    """Its tensions add up to the 53.9 kN that were read."""
    form = find_form(read_line((files(systems) / "railway/lines/heavy-compound.toml").read_text(encoding="utf-8")), parameters())
    assert sum(wire.tension for wire in form.layout.wires) == 53.9e3
    assert form.preload.min() > 0.0
    assert svg(form, "compound").count('stroke="#009E73"') == 1
    drawn = text_drawing(form)
    assert "~ auxiliary" in drawn
    assert drawn.count("~") > 100


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tension = 14.7e3, mass = 1.375,", "mass = 1.375,", "no tension"),
        ("mass = 1.375, ", "", "no mass"),
        (", height = 0.15", "", "no height"),
        ("auxiliary = { tension = 14.7e3, mass = 1.375, height = 0.15 }", "", "auxiliary wire that is not there"),
        ("spans = [50, 50, 50]", "spans = [50, { length = 50, main_positions = [55] }]", "main_positions: got"),
        ("height = 0.15", "height = 2.0", "an upper wire above the lower one"),
        ("height = 0.15", "height = 0.15, heigth = 2", "Did you mean"),
    ],
)
def test_what_no_compound_line_is(old, new, message):
    with pytest.raises(BadInput, match=message):
        find_form(read_line(COMPOUND.replace(old, new)), parameters())


def test_the_front_keeps_the_heights_under_two_pantographs():
    """Against the whole line, at 70 m/s; in the one what is far ahead rests, in the other all moves."""
    text, runs = COMPOUND.replace("50, 50, 50", "{ length = 50, repeat = 10 }"), []
    for threshold in (0.0, 1e-4):
        made = catenary(text, (*EFFECTS, "second_pantograph"), 60.0, 150.0, front_threshold=threshold)
        heights = []
        for k in range(150):
            made.set("contact_position", 60.0 + 0.14 * k)
            made.set("second_pantograph.contact_position", 35.0 + 0.14 * k)
            made.set("second_pantograph.contact_force", 150.0)
            made.step(2e-3 * k, 2e-3)
            heights.append((made["wire_height"], made["second_pantograph.wire_height"]))
        runs.append((np.array(heights), made.motion[1][3 * np.searchsorted(made.mesh.position, 250.0) :]))
    (whole, moved), (near, still) = runs
    assert np.abs(whole - near).max() < 1e-4 * np.ptp(whole)
    assert np.count_nonzero(moved) > 2 * np.count_nonzero(still)


@pytest.mark.interpreted
@pytest.mark.parametrize(("text", "lane"), [(COMPOUND, 2), (SIMPLE, None)])
def test_the_profile_tells_of_the_auxiliary_wire(text, lane):
    """Its own displacement at places 1 m apart, under a force; 0 without one."""
    made = catenary(text, (*EFFECTS, "wire_profile", "line_profile"), force=150.0, element=2.5)
    told = [made[f"line_profile.auxiliary_uplift[{k + 1}]"] for k in range(PROFILE)]
    own = np.zeros(made.mesh.position.size) if lane is None else made.motion[0][lane::3]
    assert told == pytest.approx(np.interp(15.0 + np.arange(PROFILE), made.mesh.position, own), abs=1e-15)
    assert np.ptp(told) > 0.01 or lane is None


def test_lines_without_an_auxiliary_wire_have_no_third_lane():
    assert catenary(SIMPLE).mesh.bending_gradient.size == 2
    made = catenary(COMPOUND)
    assert made.mesh.bending_gradient.size == 3
    assert wire_height(75.0, made.motion[0], 0, made.mesh) == pytest.approx(made["wire_height"])


@pytest.mark.full
def test_the_passage_shows_the_auxiliary_wire_between_its_droppers():
    """Where the run has recorded it; droppers end on the wires as they are now."""
    result = finished(load_scene("compound-line"))
    figure = passage_figure(result, passages(result)[0], ButterworthFilter()).figure
    names, last = [trace["name"] for trace in figure["data"]], figure["frames"][-1]
    now = {names[i]: trace for i, trace in zip(last["traces"], last["data"], strict=True)}
    wire, at = now["auxiliary wire"], now["force now"]["x"][0]
    assert np.ptp(result.snapshots["catenary.line_profile.auxiliary_uplift"].values[-1]) > 0.02  # m
    x, ends = (np.array(now["dropper"][n], dtype=float).reshape(-1, 3) for n in "xy")
    near = np.abs(x[:, 0] - at) < 50.0
    off = np.abs(ends[near, :2] - np.interp(x[near, 0], wire["x"], wire["y"])[:, None]).min(axis=1)
    assert near.sum() > 20
    assert off.max() < 5e-3  # of either row: points of the wire, which is kinked there, are 1 m apart
