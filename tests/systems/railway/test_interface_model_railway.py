"""Pantograph and catenary with the contact in the master, in steps of 5 ms: the table, and the error of the coupling."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter, uniform
from cosimo.orchestrator.harness.validation.case import compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.records import measured, passages, statistics
from cosimo.orchestrator.systems.railway.runs import at_speed
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full

RAILWAY = "en50318-2002-interface-model"
SIGNALS = {
    "record": {
        "signals": ["pantograph.contact_force", "pantograph.contact_position", "catenary.wire_height", "catenary.support_uplift"]
    }
}


@pytest.mark.parametrize("speed", [250.0, 300.0])
@pytest.mark.parametrize("element", [0.25, 0.5])
def test_all_cells_of_the_2002_table_hold_with_steps_of_5_ms(speed, element):
    """At 300 km/h the impedance would be 619 N s/m; that of 250 km/h is left, as a sweep over the speed would."""
    scene = at_speed(load_scene(RAILWAY), speed, {**SIGNALS, "catenary.element": element})
    rows = compare(load_table("en50318-2002").under(f"{speed:g} km/h"), measured(statistics(finished(scene))))
    assert len(rows) == 8
    outside = [f"{r.reference.quantity}: {r.simulated:.4g}" for r in rows if not r.inside]
    assert not outside


def filtered(result, keep=1):
    """20 Hz-filtered force over spans 5 and 6, N, from every `keep`-th sample."""
    record = passages(result)[0].record
    rate, _, (position, force) = uniform(record.time[::keep], record.position[::keep], record.force[::keep])
    return np.interp(np.linspace(240.0, 360.0, 1201), position, ButterworthFilter().apply(force, rate))


def test_error_of_the_railway_pair_is_less_than_half_of_gauss_seidel():
    """Both on one mesh, against a step twenty times shorter that is sampled as coarsely: what the coupling alone does."""
    fine = {"catenary.element": 0.25, "catenary.substep": 2.5e-4, **SIGNALS}
    reference = filtered(
        finished(load_scene("en50318-2002").with_changes({**fine, "master.step": 2.5e-4, "master.extrapolation": 2})), keep=20
    )

    def distance(name):
        result = finished(load_scene(name).with_changes({**fine, "master.step": 5e-3}))
        return np.sqrt(np.mean((filtered(result) - reference) ** 2)) / reference.std()

    assert distance(RAILWAY) < 0.5 * distance("en50318-2002")
    assert distance(RAILWAY) < 0.015
