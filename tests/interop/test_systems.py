"""Shipped scenes in masters of other makers: they get the numbers that `cosimo ssp` announces, from the same package.

What is announced is our own run with Jacobi's scheme and held inputs; the equations are the same, so that only rounding may
differ. The packages hold native FMUs, as of `cosimo ssp --native`, which are cheap to run from empty caches; one holds FMUs of
pythonfmu. The announced run takes native FMUs, too: it then has every bit of the one in process (tests/run/test_native_run.py).
"""

from functools import cache

import numpy as np
import pytest
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.harness.other_masters import as_other_masters
from cosimo.orchestrator.opened.native import initial_inputs, with_native_fmus
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.interop.masters import CLIENTS, require, run_in
from cosimo.tests.scene_runs import finished

LOOKS = 10
SCENES = {"en50318-2002": 0.5, "rov-station-keeping": 10.0, "rotor-run-up": 0.02, "wind-pump-start": 10.0}  # s
PACKAGES = [*((name, "native") for name in SCENES), ("en50318-2002", "pythonfmu")]
ROUNDING = 1e-10  # of a signal's range: rounding of sums of transformations and of time, over some hundred steps
pytestmark = [
    pytest.mark.full,
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(own_target() != "linux64", reason="the masters are installed and compared on Linux"),
]


@pytest.fixture(scope="module", params=CLIENTS)
def master(request):
    """A master that is there; asked for before a scene is packed."""
    require(request.param)
    return request.param


@cache
def announced(name):
    """(scene cut short, its announced run)."""
    scene = load_scene(name).with_changes({"stop_time": SCENES[name], "record.interval": None})
    result = finished(as_other_masters(scene), native=True, in_process=False)
    return scene, result


@pytest.fixture(scope="module", params=PACKAGES, ids="-".join)
def packed(request, tmp_path_factory):
    """(scene, package, announced run) of a scene cut short."""
    name, packaging = request.param
    scene, result = announced(name)
    content = with_native_fmus(scene) if packaging == "native" else scene
    return scene, write(content, tmp_path_factory.mktemp("packages") / f"{name}.ssp", initial_inputs(scene)), result


def test_other_masters_get_what_is_announced(master, packed):
    """Ecos shows an output that depends on its inputs at once with the inputs of the next step; such are left out there."""
    scene, package, announced = packed
    every = round(scene.stop_time / scene.master.step) // LOOKS
    outputs = {(u, n): s for u, i in scene.coupling.interfaces.items() for n, s in i.outputs.items()}
    signals = [(u, n, outputs[u, n].kind) for u, n in (name.split(".", 1) for name in announced.columns)]
    if master == "Ecos":
        driven = {link.target for link in scene.coupling.links}
        signals = [(u, n, kind) for u, n, kind in signals if not any((u, i) in driven for i in outputs[u, n].feedthrough or ())]
    assert len(signals) >= 4
    theirs, _ = run_in(master, package, scene.master.step, LOOKS, every, signals)
    rows = np.searchsorted(announced.time, np.arange(1, LOOKS + 1) * every * scene.master.step - 1e-9)
    for k, signal in enumerate(signals):
        ours = announced[".".join(signal[:2])]
        assert np.abs(theirs[:, k] - ours[rows]).max() <= ROUNDING * max(np.ptp(ours), np.abs(ours).max()), signal
