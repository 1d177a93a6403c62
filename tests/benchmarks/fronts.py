"""Measure the accuracy tables that ship anew: python -m cosimo.tests.benchmarks.fronts [SCENE ...] [--budget SECONDS]

They hold errors and counted work, which depend on no machine; what the budget does not reach is left out of them.
"""

import argparse
from dataclasses import replace
from time import perf_counter

from cosimo.orchestrator.harness.studies.accuracy import BUDGET, accuracy
from cosimo.orchestrator.harness.studies.accuracy_table import write_points
from cosimo.orchestrator.harness.studies.fronts import marked
from cosimo.orchestrator.harness.studies.quantities import percent
from cosimo.orchestrator.scene.files import shipped
from cosimo.orchestrator.systems import load_scene


def main() -> None:
    tables = shipped("fronts", ".csv")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="; ".join(tables))
    parser.add_argument("--budget", type=float, default=BUDGET, help="s of measuring for each scene, beside the reference")
    given = parser.parse_args()
    for name in given.scenes or tables:
        scene, start = load_scene(name), perf_counter()
        measured = marked(scene, accuracy(scene, budget=given.budget))
        kept = replace(measured, points=tuple(p for p in measured.points if p.outcome != "skipped"))
        path = write_points(kept, tables[name].parent, tables[name].name, times=False)
        own = kept.own
        print(
            f"{name}: {len(kept.points)} settings in {perf_counter() - start:.0f} s. Its own: error {percent(own.error)}, at "
            f"its largest {percent(own.largest)}, of which {percent(kept.smallest_known)} are the reference's. Wrote {path}",
            flush=True,
        )


if __name__ == "__main__":
    main()
