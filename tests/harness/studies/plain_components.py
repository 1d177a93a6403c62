"""Every component of the catalogue alone for a few steps, by itself and by SciPy; run in plain Python, where nothing compiles.

Prints JSON: component -> largest difference of an output over its range, or null where SciPy has nothing to solve.
"""

import json

import numpy as np
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.harness.studies.component_accuracy import ComponentRun

STEPS = 4


def difference(name):
    one = ComponentRun(name, stop=STEPS * component_class(name).default_step)
    own = one.own().history
    assert all(np.isfinite(x).all() for x in own.columns.values())
    probe = one.make()
    probe.initialize(0.0)
    if one.kernel is None or not probe.x.size:
        return None
    other = one.by_scipy("DOP853", 1e-8).history
    scales = {k: max(np.ptp(x), 1e-6 * probe.variables[k].nominal) for k, x in other.columns.items()}
    return max(float(np.abs(x - own.columns[k]).max() / scales[k]) for k, x in other.columns.items())


if __name__ == "__main__":
    print(json.dumps({name: difference(name) for name in CATALOGUE}))
