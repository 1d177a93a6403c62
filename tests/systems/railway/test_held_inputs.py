"""Held inputs under a moving contact: the wire gets the force at the place where the head is, in whatever order units step."""

from itertools import product

import numpy as np
import pytest
from cosimo.components.railway.pantograph import Pantograph
from cosimo.fmus.build import build
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.units import describe
from cosimo.tests.short_run import shipped_scenes

ORDERS = {"catenary first": ["catenary", "pantograph"], "pantograph first": ["pantograph", "catenary"]}
SCHEMES = [("jacobi", None), ("iterative", None), *(("gauss-seidel", order) for order in ORDERS)]


def held(name, step=None, algorithm="gauss-seidel", order=None, **options):
    scene = load_scene(name)
    changes = {
        "master.extrapolation": 0,
        "master.algorithm": algorithm,
        "master.order": ORDERS[order] if order else [],
        "record.signals": None,
    }
    return run(scene.with_changes(changes | ({"master.step": step} if step else {}) | options), in_process=True)


def balance(result, begin):
    """Mean force on the wire, N, that the pantograph's own equation of motion gives from its recorded motion."""
    kept = result.time >= begin
    t, frame = result.time[kept], result["pantograph.frame_height"][kept]
    head_velocity = result["pantograph.head_velocity"][kept]
    p = Pantograph((), preset="EN 50318:2002").parameters
    span, frame_velocity = t[-1] - t[0], np.gradient(frame, t, edge_order=2)
    momentum = p["head_mass"] * (head_velocity[-1] - head_velocity[0]) + p["frame_mass"] * (
        frame_velocity[-1] - frame_velocity[0]
    )
    damper = p["frame_damping"] * (frame[-1] - frame[0])
    return p["static_force"] - p["frame_stiffness"] * frame.mean() - (momentum + damper) / span


@pytest.mark.parametrize(
    ("scheme", "step"),
    [pytest.param(*one, marks=[] if one[1] == 1e-3 else pytest.mark.full) for one in product(SCHEMES, (5e-4, 1e-3, 2e-3))],
)
def test_the_mean_force_is_that_of_the_pantographs_own_balance(scheme, step):
    result = held("en50318-2002", step, *scheme)
    force = result["pantograph.contact_force"][result.time >= 1.0]
    assert force.mean() == pytest.approx(balance(result, 1.0), abs=0.2e3 * step)  # N: of first order, 4 to 19 N before


def moving_scenes():
    """Shipped scenes with an input that is a place which moves on and gets its value from another unit."""
    for name, scene in shipped_scenes().items():
        interfaces = scene.coupling.interfaces
        if any(interfaces[u].inputs[n].moving for link in scene.coupling.links for u, n in [link.target]):
            yield name


@pytest.mark.full
@pytest.mark.parametrize("name", list(moving_scenes()))
def test_held_inputs_keep_the_mean_force_of_every_scene(name):
    scene = load_scene(name)
    short = {
        "stop_time": min(scene.stop_time, 2.0),
        "record.interval": None,
        "record.snapshots": [],
        "record.snapshot_interval": None,
    }
    one, other = held(name, **short), run(scene.with_changes(short), in_process=True)
    for force in (n for n in one.columns if n.endswith(".contact_force")):
        deviation = other[force].std()
        assert one[force].mean() == pytest.approx(other[force].mean(), abs=0.1 * deviation + 0.1), force


def test_an_fmu_says_that_its_place_moves_on(tmp_path):
    interface = describe("catenary", UnitSettings(fmu=str(build("Catenary", tmp_path))))
    assert [name for name, signal in interface.inputs.items() if signal.moving] == ["contact_position"]
