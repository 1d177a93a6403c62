"""Shipped scenes in masters of other makers: they get the numbers that `cosimo ssp` announces, from the same package.

What is announced is our own run with Jacobi's scheme and held inputs; the FMUs are the same, so that only rounding may differ.
"""

import numpy as np
import pytest
from cosimo.orchestrator.harness.other_masters import as_other_masters
from cosimo.orchestrator.native import initial_inputs
from cosimo.orchestrator.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.interop.masters import CLIENTS, require, run_in

LOOKS = 10
SCENES = {"en50318-2002": 0.5, "rov-station-keeping": 10.0, "rotor-run-up": 0.02, "wind-pump-start": 10.0}  # s
ROUNDING = 1e-10  # of a signal's range: rounding of sums of transformations and of time, over some hundred steps
pytestmark = [pytest.mark.full, pytest.mark.filterwarnings("ignore")]


@pytest.fixture(scope="module", params=CLIENTS)
def master(request):
    """A master that is there; asked for before a scene is packed."""
    require(request.param)
    return request.param


@pytest.fixture(scope="module", params=SCENES)
def packed(request, tmp_path_factory):
    """(scene, package, announced run) of a scene cut short."""
    scene = load_scene(request.param).with_changes({"stop_time": SCENES[request.param], "record.interval": None})
    announced = run(as_other_masters(scene), in_process=True)
    assert announced.outcome == "done", announced.message
    package = write(scene, tmp_path_factory.mktemp("packages") / f"{scene.name}.ssp", initial_inputs(scene))
    return scene, package, announced


def test_other_masters_get_what_is_announced(master, packed):
    """Ecos shows an output that depends on its inputs at once with the inputs of the next step; such are left out there."""
    scene, package, announced = packed
    every = round(scene.stop_time / scene.master.step) // LOOKS
    outputs = {(u, n): s for u, i in scene.coupling.interfaces.items() for n, s in i.outputs.items()}
    signals = [tuple(name.split(".", 1)) for name in announced.columns]
    if master == "Ecos":
        driven = {link.target for link in scene.coupling.links}
        signals = [(u, n) for u, n in signals if not any((u, i) in driven for i in outputs[u, n].feedthrough or ())]
    assert len(signals) >= 4
    theirs = run_in(master, package, scene.master.step, LOOKS, every, signals)
    rows = np.searchsorted(announced.time, np.arange(1, LOOKS + 1) * every * scene.master.step - 1e-9)
    for k, signal in enumerate(signals):
        ours = announced[".".join(signal)]
        assert np.abs(theirs[:, k] - ours[rows]).max() <= ROUNDING * max(np.ptp(ours), np.abs(ours).max()), signal
