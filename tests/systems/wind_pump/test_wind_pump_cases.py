"""The wind pump cases pass, and would not if the chain were another."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.validation.case import Options
from cosimo.orchestrator.harness.validation.reference import compare, load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.wind_pump.cases import closed_forms as wind_pump_closed_forms
from cosimo.orchestrator.systems.wind_pump.cases import equilibrium as wind_pump_equilibrium
from cosimo.orchestrator.systems.wind_pump.cases import start as wind_pump_start


@pytest.mark.full
def test_another_mass_on_the_lever_is_another_operating_point(monkeypatch):
    """A per cent of the mass is seen in the speeds; the power balance holds for every mass."""
    given = wind_pump_equilibrium.scene
    heavier = {"converter.lever_mass": 20.2}
    monkeypatch.setattr(wind_pump_equilibrium, "scene", lambda wind: given(wind).with_changes(heavier))
    monkeypatch.setattr(wind_pump_equilibrium, "WINDS", (2.0, 2.5, 6.0))
    (question,) = cases()["wind-pump-equilibrium"].questions
    rows = compare(load_table("wind-pump-equilibrium").rows, question.ask(Options(in_process=True)).numbers)
    inside = {r.reference.measure: r.inside for r in rows}
    assert not any(inside[f"{n}.{v}"] for n in ("turbine_speed", "pump_speed", "ratio") for v in ("2", "2.5", "6"))
    assert all(inside[f"power_ratio.{v}"] for v in ("2", "2.5", "6"))
    assert not inside["cp.3"]  # not run, and so not inside


@pytest.mark.full
def test_a_double_acting_pump_starts_at_the_same_wind_and_stops_later(monkeypatch):
    """Its peak is the same and its mean twice as large: with the mean of the one for the other, the ratio is sqrt(pi / 2)."""
    given = wind_pump_start.scene
    first, last = 3.1, 2.75  # m/s, about sqrt(2) * 2.02
    monkeypatch.setitem(wind_pump_start.STOPPING, "fixed", (first, last, 1e-3))
    changed = {"transmission.load_torque": 2.0 * wind_pump_start.MEAN_TORQUE}
    monkeypatch.setattr(wind_pump_start, "scene", lambda kind, what: given(kind, what).with_changes(changed))
    result = run(wind_pump_start.scene("fixed", "stop"), in_process=True)
    # 2 i T / (rho A R C_Q0) with twice the mean torque
    assert wind_pump_start.turning_point(result, "stop") == pytest.approx(2.0195356 * 2.0**0.5, rel=5e-3)


def test_another_curve_is_seen_at_its_maximum():
    """The last term of Heier's curve with 1/l instead of the ratio, as some libraries have it, has its maximum elsewhere."""
    x = [4.0 + 0.002 * k for k in range(4001)]
    inverse = [1.0 / v - 0.035 for v in x]
    y = [0.5176 * (116.0 * i - 5.0) * 2.718281828459045 ** (-21.0 * i) + 0.0068 / i for i in inverse]
    at, height = wind_pump_closed_forms.peak(*map(np.array, (x, y)))
    assert (at, height) == pytest.approx((8.2449, 0.5022715), rel=1e-5)  # of that variant
    rows = {r.measure: r for r in load_table("wind-pump-closed-forms").rows}
    assert not rows["cp.heier"].low <= height <= rows["cp.heier"].high
    assert not rows["lambda.heier"].low <= at <= rows["lambda.heier"].high
