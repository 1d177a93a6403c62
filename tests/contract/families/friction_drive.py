"""Friction-wheel drive; its motor is in `drives`."""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {
    "ServoController": Facts(
        plain=(("quantisation", "reference"), {}, 20),
        other_ways=(({"feedback": "wheels", "layout": "orthogonal"}, ()),),
        disturbance={"feed": 1e-3, "rotation": -0.02, "first_rate": 0.1},
        strengths={"reference.feed[2]": ({"reference.rotation[2]": 0.0}, 1e-5),
                   "reference.rotation[2]": ({"reference.feed[2]": 0.0}, 1e-4)},
        structural=frozenset({"quantisation"}),  # rates are differences of counts, however small the steps
        form=frozenset({"reference.time"}),
    ),
}
