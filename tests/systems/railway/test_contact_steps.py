"""A contact that lifts off bounds what an unstable coupling makes: a stiff contact at steps that are too long is never silent."""

import numpy as np
import pytest
from cosimo import Result, load_scene
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.orchestrator.run.run import run

FORCE = "pantograph.contact_force"
STIFFNESS = 5e4  # N/m, of the scene
WITHIN = 0.1  # of the range of the force, rms
LIFTED = 0.01  # share of samples without contact, beyond the reference's
ROUGH = 1.3  # peak over that of the reference


def error(result: Result, reference: Result) -> float:
    """rms of the force's error over the range of the reference."""
    true = np.interp(result.time, reference.time, reference.columns[FORCE])
    return float(np.sqrt(np.mean((result.columns[FORCE] - true) ** 2)) / np.ptp(true))


def lifted(result: Result) -> float:
    """Share of the samples without contact."""
    return float(np.mean(result.columns[FORCE] <= 0.0))


@pytest.mark.full
@pytest.mark.parametrize("stiffer", [1.0, 10.0, 100.0])
def test_a_diverging_contact_is_never_silent(stiffer):
    """Without a warning, the force is right, its peak is no multiple of the true one, and nothing lifts off that stays on."""
    scene = load_scene("en50318-2002")
    step = scene.master.step
    stiff = {"stop_time": 1.0, "pantograph.contact_stiffness": stiffer * STIFFNESS, "pantograph.substep": 5e-5}
    scene = scene.with_changes(stiff)
    reference = run(scene.with_changes({"master.step": step / 8}), in_process=True)
    assert not reference.info.warnings
    silent, diverged = [], 0
    for factor in (1, 2, 5, 10, 20, 50):
        result = run_verified(scene.with_changes({"master.step": factor * step}), in_process=True)
        warned = bool(result.info.warnings) or result.outcome != "done"
        wrong = (
            error(result, reference) > WITHIN
            or lifted(result) > lifted(reference) + LIFTED
            or result.columns[FORCE].max() > ROUGH * reference.columns[FORCE].max()
        )
        diverged += wrong
        silent += [factor] if wrong and not warned else []
    assert silent == []
    assert diverged >= 2
