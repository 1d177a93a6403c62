"""References: against closed forms and matrix exponentials, by both ways they are found; and when there is none."""

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import output, parameter
from cosimo.orchestrator.harness.studies.coupled_ode import CoupledOde, rate_kernel
from cosimo.orchestrator.harness.studies.quantities import quantities_of
from cosimo.orchestrator.harness.studies.reference import MESH, reference, remaining_error
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.engine.algorithms.oscillators import TwoMasses
from cosimo.tests.short_run import ONE_A_SYSTEM, full_but
from cosimo.tests.support import OfTime

SMOOTH = [name for name in CATALOGUE if rate_kernel(component_class(name)) is not None]
PAIR = {**TwoMasses().scene("FD", 1e-2, 0.5), "record": {"signals": ["a.x_out", "b.x_out"]}}


def with_states(cls):
    """An initialized component; some have states with an effect only."""
    for effects in ((), *((effect,) for effect in cls.effects)):
        component = cls(effects, preset="" if effects else next(iter(cls.presets), ""))
        component.initialize(0.0)
        if component.x.size:
            return component
    raise AssertionError("no states")


@pytest.mark.parametrize("name", full_but(ONE_A_SYSTEM[:2], SMOOTH))
def test_rates_are_what_a_short_step_makes_of_the_state(name):
    """The kernel that SciPy is given is the equation the component itself integrates."""
    cls = component_class(name)
    component = with_states(cls)
    saved, dx = component.save(), np.empty_like(component.x)
    before = component.x.copy()
    rate_kernel(cls)(0.0, component.x, component.u[0], dx, *component.arguments)
    slopes = []
    for h in (1e-5, 5e-6):
        component.step(0.0, h)
        slopes.append((component.x - before) / h)
        component.restore(saved)
    scale = np.abs(dx).max() + np.abs(before).max()
    np.testing.assert_allclose(dx, 2.0 * slopes[1] - slopes[0], rtol=1e-4, atol=1e-5 * scale)


def test_a_smooth_scene_is_solved_as_one_differential_equation():
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 2.0})
    found = reference(scene, quantities_of(scene), 5e-3)
    assert "DOP853" in found.method
    assert len(found.second) == 1
    spring = scene.units["spring"].parameters  # the mass is 1 kg and starts with 1 m/s
    decay = 0.5 * spring["damping"]
    omega = np.sqrt(spring["stiffness"] - decay**2)
    t = found.history.time
    np.testing.assert_allclose(found.history.columns["mass.base_x"], np.exp(-decay * t) * np.sin(omega * t) / omega, atol=1e-10)
    assert found.uncertainty["mass.base_x, time history"] < 1e-7  # LSODA at 1e-9 is what limits it


def test_other_scenes_are_solved_by_the_master():
    scene = read_scene(PAIR)
    with pytest.raises(BadInput, match="smooth differential equation"):
        CoupledOde(scene)
    found = reference(scene, quantities_of(scene), 1e-3)
    assert "iterative, quadratic" in found.method
    assert all("gauss-seidel" in method for method in found.second)
    states = np.array([TwoMasses().exact(t)[[0, 2]] for t in found.history.time[::200]])
    size = np.abs(states).max()
    for column, values in zip(("a.x_out", "b.x_out"), states.T, strict=True):
        worst = np.abs(found.history.columns[column][::200] - values).max() / size
        assert worst < 2.0 * max(found.uncertainty.values())  # the second solution does not promise too much
        assert worst < 1e-4


class Meshed(OfTime):
    """A slope of 1 that elements of length h miss by h², as a method of second order does."""

    title = "slope with a mesh"
    element = parameter(0.1, "m", "length of the elements")
    total = output("1", "the integral of the slope")

    def _outputs(self, t: float) -> None:
        self.y[0] = t * (1.0 + self.get("element") ** 2)


def test_the_error_of_a_mesh_is_part_of_the_reference_s_own():
    """The reference has elements half as long; what it still misses is known here in closed form."""
    unit = {"component": f"{__name__}:Meshed"}
    scene = read_scene({"stop_time": 1.0, "units": {"m": unit}, "master": {"step": 0.1}, "study": {"mesh": ["m.element"]}})
    quantities = quantities_of(scene)
    found = reference(scene, quantities, 0.1)
    assert MESH in found.shares
    assert "elements x 0.5" in found.method
    assert found.history.columns["m.total"][-1] == pytest.approx(1.0 + 0.05**2, rel=1e-12)
    name = "m.total, maximum"
    assert found.agreement[name] == 0.0  # two solutions with one mesh agree, and are wrong all the same
    assert found.uncertainty[name] == pytest.approx(0.05**2, rel=2e-2)  # the distances are shares of ranges that differ


@pytest.mark.parametrize(
    ("coarse", "fine", "remaining"),
    [(4.0, 1.0, 1.0 / 3.0), (2.0, 1.0, 1.0), (64.0, 1.0, 1.0 / 3.0), (0.5, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)],
)
def test_what_remains_behind_three_meshes(coarse, fine, remaining):
    """No order is taken below 1, which would promise nothing, or above 2, which three meshes may feign."""
    assert remaining_error(coarse, fine) == pytest.approx(remaining)


def test_a_monolith_is_a_further_solution():
    whole = {"scene": "mass-on-spring", "signals": {"mass.base_x": "mass.base_x"}}
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.5, "study.monolith": whole})
    found = reference(scene, quantities_of(scene), 5e-3)
    assert len(found.second) == 2
    _, (method, errors) = found.second.items()
    assert method.startswith("mass-on-spring: ")
    assert max(errors.values()) == 0.0  # here it is the very same scene


def test_a_monolith_without_the_signals_is_refused():
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.5, "study.monolith": {"scene": "damped-chain"}})
    with pytest.raises(BadInput, match="none of the signals"):
        reference(scene, quantities_of(scene), 5e-3)


def test_a_scene_whose_runs_all_fail_has_no_reference():
    scene = read_scene(
        {**PAIR, "units": {**PAIR["units"], "b": {"component": "cosimo.tests.support:Oscillator", "parameters": {"kc": -1e12}}}}
    )
    with pytest.raises(BadInput, match="two that can be compared"):
        reference(scene, quantities_of(scene), 1e-3)
