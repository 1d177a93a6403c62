"""Which method is the cheaper one at the same error, in counted work: what no machine and no other process can change."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.studies.quantities import errors, quantities_of
from cosimo.orchestrator.harness.studies.settings_axes import coupling_changes
from cosimo.orchestrator.harness.studies.trial import trial
from cosimo.orchestrator.scene.shorter_steps import refined
from cosimo.orchestrator.systems import load_scene, read_scene


class Measured:
    """Trials of a scene against a much finer run of it."""

    def __init__(self, scene, finest):
        self.scene, self.quantities = scene, quantities_of(scene)
        self.reference = trial(scene, finest, repeats=1).history

    def at(self, changes):
        """(error, trial)"""
        found = trial(self.scene, changes, repeats=1)
        return max(errors(self.quantities, found.history, self.reference).values()) if found.done else np.inf, found

    def fewest(self, algorithm, degree, steps, allowed):
        """Macro steps of the longest step that keeps the error, as all shorter ones do; infinite where none does."""
        fewest = np.inf
        for step in sorted(steps):
            error, found = self.at({**coupling_changes(self.scene, algorithm, degree), "master.step": step})
            if error > allowed:
                break
            fewest = found.work["macro_steps"]
        return fewest


def measured(name, stop, step, **more):
    """The scene's first seconds, against Gauss-Seidel with short steps inside and out."""
    scene = load_scene(name).with_changes({"stop_time": stop, **more})
    degree = scene.master.extrapolation
    return Measured(scene, {**coupling_changes(scene, "gauss-seidel", degree), "master.step": step, **refined(scene, 0.25)})


def test_railway_linear_gauss_seidel_against_held_jacobi():
    """At 2 % of the force's range; held values let the contact see a wire that stands still for a step."""
    railway = measured(
        "en50318-2002",
        1.0,
        1.25e-4,
        **{
            "record.snapshots": (),
            "record.snapshot_interval": None,
            "study.quantities": ["pantograph.contact_force, time history", "pantograph.contact_force, standard deviation"],
        },
    )
    steps = [4e-3, 2e-3, 1e-3, 5e-4]
    linear = railway.fewest("gauss-seidel", 1, steps, 0.02)
    assert linear < np.inf
    assert 2 * linear <= railway.fewest("jacobi", 0, steps, 0.02)


@pytest.mark.full
def test_vehicle_held_commands_in_the_order_of_the_signals():
    """Commands are stairs, which no degree extrapolates: handed on a step later, they need more steps for the same 1 %."""
    vehicle = measured(
        "rov-station-keeping",
        20.0,
        5e-3,
        **{
            "study.quantities": [
                "hull.position_north, time history",
                "hull.yaw, time history",
                "thruster_1.thrust, time history",
            ],
            "analysis.transient": 0.0,
        },
    )
    steps = [0.16, 0.08, 0.04, 0.02]
    held = vehicle.fewest("gauss-seidel", 0, steps, 0.01)
    assert held < np.inf
    assert 2 * held <= vehicle.fewest("jacobi", 0, steps, 0.01)
    assert held == vehicle.fewest("gauss-seidel", 1, steps, 0.01)


@pytest.mark.full
def test_bearing_internal_steps_buy_accuracy_and_macro_steps_do_not():
    """A unit alone: its own steps count, while a macro step is but the time between two samples.

    Between contacts that open and close the order is four; these, at half the steps, cost an error of order 2.5.
    """
    bearing = Measured(
        load_scene("outer-ring-defect").with_changes(
            {"stop_time": 0.05, "analysis.transient": 0.0, "study.quantities": ["bearing.displacement_x, time history"]}
        ),
        {"bearing.substep": 1.25e-6},
    )
    (one, first), (half, second) = (bearing.at({"master.step": step, "bearing.substep": 2e-5}) for step in (4e-5, 2e-5))
    finer, third = bearing.at({"master.step": 4e-5, "bearing.substep": 1e-5})
    assert first.work["derivative_calls"] == second.work["derivative_calls"] == third.work["derivative_calls"] / 2
    assert half == pytest.approx(one, rel=0.2)
    assert finer < one / 2.0**2.5


@pytest.mark.full
def test_friction_located_events_against_a_smoothed_law():
    """Two axes swing and come to rest. A smoothed law is wrong by its width, and short steps are the price of a narrow one."""
    units = load_scene("joint-stiction").settings()["units"]

    def scene(unit):
        return read_scene(
            {
                "stop_time": 6.0,
                "master": {"step": 0.02},
                "units": {"body": units[unit]},
                "study": {"quantities": ["body.outer_angle, time history", "body.inner_angle, time history"]},
            }
        )

    level = {"body.stick_friction.static_ratio": 1.0}  # as the smoothed law has it
    exact = Measured(scene("exact"), {**level, "body.substep": 5e-4})
    error, events = exact.at({**level, "body.substep": 0.02})
    assert error < 1e-4
    smoothed = Measured.__new__(Measured)
    smoothed.scene, smoothed.quantities, smoothed.reference = scene("smoothed"), exact.quantities, exact.reference
    enough = []
    for width, substep in ((0.1, 0.01), (0.03, 0.01), (0.01, 5e-3), (3e-3, 1e-3)):  # each close to its longest stable step
        found, run = smoothed.at({"body.smoothed_friction.width": width, "body.substep": substep})
        enough += [run.work["derivative_calls"]] if found <= 5e-3 else []
    assert enough
    assert 3 * events.work["derivative_calls"] < min(enough)
