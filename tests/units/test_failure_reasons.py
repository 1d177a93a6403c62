"""The reason of a unit's failure arrives whole, whatever packaging the unit has; a component never ends a simulation."""

import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems.wrist.cases.four_bar import scenes

REASON = "the toggle, where coupler and rocker are in one line. Keep the crank within its range, or change the lengths"
PACKAGINGS = [
    ({"in_process": True}, "none"),
    ({}, "none"),
    ({}, "process"),
    pytest.param({"native": True}, "none", marks=pytest.mark.full),
]


@pytest.mark.parametrize(("options", "isolation"), PACKAGINGS)
def test_a_linkage_at_its_toggle_says_so(options, isolation):
    scene = scenes()["driven by its rocker"]
    scene = scene.with_changes({f"units.{name}.isolation": isolation for name in scene.units})
    result = run(scene, **options)
    assert result.outcome == "failed"  # and not ended
    assert REASON in result.message
    assert result.message.startswith("bar failed at t = ")
    assert result.time[-1] == pytest.approx(0.633)
