"""The likelihood under process noise: the filter's own number, the Kalman filter by hand, and its gradient."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.oscillator import KICK, NOISE, SIGNAL, Oscillator

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TRUTH = Oscillator(count=60)
NAMES = ("spring.stiffness", "spring.damping")


@pytest.fixture
def plan(tmp_path):
    y, _ = TRUTH.drawn(4)
    rows = "".join(f"{float(t)!r},{float(v)!r}\n" for t, v in zip(TRUTH.times, y, strict=True))
    (tmp_path / "position.csv").write_text(f"time [s],position [m]\n{rows}")
    measured = [{"signal": SIGNAL, "file": "position.csv", "column": "position", "noise": NOISE}]
    vary = {NAMES[0]: {"low": 50.0, "high": 200.0}, NAMES[1]: {"low": 0.0, "high": 2.0}}
    return TRUTH.plan(measured=measured, vary=vary), y


def test_it_is_the_number_of_the_filter_and_that_by_hand(plan, tmp_path):
    given, y = plan
    own = {k: v for k, v in given.items() if k != "vary"}
    with cosimo.likelihood(TRUTH.scene(), given, folder=tmp_path) as likelihood:
        assert likelihood.names == NAMES
        first, hand = None, []
        for x in ([100.0, 0.4], [80.0, 1.5], [120.0, 0.0]):
            scene = TRUTH.scene(**dict(zip(NAMES, x, strict=True)))
            found = cosimo.estimate(scene, own, folder=tmp_path, halved=False)
            assert likelihood(np.array(x)) == pytest.approx(found.log_likelihood, rel=1e-9)
            hand.append(Oscillator(count=60, stiffness=x[0], damping=x[1]).filtered(y)[2] - likelihood(np.array(x)))
            first = likelihood(np.array([100.0, 0.4])) if first is None else first
        assert max(map(abs, hand)) < 1.0  # of the step: log units, of which 100 lie between these points
        assert likelihood(np.array([100.0, 0.4])) == first  # nothing stays from other points
        assert likelihood(np.array([201.0, 0.4])) == -np.inf


def test_its_gradient_is_by_differences_and_says_so(plan, tmp_path):
    given, y = plan
    with cosimo.likelihood(TRUTH.scene(), given, folder=tmp_path) as likelihood:
        assert all(how.startswith("differences (") for how in likelihood.exact.values())
        x = np.array([92.0, 0.6])
        by_hand = []
        for k, h in enumerate((1e-3, 1e-4)):
            ahead, back = (x + way * h * np.eye(2)[k] for way in (1.0, -1.0))
            one, two = (Oscillator(count=60, stiffness=p[0], damping=p[1]).filtered(y)[2] for p in (ahead, back))
            by_hand.append((one - two) / (2.0 * h))
        assert likelihood.gradient(x) == pytest.approx(by_hand, rel=0.05)
        at_bound = likelihood.gradient(np.array([100.0, 0.0]))
        assert np.isfinite(at_bound).all()
        with pytest.raises(BadInput, match="bounds"):
            likelihood.gradient(np.array([100.0, -1.0]))


def test_what_is_estimated_is_integrated_over(plan, tmp_path):
    """An estimated number and one that varies are not the same: over the former, the likelihood by hand is integrated by quadrature."""
    given, y = plan
    open_ = given["estimated"] | {NAMES[0]: {"deviation": "12 %"}}
    vary = {NAMES[1]: given["vary"][NAMES[1]]}
    with cosimo.likelihood(TRUTH.scene(), given | {"estimated": open_, "vary": vary}, folder=tmp_path) as likelihood:
        own = {k: v for k, v in given.items() if k != "vary"} | {"estimated": open_}
        found = cosimo.estimate(TRUTH.scene(), own, folder=tmp_path, halved=False)
        q = np.linspace(-0.6, 0.6, 61)
        log = [Oscillator(count=60, stiffness=100.0 * np.exp(v)).filtered(y)[2] - 0.5 * (v / 0.12) ** 2 for v in q]
        whole = np.logaddexp.reduce(log) + np.log((q[1] - q[0]) / (0.12 * np.sqrt(2.0 * np.pi)))
        assert likelihood(np.array([0.4])) == pytest.approx(whole, abs=1.0)  # of the step, as above
        assert likelihood(np.array([0.4])) == pytest.approx(
            found.log_likelihood, abs=0.1
        )  # constants are linearised on the way, and at the end


def test_what_has_no_likelihood_or_gradient_is_refused(plan, tmp_path):
    given, _ = plan
    for change, match in (
        ({"vary": {}}, "vary"),
        ({"vary": {"mass.start_x": {"low": -1.0, "high": 1.0}}}, "which is estimated"),
        ({"measured": [{k: v for k, v in given["measured"][0].items() if k != "noise"}]}, "without noise"),
        ({"vary": {"spring.stifness": {"low": 1.0, "high": 2.0}}}, "spring.stiffness"),
    ):
        with pytest.raises(BadInput, match=match):
            cosimo.likelihood(TRUTH.scene(), given | change, folder=tmp_path)
    walks = {"spring.damping": {"deviation": 0.1, "walk": 0.1}}
    vary = {NAMES[0]: given["vary"][NAMES[0]]}
    drawn = given | {"filter": "ensemble", "estimated": walks, "states": {"mass.base_velocity_x": {"walk": KICK}}, "vary": vary}
    with cosimo.likelihood(TRUTH.scene(), drawn, folder=tmp_path) as likelihood:
        assert np.isfinite(likelihood(np.array([100.0])))
        with pytest.raises(BadInput, match="ensemble"):
            likelihood.gradient(np.array([100.0]))
