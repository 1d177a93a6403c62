"""Measure the committed accuracy fronts anew: python -m cosimo.tests.benchmarks.fronts [SCENE ...] [--budget SECONDS]

A front is written over the committed one only if its times can be believed: of the runs that came to their end no more than 5 %
have times that no second measurement confirms, the scene's own settings are not among these, and the calibration workload takes
as long after the measurement as before it, within 20 %. Otherwise the machine is too busy: exit code 1, and nothing is changed.
"""

import argparse
import sys
from time import perf_counter

from cosimo.orchestrator.harness.studies.accuracy import BUDGET, Accuracy, accuracy
from cosimo.orchestrator.harness.studies.accuracy_table import write_points
from cosimo.orchestrator.harness.studies.fronts import marked
from cosimo.orchestrator.harness.studies.quantities import percent
from cosimo.orchestrator.harness.studies.timing import SCATTER, Timing, calibrate, timing_of
from cosimo.orchestrator.scene.files import shipped
from cosimo.orchestrator.systems import load_scene

REFUSED = 0.05  # of the runs that came to their end


def doubts(measured: Accuracy, before: Timing, after: Timing) -> list[str]:
    """Why the times of a measurement cannot be believed; none where they can."""
    found = []
    done = sum(p.outcome == "done" for p in measured.points)
    if measured.refused_times > REFUSED * done:
        found.append(f"no two measurements agree for {measured.refused_times} of {done} runs")
    if measured.own.outcome == "done" and not measured.own.seconds > 0.0:
        found.append("the time of the scene's own settings is refused")
    if not (before.confirmed and after.confirmed):
        found.append("the calibration workload has no two times that agree")
    between = timing_of([before.seconds, after.seconds]).scatter
    if between > SCATTER:
        found.append(f"the calibration workload takes {percent(between)} longer at one end of the measurement")
    return found


def main() -> None:
    tables = shipped("fronts", ".csv")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="; ".join(tables))
    parser.add_argument("--budget", type=float, default=BUDGET, help="s of measuring for each scene, beside the reference")
    given = parser.parse_args()
    busy = False
    for name in given.scenes or tables:
        scene, start, before = load_scene(name), perf_counter(), calibrate()
        measured = marked(scene, accuracy(scene, budget=given.budget))
        reasons = doubts(measured, before, calibrate())
        if reasons:
            busy = True
            print(f"{name}: NOT written, the machine is too busy: {'; '.join(reasons)}", flush=True)
            continue
        path = write_points(measured, tables[name].parent, tables[name].name)
        own = measured.own
        seconds = perf_counter() - start
        print(f"{name}: {len(measured.points)} settings in {seconds:.0f} s, {measured.refused_times} times refused. "
              f"Its own settings: {own.seconds:.3g} s, error {percent(own.error)}, of which {percent(measured.smallest_known)} "
              f"are the reference's. Wrote {path}", flush=True)
    sys.exit(1 if busy else 0)


if __name__ == "__main__":
    main()
