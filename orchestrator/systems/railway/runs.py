"""Runs that several cases and studies share, kept for the life of the process."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ....components.core.errors import BadInput
from ...harness.analysis.signals import ButterworthFilter
from ...harness.validation import Options, done
from ...run.results import Result
from ...run.run import run
from ...scene.scene import Scene
from ...scene.shorter_steps import kept_runs
from ...units.component import make
from .. import load_scene
from .records import measured, of_each, statistics

KMH = 1.0 / 3.6  # m/s
WITHOUT_PICTURES: dict[str, Any] = {"record.snapshots": (), "record.snapshot_interval": None}
FORCE_PER_MEAN = 1.09  # first guess of static force over mean force: the base spring takes about 8 % of the lift


def at_speed(scene: Scene, speed: float, changes: Mapping[str, Any] | None = None, unit: str = "pantograph") -> Scene:
    """The scene with its pantograph at another speed (km/h) over the same distance, with further changes."""
    if scene.start_time:  # where the pantograph stands then depends on its speed
        raise BadInput(f"{scene.name}: start_time", f"{scene.start_time:g} s", "0, where runs at several speeds begin")
    pantograph: Any = make(unit, scene.units[unit])
    steps = scene.stop_time * pantograph.parameters["speed"] / (speed * KMH) / scene.master.step
    stop = round(steps) * scene.master.step
    always = {f"{unit}.speed": speed * KMH, "stop_time": stop}
    return scene.with_changes({**always, **(changes or {})})


def with_stable_substep(scene: Scene) -> Scene:
    """The scene with a shorter internal step of the catenary where its explicit method needs one."""
    catenary: Any = make("catenary", scene.units["catenary"])
    limit = catenary.stable_step()
    if catenary.parameters["substep"] <= limit:
        return scene
    return scene.with_changes({"catenary.substep": scene.master.step / math.ceil(scene.master.step / (0.9 * limit))})


@kept_runs
def reference_run(speed: float, options: Options) -> Result:
    """EN 50318:2002 at a speed in km/h. Raises `RunFailed`."""
    scene = at_speed(load_scene("en50318-2002"), speed)
    return done(run(scene, in_process=options.in_process, progress=options.progress))


def target_mean(speed: float, at_rest: float = 70.0) -> float:
    """Mean force to be set at a speed in km/h, N: 0.00097 v² + 70 for AC; at_rest: 110 for 3 kV DC."""
    return 0.00097 * speed**2 + at_rest


def ac_simple_run(speed: float, options: Options) -> tuple[Result, float, float]:
    """`set_mean_run` of EN 50318:2018 AC simple at a speed in km/h."""
    return set_mean_run("en50318-2018-ac-simple", speed, target_mean(speed), options)


@kept_runs
def set_mean_run(name: str, speed: float, target: float, options: Options) -> tuple[Result, float, float]:
    """A scene of EN 50318:2018 at a speed in km/h: the run, its static force in N, and the mean force in N of the trial.

    The mean force, `target` in N, is a set quantity there. One trial in process with a guessed static force, which is then scaled
    by target over mean; the base spring's share of the lift hardly changes in between, so that one trial is enough.
    Raises `RunFailed`.
    """
    scene = load_scene(name)
    force = "pantograph.static_force"
    guess = FORCE_PER_MEAN * target
    mean = statistics(done(run(at_speed(scene, speed, {force: guess}), in_process=True))).mean
    static_force = guess * target / mean
    scaled = at_speed(scene, speed, {force: static_force})
    return done(run(scaled, in_process=options.in_process, progress=options.progress)), static_force, mean


def numbers_of_each(result: Result) -> dict[str, float]:
    """As `numbers`, of several pantographs of each, see `of_each`."""
    return of_each(result, lambda i: measured(statistics(result, pantograph=i))) if result.outcome == "done" else {}


def numbers(result: Result, low_pass: ButterworthFilter | None = None) -> dict[str, float]:
    """The run's statistics by the names of the reference tables; empty if it did not reach its end."""
    return measured(statistics(result, low_pass)) if result.outcome == "done" else {}
