"""The rotor cases pass, and would not if the rotor were another."""

import dataclasses

import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.orchestrator.harness.validation.case import Options, outcome
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.rotor.cases import jeffcott


@pytest.mark.full
def test_a_rotor_without_gyroscopic_effect_fails(monkeypatch):
    """Whirl does not split then: every row of the running rotor is outside."""
    preset = BeamRotor.presets["Friswell 5.9.1"]
    bare = dataclasses.replace(preset, effects=("disks", "linear_supports"))
    monkeypatch.setitem(BeamRotor.presets, "Friswell 5.9.1", bare)
    findings = cases()["friswell-5.9.1"].findings(Options(in_process=True))
    assert outcome(findings.rows) == "failed"
    inside = {r.reference.condition: r.inside for r in findings.rows}
    assert inside == {"at rest": True, "1000 rpm": False, "4000 rpm": False, "synchronous": False}


def test_a_sign_of_the_phase_would_show(monkeypatch):
    """A response that leads instead of lags has the amplitudes, and not the phases."""
    monkeypatch.setattr(jeffcott, "synchronous", lambda result, measure=jeffcott.synchronous: measure(result).conjugate())
    findings = cases()["jeffcott"].findings(Options(in_process=True))
    inside = {r.reference.measure: r.inside for r in findings.rows}
    assert all(value for name, value in inside.items() if name.startswith("amplitude"))
    assert not any(value for name, value in inside.items() if name.startswith("lag"))
