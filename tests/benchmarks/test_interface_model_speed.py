"""Interface model against Gauss-Seidel on the railway pair: error and stepping time over the macro step.

Run with `pytest -n 0 tests/benchmarks --write-page`. Nothing here is a statement about another machine.
"""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter, uniform
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.records import passages

SIGNALS = ["pantograph.contact_force", "pantograph.contact_position", "catenary.wire_height"]
WINDOW = np.linspace(240.0, 360.0, 1201)
FINE = 2.5e-4  # s, the reference's macro step and everybody's internal one
SCHEMES = {
    "Gauss-Seidel, linear": ("en50318-2002", {"master.extrapolation": 1}),
    "Gauss-Seidel, quadratic": ("en50318-2002", {"master.extrapolation": 2}),
    "interface model": ("en50318-2002-interface-model", {}),
    "interface model, both at once": ("en50318-2002-interface-model", {"contacts": None}),
}


def scene(name, step, changes, element=0.25, substep=FINE):
    given = load_scene(name)
    if "contacts" in changes:
        contact = {k: v for k, v in given.settings()["contacts"][0].items() if k != "leader"}
        second = {k: v for k, v in contact["second"].items() if k != "degree"}
        changes = {"contacts": [contact | {"second": second}]}
    return given.with_changes(
        {
            "master.step": step,
            "record": {"signals": SIGNALS},
            "catenary.element": element,
            "catenary.substep": substep,
            "units.catenary.effects": ["dropper_slackening", "gravity_sag", "damping"],
            **changes,
        }
    )


def filtered(result, keep=1):
    """20 Hz-filtered contact force over spans 5 and 6 on a fixed grid of positions, N, from every `keep`-th sample."""
    record = passages(result)[0].record
    rate, _, (position, force) = uniform(record.time[::keep], record.position[::keep], record.force[::keep])
    return np.interp(WINDOW, position, ButterworthFilter().apply(force, rate))


def error(history, reference):
    """rms difference of the filtered force over its standard deviation."""
    return float(np.sqrt(np.mean((history - reference) ** 2)) / reference.std())


def test_error_over_the_macro_step(told):
    """On one mesh: against the converged history, and against the same sampled as coarsely, which is the coupling alone."""
    converged = run(scene("en50318-2002", FINE, {"master.extrapolation": 2}), in_process=True)
    found = {}
    for label, (name, changes) in SCHEMES.items():
        cells = {}
        for step in (1e-3, 2e-3, 3e-3, 5e-3, 8e-3):
            history = filtered(run(scene(name, step, changes), in_process=True))
            found[label, step] = error(history, filtered(converged, round(step / FINE)))
            cells[f"{1e3 * step:g} ms"] = f"{100.0 * found[label, step]:.2f} %"
        told("error of the coupling", label, **cells)
    assert found["interface model", 5e-3] < 0.5 * found["Gauss-Seidel, linear", 5e-3]
    assert found["interface model", 5e-3] < found["Gauss-Seidel, linear", 3e-3]
    assert found["interface model", 2e-3] < 0.5 * found["Gauss-Seidel, linear", 2e-3]


@pytest.mark.parametrize("in_process", [True, False])
def test_time_for_an_error(in_process, told):
    """Stepping time where errors are alike. In process the units are so cheap that the master's micro steps cost as much."""
    converged = run(scene("en50318-2002", FINE, {"master.extrapolation": 2}), in_process=True)
    seconds = {}
    for label, step in (
        ("Gauss-Seidel, linear", 2e-3),
        ("Gauss-Seidel, linear", 5e-3),
        ("interface model", 2e-3),
        ("interface model", 5e-3),
    ):
        s = scene(SCHEMES[label][0], step, SCHEMES[label][1], substep=5e-4)
        results = [run(s, in_process=in_process) for _ in range(6)][1:]
        seconds[label, step] = best = min(r.info.timing.run for r in results)
        missed = 100.0 * error(filtered(results[0]), filtered(converged, round(step / FINE)))
        way, each = "in process" if in_process else "FMUs", 1e6 * best * step / s.stop_time
        cells = {"× real time": s.stop_time / best, "µs a macro step": each, "error": f"{missed:.2f} %"}
        told("interface model", f"{label}, {1e3 * step:g} ms, {way}", **cells)
    assert seconds["interface model", 5e-3] < 3.0 * seconds["Gauss-Seidel, linear", 5e-3]
