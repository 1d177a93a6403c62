"""An overlap of two sections by formulations of its own: networks of strings, one for each section, and impedances of wires."""

from functools import cache

import numpy as np
import pytest
from cosimo.components.railway.catenary import OUT, Catenary, put_outputs
from cosimo.components.railway.contact import contact_compliance, wire_height
from cosimo.components.railway.line.form import find_form
from cosimo.components.railway.line.from_table import resolved_sections
from cosimo.components.railway.line.table import read_line
from cosimo.components.railway.statics import elasticity
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.cases.en50318_2018 import CONTACT, first_share
from cosimo.tests.support import initialized
from cosimo.tests.systems.railway.network import G, Network

PLACES = (305.0, 330.3, 352.0, 366.7, 380.0, 393.3, 408.0, 429.7)
TENSION, MASS = (22e3, 16e3), (1.35, 1.08)


def table():
    return load_scene("overlap").units["catenary"].parameters["line_table.table"]


@cache
def catenary(element):
    return initialized(
        Catenary(
            ["dropper_slackening", "gravity_sag", "line_table", "second_wire"],
            {"line_table.table": table(), "method": "implicit", "element": element},
        ),
        {"contact_position": 380.0},
    )


def networks():
    """Both sections, with the cut lengths, rest heights and arms' forces of form finding. Heights count from 5.30 m."""
    found = find_form(read_line(table()), Catenary()._declared_arguments()[0])
    d, sections, inner = found.layout.droppers, [], 0
    for number, section in enumerate(resolved_sections(read_line(table()))):
        net, x = Network(), section.x
        mine = np.flatnonzero(d.lower == 2 * number)
        z = np.array([s.contact_height for s in section.supports]) - 5.30
        places = [p for p in PLACES if x[0] < p < x[-1]]
        net.wire("c", [*x, *d.position[mine], *places], TENSION[0], G * MASS[0])
        net.wire("m", [*x, *d.position[mine]], TENSION[1], G * MASS[1])
        for i in mine:
            at = round(float(d.position[i]), 6)
            weights = G * np.array([d.mass_below[i], d.mass_above[i]])
            net.droppers.append((("c", at), ("m", at), d.stiffness[i], found.cut_length[i], weights))
        for end in (0, -1):
            net.fixed |= {("c", x[end]): z[end], ("m", x[end]): z[end] + section.supports[end].system_height}
        own = slice(inner, inner + x.size - 2)
        inner += x.size - 2
        assert found.support[own] == pytest.approx(x[1:-1])
        net.springs = [(("m", s), 500e3, rest) for s, rest in zip(x[1:-1], found.rest_height[own], strict=True)]
        for (s, lane), force in zip(found.held, found.contact_force, strict=True):
            if lane == 2 * number:
                height = z[np.searchsorted(x, s)]
                net.springs.append((("c", s), 50e3, height + force / 50e3))
        sections.append((net, *net.solve()))
    return sections, found


def test_both_sections_hang_as_was_wanted():
    """With droppers cut and arms loaded as form finding says, clamps and held wires are where the table has them."""
    sections, found = networks()
    d = found.layout.droppers
    for number, (_, rest, tension) in enumerate(sections):
        mine = np.flatnonzero(d.lower == 2 * number)
        assert [rest["c", round(float(x), 6)] for x in d.position[mine]] == pytest.approx(d.height[mine], abs=1e-7)
        assert tension == pytest.approx(found.preload[mine], abs=1e-3)
        assert tension.min() > 0.0
        held = 460.0 if number == 0 else 300.0
        assert rest["c", held] == pytest.approx(0.5, abs=1e-7)  # 5.80 m
    mesh = catenary(0.2).mesh
    for place in PLACES:
        for wire, (_, rest, _) in enumerate(sections):
            assert wire_height(place, np.zeros(mesh.mass.size), wire, mesh) == pytest.approx(rest["c", place], abs=5e-6)


@pytest.mark.parametrize("force", [100.0, pytest.param(200.0, marks=pytest.mark.full)])
def test_elasticity_along_an_overlap_is_that_of_the_networks(force):
    sections, _ = networks()
    for wire, (net, rest, _) in enumerate(sections):
        expected = [(net.solve({("c", p): force})[0]["c", p] - rest["c", p]) / force for p in PLACES]
        assert elasticity(catenary(0.1).mesh, PLACES, force, wire=wire) == pytest.approx(expected, rel=4e-3)


@pytest.mark.parametrize("force", [100.0, pytest.param(250.0, marks=pytest.mark.full)])
def test_a_head_passes_from_wire_to_wire_as_in_the_networks(force):
    """The model's shares, put on the networks: both wires hold the head at one height, or the lower one carries all."""
    sections, _ = networks()
    mesh = catenary(0.1).mesh
    shares = []
    for place in PLACES:
        share = first_share(mesh, place, force)
        forces = share * force, (1.0 - share) * force
        head = [
            net.solve({("c", place): own})[0]["c", place] + own / CONTACT
            for (net, _, _), own in zip(sections, forces, strict=True)
        ]
        apart = head[0] - head[1]
        soft = 2.0 * 0.4e-3 + contact_compliance(0.0, place, 0, mesh)  # m/N, about what both wires give together
        if share < 1e-6:
            assert apart > 0.0
        elif share > 1.0 - 1e-6:
            assert apart < 0.0
        else:
            assert abs(apart) < 5e-3 * soft * force
        shares.append(share)
    assert shares[0] == pytest.approx(1.0, abs=1e-6)
    assert shares[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.all(np.diff(shares) <= 1e-9)
    assert shares[4] == pytest.approx(0.5, abs=1e-4)  # the middle of the mirror


def test_a_head_on_both_wires_meets_the_impedance_of_both():
    """Y = F t / (2 Z) under a force that starts between droppers: 2 Z of one wire, 2 (Z + Z) of both."""
    Z = np.sqrt(TENSION[0] * MASS[0])
    made = Catenary(["gravity_sag", "line_table", "second_wire"], {"line_table.table": table(), "element": 0.1, "substep": 1e-4})
    made.set("contact_position", 374.14)  # in the middle of a gap of both
    made.initialize(0.0)
    start = made["wire_height"], made["second_wire.wire_height[1]"]
    forces, moved = (60.0, 140.0), []
    for i in range(20):
        made.u[0, made.input_positions(["contact_force", "second_wire.contact_force[1]"])] = forces
        made.step(i * 1e-3, 1e-3)
        moved.append((made["wire_height"] - start[0], made["second_wire.wire_height[1]"] - start[1]))
    moved = np.array(moved)
    velocity = (moved[19] - moved[7]) / 12e-3
    assert velocity == pytest.approx(np.array(forces) / (2.0 * Z), rel=2e-3)
    assert velocity.sum() / sum(forces) == pytest.approx(2.0 / (2.0 * (Z + Z)), rel=2e-3)


def test_uplift_at_a_support_is_that_of_the_wires_that_are_there():
    """Pushed down by 7 mm where only one of both wires is: -7 mm, not the 0 of the wire that is not there."""
    made = catenary(2.0)
    mesh, N, W = made.mesh, made.mesh.mass.size, made.mesh.bending_gradient.size
    state = made.x[:N].copy()
    seen = set()
    for support in range(mesh.support.size):
        lanes = [lane for lane in (0, 2) if mesh.mass[W * mesh.support[support] + lane] > 0.0]
        seen.add(tuple(lanes))
        for pushed in lanes:
            made.x[:N] = 0.0
            made.x[W * mesh.support[support] + pushed] = -7e-3
            y, s, p, e = made.y, *made.arguments
            put_outputs(made.t, mesh, s, p._replace(first_watched_support=support), e)
            assert y[OUT.support_uplift] == (-7e-3 if len(lanes) == 1 else 0.0)
    made.x[:N] = state
    assert {(0,), (2,), (0, 2)} <= seen
