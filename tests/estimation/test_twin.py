"""The twin of the underwater vehicle: in real time beside the vehicle's FMUs, which run in a second process, over UDP."""

from __future__ import annotations

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.session.session import Session
from cosimo.orchestrator.systems.rov.twin import ALARM, LOST, Twin, demonstrate, measured, real

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
LOST_AT, STOP = 4.0, 6.0  # s


def test_the_twin_finds_the_lost_thruster_within_a_second_beside_the_vehicle():
    outcome = demonstrate(STOP, LOST_AT)
    print(f"worked for {outcome.share:.0%} of real time, {outcome.lag:.3f} s behind the last message")
    assert outcome.first is not None
    assert outcome.first.thruster == LOST
    assert LOST_AT < outcome.first.time <= LOST_AT + 1.0  # simulated time
    assert outcome.used == outcome.sent == 60  # nothing was lost on the way: the twin has kept up
    assert outcome.last.thruster == LOST
    speed = outcome.last.now["current.speed"]
    assert abs(speed.value - 0.25) < 3.0 * speed.deviation


@pytest.mark.full
def test_the_thruster_is_found_with_other_noise_and_none_before_it_is_lost():
    late = []
    with Session(real(STOP, LOST_AT)) as vehicle:
        for seed in range(1, 6):
            twin = Twin(STOP)
            vehicle.reset()
            findings = [twin.take(message) for message in measured(vehicle, seed, paced=False)]
            assert max(f.chi_square for f in findings if f.time <= LOST_AT) < ALARM / 2.0
            first = next(f for f in findings if f.thruster)
            assert first.thruster == LOST
            assert findings[-1].thrust == pytest.approx(twin.sim[f"thruster_{LOST}.thrust"], rel=0.15)  # what it was told to give
            twin.close()
            late.append(first.time - LOST_AT)
    assert max(late) <= 1.0


def test_a_loss_outside_of_the_run_is_refused():
    with pytest.raises(BadInput, match="within the run"):
        demonstrate(STOP, 7.0)
