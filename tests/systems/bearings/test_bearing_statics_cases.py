"""The cases of bearing statics: what passes, what is unconfirmed, and rows that notice a wrong model."""

import numpy as np
import pytest
from cosimo.components.core.errors import StepFailed
from cosimo.orchestrator.harness.validation.case import compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems.bearings.cases import clearance, hertz_textbook, statics


def test_a_radial_clearance_for_a_diametral_one_fails_the_published_displacement():
    """Mistake three in the published solver's row: 10 um taken as the radial gap."""
    wrong = 1e6 * statics.bearing(20e-6).equilibrium(statics.LOAD * statics.RADIAL).displacement[0]
    rows = compare(load_table("iso16281").rows, {"10.radial": wrong})
    assert not any(r.inside for r in rows if r.reference.measure == "10.radial")


def test_e_star_for_e_prime_fails_the_textbook_stiffness():
    half = hertz_textbook.HARRIS["209"].stiffness(0.5 * hertz_textbook.HARRIS_MODULUS)
    rows = compare(load_table("hertz-textbook").rows, {"209.both": half, "209.millimetre": half / hertz_textbook.NEWTON_PER_MM})
    assert not any(r.inside for r in rows if r.reference.measure in ("209.both", "209.millimetre"))


def test_a_shaft_that_is_free_sideways_has_other_frequencies():
    """So that the condition of the table's rows matters."""
    held, free = clearance.frequencies(15.0, ("x",))[0], clearance.frequencies(15.0, ())[1]
    assert np.abs(held - free).max() > 2.0


def test_an_equilibrium_that_was_not_found_ends_the_case():
    with pytest.raises(StepFailed):
        statics.at_rest(statics.bearing(0.0), 1e6 * statics.RADIAL)
