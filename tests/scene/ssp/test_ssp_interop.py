"""A system written here, run by libcosim: conversions, types and held inputs in numbers that follow by hand."""

import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.interop.masters import run_in


def test_libcosim_comes_to_the_same_numbers(folder):
    """Jacobi with held inputs and no feed-through within an instant is what libcosim does; units of measure are converted by
    a transformation, parameters of three types are set."""
    scene = read_scene(
        {
            "stop_time": 1.0,
            "units": {
                "a": {"fmu": str(folder / "metres.fmu"), "parameters": {"u": 0.3, "count": 1, "flag": True, "text": "abc"}},
                "b": {"fmu": str(folder / "mixed.fmu"), "parameters": {"gain": 1.5}},
                "c": {"fmu": str(folder / "metres.fmu")},
            },
            "connections": ["a.y -> b.u", {"source": "b.x", "target": "c.u", "factor": 0.1, "offset": 2.0}],
            "master": {"algorithm": "jacobi", "step": 0.01, "extrapolation": 0, "feedthrough": "delayed"},
        },
        "adders",
        folder,
    )
    ours = {name: column[-1] for name, column in run(scene).columns.items()}
    signals = [(*name.split("."), "real") for name in ours]
    last = run_in("libcosim", write(scene, folder / "there.ssp"), 0.01, 1, 100, signals)[0][0]
    theirs = dict(zip(ours, last.tolist(), strict=True))
    assert theirs["b.x"] == pytest.approx(1000.0 * 30101.3, rel=1e-13)  # a.y, in mm, over one second
    moved = [n for n in ours if n != "c.y"]  # which follows c's input: libcosim shows it with that of the step before
    assert [theirs[n] for n in moved] == pytest.approx([ours[n] for n in moved], rel=1e-13)  # rounding of 100 steps
    assert theirs["c.y"] == pytest.approx(2.0 + 0.1 * 1000.0 * 30101.3 * 0.99, rel=1e-13)
