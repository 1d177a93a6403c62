"""A made-up run of a pantograph under a catenary, as the report sees one."""

from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.orchestrator.run.run_record import EffectsRecord, RunRecord, UnitRecord
from cosimo.orchestrator.systems import read_scene

PLACES = [5.0, 10.5, 17.0, 23.5, 30.0, 36.5, 43.0, 49.5, 55.0]
DROPPERS = {"droppers": len(PLACES)} | {f"dropper_position[{k}]": x for k, x in enumerate(PLACES, 1)}


def made_up_run(speed=69.444, title="Made-up run", second=False):
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 7.0005, 1e-3)
    x = 30.0 + speed * t
    force = 117.0 + 35 * np.cos(2 * np.pi * x / 60) + 12 * np.sin(2 * np.pi * x / 6.5) + 20 * np.sin(2 * np.pi * 60 * t)
    force += rng.normal(size=t.size)
    columns = {
        "pantograph.contact_force": force,
        "pantograph.contact_position": x,
        "pantograph.head_height": 0.02 * np.sin(t),
        "catenary.wire_height": 0.03 - 0.02 * np.cos(2 * np.pi * x / 60),
    }
    for i in range(1, 6):
        passing = t - (60.0 * (3 + i) - 30.0) / speed
        columns[f"catenary.support_uplift[{i}]"] = 0.053 * np.exp(-40 * passing**2) * (1 + 0.3 * np.sin(12 * passing))
    every = slice(None, None, 20)
    offsets = np.arange(-60, 61)
    heights = 0.03 * np.exp(-((offsets / 20.0) ** 2)) * (1 + 0.3 * np.sin(5 * t[every, None])) - 0.004
    scene = read_scene(
        {
            "title": title,
            "stop_time": 7.0,
            "master": {"step": 1e-3},
            "connections": [
                "pantograph.contact_position -> catenary.contact_position",
                "catenary.wire_height -> pantograph.wire_height",
                "pantograph.contact_force -> catenary.contact_force",
            ],
            "units": {
                "pantograph": {"component": "Pantograph", "effects": ["contact_loss"]},
                "catenary": {"component": "Catenary"},
            },
            "analysis": {"system": "railway", "spans": [5, 6]},
        }
    )
    return SimpleNamespace(
        scene=scene,
        time=t,
        columns=columns,
        outcome="done",
        message="",
        measures=dict.fromkeys(columns, "N"),
        snapshots={"catenary.wire_profile.height": SimpleNamespace(time=t[every], values=heights)},
        info=RunRecord(
            outcome="done",
            effects={"pantograph": EffectsRecord(on={"contact_loss": "the scene"}, off={"bump_stops": "not named"})},
            units={"catenary": UnitRecord(parameters={"span_length": 60.0, "first_watched_support": 4} | DROPPERS)},
            versions={"numpy": "2.0"},
        ),
    )


@pytest.fixture
def run():
    return made_up_run()
