"""A scene as one FMU in masters of other makers: bit-identical to the run in process, for nothing is coupled there."""

import numpy as np
import pytest
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.scene_fmu import build_scene_fmu
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.interop.masters import CLIENTS, require, run_in

LOOKS, EVERY = 10, 20
pytestmark = [
    pytest.mark.full,
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(own_target() != "linux64", reason="the masters are installed and compared on Linux"),
]


@pytest.mark.parametrize("name", ["mass-on-spring", "gimbal-rotor"])
@pytest.mark.parametrize("master", CLIENTS)
def test_other_masters_get_the_bits_of_the_run_in_process(master, name, tmp_path):
    require(master)
    scene = load_scene(name)
    step = scene.master.step
    reference = run(scene.with_changes({"stop_time": LOOKS * EVERY * step, "record.interval": None}), in_process=True)
    (path,) = build_scene_fmu(scene, tmp_path, [own_target()])
    whole = read_scene({"stop_time": LOOKS * EVERY * step, "units": {"whole": {"fmu": str(path)}}, "master": {"step": step}})
    theirs, _ = run_in(
        master, write(whole, tmp_path / "whole.ssp", {}), step, LOOKS, EVERY, [("whole", n, "real") for n in reference.columns]
    )
    ours = np.column_stack([np.asarray(reference[n])[EVERY::EVERY] for n in reference.columns])
    assert theirs.tobytes() == ours.tobytes()
