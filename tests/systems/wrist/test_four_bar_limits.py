"""Where a four-bar linkage stops, folds or cannot be built: toggle, change points, lengths that do not close."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.wrist import linkage
from cosimo.components.wrist.four_bar import FourBar
from cosimo.tests.support import initialized
from cosimo.tests.systems.wrist.linkage_limits import crank_limits

pytestmark = pytest.mark.full

NAMES = ("crank", "coupler", "rocker", "ground")
ROCKER_DRIVES = (0.040, 0.050, 0.020, 0.055)
PARALLELOGRAM = (0.020, 0.050, 0.020, 0.050)
CHANGE_POINTS = {
    "parallelogram": PARALLELOGRAM,
    "upright parallelogram": (0.050, 0.020, 0.050, 0.020),
    "deltoid": (0.050, 0.050, 0.020, 0.020),
    "lying deltoid": (0.020, 0.020, 0.050, 0.050),
    "far": (0.020, 0.045, 0.030, 0.055),
    "near, long coupler": (0.020, 0.060, 0.030, 0.050),
    "near, long rocker": (0.020, 0.030, 0.060, 0.050),
}


def four_bar(lengths, angle, rate=1.0, **parameters) -> FourBar:
    return initialized(
        FourBar((), dict(zip(NAMES, lengths, strict=True)) | parameters), {"input_angle": angle, "input_rate": rate}
    )


def test_the_ratio_at_the_toggle_grows_as_one_over_the_root_of_the_distance():
    """Four times nearer, twice the ratio: the output has the slope of a square root there."""
    high = crank_limits(*ROCKER_DRIVES)[1]
    near, nearer = (abs(four_bar(ROCKER_DRIVES, high - s, least_transmission_angle=1e-6)["ratio"]) for s in (1e-6, 0.25e-6))
    assert nearer / near == pytest.approx(2.0, rel=2e-3)


def test_a_start_at_no_number_is_refused():
    with pytest.raises(StepFailed, match="toggle"):
        four_bar(ROCKER_DRIVES, math.nan)


@pytest.mark.parametrize("assembly", ["open", "crossed"])
@pytest.mark.parametrize("name", CHANGE_POINTS)
def test_through_a_change_point_without_a_kink(name, assembly):
    """Over two turns, change points among the samples: the loop closes, angle and ratio go on, the slope is the ratio."""
    a, b, c, d = lengths = CHANGE_POINTS[name]
    crank = np.arange(0, 721) * (math.pi / 180.0)
    found = [four_bar(lengths, p, change_point="through", assembly=assembly) for p in crank]
    angle, ratio = (np.array([f[n] for f in found]) for n in ("output_angle", "ratio"))
    np.testing.assert_allclose(np.abs(d + c * np.exp(1j * angle) - a * np.exp(1j * crank)), b, rtol=1e-12)
    step = math.pi / 180.0
    # Simpson's rule over two samples against the angle: h^5 / 90 of the ratio's fourth derivative
    simpson = step / 3.0 * (ratio[:-2] + 4.0 * ratio[1:-1] + ratio[2:])
    np.testing.assert_allclose(angle[2:] - angle[:-2], simpson, atol=2e-5)
    transmission = np.array([f["transmission_angle"] for f in found])  # between coupler and rocker, past a change point, too
    cosines = (b * b + c * c - a * a - d * d + 2.0 * a * d * np.cos(crank)) / (2.0 * b * c)
    np.testing.assert_allclose(np.cos(transmission), cosines, atol=1e-12)
    assert transmission.min() >= 0.0


def test_a_parallelogram_keeps_its_sides_parallel_and_an_antiparallelogram_does_not():
    for crank in np.linspace(0.1, 12.0, 37):
        assert four_bar(PARALLELOGRAM, crank, change_point="through")["output_angle"] == pytest.approx(crank, abs=1e-12)
        assert four_bar(PARALLELOGRAM, crank, change_point="through")["ratio"] == pytest.approx(1.0, abs=1e-12)
        crossed = four_bar(PARALLELOGRAM, crank, change_point="through", assembly="crossed")
        # antiparallelogram: tan(psi/2) = (a + d) / (a - d) tan(phi/2), by the tangent of half angles in Freudenstein's equation
        quotient = math.tan(0.5 * crossed["output_angle"]) / math.tan(0.5 * crank)
        assert quotient == pytest.approx((0.02 + 0.05) / (0.02 - 0.05), rel=1e-9)


def test_folded_it_stays_in_its_assembly_with_a_kink():
    """Past the change point a parallelogram goes on as the antiparallelogram: the other sign of the ratio's jump."""
    before, after = (four_bar(PARALLELOGRAM, math.pi + s, change_point="fold") for s in (-1e-9, 1e-9))
    assert before["output_angle"] == pytest.approx(after["output_angle"], abs=1e-7)
    assert before["ratio"] == pytest.approx(1.0, abs=1e-6)
    assert after["ratio"] == pytest.approx((0.02 - 0.05) / (0.02 + 0.05), rel=1e-6)  # the antiparallelogram's there


@pytest.mark.parametrize("share", [1e-12, 1e-6, 1e-3])
def test_nearly_a_change_point(share):
    """Tolerances of manufacture are no change point: it toggles, or swings past; what counts as equal is said to be."""
    lengths = (0.020, 0.050, 0.020 * (1.0 + share), 0.050)
    if share < linkage.SAME:
        assert four_bar(lengths, 1.0, change_point="through")["ratio"] == pytest.approx(1.0, abs=1e-9)
        return
    assert linkage.kind(*lengths) != "change point"
    with pytest.raises(BadInput, match="no effect"):
        four_bar(lengths, 1.0, change_point="through")
    assert four_bar(lengths, 1.0)["ratio"] == pytest.approx(1.0, abs=10.0 * share)
