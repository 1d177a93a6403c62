"""What the tests try of few, tried of many: runs of components, every effect of every component as WebAssembly."""

import pytest
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.fmus.native.test_wasm32 import as_in_process, every_effect
from cosimo.tests.short_run import ONE_A_SYSTEM
from cosimo.tests.units.test_many_runs import counted_here, growth  # noqa: F401


def test_two_thousand_runs_of_components():
    """A signal of the result that was kept would be some hundred bytes."""
    unit = {"component": "Pantograph", "effects": ["contact_loss"]}
    scene = read_scene(
        {
            "stop_time": 2e-3,
            "units": {"p": unit, "q": unit},
            "master": {"step": 1e-3},
            "connections": ["p.head_height -> q.wire_height"],
        }
    )
    assert growth(scene, 2000, 100, in_process=True) < 100.0


@pytest.mark.parametrize(
    "configuration", [c for c in every_effect() if c.component not in (*ONE_A_SYSTEM, "PlanarLink")], ids=lambda c: c.label
)
def test_a_component_with_all_its_effects(configuration, tmp_path):
    as_in_process(configuration, tmp_path)
