"""One process that steps two coupled FMUs with a master: prints macro steps per second, and where the mass is at the end.

python peers.py WHO MSD.fmu CTRL.fmu STEPS; WHO: cosimo, recording (cosimo with every output of every step), ecos, libcosim,
fmpy or ctypes. On one core: several pythonfmu FMUs share one
interpreter, and masters with threads of their own lose most of their speed in handing its lock around.
"""

import ctypes
import os
import sys
from time import perf_counter

WIRES = (("p", "x", "c", "x"), ("p", "v", "c", "v"), ("c", "force", "p", "f"))
STEP = 1e-3  # s


def cosimo(msd, ctrl, steps, record=None):
    from cosimo.orchestrator.run.run import run
    from cosimo.orchestrator.scene.scene import read_scene

    scene = read_scene(
        {
            "stop_time": steps * STEP,
            "connections": [f"{a}.{x} -> {b}.{u}" for a, x, b, u in WIRES],
            "units": {"p": {"fmu": msd}, "c": {"fmu": ctrl}},
            "master": {"algorithm": "jacobi", "step": STEP, "extrapolation": 0},
            "record": {"signals": ["p.x"], "interval": steps * STEP} if record is None else record,
        }
    )
    result = run(scene)
    return result.info.timing.run, result["p.x"][-1].item()


def recording(msd, ctrl, steps):
    return cosimo(msd, ctrl, steps, record={})


def ecos(msd, ctrl, steps):
    from ecospy import EcosSimulation, EcosSimulationStructure

    system = EcosSimulationStructure()
    for name, path in (("p", msd), ("c", ctrl)):
        system.add_model(name, path)
    for a, x, b, u in WIRES:
        system.make_real_connection(f"{a}::{x}", f"{b}::{u}")
    simulation = EcosSimulation(structure=system, step_size=STEP)
    simulation.init()
    seconds = timed(lambda: simulation.step(steps))
    return seconds, simulation.get_real("p::x")


def libcosim(msd, ctrl, steps):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
    index, references = {}, {}
    for name, path in (("p", msd), ("c", ctrl)):
        index[name] = execution.add_local_slave(local_slave=CosimLocalSlave(fmu_path=path, instance_name=name))
        references[name] = {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=index[name])}
    for a, x, b, u in WIRES:
        execution.connect_real_variables(index[a], references[a][x], index[b], references[b][u])
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    seconds = timed(lambda: execution.step(step_count=steps))
    return seconds, observer.last_real_values(slave_index=index["p"], variable_references=[references["p"]["x"]])[0]


def started(path):
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(path, validate=False)
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(path),
        instanceName="unit",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, {v.name: v.valueReference for v in description.modelVariables}


def fmpy(msd, ctrl, steps):
    """A loop over FMPy's own methods, as its examples have it."""
    (p, vp), (c, vc) = started(msd), started(ctrl)
    motion, force = ([vp["x"], vp["v"]], [vc["x"], vc["v"]]), ([vc["force"]], [vp["f"]])

    def loop():
        for k in range(steps):
            moved, pushed = p.getReal(motion[0]), c.getReal(force[0])
            c.setReal(motion[1], moved)
            p.setReal(force[1], pushed)
            p.doStep(k * STEP, STEP)
            c.doStep(k * STEP, STEP)

    return timed(loop), p.getReal([vp["x"]])[0]


def bare(msd, ctrl, steps):
    """A loop over the C functions, with buffers made once and shared by the two ends of a connection."""
    (p, vp), (c, vc) = started(msd), started(ctrl)
    pointer, size, real = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double

    def functions(fmu):
        get, put, step = (fmu.dll[f"fmi2{name}"] for name in ("GetReal", "SetReal", "DoStep"))
        for function in (get, put):
            function.argtypes = (pointer, pointer, size, pointer)
        step.argtypes = (pointer, real, real, ctypes.c_int)
        return get, put, step, fmu.component

    arrays = [(ctypes.c_uint32 * len(r))(*r) for r in ([vp["x"], vp["v"]], [vc["x"], vc["v"]], [vc["force"]], [vp["f"]])]
    buffers = [(real * 2)(), (real * 1)()]
    out, into, given, taken = map(ctypes.addressof, arrays)
    moved, pushed = map(ctypes.addressof, buffers)
    p_get, p_set, p_step, a = functions(p)
    c_get, c_set, c_step, b = functions(c)

    def loop():
        for k in range(steps):
            p_get(a, out, 2, moved)
            c_get(b, given, 1, pushed)
            c_set(b, into, 2, moved)
            p_set(a, taken, 1, pushed)
            p_step(a, k * STEP, STEP, 1)
            c_step(b, k * STEP, STEP, 1)

    return timed(loop), p.getReal([vp["x"]])[0]


def timed(call):
    begin = perf_counter()
    call()
    return perf_counter() - begin


if __name__ == "__main__":
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    who, first, second, count = sys.argv[1:]
    masters = {"cosimo": cosimo, "recording": recording, "ecos": ecos, "libcosim": libcosim, "fmpy": fmpy, "ctypes": bare}
    seconds, reached = masters[who](first, second, int(count))
    print(f"{int(count) / seconds:.0f} {reached!r}")
    sys.stdout.flush()
    os._exit(0)  # libraries of others crash now and then in leaving
