"""A native FMU gives the bits of the component in process, at any step length, also from a restored state.

Here a component of each system, and those that no shipped scene has. The others are compared in their scenes, test_native_run.py.
"""

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.components.railway.hard_cases import COMPOUND_OVERLAP
from cosimo.tests.fmus.native.support import compiled, in_process, maker, native
from cosimo.tests.short_run import ONE_A_SYSTEM, shipped_scenes

OTHERS = [
    ("Catenary", ("gravity_sag", "line_table", "second_wire"), (("method", "implicit"), ("line_table.table", COMPOUND_OVERLAP))),
    ("Catenary", ("dropper_slackening", "moving_window", "gusts"), (("spans", 3), ("gusts.lift_coefficient", 0.2))),
    ("DeepGrooveBearing", ("outer_defect", "ball_defect", "inner_waviness", "ball_inertia", "cage_slip"), ()),
]
QUICK = ("PlanarLink",)
IN_SCENES = {unit.component for scene in shipped_scenes().values() for unit in scene.units.values()}
ALONE = [n for n in CATALOGUE if n in {*QUICK, *ONE_A_SYSTEM} or n not in IN_SCENES]
ALL = [pytest.param(n, (), (), marks=() if n in QUICK else pytest.mark.full) for n in ALONE]
ALL += [pytest.param(*other, marks=pytest.mark.full) for other in OTHERS]


@pytest.mark.parametrize(("name", "effects", "parameters"), ALL)
def test_thousand_driven_steps_at_three_lengths(name, effects, parameters, tmp_path):
    found = compiled(name, effects, parameters)
    for share in (1.0, 0.37, 1.9):
        component = maker(name, effects, parameters)()
        h = share * component.default_step
        expected = in_process(component, h, 1000)
        assert np.isfinite(expected).all()
        assert expected.shape[1] == 0 or np.ptp(expected, axis=0).any(), "nothing moves: the comparison would say nothing"
        np.testing.assert_array_equal(native(found, tmp_path, h, 1000), expected)
    np.testing.assert_array_equal(native(found, tmp_path, h, 1000, version=3, restored_at=471), expected)
