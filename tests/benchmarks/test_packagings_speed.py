"""Coupled macro steps a second of two pairs of units, by packaging and by master: one table, one run.

Held inputs, all exchanged once per step, which every master can do. Each cell is a process of its own on one core; the best of
several turns counts. COSIMO_INTEROP_PYTHON names a Python that has the extra `interop` where the one of the tests has not.
`pytest -n 0 -s tests/benchmarks/test_packagings_speed.py`; how evenly a native step
of the railway pair takes its time: test_native_jitter.py.
"""

import os
import subprocess
import sys
from pathlib import Path
from time import perf_counter

import pytest

INTEROP = os.environ.get("COSIMO_INTEROP_PYTHON", sys.executable)
TURNS = 3
HELD = {"master.algorithm": "jacobi", "master.extrapolation": 0, "master.feedthrough": "delayed"}
# name: scene, its macro step, s, number of steps, output that is compared, changes
PAIRS = {
    "two small units": ("mass-on-spring", 1e-3, 50_000, "mass.base_x", {"mass.start_x": 0.1}),
    "railway pair": (
        "en50318-2002",
        5e-4,
        6_000,
        "catenary.wire_height",
        {
            "units.catenary.effects": ["dropper_slackening", "gravity_sag", "damping"],
            "record.snapshots": [],
            "record.snapshot_interval": None,
        },
    ),
}
HOWS = ("in process", "native FMUs", "FMUs of pythonfmu")
PLACES = [(master, how) for master in ("cosimo", "ecos", "libcosim") for how in HOWS[master != "cosimo" :]]


def scene_of(pair):
    """The scene of a pair for all masters."""
    from cosimo.orchestrator.systems import load_scene

    name, step, steps, output, changes = PAIRS[pair]
    return load_scene(name).with_changes(
        {
            "stop_time": steps * step,
            "master.step": step,
            **HELD,
            **changes,
            "record.signals": [output],
            "record.interval": steps * step,
        }
    )


def cosimo(pair, how, package):
    """(seconds of stepping, output at the end)."""
    from cosimo.orchestrator.run.run import run

    result = run(scene_of(pair), in_process=how == HOWS[0], native=how == HOWS[1])
    assert result.outcome == "done", result.message
    return result.info.timing.run, result[PAIRS[pair][3]][-1].item()


def ecos(pair, how, package):
    from ecospy import EcosSimulation

    _, step, steps, output, _ = PAIRS[pair]
    simulation = EcosSimulation(step_size=step, ssp_path=package)
    simulation.init()
    return timed(lambda: simulation.step(steps)), simulation.get_real(output.replace(".", "::"))


def libcosim(pair, how, package):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    _, step, steps, output, _ = PAIRS[pair]
    execution = CosimExecution.from_ssp_file(ssp_path=package, step_size=round(step * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    seconds = timed(lambda: execution.step(step_count=steps))
    unit = next(s.index for s in execution.slave_infos() if s.name.decode() == output.partition(".")[0])
    names = {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=unit)}
    return seconds, observer.last_real_values(slave_index=unit, variable_references=[names[output.partition(".")[2]]])[0]


def timed(call):
    begin = perf_counter()
    call()
    return perf_counter() - begin


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """SSP files by pair and packaging."""
    from cosimo.orchestrator.opened.native import with_native_fmus
    from cosimo.orchestrator.scene.ssp.write import write

    folder, made = tmp_path_factory.mktemp("packages"), {}
    for pair in PAIRS:
        for how, scene in ((HOWS[1], with_native_fmus(scene_of(pair))), (HOWS[2], scene_of(pair))):
            made[pair, how] = write(scene, folder / f"{pair}-{how}.ssp".replace(" ", "-"))
    return made


@pytest.fixture(scope="module")
def rates(packages):
    """(pair, master, packaging) -> (steps a second, output at the end); without those that cannot run here."""
    from cosimo.tests.interop.masters import surroundings

    best = {}
    for _ in range(TURNS):
        for pair in PAIRS:
            for master, how in PLACES:
                python = sys.executable if master == "cosimo" else INTEROP
                done = subprocess.run(
                    [python, __file__, master, pair, how, str(packages.get((pair, how), ""))],
                    capture_output=True,
                    text=True,
                    env=surroundings(),
                )
                if done.returncode == 0 and done.stdout.strip():
                    rate, reached = map(float, done.stdout.split()[-2:])
                    best[pair, master, how] = max(best.get((pair, master, how), (0.0, reached)), (rate, reached))
                elif master == "cosimo" or "ModuleNotFoundError" not in done.stderr:
                    print(f"\n{pair}, {master}, {how}: {(done.stderr or str(done.returncode)).strip()[-300:]}")
    print(f"\n{'coupled macro steps a second':36}" + "".join(f"{how:>20}" for how in HOWS))
    for pair in PAIRS:
        for master in dict.fromkeys(m for m, _ in PLACES):
            cells = [best.get((pair, master, how)) for how in HOWS]
            print(f"{pair + ', ' + master:36}" + "".join(f"{c[0]:20.0f}" if c else f"{'-':>20}" for c in cells))
    return best


@pytest.mark.parametrize("pair", PAIRS)
def test_packagings_give_the_same_numbers_and_python_costs(pair, rates):
    ours = {how: rates[pair, "cosimo", how] for how in HOWS}
    assert len({reached for _, reached in ours.values()}) == 1  # bit-identical
    assert ours["in process"][0] > ours["FMUs of pythonfmu"][0]
    assert ours["native FMUs"][0] > ours["FMUs of pythonfmu"][0]
    for (other, master, how), (_, reached) in rates.items():
        if other == pair == "two small units":  # the masters of others start the railway pair without its initial equilibrium
            assert reached == pytest.approx(ours[HOWS[0]][1], abs=1e-4), (master, how)


if __name__ == "__main__":
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    who, *arguments = sys.argv[1:]
    sys.path[:] = [p for p in sys.path if Path(p or ".").resolve() != Path(__file__).parent]
    seconds, reached = {"cosimo": cosimo, "ecos": ecos, "libcosim": libcosim}[who](*arguments)
    print(f"{PAIRS[arguments[0]][2] / seconds:.0f} {reached!r}")
    sys.stdout.flush()
    os._exit(0)  # libraries of others crash now and then in leaving
