"""Speed of the railway pair: whole runs, ratios within one process, errors against an independent solution.

Run with `pytest -n 0 tests/benchmarks --write-page`. Nothing here is a statement about another machine.
"""

import subprocess
import sys
import time

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.pantograph import Pantograph
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter, uniform
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.modal import Head, Line, passage
from cosimo.orchestrator.systems.railway.records import passages

EFFECTS = ["dropper_slackening", "gravity_sag", "damping"]
SIGNALS = ["pantograph.contact_force", "pantograph.contact_position", "catenary.wire_height"]
NARROW = {"moving_window.behind": 180.0}  # half of what 0.5 % of the force asks for
WINDOW = np.linspace(240.0, 360.0, 1201)


def scene(step=1e-3, effects=(), spans=10, **parameters):
    """The EN 50318:2002 scene without pictures: only what the statistics need is recorded."""
    changes = {"units.catenary.effects": [*EFFECTS, *effects], "record": {"signals": SIGNALS}, "master.step": step}
    narrow = NARROW if "moving_window" in effects else {}
    changes |= {f"catenary.{n}": v for n, v in {"spans": spans, **narrow, **parameters}.items()}
    return load_scene("en50318-2002").with_changes(changes)


def best(scene, in_process=True, runs=5):
    """Result and shortest CPU time of stepping of several warm runs, s."""
    results = [run(scene, in_process=in_process) for _ in range(runs + 1)][1:]
    return results[-1], min(r.info.timing.cpu for r in results)


def filtered(result):
    """20 Hz-filtered contact force over spans 5 and 6 on a fixed grid of positions, N."""
    record = passages(result)[0].record
    rate, _, (position, force) = uniform(record.time, record.position, record.force)
    return np.interp(WINDOW, position, ButterworthFilter().apply(force, rate))


@pytest.fixture(scope="module")
def reference():
    """Strings as sine series of 6000 modes, exact in time, on the same grid, N."""
    force = passage(Line(), Head(), 69.444444, 30.0, 5.0, 6000, 5e-4)
    return np.interp(WINDOW, force[1], ButterworthFilter().apply(force[2], 2000.0))


def error(result, reference):
    """rms difference of the filtered force over its standard deviation."""
    return float(np.sqrt(np.mean((filtered(result) - reference) ** 2)) / reference.std())


QUADRATIC = {"master.extrapolation": 2}
SETTINGS = {  # the scene without pictures, of its ten spans, 5 s: elements of 0.4 m, substep 1 ms, linear extrapolation, unless told
    "as shipped": scene(),
    "macro step 2 ms": scene(2e-3),
    "macro step 2 ms, quadratic extrapolation": scene(2e-3).with_changes(QUADRATIC),
    "180 m behind": scene(1e-3, ["moving_window"]),
    "180 m behind, 2 ms, quadratic extrapolation": scene(2e-3, ["moving_window"]).with_changes(QUADRATIC),
    "elements of 0.25 m, substep 0.5 ms": scene(element=0.25, substep=5e-4),
    "sixty spans": scene(spans=60),
    "implicit": scene(method="implicit"),
    "implicit, elements of 1 m": scene(method="implicit", element=1.0),
}
THROUGH_FMUS = ("as shipped", "macro step 2 ms, quadratic extrapolation")


def test_accuracy_costs(reference, told):
    """At 1 % at least 60 times faster than real time in process and 20 times through FMUs."""
    measured = {}
    for in_process, labels in ((True, SETTINGS), (False, THROUGH_FMUS)):
        for label in labels:
            result, seconds = best(SETTINGS[label], in_process)
            factor, e = measured[label, in_process] = result.scene.stop_time / seconds, error(result, reference)
            name = label if in_process else f"FMUs of pythonfmu, {label}"
            told("railway", name, **{"× real time": factor, "error of the force's history": f"{100.0 * e:.2f} %"})
    told.target("EN 50318:2002 in process", measured["as shipped", True][0], 330.0, "× real time", least=True)
    told.target("the same, 180 m behind", measured["180 m behind", True][0], 380.0, "× real time", least=True)
    told.target("sixty spans of it", measured["sixty spans", True][0], 320.0, "× real time", least=True)
    told.target("EN 50318:2002 as FMUs of pythonfmu", measured["as shipped", False][0], 80.0, "× real time", least=True)
    assert any(e <= 0.01 and factor >= (60.0 if inside else 20.0) for (_, inside), (factor, e) in measured.items() if inside)
    assert any(e <= 0.01 and factor >= 20.0 for (_, inside), (factor, e) in measured.items() if not inside)


def test_cost_over_the_number_of_spans(told):
    """Linear where the whole line moves, flat behind the front; stepping time of equal runs near the start of longer and longer lines.

    A fine mesh makes the wires the whole cost, so that nothing fixed blurs the ratios.
    """
    seconds = {}
    for threshold in (0.0, 1e-4):
        for spans in (10, 20, 60):
            fine = scene(1e-3, (), spans, element=0.125, substep=1e-4, front_threshold=threshold).with_changes({"stop_time": 2.0})
            _, seconds[spans, threshold > 0.0] = best(fine, runs=3)
    for front, label in ((False, "the whole line moves"), (True, "behind the front")):
        told("spans", label, **{f"{n} spans, s": seconds[n, front] for n in (10, 20, 60)})
    assert 1.6 < seconds[20, False] / seconds[10, False] < 2.6
    assert 4.5 < seconds[60, False] / seconds[10, False] < 9.0  # 6 if linear; long lines leave the processor's nearest cache
    assert seconds[60, True] < 1.25 * seconds[10, True]


def on_line(name, effects, **parameters):
    """A shipped scene for 3 s, without pictures, its catenary with other effects and parameters on one mesh and substep."""
    loaded = load_scene(name)
    values = {
        "line_table.table": loaded.units["catenary"].parameters.get("line_table.table"),
        "element": 0.4,
        "substep": 5e-4,
        "damping.beta": 1e-3,
        **parameters,
    }
    return loaded.with_changes(
        {
            "units.catenary.effects": [*EFFECTS, *effects],
            "units.catenary.parameters": values,
            "record": {"signals": SIGNALS[:2]},
            "study": {},
            "analysis.spans": [2, 3],
            "stop_time": 3.0,
        }
    )


def test_price_of_a_second_wire_and_of_stagger(told):
    """Two contact wires, an overlap and lateral geometry against one straight contact wire on the same line: at most twice."""
    first, twin = (
        "\n".join(
            line
            for line in load_scene(name).units["catenary"].parameters["line_table.table"].splitlines()
            if "second_contact_wire" not in line
        )
        for name in ("overlap", "two-contact-wires")
    )
    one_wire = twin.replace(", second_positions = [8, 18, 26, 34, 42, 50, 60]", "")
    section = first.split("[[sections]]")[1].split("spans =")[0]
    whole = f"[[sections]]{section}spans = [{{ length = 60, repeat = 5 }}, 55, 50, 55, {{ length = 60, repeat = 5 }}]"
    zigzag = one_wire + "\nsupports = [" + ", ".join(f"{{ stagger = {b} }}" for b in [0.2, -0.2] * 5 + [0.2]) + "]"
    pairs = {
        "two contact wires": (on_line("two-contact-wires", ["line_table", "second_wire"]), one_wire),
        "overlap": (on_line("overlap", ["line_table", "second_wire"]), whole),
        "stagger": (on_line("en50318-2002", ["line_table", "stagger"], **{"line_table.table": zigzag}), one_wire),
    }
    for name, (dear, text) in pairs.items():
        plain = on_line("en50318-2002", ["line_table"], **{"line_table.table": text})
        seconds = [best(which)[1] for which in (plain, dear)]
        told("lines", name, **{"× one straight wire": seconds[1] / seconds[0]})
        assert seconds[1] <= 2.0 * seconds[0]


def test_memory_of_sixty_spans(told):
    # ru_maxrss would not do: a process inherits it from the one that started it
    program = (
        "from cosimo.orchestrator.run.run import run; from cosimo.orchestrator.systems import load_scene\n"
        "s = load_scene('en50318-2002').with_changes({'catenary.spans': 60, 'stop_time': 1.0})\n"
        "assert run(s).outcome == 'done'\n"
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    )
    for _ in range(2):  # the first one may have to compile
        out = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    megabytes = int(out.split()[-1]) / 1024.0
    told("lines", "memory of a process with sixty spans as FMUs", MB=megabytes)
    assert megabytes < 400.0


def test_price_of_the_packaging(told):
    """Microseconds of a macro step, split by running the same scene at four depths."""
    s = scene()
    n = round(s.stop_time / s.master.step)
    _, in_process = best(s)
    _, fmu = best(s, in_process=False)
    units = {"catenary": Catenary(EFFECTS, {"damping.beta": 1e-3}), "pantograph": Pantograph(["contact_loss"])}
    physics, direct = {}, {}
    for name, unit in units.items():
        unit.set("contact_position" if name == "catenary" else "wire_height", 300.0 if name == "catenary" else 0.0)
        unit.initialize(0.0)
        physics[name] = shortest_mean(unit.step)
        direct[name] = fmu_step(type(unit), unit.on)
    packaging = sum(direct.values()) - sum(physics.values())
    parts = {
        "whole": fmu / n,
        **{f"physics of the {name}, called from Python": seconds for name, seconds in physics.items()},
        "pythonfmu and ctypes around the two steps": packaging,
        "reading and setting through FMI": (fmu - in_process) / n - packaging,
        "master and recording": in_process / n - sum(physics.values()),
    }
    for part, seconds in parts.items():
        told("packaging", part, µs=1e6 * seconds)
    assert fmu > in_process > n * sum(physics.values()) * 0.5


def shortest_mean(step):
    """Shortest mean time of 500 calls step(t, h), s."""
    batches = []
    for _ in range(20):
        start = time.perf_counter()
        for _ in range(500):
            step(0.0, 1e-3)
        batches.append((time.perf_counter() - start) / 500)
    return min(batches)


def fmu_step(cls, effects):
    """Shortest mean time of fmi2DoStep through FMPy's ctypes binding, s."""
    import shutil

    from cosimo.fmus.build import built
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    path = built(cls.__name__)
    description, folder = read_model_description(path), extract(str(path))
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        instanceName="timed",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.setBoolean([references[f"effects.{e}"] for e in effects], [True] * len(effects))
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    seconds = shortest_mean(slave.doStep)
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    return seconds
