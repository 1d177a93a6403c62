"""What other masters get from a package: explicit Euler's closed form for two integrators in a ring."""

import numpy as np
import pytest
from cosimo import BadInput, load_scene
from cosimo.orchestrator.harness.other_masters import OtherMasters, as_other_masters
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import read_scene, write_scene
from cosimo.tests.commands import exit_code

H, STOP = 0.05, 5.0


@pytest.fixture
def ring(folder):
    """a' = 1 - b, b' = a from rest: b = 1 - cos t."""
    return {
        "stop_time": STOP,
        "units": {n: {"fmu": str(folder / "adder.fmu")} for n in "ab"},
        "connections": [{"source": "b.x", "target": "a.u", "factor": -1.0, "offset": 1.0}, "a.x -> b.u"],
        "master": {"algorithm": "gauss-seidel", "step": H, "extrapolation": 1},
        "study": {"quantities": ["b.x, time history", "b.x, end"]},
    }


def euler(h: float) -> np.ndarray:
    """b after every step of explicit Euler, which is Jacobi with held inputs here."""
    return 1.0 - ((1.0 + 1j * h) ** np.arange(round(STOP / h) + 1)).real


def test_what_other_masters_get_is_eulers_method(ring):
    scene = read_scene(ring)
    np.testing.assert_allclose(run(as_other_masters(scene))["b.x"], euler(H), rtol=1e-12, atol=1e-14)
    own = run(scene)["b.x"]
    found = OtherMasters(scene).compare()
    assert [row.there for row in found.rows] == pytest.approx([euler(H).mean(), euler(H)[-1]], rel=1e-12)
    assert found.rows[0].difference == pytest.approx(np.sqrt(np.mean((euler(H) - own) ** 2)) / np.ptp(own), rel=1e-9)


def test_a_step_that_holds_is_found_by_halving(ring):
    masters = OtherMasters(read_scene(ring))
    assert masters.compare().difference > 0.02
    found = masters.step_within(0.02)
    assert found.difference <= 0.02 < masters.compare(2.0 * found.step).difference


def test_what_only_this_master_has_is_left_away(ring):
    ring["units"]["a"]["every"] = 2
    ring["faults"] = [{"kind": "offset", "signal": "a.x", "begin": 1.0, "value": 1.0}]
    scene = as_other_masters(read_scene(ring))
    assert (scene.master.algorithm, scene.master.extrapolation, scene.faults) == ("jacobi", 0, ())
    assert scene.units["a"].every == 1


def test_the_command_needs_force_beyond_its_tolerance(ring, tmp_path, capsys):
    source, path = tmp_path / "ring.toml", tmp_path / "ring.ssp"
    write_scene(read_scene(ring), source)

    def ssp(*options: str) -> tuple[int, str, str]:
        end = exit_code("ssp", str(source), "-o", str(path), "--tolerance", "2%", *options)
        captured = capsys.readouterr()
        return end, captured.out, captured.err

    code, out, err = ssp()
    assert (code, path.exists()) == (1, False)
    assert "is not written: other masters would be farther than 2 %" in err
    offered = out.partition("With --step ")[2].split()[0]
    assert ssp("--step", offered)[0] == 0
    assert load_scene(path).master.step == float(offered)
    path.unlink()
    assert (ssp("--force")[0], path.exists()) == (0, True)


def test_a_scene_that_does_not_reach_its_end_is_refused(ring):
    ring["connections"][0]["factor"] = 1e6
    ring["stop_time"] = 50.0
    with pytest.raises(BadInput, match="expected a scene that runs to its end"):
        OtherMasters(read_scene(ring))
