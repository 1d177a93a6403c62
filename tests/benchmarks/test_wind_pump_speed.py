"""Speed of a day of wind on the averaged wind pump, and what the full converter costs beside it.

Run with `pytest -n 0 tests/benchmarks --write-page`. Nothing here is a statement about another machine.
"""

from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

SHARED = {"gear_ratio", "crank_radius", "lever_mass", "slider_mass", "clutch_arm", "driven_inertia"}  # by both converters


def best(scene, in_process, runs=3):
    """Shortest stepping time of some warm runs, s."""
    run(scene.with_changes({"stop_time": 20.0 * scene.master.step, "record.interval": None}), in_process=in_process)
    results = [run(scene, in_process=in_process) for _ in range(runs)]
    assert all(r.outcome == "done" for r in results)
    return min(r.info.timing.run for r in results)


def test_a_day_of_wind(told):
    """Five units, 108 000 macro steps: under 10 s in one process."""
    scene = load_scene("wind-pump-day")
    assert scene.stop_time == 86400.0
    seconds = best(scene, True)
    fmus = best(scene, False, 1)
    for label, spent in (("in process", seconds), ("as FMUs", fmus)):
        told("systems", f"wind pump, a day, averaged converter, {label}", s=spent, **{"× real time": scene.stop_time / spent})
    assert seconds < 10.0


def test_price_of_the_clutches(told):
    """The full converter against its mean, both coupled to turbine, pump and pipe, per simulated second."""
    full = load_scene("wind-pump-gusts").with_changes({"master.bonds": []})
    mean = full.with_changes(
        {
            "units.converter.component": "AveragedConverter",
            "units.converter.effects": [],
            "units.converter.parameters": {n: v for n, v in full.units["converter"].parameters.items() if n in SHARED},
            "units.turbine.parameters": {"inertia": 15.0 + 100.0 * (0.1 + 47.0 * 4.0 * 0.02**2 / 2.0)},
            "record.signals": ["wind.speed", "turbine.speed", "converter.speed"],
            "master.step": 0.05,
        }
    )
    seconds = {name: best(scene, True) / scene.stop_time for name, scene in (("full", full), ("in the mean", mean))}
    for name, spent in seconds.items():
        told("systems", f"wind pump, a second of gusts, converter {name}", s=spent)
    assert seconds["full"] > 5.0 * seconds["in the mean"]  # 20 times the macro steps, and clutches in each
