"""Lines from tables: form finding and elasticity against a network of strings, closed forms and a published drawing."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.contact import contact_compliance, wire_height
from cosimo.components.railway.line.form import find_form, form_of
from cosimo.components.railway.line.from_table import resolved_sections
from cosimo.components.railway.line.plan import arm_of
from cosimo.components.railway.line.table import read_line, schema
from cosimo.components.railway.statics import Statics, elasticity
from cosimo.tests.support import initialized
from cosimo.tests.systems.railway.network import G, Network

pytestmark = pytest.mark.interpreted

WIRES = """
contact_wire = { tension = 22e3, mass = 1.35 }
messenger = { tension = 16e3, mass = 1.08 }
droppers.first = 4.5
droppers.gap = 6.5
droppers.axial_stiffness = 200e3
droppers.mass_per_length = 0.117
droppers.contact_clamp = 0.165
droppers.messenger_clamp = 0.195
"""
UNEQUAL = (
    "[[sections]]"
    + WIRES
    + """
span = { relative_sag = 0.001 }
support = { system_height = 1.2, stiffness = 500e3 }
spans = [50, 65, 55, 45, 60, 50]
supports = [5.30, 5.30, 5.30, 5.25, { contact_height = 5.20, system_height = 1.0 }, 5.20, 5.20]
"""
)
STITCHED = """
[[sections]]
contact_wire = { tension = 27e3, mass = 1.07 }
messenger = { tension = 21e3, mass = 1.06 }
stitch = { half_length = 9.0, tension = 3500.0, mass = 0.31 }
droppers = { stiffness = 200e3, mass = 0.0, contact_clamp = 0.165, messenger_clamp = 0.195 }
support = { system_height = 1.8, stiffness = 500e3 }
span = { positions = [5.0, 14.1666667, 23.3333333, 32.5, 41.6666667, 50.8333333, 60.0] }
spans = [{ length = 65.0, repeat = 9 }]
"""


def parameters():
    return Catenary()._declared_arguments()[0]


def form(text):
    return find_form(read_line(text), parameters())


def catenary(text, effects=("dropper_slackening", "gravity_sag"), **values):
    values = {"line_table.table": text, "method": "implicit", "first_watched_support": 0} | values
    return initialized(Catenary((*effects, "line_table"), values), {"contact_position": 80.0})


def network(text, places=(), wires=((22e3, 1.35), (16e3, 1.08)), stitch=None, supports=500e3):
    """The line of a table by the network, with the cut lengths that form finding gives; places: extra points of contact wires."""
    found = form(text)
    section, d = resolved_sections(read_line(text))[0], found.layout.droppers
    z = np.array([s.contact_height for s in section.supports]) - section.supports[0].contact_height
    top = z + np.array([s.system_height for s in section.supports])
    net, x = Network(), section.x
    clamps = [] if stitch is None else [c for s in x[1:-1] for c in (s - stitch[0], s + stitch[0])]
    under = [stitch is not None and min(abs(x[1:-1] - p)) < stitch[0] for p in d.position]
    contacts = {0: "c"} | ({2: "d"} if 2 in d.lower else {})
    for lane, contact in contacts.items():
        net.wire(contact, [x[0], x[-1], *d.position[d.lower == lane], *places], wires[0][0], G * wires[0][1])
    inside = (lambda p: -stitch[1] if min(abs(x[1:-1] - p)) < stitch[0] else 0.0) if stitch else (lambda p: 0.0)
    net.wire("m", [*x, *clamps, *d.position[~np.array(under)]], wires[1][0], G * wires[1][1], inside)
    for s in x[1:-1] if stitch else ():
        a, b = s - stitch[0], s + stitch[0]
        mine = [p for p in d.position if a < p < b]
        net.wire(f"y{s:g}", [a, *mine, b], stitch[1], G * stitch[2], ends=(("m", round(a, 6)), ("m", round(b, 6))))

    def upper(p, below_stitch):
        name = f"y{x[1:-1][np.argmin(abs(x[1:-1] - p))]:g}" if below_stitch else "m"
        return name, round(p, 6)

    for i, p in enumerate(d.position):
        weights = G * np.array([d.mass_below[i], d.mass_above[i]])
        ends = (contacts[d.lower[i]], round(p, 6)), upper(p, under[i])
        net.droppers.append((*ends, d.stiffness[i], found.cut_length[i], weights))
    for end in (0, -1):
        net.fixed |= {("m", x[end]): top[end]} | {(contact, x[end]): z[end] for contact in contacts.values()}
    net.springs = [(("m", s), supports, rest) for s, rest in zip(x[1:-1], found.rest_height, strict=True)]
    return net, found


TWIN = """
[[sections]]
contact_wire = { tension = 18.75e3, mass = 1.335 }
second_contact_wire = { tension = 18.75e3 }
messenger = { tension = 30e3, mass = 2.16 }
droppers = { stiffness = 100e3, contact_clamp = 0.165 }
support = { system_height = 1.4, stiffness = 500e3 }
span.positions = [4, 14, 22, 30, 38, 46, 56]
span.second_positions = [8, 18, 26, 34, 42, 50, 60]
spans = [64, 64, 64, 64, 64, 64, 64]
"""
TWIN_WIRES = {"wires": ((18.75e3, 1.335), (30e3, 2.16))}

CASES = {"unequal": (UNEQUAL, {}), "stitched": (STITCHED, {"wires": ((27e3, 1.07), (21e3, 1.06)), "stitch": (9.0, 3500.0, 0.31)})}


@pytest.mark.parametrize("name", CASES)
def test_a_line_cut_as_form_finding_says_hangs_as_was_wanted(name):
    """Droppers of the cut lengths and springs at the rest heights bring wires and tensions where they were to be."""
    text, more = CASES[name]
    net, found = network(text, **more)
    heights, tension = net.solve()
    assert tension == pytest.approx(found.preload, rel=1e-6)
    d = found.layout.droppers
    assert [heights["c", round(p, 6)] for p in d.position] == pytest.approx(d.height, abs=1e-8)
    supports = [heights["m", p] for p in found.support]
    assert supports == pytest.approx(found.layout.holds.height[~np.isnan(found.layout.holds.height)], abs=1e-8)


@pytest.mark.known_answers(Catenary="line_table")
@pytest.mark.parametrize(
    ("name", "places"), [("unequal", [50.0, 75.0, 82.5, 115.0, 140.3, 245.7]), ("stitched", [260.0, 268.0, 280.0, 288.5])]
)
@pytest.mark.parametrize("force", [100.0, 200.0])
@pytest.mark.first(2)
def test_elasticity_of_a_table_is_that_of_the_network(name, places, force):
    """Uplift of the loaded, unilateral line; what is left is the kink's place in an element, or short waves at droppers."""
    text, more = CASES[name]
    net, _ = network(text, places, **more)
    rest, _ = net.solve()
    expected = [(net.solve({("c", p): force})[0]["c", p] - rest["c", p]) / force for p in places]
    assert elasticity(catenary(text, element=0.1).mesh, places, force) == pytest.approx(expected, rel=4e-3)


@pytest.mark.known_answers(Catenary="second_wire")
@pytest.mark.first
@pytest.mark.parametrize("forces", [(100.0, 0.0), (60.0, 40.0), (150.0, 150.0)])
def test_two_wires_share_a_force_as_in_the_network(forces):
    """Heights of both contact wires of a twin under a force on each."""
    places = [195.1, 211.2, 224.0, 231.7]
    net, _ = network(TWIN, places, **TWIN_WIRES)
    made = catenary(TWIN, ("dropper_slackening", "gravity_sag", "second_wire"), element=0.1)
    rest, _ = net.solve()
    for place in places:
        heights, _ = net.solve({("c", place): forces[0], ("d", place): forces[1]})
        q, _, _ = Statics(made.mesh).under([(place, forces[0], 0), (place, forces[1], 1)], True)
        for wire, name in enumerate("cd"):
            at_rest = wire_height(place, 0.0 * q, wire, made.mesh)
            assert at_rest == pytest.approx(rest[name, place], abs=2e-6)
            own = contact_compliance(0.0, place, wire, made.mesh) * forces[wire]
            uplift = wire_height(place, q, wire, made.mesh) - at_rest + own
            assert uplift == pytest.approx(heights[name, place] - rest[name, place], rel=5e-3)


def test_lengths_are_those_of_a_published_drawing():
    """AC simple of EN 50318:2018; lengths read in a public repository, rounded to the millimetre there."""
    found = form(
        "[[sections]]" + WIRES + "span = { sag = 0.055 }\nsupport = { system_height = 1.2, stiffness = 500e3 }\n"
        "spans = [{ length = 55.0, repeat = 9 }]"
    )
    inside = (found.layout.droppers.position > 220.0) & (found.layout.droppers.position < 275.0)
    published = [1.017, 0.896, 0.810, 0.758, 0.741, 0.758, 0.810, 0.896, 1.017]
    assert found.length[inside] == pytest.approx(published, abs=7e-4)


def test_dropper_lengths_and_reactions_of_an_uneven_line():
    """Numbers of an independent script (strings, exact parabolas), printed to 0.1 mm and 0.1 N."""
    found = form(UNEQUAL)
    x = found.layout.droppers.position
    spans = [(x > a) & (x < b) for a, b in ((50.0, 115.0), (170.0, 215.0))]
    assert found.length[spans[0]] == pytest.approx(
        [0.9825, 0.8058, 0.6733, 0.5849, 0.5406, 0.5403, 0.5841, 0.6720, 0.8039, 0.9801], abs=6e-5
    )
    assert found.length[spans[1]] == pytest.approx([1.0311, 0.9261, 0.8526, 0.8107, 0.8004, 0.8217, 0.8745], abs=6e-5)
    assert found.reaction[:4] == pytest.approx([1408.8, 1505.6, 1306.2, 1122.3], abs=0.06)
    at_clamp = found.preload - 0.5 * G * 0.117 * found.length  # half of the dropper hangs below its middle
    assert at_clamp[spans[0]][[0, 4, -1]] == pytest.approx([193.21, 61.32, 203.21], abs=0.01)


def test_the_messenger_inside_a_stitch_carries_less():
    """Lengths of an independent script; with the full tension inside they would be 58 mm longer."""
    found = form(STITCHED)
    x = found.layout.droppers.position
    inside = (x > 260.0) & (x < 293.0)
    assert found.length[inside] == pytest.approx([1.3111, 1.3395, 1.2118, 1.1692], abs=6e-5)
    assert found.preload[inside] == pytest.approx([102.21, 97.84, 97.84, 97.84], abs=6e-3)
    assert found.reaction[3] == pytest.approx(1437.7, abs=0.06)
    clamp = found.height[np.searchsorted(found.position, 269.0 - 1e-6), 1]
    assert 1.8 - clamp == pytest.approx(0.3456, abs=6e-5)


def test_a_parabola_takes_its_curvature_off_the_droppers():
    """Inner droppers lose 8 T d / D² per metre: closed form of a string."""
    flat, bowed = (
        form("[[sections]]" + WIRES + f"span.sag = {d}\nsupport.stiffness = 500e3\nspans = [55, 55, 55]") for d in (0.0, 0.055)
    )
    inner = slice(10, 17)
    lost = flat.preload[inner] - bowed.preload[inner]
    longer = 0.5 * G * 0.117 * (flat.length[inner] - bowed.length[inner])
    assert lost - longer == pytest.approx(np.full(7, 22e3 * 8.0 * 0.055 / 46.0**2 * 5.75), rel=1e-9)


def test_an_even_gradient_changes_no_dropper():
    level, steep = (
        form(
            "[[sections]]"
            + WIRES
            + "spans = [55, 45, 60]\nsupports = ["
            + ", ".join(str(5.3 + g * x) for x in (0.0, 55.0, 100.0, 160.0))
            + "]"
        )
        for g in (0.0, 0.004)
    )
    assert steep.preload == pytest.approx(level.preload, rel=1e-9)
    assert steep.length == pytest.approx(level.length, abs=1e-9)


def test_a_change_of_gradient_loads_the_droppers_around_it():
    """- T times the change, over the two droppers beside the support."""

    def preload(heights):
        return form("[[sections]]" + WIRES + f"spans = [55, 55, 55, 55]\nsupports = {heights}").preload

    change = 0.005
    rise = preload([5.0, 5.0, 5.0, 5.0 + change * 55, 5.0 + change * 110])
    flat = preload([5.0] * 5)
    assert (rise - flat).sum() == pytest.approx(-22e3 * change, abs=0.2)  # less a little dropper weight
    around = slice(17, 19)  # the droppers beside the support at 110 m
    assert (rise - flat)[around].sum() == pytest.approx(-22e3 * change, rel=0.01)


def test_a_uniform_table_is_the_uniform_catenary():
    """The same line in both forms: masses, preloads, stiffnesses and heights of the mesh agree."""
    table = "[[sections]]\nspans = [60, 60, 60, 60]\nspan.positions = [5, 10.5, 17, 23.5, 30, 36.5, 43, 49.5, 55]"
    uniform = Catenary(["gravity_sag"], {"spans": 4, "method": "implicit"})
    uniform.initialize(0.0)
    both = uniform.mesh, catenary(table, ("gravity_sag",)).mesh
    for name in ("position", "mass", "tension", "curvature", "ground", "dropper_stiffness", "preload", "height", "bow"):
        assert getattr(both[1], name) == pytest.approx(getattr(both[0], name), rel=1e-12, abs=1e-15), name


STAGGERED = """
[[sections]]
contact_wire.tension = 22e3
support.arm = { length = 1.2, angle = 10.0, mass = 0.9 }
spans = [55, 55, 55, 55]
supports = [{ stagger = 0.2 }, { stagger = -0.2 }, { stagger = 0.2 }, { stagger = -0.2 }, { stagger = 0.2 }]
"""


@pytest.mark.known_answers(Catenary="stagger")
def test_lateral_position_is_that_of_the_table():
    made = catenary(STAGGERED, ("stagger",))
    for x, expected in ((55.0, -0.2), (82.5, 0.0), (110.0, 0.2), (68.75, -0.1)):
        made.set("contact_position", x)
        made.refresh()
        assert made["stagger.lateral_position"] == pytest.approx(expected, abs=1e-12)


def test_stagger_pulls_at_the_arms():
    """4 b T / L = 320 N for 0.2 m, 55 m, 22 kN; no force at the anchors. The arm's stiffness is F / (l cos³ phi)."""
    layout = form(STAGGERED).layout
    assert np.abs(layout.lateral_force) == pytest.approx([0.0, 320.0, 320.0, 320.0, 0.0], abs=1e-9)
    arms = layout.holds.lane == 0
    assert layout.holds.stiffness[arms] == pytest.approx(np.full(3, 320.0 / 1.2 / np.cos(np.radians(10.0)) ** 3))
    assert layout.holds.mass[arms] == pytest.approx(np.full(3, 0.3))
    assert layout.holds.lift[arms] == pytest.approx(np.full(3, 320.0 * np.tan(np.radians(10.0)) - 0.5 * G * 0.9))


def test_an_arm_swings_about_its_hinge_as_its_stiffness_says():
    """Exact statics of a rod with a lateral force at its end: height against vertical force, by moments about the hinge."""
    length, force, phi = 1.2, 320.0, np.radians(10.0)
    _, stiffness, _, _ = arm_of(force, length, phi, 0.0)
    angles = phi + np.array([-1e-4, 1e-4])
    heights, vertical = -length * np.sin(angles), force * np.tan(angles)
    assert stiffness == pytest.approx(-np.diff(vertical)[0] / np.diff(heights)[0], rel=1e-6)
    assert [arm_of(force, length, np.radians(a), 0.0)[1] for a in (5.0, 10.0, 20.0)] == pytest.approx(
        [270.0, 279.0, 321.0], abs=0.8
    )


def test_an_arm_that_carries_more_unloads_the_first_droppers():
    """Its lift is taken off the droppers beside the support, as a force on the wire between them."""
    lifted, bare = form(STAGGERED), form(STAGGERED.replace("angle = 10.0, ", ""))
    x = lifted.layout.droppers.position
    beside = np.abs(x - 110.0) < 6.0
    lift = 320.0 * np.tan(np.radians(10.0)) - 0.5 * G * 0.9
    assert (bare.preload - lifted.preload)[beside].sum() == pytest.approx(lift, rel=1e-9)


def test_an_arm_is_a_spring_beside_the_compliance_of_the_wire():
    """Elasticity at a support with arms e / (1 + k e), but for what the other arms take."""
    bare = catenary(STAGGERED.replace("support.arm = { length = 1.2, angle = 10.0, mass = 0.9 }", ""), ())
    stiff = catenary(STAGGERED, ())
    e, held = (elasticity(m.mesh, [110.0], 50.0, unilateral=False)[0] for m in (bare, stiff))
    assert held == pytest.approx(e / (1.0 + 279.2 * e), rel=0.02)
    assert held < e


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("spans = [50]", "key 'spans'"),
        ("[[sections]]", "at least one span"),
        ("[[sections]]\nspans = [50, 'x']", r"spans\[2\].*a table"),
        ("[[sections]]\nspans = [{ length = -3 }]", r"length: got -3, expected a value in \[1"),
        ("[[sections]]\nspans = [4294967296]", r"expected a value in \[1, 1000\] m"),
        ("[[sections]]\nspans = [50, 50]\ndroppers.gap = 0.01", "droppers 0.01 m apart, expected at most 200"),
        ("[[sections]]\nspans = [{ length = 50, repeat = 2001 }]", r"repeat: got 2001, expected a value in \[1, 2000\]"),
        ("[[sections]]\nspans = [50, 50]\nsupports = [5.3]", "1 for 2 spans"),
        ("[[sections]]\nspans = [{ length = 50, positions = [40, 20] }]", "increasing positions"),
        ("[[sections]]\nspans = [{ length = 50, positions = [20], heights = [0, 0] }]", "2 for 1 droppers"),
        ("[[sections]]\nspans = [{ length = 50, sagg = 0.1 }]", "Did you mean 'sag'"),
        ("[[sections]]\nspans = [50, 50]\nstitch = { half_length = 9 }", "without tension or mass"),
        ("[[sections]\nspans", "syntax error"),
        ("[[sections]]\nspans = [" + 5000 * "5" + "]", "syntax error"),
        ("[[sections]]\nspans = [" + 400 * "5" + "]", r"spans\[1\].*a number in m"),
        ("[[sections]]\nspans = [50, 50]\nsupport = { system_height = 0.2 }", "above the lower one"),
        ("[[sections]]\nspans = [50]\n[[sections]]\nstart = 70.0\nspans = [50]", "a position in section 1"),
        ("[[sections]]\nspans = [50]\ndroppers = { stiffness = 1e5, axial_stiffness = 2e5 }", "only one would have an effect"),
        ("[[sections]]\nspans = [{ length = 50, positions = [20], heights = [0], sag = 0.1 }]", "heights and sag"),
        ("[[sections]]\nspans = [50, 50]\nsupports = [5, 5, { stiffness = 1e5 }]", r"supports\[3\].stiffness.*anchor"),
        ("[[sections]]\nspans = [50, 50]\nsupport.arm = { angle = 10 }", "arm: got no length"),
        ("[[sections]]\nspans = [50, 50]\nstitch = { tension = 3e3, mass = 0.3 }", "stitch: got no half_length"),
        ("[[sections]]\nspans = [50, 50]\nsecond_contact_wire.mass = 1.3", "expected the tension of the second contact wire"),
        ("[[sections]]\nspans = [{ length = 50, dropper_list = [{ height = 1 }] }]", "without position"),
        ("[[sections]]\nspans = [{ length = 50, dropper_list = [20], positions = [20] }]", "dropper_list and positions"),
        (
            "[[sections]]\nspans = [{ length = 50, dropper_list = [{ position = 20, hangs_from = 'stitch' }] }]",
            "expected messenger",
        ),
        (
            "[[sections]]\nspans = [{ length = 50, dropper_list = [{ position = 20, height = 0, cut_length = 1.0 }] }]",
            "a cut length of 1 of the dropper at 20 m",
        ),
        ("[[sections]]\nspans = [{ length = 50, dropper_list = [{ position = 20, contact_wire = 2 }] }]", "second contact wire"),
    ],
)
def test_a_table_that_cannot_be_is_one_message(text, message):
    with pytest.raises(BadInput, match=message):
        form(text)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("some", [slice(None), slice(0, None, 3), slice(10, 20)])
def test_droppers_of_given_lengths_hang_where_the_network_has_them(name, some):
    """Cut by up to 0.6 mm from the wanted lengths, all of them or some beside droppers of wanted heights."""
    text, more = CASES[name]
    found = form(text)
    d, cut = found.layout.droppers, found.cut_length.copy()
    cut[some] += np.random.default_rng(3).uniform(-6e-4, 6e-4, cut[some].size)
    height = d.height.copy()
    height[some] = np.nan
    other = form_of(replace(found.layout, droppers=replace(d, height=height, cut_length=cut)))
    assert other.cut_length[some] == pytest.approx(cut[some], abs=1e-9)
    net, _ = network(text, **more)
    net.droppers = [(*row[:3], length, row[4]) for row, length in zip(net.droppers, other.cut_length, strict=True)]
    net.springs = [(*row[:2], rest) for row, rest in zip(net.springs, other.rest_height, strict=True)]
    heights, tension = net.solve()
    assert tension == pytest.approx(other.preload, rel=1e-6)
    assert np.abs(other.preload - found.preload).max() > 0.5
    assert [heights["c", round(p, 6)] for p in d.position] == pytest.approx(other.layout.droppers.height, abs=1e-8)
    assert np.array_equal(other.layout.droppers.height[~np.isnan(height)], d.height[~np.isnan(height)])


def test_droppers_of_a_table_one_by_one():
    """A length given as one found, a stiffness, a mass and clamps of one's own; what stays out comes from the section."""
    text = "[[sections]]" + WIRES + "spans = [50, { length = 50, dropper_list = [%s] }, 50]\nsupports = [5.3, 5.3, 5.4, 5.4]"
    rows = "5, {{ position = 15, height = 5.32, stiffness = 3e5 }}, {{ position = 30, {}, mass = 0.2 }}, 45"
    wanted = form(text % rows.format("height = 5.355"))
    k = int(np.flatnonzero(wanted.layout.droppers.position == 80.0)[0])
    assert wanted.layout.droppers.height[k - 2 : k + 2] == pytest.approx([0.01, 0.02, 0.055, 0.09], abs=1e-12)
    assert wanted.layout.droppers.stiffness[k - 1] == 3e5
    assert wanted.layout.droppers.mass_below[k] == pytest.approx(0.165 + 0.1)
    cut = form(text % rows.format(f"cut_length = {wanted.cut_length[k]:.15g}"))
    assert cut.layout.droppers.height == pytest.approx(wanted.layout.droppers.height, abs=1e-9)
    assert cut.preload == pytest.approx(wanted.preload, abs=1e-6)


def test_what_a_span_says_of_its_droppers_rules_over_the_section():
    """Also where it says it in another way: a stiffness over the section's EA, a length without sag over a relative one."""
    said = "spans = [50, { length = 50, droppers.stiffness = 3e5, droppers.mass = 0.0, sag = 0.0 }]"
    layout = form("[[sections]]" + WIRES + "span.relative_sag = 0.001\n" + said).layout
    right = layout.droppers.position > 50.0
    assert set(layout.droppers.stiffness[right]) == {3e5}
    assert set(layout.droppers.mass_below[right]) == {0.165}
    assert np.abs(layout.droppers.height[right]).max() < 1e-12
    assert layout.droppers.height[~right].min() < -0.045
    assert layout.droppers.mass_below[~right].min() > 0.165


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"span_length": 60.0}, "span_length = 60.0"),
        ({"dropper_position[2]": 11.0, "spans": 3}, r"dropper_position\[2\] = 11.0"),
        ({"contact_wire_tension": 25e3}, "contact_wire_tension = 25000.0.*in every place"),
        ({"dropper_stiffness": 1e5}, "dropper_stiffness = 100000.0"),
        ({"bending_stiffness.contact_wire": 195.0}, "bending_stiffness.contact_wire"),
        ({"method": "explicit", "spectral_radius": 0.8}, "method 'explicit'"),
    ],
)
def test_a_parameter_that_a_table_leaves_no_use_for_is_refused(values, named):
    """In a scene with any value, elsewhere with another one than the default: a tool may write all parameters of an FMU."""
    table = UNEQUAL.replace("mass = 1.35", "mass = 1.35, bending = 195.0")
    effects = ["line_table", "bending_stiffness"]
    unit = {"component": "Catenary", "effects": effects, "parameters": {"line_table.table": table} | values}
    with pytest.raises(BadInput, match=named):
        read_scene({"stop_time": 0.1, "units": {"catenary": unit}, "master": {"step": 1e-3}})
    made = Catenary(effects, {"line_table.table": table, "method": "implicit"} | values)
    if made.parameters != Catenary(effects, {"line_table.table": table, "method": made["method"]}).parameters:
        with pytest.raises(BadInput, match="has no effect here"):
            made.initialize(0.0)


def test_a_parameter_that_a_table_leaves_out_somewhere_is_taken():
    """Messenger tension, support damping, and a dropper stiffness that one span leaves out."""
    table = "[[sections]]\ncontact_wire.tension = 22e3\nspans = [50, { length = 50, droppers.stiffness = 3e5 }]"
    values = {"dropper_stiffness": 1.5e5, "support_damping": 10.0, "messenger_tension": 17e3, "line_table.table": table}
    unit = {"component": "Catenary", "effects": ["line_table"], "parameters": values}
    read_scene({"stop_time": 0.1, "units": {"catenary": unit}, "master": {"step": 1e-3}})
    made = Catenary(["line_table"], values | {"method": "implicit"})
    made.initialize(0.0)
    assert set(made.form().layout.droppers.stiffness) == {1.5e5, 3e5}


def test_schema_names_every_key():
    row = schema()["properties"]["sections"]["items"]
    assert row["properties"]["spans"]["items"]["anyOf"][0] == {"type": "number"}
    assert row["properties"]["contact_wire"]["properties"]["tension"]["minimum"] == 1.0
    assert row["additionalProperties"] is False
