"""Hard cases of the railway components alone: contact lost, nearly massless, no damping, slack everywhere, extreme sizes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.pantograph import Pantograph

ROOT = Path(__file__).resolve().parents[2]


def test_contact_is_lost_and_regained():
    """The wire drops... upwards, out of reach for 0.3 s, and returns: a free flight between two contacts."""
    h = 1e-3
    pantograph = Pantograph(
        ["contact_loss"], {"substep": 1e-4, "frame_stiffness": 0.0, "frame_damping": 0.0, "head_damping": 0.0}
    )
    pantograph.initialize(0.0)
    p = pantograph.parameters
    mass = np.array([p["head_mass"], p["frame_mass"]])
    force, momentum = [], []
    for k in range(1000):
        t = k * h
        pantograph.set("wire_height", 1.0 if 0.2 <= t < 0.5 else 0.0)
        pantograph.step(t, h)
        force.append(pantograph["contact_force"])
        momentum.append(mass @ pantograph.x[[1, 3]])
    force, momentum = np.array(force), np.array(momentum)
    assert np.isfinite(force).all()
    assert force.min() == 0.0  # a wire cannot pull
    apart = slice(200, 500)
    assert not force[apart].any()  # exactly nothing while apart
    # Only the static force acts then: momentum grows by F0 t, to rounding of 3000 internal steps (1e-16 each, of 36 N.s).
    gained = momentum[apart] - momentum[200]
    np.testing.assert_allclose(gained, p["static_force"] * h * np.arange(300), rtol=0.0, atol=1e-10)
    assert force[500] > 1e3  # N; the head has flown 0.2 m past the wire's place and is driven into it
    assert (np.diff(np.sign(force)) != 0).sum() >= 3  # and it bounces


@pytest.mark.parametrize(
    "changed",
    [{"head_mass": m} for m in (1e-6, 1e-5, 1e-4, 1e-3)] + [{"contact_stiffness": k} for k in (1e7, 1e9, 1e12)],
    ids=str,
)
def test_stiff_pantographs_are_refused_or_stable(changed):
    """What is stable is said by `stable_step`: above it the default substep is refused, at it the run stays at rest."""
    # The highest frequency is that of the head between contact spring and head spring; RK4 is trusted up to 2.61 over it.
    stiff = Pantograph(["contact_loss"], changed)
    omega = np.sqrt((stiff["contact_stiffness"] + stiff["head_stiffness"]) / stiff["head_mass"])
    limit = stiff.stable_step()
    # Damping and frame shift the eigenvalue: by c / (2 m omega) or less, most for the lightest head.
    shift = stiff["head_damping"] / (stiff["head_mass"] * omega)
    assert 1.0 / (1.0 + shift) < limit * omega / 2.61 < 1.02
    if limit < stiff["substep"]:
        with pytest.raises(BadInput, match="substep"):
            stiff.initialize(0.0)
    stiff.set("substep", min(limit, stiff["substep"]))
    stiff.initialize(0.0)
    rest = stiff.x.copy()
    push = 0.5 * stiff["static_force"] / stiff["contact_stiffness"]  # m; takes half of the contact force away
    stiff.x[0] -= push
    for k in range(5):
        stiff.step(k * 1e-3, 1e-3)
    assert np.isfinite(stiff.x).all()
    # A stable step keeps the push or damps it, an unstable one multiplies it. The frame, 15 kg, hardly moves in 5 ms.
    assert abs(stiff.x[0] - rest[0]) <= 1.1 * push
    assert abs(stiff.x[2] - rest[2]) <= 0.1 * push + 1e-15


def test_an_explicit_substep_above_the_limit_is_refused_with_the_limit():
    catenary = Catenary(parameters={"spans": 2, "element": 0.1})
    limit = catenary.stable_step()
    assert limit < catenary["substep"]
    with pytest.raises(BadInput, match=rf"at most {limit:.3g} s"):
        catenary.initialize(0.0)
    catenary.set("substep", 0.95 * limit)  # the mass matrix follows the substep, and with it the limit by 2 %
    catenary.initialize(0.0)


@pytest.mark.full  # one of each method is a hard case of the catalogue, too
@pytest.mark.parametrize(
    ("method", "effects", "ripple"),
    [
        # Verlet conserves a neighbouring energy: E swings by (omega h)²/8 of the share of the modes that take part.
        ("explicit", (), 2e-3),
        ("explicit", ("dropper_slackening",), 2e-3),
        # The midpoint rule conserves a quadratic energy exactly: rounding of 5000 steps.
        ("implicit", (), 1e-8),
        # A dropper that changes within a step costs or gains k (v h)²/2, 5e-4 J of 9 J at 0.1 m/s; ten in a row of one sign.
        ("implicit", ("dropper_slackening",), 5e-4),
    ],
)
def test_an_undamped_wire_keeps_its_energy(method, effects, ripple):
    """Released from a static load of 200 N and left alone for 5 s."""
    catenary = Catenary(effects, {"spans": 3, "element": 1.0, "method": method})
    catenary.set("contact_position", 90.0)
    catenary.set("contact_force", 200.0)
    catenary.initialize(0.0)
    catenary.set("contact_force", 0.0)
    energy = [catenary.energy()]
    for k in range(2500):
        catenary.step(k * 2e-3, 2e-3)
        energy.append(catenary.energy())
    energy = np.array(energy) / energy[0]
    assert np.abs(energy - 1.0).max() <= ripple
    assert abs(energy[-500:].mean() - energy[1:501].mean()) <= 0.5 * ripple  # it swings or wanders, and does not grow
    assert np.abs(catenary.x[: catenary.mesh.mass.size]).max() > 0.01  # m; it still swings


@pytest.mark.full
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_one_span(method):
    catenary = Catenary(["dropper_slackening", "gravity_sag"], {"spans": 1, "method": method})
    catenary.set("contact_force", 120.0)
    catenary.initialize(0.0)
    before = catenary["wire_height"]
    for k in range(300):
        catenary.step(k * 1e-3, 1e-3)
    assert catenary["wire_height"] == pytest.approx(before, abs=1e-12)  # m; the equilibrium is kept, to rounding


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of a process is read as Linux gives it")
def test_sixty_spans_fit_in_400_megabytes():
    source = """
import json, re
from cosimo.components.railway.catenary import Catenary
c = Catenary(["dropper_slackening", "gravity_sag", "damping", "wire_profile"], {"spans": 60, "first_watched_support": 30})
c.set("contact_force", 120.0)
c.initialize(0.0)
for k in range(200):
    c.step(k * 1e-3, 1e-3)
peak = re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())  # getrusage would count the parent's memory
print(json.dumps([c["wire_height"], c["static_residual"], int(peak[1]) / 1024]))
"""
    done = subprocess.run(
        [sys.executable, "-c", source], capture_output=True, text=True, check=True, cwd=ROOT, env={**os.environ}
    )
    height, residual, megabytes = json.loads(done.stdout)
    assert 0.01 < height < 0.2  # m; 120 N over 1.2 to 4.7 N/mm
    assert residual < 1e-10
    assert megabytes < 400.0


@pytest.mark.full  # a hard case of the catalogue, too
@pytest.mark.parametrize("force", [500.0, 1e3, 3e3, 1e4])
def test_slack_droppers_around_a_large_force_settle(force):
    """A blow that lifts most of the wire off its droppers: the active set finds an answer in every step, or says so."""
    catenary = Catenary(["dropper_slackening", "gravity_sag"], {"spans": 3, "method": "implicit"})
    catenary.set("contact_position", 90.0)
    catenary.initialize(0.0)
    catenary.set("contact_force", force)
    slackest = 0
    for k in range(500):
        catenary.step(k * 1e-3, 1e-3)  # raises StepFailed where the set does not converge
        d = catenary.mesh.dropper.size
        slackest = max(slackest, d - int(catenary.x[catenary.x.size - d :].sum()))  # the state ends with which are taut
    assert slackest >= 5
    assert np.isfinite(catenary.x).all()
    # At most as many solutions as steps and changes of the set; a set that chatters would need up to 50 per step.
    assert catenary.work["solves"] <= 2 * catenary.work["steps"]


@pytest.mark.full
def test_a_dropper_that_would_push_at_rest_is_refused():
    light = Catenary(["dropper_slackening", "pre_sag"], {"spans": 2, "pre_sag.depth": 0.3, "contact_wire_mass": 0.3})
    with pytest.raises(BadInput, match=r"dropper at .* would carry -.* N at rest"):
        light.initialize(0.0)
    Catenary(["pre_sag"], light.parameters).initialize(0.0)  # bilateral droppers may push


@pytest.mark.full
def test_a_contact_point_beyond_the_wire_is_a_failed_step_that_can_be_taken_back():
    for method in ("explicit", "implicit"):
        catenary = Catenary(parameters={"spans": 1, "method": method})
        catenary.set("contact_position", 59.0)
        catenary.initialize(0.0)
        state = catenary.save()
        catenary.u[1, 0] = 80.0
        with pytest.raises(StepFailed, match="left the range"):
            catenary.step(0.0, 0.1)
        catenary.restore(state)
        catenary.step(0.0, 1e-3)
        assert catenary["contact_position"] == 59.0
