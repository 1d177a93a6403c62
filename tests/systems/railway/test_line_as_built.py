"""A line as built: random deviations of dropper lengths, supports and tensions against an independent network of strings."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.line.later import deviations
from cosimo.tests.support import initialized
from cosimo.tests.systems.railway.network import G, Network

LINE = """[[sections]]
contact_wire = { tension = 22e3, mass = 1.35 }
messenger = { tension = 16e3, mass = 1.08 }
droppers = { first = 4.5, gap = 6.5, stiffness = 200e3 }
support = { system_height = 1.2, stiffness = 500e3 }
spans = [50, 50, 50, 50]
"""
DROPPER, SUPPORT, TENSION = 0.012, 0.01, 0.02  # so large that droppers are slack at rest
VALUES = {"line_table.table": LINE, "method": "implicit", "element": 0.2}
WIDE = {"scatter.dropper_length": DROPPER, "scatter.support_height": SUPPORT, "scatter.tension": TENSION}


def built(effects=("scatter",), **more):
    return initialized(Catenary(["line_table", "dropper_slackening", *effects], {**VALUES, **more}), {"contact_position": 90.0})


@pytest.mark.known_answers(Catenary="scatter")
def test_a_line_as_built_hangs_as_a_network_of_strings_with_slack_droppers():
    """Tensions of all droppers, 0 of the slack ones, and heights; cut lengths and tensions from the seed's numbers."""
    catenary = built(**WIDE, **{"scatter.seed": 3})
    s, mesh, form = catenary.arguments[0], catenary.mesh, Catenary(["line_table"], {"line_table.table": LINE}).form()
    random, d, h = deviations(s.plan, 3), s.plan.droppers.shape[0], s.plan.holds.shape[0]
    x, as_built, net = form.layout.droppers.position.round(6), catenary.form(), Network()
    assert as_built.cut_length == pytest.approx(form.cut_length + DROPPER * random[:d], abs=1e-9)
    places = [*x, 0.0, 50.0, 100.0, 150.0, 200.0]
    for name, tension, mass, k in (("c", 22e3, 1.35, 0), ("m", 16e3, 1.08, 1)):
        net.wire(name, places, tension * (1.0 + TENSION * random[d + h + k]), G * mass)
    net.fixed = {("c", 0.0): 0.0, ("c", 200.0): 0.0, ("m", 0.0): 1.2, ("m", 200.0): 1.2}
    net.springs = [(("m", p), 500e3, z) for p, z in zip((50.0, 100.0, 150.0), as_built.rest_height, strict=True)]
    net.droppers = [(("c", p), ("m", p), 200e3, cut, (0.0, 0.0)) for p, cut in zip(x, as_built.cut_length, strict=True)]
    heights, tensions = net.solve()
    assert (tensions == 0.0).sum() >= 2
    now = mesh.preload + mesh.dropper_stiffness * (s.at_rest[mesh.upper] - s.at_rest[mesh.lower])
    assert np.maximum(now, 0.0) == pytest.approx(tensions, abs=0.01)
    W, at = mesh.bending_gradient.size, mesh.lower // mesh.bending_gradient.size
    assert mesh.height[at] + s.at_rest[W * at] == pytest.approx([heights["c", p] for p in x], abs=1e-4)  # by the mesh, 0.06 mm


def test_uplifts_count_from_the_line_as_built():
    """At rest, without a force, they are 0 though slack droppers have let the wire go; another seed is another line."""
    one, other = (built(**WIDE, **{"scatter.seed": seed}) for seed in (3, 4))
    assert abs(one.arguments[0].at_rest).max() > 1e-3
    assert [one[f"support_uplift[{k}]"] for k in (1, 2)] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert one["wire_height"] != other["wire_height"]
    assert one["wire_height"] == built(**WIDE, **{"scatter.seed": 3})["wire_height"]


def test_no_deviation_changes_nothing():
    none, plain = built(**dict.fromkeys(WIDE, 0.0)), built(())
    assert none["wire_height"] == pytest.approx(plain["wire_height"], abs=1e-10)
    assert plain.arguments[0].at_rest is None


def test_what_no_line_can_be_is_refused():
    with pytest.raises(BadInput, match="the dropper at"):
        built(**{"scatter.dropper_length": 0.9})
    with pytest.raises(BadInput, match="exclude each other"):
        built(("scatter", "moving_window"), method="explicit", substep=1e-4)
