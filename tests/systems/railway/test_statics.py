"""Static equilibrium against a formulation without a mesh: Green's functions of strings joined by dropper forces."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.mesh import GRAVITY
from cosimo.components.railway.statics import Statics, elasticity, messenger_shape, stiffness_series
from cosimo.components.railway.wires import dropper_tension

pytestmark = pytest.mark.interpreted

ROUNDING = 1e-9


def green(x, y, length, tension):
    """Deflection at x of a string fixed at both ends under a unit force at y, m/N."""
    low, high = np.minimum(x, y), np.maximum(x, y)
    return low * (length - high) / (length * tension)


def force_method(catenary: Catenary, position: float) -> float:
    """Uplift per force at a position with every dropper taut, from dropper and support forces as the unknowns."""
    p = catenary.parameters
    spans, span = p["spans"], p["span_length"]
    length = spans * span
    within = [p[f"dropper_position[{i + 1}]"] for i in range(p["droppers"])]
    d = np.concatenate([span * k + np.array(within) for k in range(spans)])
    s = span * np.arange(1, spans)
    Gc = green(d[:, None], d, length, p["contact_wire_tension"])
    Gm = green(d[:, None], d, length, p["messenger_tension"])
    Gs = green(s[:, None], s, length, p["messenger_tension"])
    Gds = green(d[:, None], s, length, p["messenger_tension"])
    # droppers carry f (pull the contact wire down), supports r (pull the messenger down): both wires move as one
    n = d.size
    system = np.block(
        [[Gc + Gm + np.eye(n) / p["dropper_stiffness"], -Gds], [-Gds.T, Gs + np.eye(s.size) / p["support_stiffness"]]]
    )
    load = np.concatenate((green(d, position, length, p["contact_wire_tension"]), np.zeros(s.size)))
    f = np.linalg.solve(system, load)[:n]
    own = green(position, position, length, p["contact_wire_tension"])
    return own - green(position, d, length, p["contact_wire_tension"]) @ f


def static_error(position: float, element: float) -> float:
    catenary = Catenary(parameters={"spans": 4, "element": element, "method": "implicit", "substep": 1e-5})
    catenary.initialize(0.0)
    return elasticity(catenary.mesh, [position], 100.0, unilateral=False)[0] / force_method(catenary, position) - 1.0


@pytest.mark.parametrize("position", [121.3, 127.13, 133.3, 147.4, 161.7])
def test_elasticity_between_droppers_equals_the_force_method(position):
    """Between nodes too: what is left is the kink's place within an element, s (1 - s), of which the mean is right."""
    assert abs(static_error(position, 0.4)) < 4e-3
    assert abs(static_error(position, 0.1)) < 1.5e-3


@pytest.mark.parametrize("position", [125.0, 150.0])
def test_elasticity_at_a_dropper_converges_to_the_force_method(position):
    """Where contact and dropper meet, the waves shorter than the mesh that they share are counted twice: first order."""
    coarse, fine = (static_error(position, element) for element in (0.4, 0.2))
    assert 0.0 < coarse < 0.015
    assert fine / coarse == pytest.approx(0.5, abs=0.1)


@pytest.mark.known_answers(Catenary="bending_stiffness")
def test_bending_stiffness_lowers_the_compliance_by_the_boundary_layer():
    """A long wire under tension deflects less by sqrt(EI/T) / (2 T) under a point load; converges with the element."""
    errors = []
    for element in (0.04, 0.02):
        common = {"spans": 1, "span_length": 6.0, "droppers": 1, "element": element, "method": "implicit"}
        common |= {"dropper_position[1]": 1.0, "dropper_stiffness": 1.0}
        string, beam = Catenary(parameters=common), Catenary(["bending_stiffness"], common)
        for catenary in (string, beam):
            catenary.set("contact_position", 3.0)
            catenary.initialize(0.0)
        less = elasticity(string.mesh, [3.0], 1.0, False)[0] - elasticity(beam.mesh, [3.0], 1.0, False)[0]
        exact = np.sqrt(195.0 / 20e3) / (2.0 * 20e3)  # the ends are 30 boundary layers away
        errors.append(abs(less / exact - 1.0))
    assert errors[1] < 0.02
    assert errors[0] / errors[1] > 3.0  # second order or better


@pytest.mark.known_answers(Catenary="dropper_slackening")
def test_droppers_let_go_one_after_the_other():
    """Under a large force the equilibrium has slack droppers with no tension, taut ones with some, and no residual."""
    catenary = Catenary(["dropper_slackening"], {"spans": 3, "method": "implicit"})
    catenary.initialize(0.0)
    counts, kept = [], Statics(catenary.mesh)
    for force in (0.0, 100.0, 300.0, 900.0, 300.0, 0.0):
        q, taut, residual = Statics(catenary.mesh).under([(90.0, force)], True)
        again, _, _ = kept.under([(90.0, force)], True)  # with factors of the forces before
        assert np.array_equal(again, q)
        tension = np.array([dropper_tension(k, q, catenary.mesh, None) for k in range(taut.size)])
        assert np.array_equal(tension > 0.0, taut > 0.0)
        assert residual < 1e-10
        counts.append(int(np.sum(taut == 0.0)))
    assert counts[0] == 0
    assert counts[:4] == sorted(counts[:4])
    assert counts[4:] == counts[2::-2]
    assert counts[3] >= 3


def test_a_line_follows_its_parameters_and_no_other_catenary():
    first, same, other = (Catenary(parameters={"spans": 2, "element": e, "method": "implicit"}) for e in (2.0, 2.0, 1.0))
    for made in (first, same, other):
        made.initialize(0.0)
    numbers, before = same.arguments[0].numbers, first.arguments[0].numbers.copy()
    assert np.array_equal(numbers, before)
    assert other.arguments[0].numbers.size > numbers.size
    same.set("contact_wire_tension", 21e3)
    same.initialize(0.0)
    assert not np.array_equal(same.arguments[0].numbers, before)
    assert np.array_equal(first.arguments[0].numbers, before)
    same.set("contact_wire_tension", 20e3)
    same.initialize(0.0)
    assert np.array_equal(same.arguments[0].numbers, before)


@pytest.mark.known_answers(Catenary="gravity_sag")
def test_sag_between_droppers_is_a_parabola():
    catenary = Catenary(["gravity_sag"])
    catenary.initialize(0.0)
    for a, b in ((300.0 + 10.5, 300.0 + 17.0), (295.0, 305.0)):  # an inner gap, and the one over a support
        middle = 0.5 * (a + b)
        for x in (middle, a + 0.1 * (b - a)):
            catenary.set("contact_position", x)
            catenary.refresh()
            exact = -1.35 * GRAVITY * (x - a) * (b - x) / (2.0 * 20e3)
            assert catenary["wire_height"] == pytest.approx(exact, rel=1e-9)


@pytest.mark.known_answers(Catenary="level_support")
def test_level_support_raises_the_wire_to_dropper_level():
    catenary = Catenary(["gravity_sag", "level_support"])
    catenary.set("contact_position", 300.0)
    catenary.initialize(0.0)
    assert abs(catenary["wire_height"]) < 1e-15


@pytest.mark.known_answers(Catenary="pre_sag")
def test_droppers_carry_the_weight_and_the_pre_sag():
    """A span's droppers carry its weight; pre-sag moves force from the inner droppers to the two at its ends.

    Over the parabola the curvature 8 d / l² takes T 8 d / l² per length off the inner droppers.
    """
    catenary = Catenary(preset="EN 50318:2018 AC simple")
    catenary.initialize(0.0)
    preload = catenary.mesh.preload[9 * 5 : 9 * 6]
    weight = GRAVITY * (1.35 * 55.0 + 9 * (0.165 + 0.5 * 0.117))
    assert preload.sum() == pytest.approx(weight, rel=ROUNDING)
    inner = GRAVITY * (1.35 * 5.75 + 0.165 + 0.5 * 0.117) - 22e3 * 8.0 * 0.055 / 46.0**2 * 5.75
    # without bending the inner droppers are all alike; the beam's boundary layer spreads 1 N between neighbours
    strings = Catenary(["pre_sag"], {n: v for n, v in catenary.parameters.items() if not n.startswith(("bending", "damping"))})
    strings.initialize(0.0)
    assert strings.mesh.preload[9 * 5 + 1 : 9 * 6 - 1] == pytest.approx(np.full(7, inner), rel=ROUNDING)


def test_messenger_carries_everything_to_its_supports():
    catenary = Catenary(["dropper_slackening"])
    catenary.initialize(0.0)
    p, mesh = catenary.arguments[1], catenary.mesh
    y = messenger_shape(p, None, mesh)
    reaction = -p.support_stiffness * y[mesh.support[5]]  # the spring under a support in the middle
    assert reaction == pytest.approx(GRAVITY * (1.35 + 1.07) * 60.0, rel=1e-6)  # the ends' influence decays over the spans
    sag = y[mesh.support[5]] - y[np.searchsorted(mesh.position, 330.0)]
    d, f = mesh.position[mesh.dropper[45:54]] - 300.0, mesh.preload[45:54]
    moment = 0.5 * f.sum() * 30.0 - f[:4] @ (30.0 - d[:4]) + GRAVITY * 1.07 * 60.0**2 / 8.0
    assert sag == pytest.approx(moment / 16e3, rel=1e-9)


def test_span_and_droppers_change_together():
    """Parameters of another line, given one by one: supports, droppers and preloads follow."""
    values = {"span_length": 50.0, "dropper_position[8]": 46.0, "droppers": 8, "spans": 3}
    catenary = Catenary(["gravity_sag"], values)
    catenary.initialize(0.0)
    mesh = catenary.mesh
    assert mesh.position[mesh.support] == pytest.approx([0.0, 50.0, 100.0, 150.0])
    assert mesh.position[mesh.dropper[8:16]] == pytest.approx([55.0, 60.5, 67.0, 73.5, 80.0, 86.5, 93.0, 96.0])
    assert mesh.preload[8:16].sum() == pytest.approx(GRAVITY * 1.35 * 50.0, rel=ROUNDING)
    with pytest.raises(BadInput, match="inside the span"):
        Catenary(parameters={"span_length": 50.0}).initialize(0.0)


def test_series_gives_back_its_own_stiffness():
    x = np.linspace(0.0, 60.0, 120, endpoint=False)
    a = np.array([0.37, 0.1, -0.02, -0.04])
    k = 2800.0 * (1.0 + np.cos(2.0 * np.pi * x[:, None] * np.arange(1, 5) / 60.0) @ a)
    k0, fitted = stiffness_series(x, k, 60.0, 6)
    assert k0 == pytest.approx(2800.0, rel=ROUNDING)
    assert fitted == pytest.approx([*a, 0.0, 0.0], abs=1e-9)
