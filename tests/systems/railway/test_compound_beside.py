"""Compound catenaries in an overlap, with two contact wires and with stitch wires: against networks of strings, and against lines
that must move alike."""

import csv

import numpy as np
import pytest
from cosimo import BadInput
from cosimo.components.railway.line.dropper_table import with_droppers
from cosimo.components.railway.line.form import find_form
from cosimo.components.railway.line.later import line_at
from cosimo.components.railway.line.table import read_line
from cosimo.components.railway.statics import elasticity
from cosimo.orchestrator.systems.railway.line import read, save, text_drawing
from cosimo.tests.systems.railway.network import G, Network
from cosimo.tests.systems.railway.test_compound import AUXILIARY, COMPOUND, CONTACT, EFFECTS, MESSENGER, catenary, parameters

SPANS, LEVEL = "spans = [50, 50, 50]", "spans = [50, 50, 50, 50]"
HELD = "{ contact_height = 0.5, held = true, contact_stiffness = 5e4 }"
ENDS = COMPOUND.replace(SPANS, f"{LEVEL}\nsupports = [0.0, 0.0, {{ contact_height = 0.06, system_height = 1.4 }}, {HELD}, 0.9]")
BEGINS = COMPOUND.replace(SPANS, f"start = 100\n{LEVEL}\nsupports = [0.9, {HELD}, 0.06, 0.0, 0.0]").replace(
    "first = 2.5, gap = 5.0", "first = 3.0, gap = 4.5"
)
OVERLAP = ENDS + BEGINS.replace(
    "height = 0.15", "height = 0.2"
)  # the second section with droppers and an auxiliary wire of its own
TWIN = COMPOUND.replace("support =", "second_contact_wire = { tension = 12e3, mass = 1.07 }\nsupport =").replace(
    "spans = [50,", "spans = [{ length = 50, second_positions = [4, 15, 21, 35, 48] },"
)
STITCH = "stitch = { half_length = 7, tension = 2e3, mass = 0.3 }\nsupport ="
STITCHED = COMPOUND.replace("support =", STITCH)
# lanes of a mesh -> wires of a network
LANES = {
    OVERLAP: ({0: "c", 1: "m", 4: "a"}, {2: "c", 3: "m", 5: "a"}),
    TWIN: ({0: "c", 1: "m", 2: "d", 3: "a"},),
    STITCHED: ({0: "c", 1: "m", 2: "y", 3: "a"},),
}
TWO = (*EFFECTS, "second_wire")


def networks(text, form, places=(), worn=0.0, warm=None, held=False):
    """A network for each section of cut droppers. places: extra points of the contact wires. held: messengers at their supports.

    worn: share of the contact wires gone since; warm: tension of the auxiliary wire of the last section in place of its own.
    """
    nets, d, supports = [], form.layout.droppers, 0
    x = [np.arange(0.0, 201.0, 50.0), np.arange(100.0, 301.0, 50.0)] if text == OVERLAP else [np.arange(0.0, 151.0, 50.0)]
    for number, (lanes, at) in enumerate(zip(LANES[text], x, strict=True)):
        net, mine = Network(), np.isin(d.lower, list(lanes))
        names = [(lanes[low], lanes[up]) for low, up in zip(d.lower[mine], d.upper[mine], strict=True)]
        position, inside = d.position[mine], [p for p in places if at[0] < p < at[-1]]
        clamps = [(s - 7.0, s + 7.0) for s in at[1:-1]] if text == STITCHED else []

        def on(*wires, names=names, position=position):
            return [p for p, ends in zip(position, names, strict=True) if set(ends) & set(wires)]

        def less(place, clamps=clamps):
            return -2e3 if any(a < place < b for a, b in clamps) else 0.0

        ends, last = [at[0], at[-1]], number == len(x) - 1
        steady = list(at[1:-1]) if text == OVERLAP else []  # where a contact wire may be held
        net.wire("c", [*ends, *on("c"), *inside, *steady], CONTACT[0], G * CONTACT[1] * (1.0 - worn))
        if text == TWIN:
            net.wire("d", [*ends, *on("d"), *inside], 12e3, G * 1.07 * (1.0 - worn))
        net.wire("a", [*ends, *on("a")], warm if warm and last else AUXILIARY[0], G * AUXILIARY[1])
        net.wire("m", [*at, *on("m"), *(p for pair in clamps for p in pair)], MESSENGER[0], G * MESSENGER[1], inside=less)
        for k, (a, b) in enumerate(clamps):
            net.wire(f"y{k}", [a, b, *(p for p in on("y") if a < p < b)], 2e3, G * 0.3, ends=(("m", a), ("m", b)))

        def point(wire, p, clamps=clamps):
            return (f"y{next(k for k, (a, b) in enumerate(clamps) if a < p < b)}" if wire == "y" else wire, round(float(p), 6))

        for (low, up), p, i in zip(names, position, np.flatnonzero(mine), strict=True):
            weights = G * np.array([d.mass_below[i], d.mass_above[i]])
            net.droppers.append((point(low, p), point(up, p), d.stiffness[i], form.cut_length[i], weights))
        levels = ((0.0, 0.9), (0.9, 0.0))[number] if text == OVERLAP else (0.0, 0.0)
        above = {"c": 0.0, "d": 0.0, "a": 0.2 if number else 0.15, "m": 1.5}
        for end, level in zip(ends, levels, strict=True):
            net.fixed |= {(wire, end): level + above[wire] for wire in set(lanes.values()) - {"y"}}
        own = slice(supports, supports + at.size - 2)
        supports += at.size - 2
        rests = zip(form.support[own], form.rest_height[own], form.reaction[own], strict=True)
        for s, rest, reaction in rests:
            if held:
                net.fixed["m", s] = rest - reaction / 500e3
            else:
                net.springs.append((("m", s), 500e3, rest))
        for (s, lane), force in zip(form.held, form.contact_force, strict=True):
            if lanes.get(int(lane)) == "c" and held:
                net.fixed["c", s] = 0.5
            elif lanes.get(int(lane)) == "c":
                net.springs.append((("c", s), 5e4, 0.5 + force / 5e4))
        nets.append((net, mine, [point(low, p) for (low, _), p in zip(names, position, strict=True)]))
    return nets


@pytest.mark.interpreted
@pytest.mark.parametrize("text", LANES)
def test_wires_and_tensions_are_those_of_networks(text):
    """Cut lengths of form finding, on strings: heights as wanted, tensions as told; the mesh has the same ones."""
    form = find_form(read_line(text), parameters())
    assert sum(mine.sum() for _, mine, _ in networks(text, form)) == form.preload.size
    for net, mine, clamps in networks(text, form):
        heights, tension = net.solve()
        assert tension == pytest.approx(form.preload[mine], rel=1e-6)
        clamp = 120.0 / 1e10 if text == STITCHED else 0.0  # m: what holds the ends of stitch wires gives way by
        assert [heights[p] for p in clamps] == pytest.approx(form.layout.droppers.height[mine], abs=1e-8 + clamp)
    assert catenary(text, TWO).mesh.preload == pytest.approx(form.preload, rel=1e-9)
    assert ("~ auxiliary or stitch" if text == STITCHED else "~ auxiliary  ") in text_drawing(form)


@pytest.mark.parametrize(
    ("text", "wire", "places", "force"),
    [
        (OVERLAP, 0, (72.5, 121.0, 133.0), 150.0),
        (OVERLAP, 1, (167.0, 178.3, 227.5), 150.0),
        (OVERLAP, 1, (171.0,), 900.0),
        (TWIN, 0, (60.0, 72.5), 150.0),
        (TWIN, 1, (28.0, 72.5), 150.0),
        (TWIN, 1, (28.0,), 900.0),
        (STITCHED, 0, (50.0, 60.0, 72.5), 150.0),
    ],
)
def test_elasticity_is_that_of_networks(text, wire, places, force):
    """Of each contact wire; under 900 N droppers are slack."""
    net, _, _ = networks(text, find_form(read_line(text), parameters()), places)[wire if text == OVERLAP else 0]
    name = "d" if text == TWIN and wire else "c"
    rest, _ = net.solve()
    expected = []
    for p in places:
        moved, tension = net.solve({(name, p): force})
        assert force < 500.0 or (tension == 0.0).sum() > 2
        expected.append((moved[name, p] - rest[name, p]) / force)
    assert elasticity(catenary(text, TWO, element=0.1).mesh, places, force, wire=wire) == pytest.approx(expected, rel=4e-3)


@pytest.mark.interpreted
@pytest.mark.parametrize("change", [0.0, 25.0])
def test_worn_and_warm_overlaps_keep_their_cut_lengths(change):
    """The auxiliary wire of the second section alone is anchored at both ends; a fifth of both contact wires is gone."""
    text = ENDS + BEGINS.replace("height = 0.15", "height = 0.2, fixed = true, axial_stiffness = 18e6")
    new = find_form(read_line(text), parameters())
    line, later = line_at(read_line(text), parameters(), change, 0.2)
    first, second = (section.auxiliary.tension for section in line.sections)
    assert first == AUXILIARY[0]
    assert second != AUXILIARY[0]
    kept = []
    for form, worn, tension in ((new, 0.0, AUXILIARY[0]), (later, 0.2, second)):
        nets = networks(OVERLAP, new, (), worn, tension, held=True)
        for (net, mine, _), height in zip(nets, (0.9, 0.0), strict=True):
            heights, pull = net.solve()
            assert height in {z for (wire, _), z in net.fixed.items() if wire == "c"}
            assert pull == pytest.approx(form.preload[mine], rel=2e-3)
        x = np.array(sorted(p for wire, p in heights if wire == "a"))
        rise, L = np.diff([heights["a", p] for p in x]), np.diff(x)
        excess = np.sum(0.5 * rise**2 / L + (G * AUXILIARY[1]) ** 2 * L**3 / (24.0 * tension**2)) / 200.0
        kept.append(tension / 18e6 - excess)
    assert kept[1] - kept[0] == pytest.approx(-1.7e-5 * change, abs=1e-9)


def passage(text, effects=TWO, shift=0.0, wire=0, shares=(1.0,), **values):
    """Heights of a contact wire under 400 N for 0.3 s from 120 m on, at 60 m/s, with slack droppers; shares: of the wires' forces."""
    made = catenary(text, effects, 120.0 - shift, **values)
    ports = ("contact_force", "second_wire.contact_force[1]")[wire : wire + len(shares)]
    for port, share in zip(ports, shares, strict=True):
        made.set(port, share * 400.0)
    heights = []
    for k in range(150):
        made.set("contact_position", 120.0 - shift + 0.12 * k)
        made.step(2e-3 * k, 2e-3)
        heights.append(made["second_wire.wire_height[1]" if wire else "wire_height"])
    return np.array(heights)


@pytest.mark.parametrize("wire", [0, 1])
def test_a_section_of_an_overlap_moves_as_it_does_alone(wire):
    """Its three wires in their lanes beside those of the other, and as a line of its own; the other section's force is 0."""
    sections = ENDS, BEGINS.replace("first = 3.0, gap = 4.5", "first = 2.5, gap = 5.0")
    alone = passage(sections[wire].replace("start = 100\n", ""), EFFECTS, shift=100.0 * wire)
    level = 0.9 if wire else 0.0  # from which heights count
    beside = passage("".join(sections), wire=wire)
    assert np.ptp(alone) > 0.02
    assert beside == pytest.approx(alone + level, abs=1e-9)


@pytest.mark.parametrize(("method", "element", "share"), [("implicit", 1.0, 1e-3), ("explicit", 0.25, 3e-4)])
def test_two_halves_of_a_contact_wire_move_as_the_whole(method, element, share):
    """Half of the tension, the mass and the droppers each, half of the force on each: a known line, with slack droppers.

    What is left goes with the element: of the auxiliary wire's yielding below a node, one dropper knows nothing of the other there.
    """
    halves = "contact_wire = { tension = 7.35e3, mass = 0.7555 }\nsecond_contact_wire = { tension = 7.35e3 }\n"
    text = COMPOUND.replace("contact_wire = { tension = 14.7e3, mass = 1.511 }\n", halves).replace(
        "droppers = { first = 2.5, gap = 5.0, stiffness = 150e3, contact_clamp = 0.165, messenger_clamp = 0.18 }",
        "droppers = { first = 2.5, gap = 5.0, stiffness = 75e3, contact_clamp = 0.0825, messenger_clamp = 0.09 }",
    )
    whole, halved = (passage(*a, method=method, element=element) for a in ((COMPOUND, EFFECTS), (text, TWO, 0.0, 0, (0.5, 0.5))))
    assert np.abs(halved - whole).max() < share * np.ptp(whole)


@pytest.mark.parametrize(("text", "place"), [(OVERLAP, 165.0), (TWIN, 75.0), (STITCHED, 75.0)])
def test_ice_that_falls_gives_no_energy(text, place):
    """2 kN downwards gone at once from every contact wire: wires fly up, droppers of both rows are slack for a while."""
    made = catenary(text, TWO, place, -2000.0, element=1.0)
    made.set("second_wire.contact_force[1]", -2000.0 if text != STITCHED else 0.0)
    made.initialize(0.0)
    start, mesh, slack, energy = made.energy(), made.mesh, set(), []
    made.set("contact_force", 0.0)
    made.set("second_wire.contact_force[1]", 0.0)
    W = mesh.bending_gradient.size
    for k in range(100):
        made.step(2e-3 * k, 2e-3)
        q = made.motion[0]
        pull = mesh.preload + mesh.dropper_stiffness * (q[mesh.upper] - q[mesh.lower])
        slack |= set((mesh.lower % W)[pull < 0.0].tolist())
        energy.append(made.energy())
    assert slack == set(np.unique(mesh.lower % W).tolist())
    assert energy == pytest.approx(np.full(100, start), rel=1e-3)


@pytest.mark.interpreted
@pytest.mark.parametrize("text", LANES)
def test_droppers_as_a_table_are_read_back(text, tmp_path):
    """By heights and by cut lengths; the auxiliary wire of an overlap's second section hangs from the second messenger."""
    line = read_line(text)
    form = find_form(line, parameters())
    table = save(form, "compound", tmp_path)[0].read_text(encoding="utf-8")
    rows = list(csv.DictReader(table.splitlines()))
    above = {row["hangs from"] for row in rows if row["contact wire"] == ""}
    assert above == {OVERLAP: {"messenger", "second messenger"}, TWIN: {"messenger"}, STITCHED: {"messenger", "stitch"}}[text]
    by_length = "\n".join([",".join(rows[0]), *(",".join("" if k == "height [m]" else v for k, v in r.items()) for r in rows)])
    for given, within in ((table, 1e-9), (by_length, 1e-6)):
        again = find_form(with_droppers(line, given, "mine"), parameters())
        assert again.preload == pytest.approx(form.preload, rel=within)
        assert again.layout.droppers.height == pytest.approx(form.layout.droppers.height, abs=2e-8)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (OVERLAP, "second messenger", "messenger", "contact wire 1 at 2.* that hangs from 'messenger'"),
        (OVERLAP, "second messenger", "third messenger", "contact wire 1 at 2.* that hangs from 'third messenger'"),
        (TWIN, "2,auxiliary", "2,messenger", "hangs from 'messenger'.*auxiliary"),
    ],
)
def test_rows_that_no_dropper_has(text, old, new, message, tmp_path):
    table = save(find_form(read_line(text), parameters()), "compound", tmp_path)[0].read_text(encoding="utf-8")
    with pytest.raises(BadInput, match=message):
        find_form(with_droppers(read_line(text), table.replace(old, new), "mine"), parameters())


@pytest.mark.interpreted
def test_a_dropper_that_pushes_is_named_by_its_wire(tmp_path):
    (tmp_path / "line.toml").write_text(OVERLAP.replace("0.5, held", "2.5, held"), encoding="utf-8")
    with pytest.raises(BadInput, match=r"\(contact wire 2\)|\(auxiliary\)"):
        read(tmp_path / "line.toml", {})


@pytest.mark.interpreted
def test_two_contact_wires_in_several_sections_are_refused():
    with pytest.raises(BadInput, match="a head would touch four wires"):
        find_form(read_line(OVERLAP.replace("support =", "second_contact_wire.tension = 1e4\nsupport =")), parameters())
