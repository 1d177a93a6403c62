"""Native FMUs beside the component in process: the same inputs, and every number compared."""

import functools
import itertools
import math
from pathlib import Path

import numpy as np
from cosimo.components.catalogue import component_class
from cosimo.fmus.interface import interface
from cosimo.fmus.native.build import library, own_target, pack
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

FMI3 = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}  # types by their names in FMI 2
SHARE = 0.01  # of an input's start or nominal value, by which it moves


def maker(name, effects=(), parameters=()):
    """A function that makes the component anew."""
    return lambda: component_class(name)(effects, dict(parameters))


@functools.cache
def compiled(name, effects=(), parameters=()):
    """The compiled component, once a test run."""
    return library(name, maker(name, effects, parameters), [own_target()])


def opened(found, folder, version=2, guid=""):
    """An instance of FMPy's, in the state after instantiation, and the value references by name."""
    path = pack(found, Path(folder), version)
    description = read_model_description(str(path))
    slave = {2: FMU2Slave, 3: FMU3Slave}[version]
    fmu = slave(
        guid=guid or description.guid,
        unzipDirectory=extract(str(path)),
        instanceName="unit",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    return fmu, {v.name: v.valueReference for v in description.modelVariables}


def amplitudes(component, start, share=SHARE):
    """By how much each input moves around its start value."""
    scalars = {s.name: s for s in interface(type(component))}
    return [share * max(abs(u), 0.1 * scalars[n].nominal) for n, u in zip(component.inputs, start, strict=True)]


def driven(component, start, moved, k, h):
    """Inputs and their derivatives of step k; the first step begins with the start values."""
    t = k * h
    values = [u + a * math.sin(7.0 * t + i) - a * math.sin(i) for i, (u, a) in enumerate(zip(start, moved, strict=True))]
    slopes = [0.5 * a * (k % 3) for a in moved]
    curves = [-0.25 * a * (k % 2) for a in moved]
    return values, slopes, curves


def in_process(component, h, steps, share=SHARE):
    """Outputs after initialization and after each step, (steps + 1, outputs)."""
    component.initialize(0.0)
    start = component.u[0].copy()
    moved = amplitudes(component, start, share)
    rows = [component.y.copy()]
    for k in range(steps):
        component.u[0], component.u[1], curves = driven(component, start, moved, k, h)
        component.u[2] = 0.5 * np.array(curves)
        component.step(k * h, h)
        rows.append(component.y.copy())
    return np.array(rows)


def native(found, folder, h, steps, version=2, restored_at=None, values=None):
    """The same of an FMU; at the step `restored_at` its state goes, as bytes, to another instance that has run elsewhere.

    `values`: of parameters and inputs (FMI 2), set in initialization mode.
    """
    component = found.component
    fmu, references = opened(found, folder, version)
    names = {"u": component.inputs, "y": component.outputs}
    form = ("{}", "der({})", "der({},2)")
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
        inputs = [references[f.format(n)] for f in form for n in names["u"]]
        put = fmu.setReal
    else:
        inputs = [references[n] for f in form for n in dict.fromkeys(base(f.format(m), references) for m in names["u"])]
        put = fmu.setFloat64
    fmu.enterInitializationMode()
    start = component.u[0].copy()
    for name, value in (values or {}).items():
        put([references[name]], [value])
        if name in component.inputs:
            start[component.inputs.index(name)] = value
    moved = amplitudes(component, start)
    outputs = by_type(found, names["y"])
    rows = [read(fmu, outputs, references, version)]
    fmu.exitInitializationMode()
    for k in range(steps):
        if k == restored_at:
            other, _ = opened(found, folder, version)
            state = fmu.getFMUState() if version == 3 else fmu.getFMUstate()
            content = fmu.serializeFMUState(state) if version == 3 else fmu.serializeFMUstate(state)
            again = other.deserializeFMUState(content) if version == 3 else other.deSerializeFMUstate(content)
            (other.setFMUState if version == 3 else other.setFMUstate)(again)
            fmu.freeFMUState(state) if version == 3 else fmu.freeFMUstate(state)
            fmu.freeInstance()
            fmu = other
            put = fmu.setReal if version == 2 else fmu.setFloat64
        values = driven(component, start, moved, k, h)
        if inputs:
            put(inputs, [v for row in values for v in row])
        fmu.doStep(k * h, h)
        rows.append(read(fmu, outputs, references, version))
    fmu.terminate()
    fmu.freeInstance()
    return np.array(rows)


def base(name, references):
    """The name under which FMI 3 has a scalar: an element of an array is part of the array."""
    return name if name in references else name.partition("[")[0]


def by_type(found, names):
    """Outputs in runs of one type: [(type of FMI 2, names)]."""
    types = {v.scalar.name: v.scalar.type for v in found.variables}
    runs = itertools.groupby(names, key=lambda n: types.get(n) or types[f"{n.partition('[')[0]}[1]"])
    return [(kind, list(part)) for kind, part in runs]


def read(fmu, outputs, references, version):
    """The numbers of outputs, of runs of one type; counts and flags as numbers."""
    values = []
    for kind, names in outputs:
        get = getattr(fmu, f"get{kind if version == 2 else FMI3[kind]}")
        if version == 2:
            values += get([references[n] for n in names])
        else:
            values += get([references[n] for n in dict.fromkeys(base(m, references) for m in names)], nValues=len(names))
    return np.array(values, dtype=float)
