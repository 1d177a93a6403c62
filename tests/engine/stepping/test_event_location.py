"""Events: changes of sign that are located by rollback, and events that units tell themselves."""

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE, hold_inputs
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms.step_control import Controller
from cosimo.orchestrator.engine.stepping.adaptive import AdaptiveStepping
from cosimo.orchestrator.engine.stepping.clock import Clock
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import open_master
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import slope
from cosimo.tests.support import OfTime


class Relay(Component):
    """Pushes a body back to 0 with a force that does not depend on the distance."""

    strength = parameter(1.0, "N", "force")
    slope = parameter(0.0, "N/m", "and what it has more for each metre")
    position = input_(0.0, "m", "position of the body")
    force = output("N", "force on the body", feedthrough=("position",))

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        hold_inputs(self.u, h)
        self._outputs(t)
        return DONE

    def _outputs(self, t):
        x, p = self.u[0, 0], self.parameters
        self.y[:] = (-p["strength"] if x >= 0.0 else p["strength"]) - p["slope"] * x


def relay(step: float, degree: int, events: list, *, slope: float = 0.0, stop: float = 9.0, **master) -> dict:
    """A mass of 1 kg that leaves 0 with 1 m/s, held back by a relay: it turns once a second and crosses 0 at 2, 4, 6 ... s."""
    return {
        "stop_time": stop,
        "connections": ["relay.force -> mass.force", "mass.x_out -> relay.position"],
        "units": {
            "mass": {"component": "cosimo.tests.support:Mass"},
            "relay": {"component": f"{__name__}:Relay", "parameters": {"slope": slope}},
        },
        "master": {"algorithm": "jacobi", "step": step, "extrapolation": degree, "events": events, **master},
    }


def exact_relay(t: np.ndarray) -> np.ndarray:
    """Parabolas of 2 s, up and down in turns."""
    rest = t % 2.0
    return (rest - rest**2 / 2.0) * np.where(t % 4.0 < 2.0, 1.0, -1.0)


@pytest.mark.parametrize("degree", [0, 1])
def test_crossings_of_a_relay_are_located_and_the_motion_is_exact(degree):
    """Between the crossings the force is constant, so that nothing is left but the location: a millionth of the step each."""
    step = 0.0717
    result = run(read_scene(relay(step, degree, ["mass.x_out"])))
    resolution = 1e-6 * step
    assert result.info.counters.stepping.events == 4
    for k, crossing in enumerate((2.0, 4.0, 6.0, 8.0), 1):
        # each lies up to a resolution late, and what comes after it twice as much later
        assert -1e-12 < result.time[np.abs(result.time - crossing).argmin()] - crossing < k * k * resolution
    assert np.abs(result["mass.x_out"] - exact_relay(result.time)).max() < 16 * resolution


def test_without_location_the_error_is_of_first_order():
    errors = {}
    for events in ([], ["mass.x_out"]):
        for step in (0.0717, 0.00717):
            result = run(read_scene(relay(step, 0, events)))
            errors[bool(events), step] = np.abs(result["mass.x_out"] - exact_relay(result.time)).max()
    assert errors[False, 0.0717] > 0.02
    assert errors[False, 0.00717] > 0.002
    assert errors[True, 0.0717] < 1e-5


def arcs(step: float, events: list, **master) -> float:
    """Error of the speed at the end of 7 s, for x'' = -1 - x and its mirror image: an arc from one crossing to the next takes
    pi / 2 s."""
    result = finished(read_scene(relay(step, 1, events, slope=1.0, stop=7.0, **master)))
    rest = 7.0 % (np.pi / 2.0)  # behind the fourth crossing
    return abs(result["mass.v_out"][-1] - (np.cos(rest) - np.sin(rest)))


@pytest.mark.full
def test_order_through_events_is_that_of_the_inputs():
    """Where in a step the events lie changes its error by a factor of up to 5 either way: many steps tell the order."""
    steps = [float(f"{h:.4g}") for h in np.geomspace(0.08, 0.0025, 24)]
    errors = [arcs(step, ["mass.x_out"]) for step in steps]
    assert slope(steps, errors) == pytest.approx(2.0, abs=0.25)
    assert arcs(0.005, ["mass.x_out"]) < 0.02 * arcs(0.005, [])


@pytest.mark.parametrize(("method", "share"), [("milne", 2.0), ("doubling", 0.05)])
def test_events_and_control_together(method, share):
    """Doubling alone does not see a jump in the first half of a step; predictors do, and go down to the smallest step."""
    control = {"method": method, "relative": 1e-4, "absolute": 1e-4}
    located, blind = (
        run(read_scene(relay(0.01, 1, events, slope=1.0, stop=7.0, control=control))).info.counters.stepping
        for events in (["mass.x_out"], [])
    )
    assert located.events == 4
    assert located.inaccurate == 0
    assert located.rejected < blind.rejected
    assert arcs(0.01, ["mass.x_out"], control=control) < min(1.5e-3, share * arcs(0.01, [], control=control))


def test_a_located_crossing_takes_few_trials():
    """Regula falsi on a smooth signal: less than ten steps for six digits, where halving would take twenty."""
    counters = run(read_scene(relay(0.0717, 1, ["mass.x_out"]))).info.counters.stepping
    assert counters.restores < 10 * counters.events


def test_steps_lead_back_to_the_grid_behind_an_event():
    result = run(read_scene(relay(0.3, 0, ["mass.x_out"], stop=3.0)))
    grid = np.arange(11) * 0.3
    assert np.abs(result.time[:, None] - grid).min(axis=0).max() < 1e-9  # each of its times has a row


def test_a_signal_that_jumps_is_located_as_well():
    result = run(read_scene(relay(0.0717, 0, ["mass.x_out"], stop=3.0)))
    other = run(read_scene(relay(0.0717, 0, ["relay.force"], stop=3.0)))  # +1, -1: a jump
    assert other.info.counters.stepping.events == 1
    near = other.time[np.abs(other.time - 2.0).argmin()]
    assert near == pytest.approx(result.time[np.abs(result.time - 2.0).argmin()], abs=2e-7)


def test_the_first_of_two_events_in_a_step_is_found_first():
    """Two free masses that cross 0 at 0.35 s and at 0.32 s."""
    scene = {
        "stop_time": 1.0,
        "master": {"step": 0.2, "events": ["a.x_out", "b.x_out"]},
        "units": {
            name: {"component": f"{__name__}:Riser", "parameters": {"start": start}}
            for name, start in (("a", -0.35), ("b", -0.32))
        },
    }
    result = run(read_scene(scene))
    for crossing in (0.32, 0.35):
        late = result.time - crossing
        assert late[late > -1e-12].min() < 2.1e-7


class Riser(OfTime):
    """A position that rises by 1 m in a second."""

    start = parameter(-1.0, "m", "position at the start")
    x_out = output("m", "position")

    def _outputs(self, t):
        self.y[0] = self.parameters["start"] + t


class Telling:
    """Stands for a master and for its only unit, which has an event of its own at some times and goes back if it is asked to."""

    def __init__(self, *times: float):
        self.times, self.event, self.steps = times, None, []

    def step(self, t, h):
        self.event = min((e for e in self.times if t < e <= t + h), default=None)
        self.steps.append((t, h))

    def save(self, reuse=None):
        return len(self.steps)

    def restore(self, saved):
        del self.steps[saved:]


def told(rollback: bool, *times: float) -> tuple[list[float], list[float], int]:
    """Ends of the steps of 0.1 s to 0.5 s, times of the restarts, and events counted."""
    clock, unit, ends, restarts = Clock.dividing(0.1, 0.5).finer(10**6), Telling(*times), [], []
    loop = AdaptiveStepping(
        unit,
        clock,
        10**6,
        5 * 10**6,
        early=[unit],
        rollback=rollback,
        restarts=[lambda: restarts.append(round(sum(unit.steps[-1]), 9))],
    )
    loop.run([lambda tick, t: ends.append(t)])
    return ends, restarts, loop.counts["events"]


def test_all_units_are_brought_to_an_event_that_one_of_them_tells():
    ends, restarts, events = told(True, 0.27)
    assert ends == pytest.approx([0.0, 0.1, 0.2, 0.27, 0.3, 0.4, 0.5], abs=1e-12)
    assert restarts == [0.27]
    assert events == 1


def test_an_event_between_two_ticks_is_rounded_up():
    ends, _, _ = told(True, 0.2 + 1.5e-7 / 3.0)
    assert ends[3] == pytest.approx(0.2000001, abs=1e-12)


def test_without_rollback_the_step_stays_and_inputs_restart_at_its_end():
    assert told(False, 0.27) == ([0.0, 0.1, 0.2, pytest.approx(0.3), 0.4, 0.5], [0.3], 1)


def test_a_step_whose_error_was_not_measured_leaves_the_next_one_as_long():
    unit, clock = Telling(*np.arange(0.05, 1.0, 0.1)), Clock.dividing(0.1, 1.0).finer(1000)
    control = Controller(1000, 1, 10_000)
    loop = AdaptiveStepping(unit, clock, 1000, 10_000, early=[unit], rollback=False, control=control, estimate=Faultless())
    loop.run([])
    assert loop.counts["events"] == loop.counts["accepted"] == 10
    assert control.length == 1000


class Faultless:
    """An estimate that finds no error."""

    def prepare(self, h):
        pass

    def measure(self, again):
        return 0.0, 2


def test_a_unit_with_a_rate_of_its_own_tells_an_event_once_only():
    """It steps with every third macro step; the event in its first step shortens none of the others."""
    scene = {
        "stop_time": 0.9,
        "master": {"algorithm": "jacobi", "step": 0.1},
        "units": {"u": {"component": f"{__name__}:Riser", "every": 3}, "p": {"component": "cosimo.tests.support:Probe"}},
        "connections": [{"source": "u.x_out", "target": "p.length"}],
    }
    master = open_master(scene, ())
    slow = master.node_of["u"]
    component, step = slow.unit.component, slow.unit.component.step

    def telling(t, h):
        slow.unit.event = 0.27 if t < 0.27 <= t + h else None
        step(t, h)

    component.step = telling
    master.machine.address()
    clock = Clock.dividing(0.1, 0.9).finer(10**6)
    loop = AdaptiveStepping(master, clock, 10**6, 9 * 10**6, early=[slow])
    ends = []
    loop.run([lambda tick, t: ends.append(t)])
    assert loop.counts["events"] == 1
    assert ends == pytest.approx([0.0, 0.1, 0.2, 0.27, *np.arange(3, 10) * 0.1], abs=1e-12)


def test_two_events_of_a_unit_in_one_step():
    ends, restarts, _ = told(True, 0.23, 0.26)
    assert restarts == [0.23, 0.26]
    assert {0.23, 0.26} <= {round(t, 9) for t in ends}


@pytest.mark.parametrize(
    ("event", "message"),
    [
        ("mass.x", "master.events: got mass.x, expected an output of mass"),
        ("body.x_out", "unit 'body', expected a unit of the scene"),
        ("mass.force", "A connection goes from an output"),
    ],
)
def test_events_that_are_no_outputs_are_refused(event, message):
    with pytest.raises(BadInput, match=message):
        read_scene(relay(0.1, 0, [event]))
