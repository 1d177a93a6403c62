"""Coupling for towing: forces, power, slack."""

import numpy as np
import pytest
from cosimo.components.pipe_robot.tow import TowCoupling
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted


def coupled(rear, front, effects=(), **parameters) -> TowCoupling:
    """A coupling between ends at (position, velocity)."""
    return initialized(
        TowCoupling(
            effects,
            {
                "rear_position": rear[0],
                "rear_velocity": rear[1],
                "front_position": front[0],
                "front_velocity": front[1],
                **parameters,
            },
        )
    )


def test_a_bar_pulls_and_pushes():
    unit = coupled((1.0, 0.2), (1.52, 0.1))
    assert unit["stretch"] == pytest.approx(0.02, rel=1e-12)
    assert unit["rear_force"] == pytest.approx(500.0 * 0.02 - 5.0 * 0.1, rel=1e-12)
    assert unit["front_force"] == -unit["rear_force"]
    assert coupled((1.0, 0.0), (1.4, 0.0))["rear_force"] == pytest.approx(-50.0, rel=1e-12)


@pytest.mark.known_answers(TowCoupling="slack")
def test_a_rope_neither_pushes_nor_sticks():
    assert coupled((1.0, 0.0), (1.4, 5.0), ["slack"])["rear_force"] == 0.0
    assert coupled((1.0, 0.0), (1.5, 5.0), ["slack"])["rear_force"] == 0.0
    assert coupled((1.0, 9.0), (1.502, 0.0), ["slack"])["rear_force"] == 0.0  # it comes back faster than the rope
    half = coupled((1.0, 0.0), (1.5 + 0.5e-3, 0.1), ["slack"])
    assert half["rear_force"] == pytest.approx(500.0 * 0.5e-3 + 0.5 * 5.0 * 0.1, rel=1e-9)
    whole = coupled((1.0, 0.0), (1.503, 0.1), ["slack"])
    assert whole["rear_force"] == pytest.approx(500.0 * 0.003 + 5.0 * 0.1, rel=1e-9)


@pytest.mark.parametrize("effects", [(), ("slack",)])
def test_what_goes_in_is_stored_or_lost(effects):
    """Power at both ends plus the growth of the stored energy is the dashpot's loss, never negative."""
    random, d = np.random.default_rng(5), 1e-7
    for _ in range(20):
        x1, v1, v2 = random.normal(size=3)
        x2 = x1 + 0.5 + random.normal() * 0.01
        unit = coupled((x1, v1), (x2, v2), effects)
        given = -(unit["rear_force"] * v1 + unit["front_force"] * v2)
        ends = [coupled((x1 + s * d * v1, v1), (x2 + s * d * v2, v2), effects).energy() for s in (1.0, -1.0)]
        lost = given - (ends[0] - ends[1]) / (2.0 * d)
        assert lost >= -1e-6
        if not effects:
            assert lost == pytest.approx(5.0 * (v2 - v1) ** 2, abs=1e-6)  # rounding of the energy over d
