"""References: against closed forms and matrix exponentials, by both ways they are found; and when there is none."""

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.studies.coupled_ode import CoupledOde, rate_kernel
from cosimo.orchestrator.harness.studies.quantities import quantities_of
from cosimo.orchestrator.harness.studies.reference import reference
from cosimo.orchestrator.scene.scene import load_scene, read_scene
from cosimo.tests.engine.algorithms.oscillators import TwoMasses

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


@pytest.mark.parametrize("name", SMOOTH)
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
    assert "DOP853" in found.how
    assert len(found.witnesses) == 1
    spring = scene.units["spring"].parameters  # the mass is 1 kg and starts with 1 m/s
    decay = 0.5 * spring["damping"]
    omega = np.sqrt(spring["stiffness"] - decay**2)
    t = found.course.time
    np.testing.assert_allclose(found.course.columns["mass.base_x"], np.exp(-decay * t) * np.sin(omega * t) / omega, atol=1e-10)
    assert found.floor < 1e-7  # LSODA at 1e-9 is what limits it


def test_other_scenes_are_solved_by_the_master():
    scene = read_scene(PAIR)
    with pytest.raises(BadInput, match="smooth differential equation"):
        CoupledOde(scene)
    found = reference(scene, quantities_of(scene), 1e-3)
    assert "iterative, quadratic" in found.how
    assert "gauss-seidel" in found.witnesses[0].how
    states = np.array([TwoMasses().exact(t)[[0, 2]] for t in found.course.time[::200]])
    size = np.abs(states).max()
    for column, values in zip(("a.x_out", "b.x_out"), states.T, strict=True):
        worst = np.abs(found.course.columns[column][::200] - values).max() / size
        assert worst < 2.0 * found.floor  # the witness does not promise too much
        assert worst < 1e-4


def test_a_monolith_is_a_further_witness():
    whole = {"scene": "mass-on-spring", "signals": {"mass.base_x": "mass.base_x"}}
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.5, "study.monolith": whole})
    found = reference(scene, quantities_of(scene), 5e-3)
    assert len(found.witnesses) == 2
    assert found.witnesses[1].how.startswith("mass-on-spring: ")
    assert found.witnesses[1].worst == 0.0  # here it is the very same scene


def test_a_monolith_without_the_signals_is_refused():
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.5, "study.monolith": {"scene": "damped-chain"}})
    with pytest.raises(BadInput, match="none of the signals"):
        reference(scene, quantities_of(scene), 5e-3)


def test_a_scene_whose_runs_all_fail_has_no_reference():
    scene = read_scene({**PAIR, "units": {**PAIR["units"], "b": {"component": "cosimo.tests.support:Oscillator",
                                                                "parameters": {"kc": -1e12}}}})
    with pytest.raises(BadInput, match="two that can be compared"):
        reference(scene, quantities_of(scene), 1e-3)
