"""A scene that somebody moves while it runs: its numbers are those of a session, and its errors hold what finer steps show."""

import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.orchestrator.harness.served.held import HeldScene
from cosimo.orchestrator.session.session import Session
from cosimo.tests.support import two_masses

PENDULUM = {"stop_time": 1.0, "units": {"chain": {"component": "TwoLinkChain"}}, "master": {"step": 0.02}}
MOVES = ((0.2, "chain.first_torque", 5.0), (0.5, "chain.first_torque", "-3 N.m"), (0.5, "chain.second_torque", 1.0))
NAMES = ["chain.first_angle", "chain.second_angle"]


@pytest.fixture(scope="module")
def moved():
    held = HeldScene(read_scene(PENDULUM))
    held.begin({"chain.start_first_angle": "30 deg"})
    answers = []
    for time, name, value in MOVES:
        answers.append(held.advance(time, NAMES))
        held.move(name, value)
    answers.append(held.advance(5.0, NAMES))
    yield held, answers
    held.close()


def by_hand(step):
    scene = read_scene({**PENDULUM, "master": {"step": step}})
    with Session(scene) as session:
        session["chain.start_first_angle"] = "30 deg"
        session.initialize()
        session.record()
        for time, name, value in MOVES:
            session.until(time)
            session[name] = value
        session.until(1.0)
        return session.result()


def test_moves_are_those_of_a_session(moved):
    _, answers = moved
    result = by_hand(0.02)
    times = [t for answer in answers for t in answer["times"]]
    assert times == result.time[1:].tolist()
    rows = np.array([row for answer in answers for row in answer["rows"]])
    assert rows[-1].tolist() == [result[n][-1] for n in NAMES]
    assert answers[-1]["done"]
    assert not answers[-1]["failure"]


def test_errors_hold_what_much_finer_steps_show(moved):
    held, _ = moved
    errors = {row["name"]: row["rms"] for row in held.errors()}
    coarse, fine = by_hand(0.02), by_hand(0.02 / 32)
    for name in NAMES:
        true = np.sqrt(np.mean((coarse[name] - fine[name][::32]) ** 2)) / coarse[name].std()
        assert 0.2 * errors[name] < true <= errors[name]


def test_a_new_start_forgets_moves(moved):
    held, _ = moved
    description = held.begin({})
    inputs = {f"{unit['name']}.{one['name']}": one["value"] for unit in description["units"] for one in unit["inputs"]}
    assert inputs["chain.first_torque"] == 0.0
    with pytest.raises(BadInput, match="no step yet"):
        held.errors()
    held.advance(0.1, NAMES)
    start = next(p for p in description["units"][0]["parameters"] if p["name"] == "start_first_angle")
    assert start["value"] == pytest.approx(np.pi / 6)  # parameters keep their values
    assert held.errors()


def test_driven_inputs_are_not_offered_and_bad_moves_are_refused():
    held = HeldScene(read_scene({**two_masses("jacobi", 5e-3, 1), "stop_time": 0.1}))
    try:
        offered = [one["name"] for unit in held.description()["units"] for one in unit["inputs"]]
        assert offered == []
        held.begin({})
        with pytest.raises(BadInput, match="nothing drives"):
            held.move("a.force", 1.0)
        with pytest.raises(BadInput, match="a parameter or an input"):
            held.move("a.x_out", 1.0)
    finally:
        held.close()
