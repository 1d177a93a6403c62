"""Smoothing: extrapolated inputs that start where they ended."""

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE, hold_inputs
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import open_master
from cosimo.tests.support import OfTime, exact_two_masses, two_masses

HERE = "cosimo.tests.engine.algorithms.test_smoothing"
STATES = [("a", "x_out"), ("a", "v_out"), ("b", "x_out"), ("b", "v_out")]


class Wave(OfTime):
    """Gives sin(3 t)."""

    y = output("m", "wave")

    def _outputs(self, t):
        self.y[0] = np.sin(3.0 * t)


class Listener(Component):
    """Gives the last value of its input."""

    u_in = input_(0.0, "m", "input")
    y = output("m", "input at the end of the step")

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        hold_inputs(self.u, h)
        self._outputs(t + h)
        return DONE

    def _outputs(self, t):
        self.y[0] = self.u[0, 0]


def driven(scene: dict, unit: str) -> list[tuple[float, float, float, float]]:
    """(value, slope, half second derivative, h) that a unit was given in each step, of its first input."""
    master, step, given = open_master(scene, ()), scene["master"]["step"], []
    for k in range(round(scene["stop_time"] / step)):
        master.step(k * step, step)
        given.append((*master.node_of[unit].given[0, :3].tolist(), step))
    return given


def wave(degree: int, smoothing: bool, step: float = 0.05) -> dict:
    return {
        "stop_time": 1.0,
        "units": {"w": {"component": f"{HERE}:Wave"}, "l": {"component": f"{HERE}:Listener"}},
        "connections": ["w.y -> l.u_in"],
        "master": {"algorithm": "jacobi", "step": step, "extrapolation": degree} | ({"smoothing": True} if smoothing else {}),
    }


@pytest.mark.parametrize("degree", [1, 2])
def test_inputs_have_no_jumps_and_end_where_the_extrapolation_ends(degree):
    smooth = driven(wave(degree, True), "l")
    ends = [v + h * (s + h * c) for v, s, c, h in smooth]
    np.testing.assert_allclose([v for v, *_ in smooth[1:]], ends[:-1], rtol=0, atol=1e-15)
    plain = driven(wave(degree, False), "l")
    np.testing.assert_allclose(ends, [v + h * (s + h * c) for v, s, c, h in plain], rtol=0, atol=1e-14)
    is_discrete = [v - (pv + h * (ps + h * pc)) for (v, *_), (pv, ps, pc, h) in zip(plain[1:], plain[:-1], strict=True)]
    assert np.abs(is_discrete).max() > 1e-3  # without it there are some
    np.testing.assert_allclose([c for _, _, c, _ in smooth], [c for _, _, c, _ in plain], atol=1e-10)  # and the curvature stays


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_the_order_of_accuracy_is_kept(algorithm):
    """The gap that is closed over a step is the error of the extrapolation before, of the same order."""
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        scene = two_masses(algorithm, step, 1)
        scene["master"]["smoothing"] = True
        result = run(read_scene(scene))
        errors.append(np.abs(np.array([result[f"{u}.{n}"][-1] for u, n in STATES]) - exact_two_masses(1.0)).max())
    slope = -np.polyfit(np.log([1.0, 2.0, 4.0]), np.log(errors), 1)[0]
    assert abs(slope - 2.0) < 0.15


def test_in_gauss_seidel_inputs_from_later_units_are_smoothed_and_the_others_end_at_fresh_values():
    """b is led ahead, a comes behind it: it ends at the force that b has given, which is not the one of the instant before."""
    scene = two_masses("gauss-seidel", 0.01, 1)
    scene["master"] |= {"smoothing": True, "order": ["b", "a"]}
    led, behind = driven(scene, "b"), driven(scene, "a")
    ends = [v + h * s for v, s, _, h in led]
    np.testing.assert_allclose([v for v, *_ in led[1:]], ends[:-1], rtol=0, atol=1e-14 * np.abs(ends).max())
    del scene["master"]["smoothing"]
    assert behind[0] == driven(scene, "a")[0]  # nothing has been led before the first step
    plain = driven(scene, "b")
    assert np.abs(np.array([v for v, *_ in plain[1:]]) - [v + h * s for v, s, _, h in plain[:-1]]).max() > 1e-6


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"extrapolation": 0}, ["held inputs", "extrapolation of 1 or 2"]),
        ({"algorithm": "iterative"}, ["iterative interpolates"]),
        ({"algorithm": "gauss-seidel"}, ["no input is extrapolated"]),
    ],
)
def test_smoothing_without_effect_is_refused(change, named):
    scene = wave(1, True)
    scene["master"] |= change
    with pytest.raises(BadInput) as caught:
        read_scene(scene)
    for part in ("master.smoothing", *named):
        assert part in str(caught.value)
