"""Which communication steps an FMU takes, whether its description says so, and what can be read after one that is discarded."""

import math
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.fmus.build import build
from cosimo.fmus.native.build import own_target, pack
from cosimo.fmus.native.description import ABILITIES
from cosimo.orchestrator.scene_fmu import build_scene_fmu
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.fmus.native.support import compiled
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2LastSuccessfulTime,
    fmi2Terminated,
)
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")
# own ones: FMPy's default logger is the last one that was given to `simulate_fmu`, even where that is no more
CALLBACKS = fmi2CallbackFunctions(
    fmi2CallbackLoggerTYPE(lambda env, name, status, category, message: None),
    fmi2CallbackAllocateMemoryTYPE(calloc),
    fmi2CallbackFreeMemoryTYPE(free),
)
STARTS = (0.0, 0.3, -7.0, 1e5, 1e9)
H = 0.005


class Host:
    """FMI 2 and 3 under the same names."""

    def __init__(self, fmu, references, version, start=0.0):
        self.fmu, self.references, self.version, self.last, self.ended = fmu, references, version, start, False
        if version == 2:
            fmu.setupExperiment(startTime=start)
            fmu.enterInitializationMode()
        else:
            fmu.enterInitializationMode(startTime=start)
        fmu.exitInitializationMode()

    @classmethod
    def of(cls, path, start=0.0, before=lambda fmu, references: None):
        """A new instance in step mode; before: is called with it and the value references before it is initialized."""
        described = fmpy.read_model_description(str(path))
        version = int(described.fmiVersion[0])
        kind = {2: FMU2Slave, 3: FMU3Slave}[version]
        fmu = kind(
            guid=described.guid,
            unzipDirectory=fmpy.extract(str(path)),
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        fmu.instantiate(**({"callbacks": CALLBACKS} if version == 2 else {}))
        references = {v.name: v.valueReference for v in described.modelVariables}
        before(fmu, references)
        return cls(fmu, references, version, start)

    def step(self, t, h):
        """The status: 0 of a step that was made, 2 of one that was discarded."""
        try:
            self.fmu.doStep(t, h)
        except FMICallException as error:
            return error.status
        return 0

    def get(self, *names):
        references = [self.references[n] for n in names]
        return self.fmu.getReal(references) if self.version == 2 else self.fmu.getFloat64(references)

    def put(self, name, value):
        (self.fmu.setReal if self.version == 2 else self.fmu.setFloat64)([self.references[name]], [value])

    def save(self):
        return self.fmu.getFMUstate() if self.version == 2 else self.fmu.getFMUState()

    def restore(self, state):
        self.fmu.setFMUstate(state) if self.version == 2 else self.fmu.setFMUState(state)

    def end(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """The FMUs of a scene with a macro step of 5 ms, of both versions of FMI."""
    scene = load_scene("mass-on-spring").with_changes({"master.step": H})
    return build_scene_fmu(scene, tmp_path_factory.mktemp("scene"), [own_target()], (2, 3))


def test_a_step_is_right_within_the_rounding_of_times(scenes):
    """Masters form steps as differences of times: at 1e5 s they are off by 1.5e-11 s, at 1e9 s by 1.2e-7 s."""
    for path in scenes:
        for start in STARTS:
            host = Host.of(path, start)
            times = [start + k * H for k in range(30)]
            positions = []
            for k, (t, after) in enumerate(pairwise(times)):
                assert host.step(t, after - t) == 0, (path.name, start, k)
                positions += host.get("mass.base_x")
            assert host.step(times[-1], times[-1] + 3 * H - times[-1]) == 0  # several macro steps at once
            whole = math.ulp(start + 33 * H)
            for wrong in (0.007, 0.0049, H + 9 * whole + 1e-9, 0.5 * H):
                assert host.step(times[-1] + 3 * H, wrong) == 2, (path.name, start, wrong)
            host.end()
            if start == 0.0:
                expected = positions
            assert positions == expected, (path.name, start)  # the model does not know the time


def test_a_refused_step_changes_nothing_and_the_right_one_follows(scenes):
    for path in scenes:
        host = Host.of(path)
        assert host.step(0.0, H) == 0
        before = host.get("mass.base_x", "mass.base_velocity_x")
        assert host.step(H, 1.4 * H) == 2
        assert host.get("mass.base_x", "mass.base_velocity_x") == before
        if host.version == 2:
            assert host.fmu.getRealStatus(fmi2LastSuccessfulTime) == H
            assert host.fmu.getBooleanStatus(fmi2Terminated)
        assert host.step(H, H) == 0
        assert host.get("mass.base_x") != before[:1]
        host.end()


def test_after_a_step_that_fails_the_last_results_are_read_and_a_state_goes_on(tmp_path):
    for version in (2, 3):
        host = Host.of(pack(compiled("ServoMotor"), tmp_path, version))
        names = ("rate", "voltage")
        host.put("voltage", 5.0)
        assert host.step(0.0, 0.01) == 0
        before, state = host.get(*names), host.save()
        host.put("voltage", 1e308)
        assert host.step(0.01, 0.01) == 2
        assert host.get("rate") == before[:1]
        if version == 2:
            assert host.fmu.getRealStatus(fmi2LastSuccessfulTime) == 0.01
            assert host.fmu.getBooleanStatus(fmi2Terminated)
        failed = host.save()  # allowed, and a state like others
        assert host.step(0.01, 0.01) == 3
        host.restore(state)
        assert (host.get(*names), host.step(0.01, 0.01)) == (before, 0)
        host.restore(failed)
        assert host.get("rate") == before[:1]
        host.end()


def test_the_description_says_which_steps_are_taken(scenes, tmp_path):
    """A step of 0.007 s is taken where steps may vary, and refused where not."""
    components = [pack(compiled(name), tmp_path, version) for name in ("ServoMotor", "ServoController") for version in (2, 3)]
    for path in [*scenes, *components, build("ServoController", tmp_path / "python")]:
        assert validate_fmu(str(path)) == []
        ability = fmpy.read_model_description(str(path)).coSimulation
        host = Host.of(path)
        taken = host.step(0.0, 0.007) == 0
        assert ability.canHandleVariableCommunicationStepSize == taken, path.name
        fixed = ability.fixedInternalStepSize
        assert (fixed is not None) == (not taken and host.version == 3), path.name
        if fixed is not None:
            assert float(fixed) == H
        host.end()


def test_a_controller_samples_at_late_times_in_the_step_that_reaches_its_instant():
    for name in ("ServoController", "GimbalController", "RovController"):
        for start in STARTS:
            component = component_class(name)()
            component.initialize(start)
            period, samples = component.parameters["period"], []
            times = [start + k * period for k in range(12)]
            for t, after in pairwise(times):
                component.step(t, after - t)
                samples.append(int(component.counts[1]))
            assert samples == list(range(1, 12)), (name, start)


@pytest.mark.full
def test_every_component_takes_steps_of_any_length():
    """As the descriptions of its FMUs say, in every packaging, which have the same step."""
    for name in CATALOGUE:
        component = component_class(name)()
        component.initialize(0.0)
        t = 0.0
        for share in (1.0, 0.7, 0.01, 0.313, 1.0):
            h = share * component.default_step
            component.step(t, h)
            t += h
            assert np.isfinite(component.y).all(), (name, share)
    for fmi in (2, 3):
        assert ABILITIES[fmi]["canHandleVariableCommunicationStepSize"] == "true"
