"""The checks themselves, run by `check` in a process that may die: python -m fmus.check_worker FILE CHECK ..."""

from __future__ import annotations

import json
import math
import os
import re
import sys
import tempfile
import types
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from .evidence_check import replayed

STEPS = 20  # steps of the checks that compare two runs
NOT_OFFERED = "not offered"
CHANGE = b"""

ComponentSlave.exit_initialization_mode = lambda self: None
ComponentSlave.do_step = lambda self, current_time, step_size: True
ComponentSlave.get_real = lambda self, vrs: [1.0] * len(vrs)
"""


class Instance:
    """An instance of an FMU of FMI 2.0 or 3.0, initialized with its start values."""

    def __init__(self, path: str, folder: str, name: str):
        self.description = read_model_description(path, validate=False)
        self.fmi3 = self.description.fmiVersion.startswith("3.")
        if self.description.coSimulation is None or not (self.fmi3 or self.description.fmiVersion == "2.0"):
            raise ValueError(f"FMI {self.description.fmiVersion}, expected a co-simulation FMU of FMI 2.0 or 3.0")
        self.fmu: Any = (FMU3Slave if self.fmi3 else FMU2Slave)(
            guid=self.description.guid,
            unzipDirectory=folder,
            instanceName=name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )
        kind = "Float64" if self.fmi3 else "Real"
        numbers = [v for v in self.description.modelVariables if v.type == kind and all(d.start for d in v.dimensions or ())]
        self.outputs = [v for v in numbers if v.causality == "output"]
        self.inputs = [v for v in numbers if v.causality == "input" and not v.name.startswith("der(")]
        self.step_size = _step_size(self.description)
        self.fmu.instantiate(loggingOn=True)
        self.initialize()

    def initialize(self) -> None:
        if self.fmi3:
            self.fmu.enterInitializationMode(startTime=0.0)
        else:
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.steps = 0

    def run(self, steps: int = STEPS) -> np.ndarray:
        """Outputs after each of the next steps, (steps, outputs), while every input swings about its start."""
        rows = []
        read, write = (self.fmu.getFloat64, self.fmu.setFloat64) if self.fmi3 else (self.fmu.getReal, self.fmu.setReal)
        outputs, size = [v.valueReference for v in self.outputs], sum(map(_elements, self.outputs))
        more = (size,) if self.fmi3 else ()
        for _ in range(steps):
            if self.inputs:
                values = [
                    _swung(v, 0.3 * (self.steps + 1) + i, k) for i, v in enumerate(self.inputs) for k in range(_elements(v))
                ]
                write([v.valueReference for v in self.inputs], values)
            self.fmu.doStep(self.steps * self.step_size, self.step_size)
            self.steps += 1
            rows.append(read(outputs, *more))
        return np.array(rows).reshape(steps, -1)

    def save(self) -> Any:
        return self.fmu.getFMUState() if self.fmi3 else self.fmu.getFMUstate()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUState(state) if self.fmi3 else self.fmu.setFMUstate(state)

    def serialized(self, state: Any) -> Any:
        """The same state, once it has been bytes."""
        if self.fmi3:
            return self.fmu.deserializeFMUState(self.fmu.serializeFMUState(state))
        return self.fmu.deSerializeFMUstate(self.fmu.serializeFMUstate(state))

    def forget(self, state: Any) -> None:
        self.fmu.freeFMUState(state) if self.fmi3 else self.fmu.freeFMUstate(state)

    def free(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


def _step_size(description) -> float:
    experiment = description.defaultExperiment
    if experiment is not None and experiment.stepSize:
        return float(experiment.stepSize)
    return float(experiment.stopTime) / 100.0 if experiment is not None and experiment.stopTime else 1e-3


def _elements(variable: Any) -> int:
    return math.prod(int(d.start) for d in variable.dimensions or ())


def _swung(variable: Any, phase: float, element: int) -> float:
    """A value within a tenth of the nominal one beside the start, and within the variable's limits."""
    starts = str(variable.start or 0.0).split()
    value = float(starts[min(element, len(starts) - 1)]) + 0.1 * abs(float(variable.nominal or 1.0)) * math.sin(phase)
    low, high = (float(v) if v is not None else None for v in (variable.min, variable.max))
    value = value if low is None else max(value, low)
    return value if high is None else min(value, high)


def _same(one: np.ndarray, other: np.ndarray, what: str) -> tuple[bool, str]:
    if one.tobytes() == other.tobytes():
        moved = int((one != one[0]).any(axis=0).sum()) if one.size else 0
        return True, f"{what}: the same {one.size} numbers, bit for bit; {moved} of {one.shape[1]} outputs moved"
    return False, f"{what}: the numbers differ by up to {np.abs(one - other).max():g}"


def model_description(path: str, folder: str) -> tuple[bool, str]:
    """XML schema, names, structure, start values and units, by FMPy."""
    problems = validate_fmu(path)
    return not problems, "; ".join(problems) or "no problems found"


def default_experiment(path: str, folder: str) -> tuple[bool, str]:
    """FMPy alone simulates the default experiment; every output is finite and the stop time is reached."""
    experiment = read_model_description(path, validate=False).defaultExperiment
    stop = float(experiment.stopTime) if experiment is not None and experiment.stopTime else 1.0
    result = simulate_fmu(path, validate=False, stop_time=stop, fmi_type="CoSimulation")
    bad = [n for n in result.dtype.names if not np.isfinite(result[n]).all()]
    if bad:
        return False, "not finite: " + ", ".join(bad)
    end = float(result["time"][-1])
    return math.isclose(end, stop), f"{len(result)} rows, {len(result.dtype.names) - 1} outputs, ended at {end:g} s of {stop:g} s"


def evidence(path: str, folder: str) -> tuple[bool, str]:
    """Experiments that the FMU brings along give the results that it promises."""
    return replayed(path)


def state(path: str, folder: str) -> tuple[bool, str]:
    """Save, step, restore, step again: bit-identical; then the same through the serialized state."""
    unit = Instance(path, folder, "state")
    offered = unit.description.coSimulation
    if not offered.canGetAndSetFMUstate:
        unit.free()
        return True, NOT_OFFERED
    unit.run()
    saved, at = unit.save(), unit.steps
    first = unit.run()
    unit.restore(saved)
    unit.steps = at
    ok, detail = _same(first, unit.run(), "after restoring")
    if ok and offered.canSerializeFMUstate:
        copy = unit.serialized(saved)
        unit.restore(copy)
        unit.steps = at
        ok, detail = _same(first, unit.run(), "after restoring and after serializing")
        unit.forget(copy)
    unit.forget(saved)
    unit.free()
    return ok, detail


def reset(path: str, folder: str) -> tuple[bool, str]:
    """After a reset the run is the same again."""
    unit = Instance(path, folder, "reset")
    first = unit.run()
    unit.fmu.reset()
    unit.initialize()
    answer = _same(first, unit.run(), "after a reset")
    unit.free()
    return answer


def two_instances(path: str, folder: str) -> tuple[bool, str]:
    """A second instance, stepped in turn with the first, changes nothing."""
    alone = Instance(path, folder, "alone")
    expected = alone.run()
    alone.free()
    first = Instance(path, folder, "first")
    if first.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
        first.free()
        return True, NOT_OFFERED
    second = Instance(path, folder, "second")
    second.run(STEPS // 2)
    rows = []
    for _ in range(STEPS):
        rows.append(first.run(1))
        second.run(1)
    answer = _same(expected, np.concatenate(rows), "beside a second instance")
    first.free()
    second.free()
    return answer


def other_bundle(path: str, folder: str) -> tuple[bool, str]:
    """An FMU of the same component with other code, loaded first, runs its own code, and this one its own."""
    if not _bundles(path):
        return True, f"{NOT_OFFERED}: {_without_python(path)}"
    with tempfile.TemporaryDirectory() as directory:
        changed = changed_copy(Path(path), Path(directory))
        place = os.environ.get("COSIMO_CACHE")
        os.environ["COSIMO_CACHE"] = directory  # the changed code shall not stay in the user's cache
        theirs = Instance(str(changed), str(extracted(changed, directory)), "unit")
        os.environ.pop("COSIMO_CACHE") if place is None else os.environ.update(COSIMO_CACHE=place)
        ours = Instance(path, folder, "unit")
        moved, own = theirs.run(), ours.run()
        theirs.free()
        ours.free()
    if not (moved == 1.0).all():
        return False, "another FMU of this name runs this one's code"
    return not (own == 1.0).all(), "beside an FMU of this name whose outputs are all 1"


def host_packages(path: str, folder: str) -> tuple[bool, str]:
    """A host that has imported packages called `components` and `slave` of its own does not change the answers."""
    if not _bundles(path):
        return True, f"{NOT_OFFERED}: {_without_python(path)}"
    for name in ("components", "components.core", "components.catalogue", "slave", "interface", "fmus"):
        sys.modules[name] = types.ModuleType(name)
    unit = Instance(path, folder, "unit")
    rows = unit.run()
    unit.free()
    return bool(np.isfinite(rows).all()), f"{rows.size} finite numbers beside a host's own packages"


def _without_python(path: str) -> str:
    own = (read_model_description(path, validate=False).generationTool or "").startswith("cosimo ")
    return "it holds no code in Python" if own else "made by another tool"


def _bundles(path: str) -> list[str]:
    with zipfile.ZipFile(path) as file:
        return [m.split("/")[1] for m in file.namelist() if re.fullmatch(r"resources/bundle_[0-9a-f]+/__init__\.py", m)]


def changed_copy(path: Path, directory: Path) -> Path:
    """A copy of one of our FMUs whose outputs are all 1, under a digest of its own, as a rebuild after an edit has it."""
    old = _bundles(str(path))[0].removeprefix("bundle_")
    new = "f" * len(old)
    copy = directory / path.name
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(copy, "w") as target:
        for member in source.namelist():
            content = source.read(member)
            if member.startswith("resources/") and not member.startswith("resources/pythonfmu/"):
                content = content.replace(old.encode(), new.encode())
            if member == f"resources/bundle_{old}/slave.py":
                content += CHANGE
            target.writestr(member.replace(old, new), content)
    return copy


def extracted(path: Path, directory: str) -> Path:
    """The FMU's folder below `directory`."""
    folder = Path(directory) / "extracted"
    with zipfile.ZipFile(path) as file:
        file.extractall(folder)
    return folder


CHECKS = {
    f.__name__: f
    for f in (model_description, default_experiment, evidence, state, reset, two_instances, other_bundle, host_packages)
}
READING = ("model_description",)  # these execute nothing of the FMU
ALONE = ("other_bundle", "host_packages")  # these need a process that has not loaded the FMU before
GROUPS = (tuple(n for n in CHECKS if n not in ALONE), *((n,) for n in ALONE))


def main(path: str, *names: str) -> None:
    """Run the named checks on an FMU, each reported before the next one starts."""
    findings = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what an FMU prints is no finding
    with tempfile.TemporaryDirectory() as directory:
        folder = str(extracted(Path(path), directory)) if set(names) - set(READING) else ""
        for name in names:
            try:
                ok, detail = CHECKS[name](path, folder)
            except Exception as error:
                ok, detail = False, f"{type(error).__name__}: {error}"
            print("finding " + json.dumps({"name": name, "ok": bool(ok), "detail": detail}), file=findings, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
