"""Closed forms of chain and gimbal are met, follow from formulas other than the code's, and another joint would miss them."""

import math

import numpy as np
import pytest
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.orchestrator.harness.validation.case import Options, compare, outcome
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems import cases
from scipy.special import ellipk

pytestmark = pytest.mark.full


def centres(name: str) -> dict[str, float]:
    return {r.measure: 0.5 * (r.low + r.high) for r in load_table(name).rows if r.low is not None}


def test_the_chain_s_table_follows_from_the_formulas():
    """Closed expressions written here, and NumPy's roots of the quartic."""
    table = centres("chain-closed-forms")
    for name, squares in (
        ("masses", (2.0 - math.sqrt(2.0), 2.0 + math.sqrt(2.0))),
        ("rods", (3.0 - 6.0 / math.sqrt(7.0), 3.0 + 6.0 / math.sqrt(7.0))),
    ):
        for mode, square in enumerate(squares, 1):
            assert table[f"frequency.{name}.{mode}"] == pytest.approx(math.sqrt(9.81 * square), abs=6e-8)
    roots = np.roots([1.0, 0.35, 4.0 * 9.81 + 0.005, 0.25 * 9.81, 2.0 * 9.81**2])
    for mode, root in enumerate(sorted(roots[roots.imag > 0.0], key=lambda r: r.imag), 1):
        numbers = table[f"damped.frequency.{mode}"], table[f"damped.decay.{mode}"]
        assert numbers == pytest.approx((root.imag, -root.real), abs=6e-9)
    slow, fast = sorted(-np.roots([1.0, 0.35, 0.005]))
    assert (table["coasting.decay.1"], table["coasting.decay.2"]) == pytest.approx((slow, fast), abs=6e-9)
    for name, amplitude in (("small", 0.1), ("quarter", math.pi / 2.0), ("high", 3.0)):
        ratio = 2.0 / math.pi * ellipk(math.sin(0.5 * amplitude) ** 2)
        assert table[f"period.{name}"] == pytest.approx(ratio, abs=6e-9)


def test_the_gimbal_s_table_follows_from_the_formulas():
    table = centres("gimbal-closed-forms")
    critical = math.sqrt(2.0 * 9.81 * 0.15 / 0.04)
    assert table["governor.speed"] == pytest.approx(critical, abs=6e-8)
    for speed in (9.0, 12.0, 20.0):
        angle = math.acos((critical / speed) ** 2)
        frequency = speed * math.sin(angle) * math.sqrt(0.04 / 0.06)
        assert table[f"governor.angle.{speed:g}"] == pytest.approx(angle, abs=6e-9)
        assert table[f"governor.frequency.{speed:g}"] == pytest.approx(frequency, abs=6e-7)
    assert table["pendulum.outer"] == pytest.approx(math.sqrt(2.943 / 0.08), abs=6e-8)
    assert table["pendulum.inner"] == pytest.approx(math.sqrt(2.943 / 0.06), abs=6e-8)
    assert table["nutation"] == pytest.approx(2.0 / math.sqrt(0.02 * 0.015), abs=6e-6)
    assert table["inertial.period.small"] == pytest.approx(2.0 * math.pi * 0.08 / 0.4 / math.sqrt(0.6), abs=6e-8)
    assert table["precession.inclined"] == pytest.approx(-0.15 / math.cos(1.2), abs=1e-11)


def outside(name: str) -> set[str]:
    findings = cases()[name].findings(Options(in_process=True))
    return {r.reference.measure for r in findings.rows if not r.inside}


def other_start(monkeypatch, cls, name: str, factor: float) -> None:
    """A component whose parameter is another than the one that is given."""
    initialize = cls._initialize

    def changed(self, t):
        if name in self.parameters:
            self.set(name, factor * self.parameters[name])
        return initialize(self, t)

    monkeypatch.setattr(cls, "_initialize", changed)


def test_another_gravity_of_the_chain_fails(monkeypatch):
    other_start(monkeypatch, TwoLinkChain, "gravity.acceleration", 1.0 + 1e-6)
    missed = outside("chain-closed-forms")
    assert {f"frequency.{n}.{k}" for n in ("masses", "rods") for k in (1, 2)} <= missed
    assert not {"coasting.decay.1", "drift.mechanical_energy", "period.high"} & missed


def test_another_inertia_of_the_gimbal_fails(monkeypatch):
    other_start(monkeypatch, GimbalBody, "cross_inertia", 1.0 + 1e-5)
    missed = outside("gimbal-closed-forms")
    assert {"governor.speed", "pendulum.outer", "inertial.period.small"} <= missed
    assert not {"pendulum.inner", "drift.outer_momentum"} & missed


def test_what_was_not_measured_fails():
    assert outcome(compare(load_table("chain-closed-forms").rows, {})) == "failed"
