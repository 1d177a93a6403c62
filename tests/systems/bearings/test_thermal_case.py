"""The case on heat resistance: it passes, and its references are no copies of what they judge."""

import pytest
from cosimo.orchestrator.harness.validation.case import compare, outcome
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems.bearings.cases import thermal_scaling


def assert_another_route(findings):
    """Finite volumes equal to four digits would be the same formula; all but one differ by more than a per mille.

    What the notes say of oil was computed: more resistance than in finite volumes, within the range that the note gives, and less
    than with air.
    """
    rows = [r for r in findings.rows if r.reference.quantity == "resistance of the lumped path"]
    middle = [0.5 * (r.reference.low + r.reference.high) for r in rows]
    assert sum(abs(r.simulated / m - 1.0) > 1e-3 for r, m in zip(rows, middle, strict=True)) >= len(rows) - 2
    named = {r.reference.condition: r for r in rows}
    oil = [r for condition, r in named.items() if "oil" in condition]
    over = [100.0 * (r.simulated / (0.5 * (r.reference.low + r.reference.high)) - 1.0) for r in oil]
    assert f"{min(over):+.1f} to {max(over):+.1f} %" in findings.notes[1]
    assert all(r.simulated < named["7008C, 1000 N axial, air beside the contacts"].simulated for r in oil)


@pytest.mark.full
def test_the_table_is_sharp():
    """Balls of another conductivity, or a ring that tilts an angle of 1 degree more, would not pass."""
    rows = [r for r in load_table("thermal-scaling").rows if r.measure == "7008C.1000.0"]
    for more in ({"ball_conductivity": 45.0}, {"contact_angle": 0.28}, {"modulus": 2.06e11}):
        wrong = thermal_scaling.bearing("7008C", (), 1000.0, 0.0, more)
        assert outcome(compare(tuple(rows), {"7008C.1000.0": 1.0 / wrong["conductance"]})) == "failed"
