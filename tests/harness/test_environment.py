"""A scene as an environment of Gymnasium: its checker is content, its steps are those of a session, failures end an episode."""

import warnings

import numpy as np
import pytest
from cosimo import BadInput, gym, load_scene
from cosimo.orchestrator.session.session import Session

pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env

TORQUE = {"chain.first_torque": (-20.0, 20.0)}
OUTPUTS = ["chain.first_angle", "chain.second_angle", "chain.first_rate"]
START = {"chain.start_first_angle [deg]": (170.0, 190.0), "chain.start_second_angle": 3.0}


def tip(observation, action):
    """A reward."""
    return -float(np.cos(observation[0]) + np.cos(observation[1]))


@pytest.fixture(scope="module")
def scene():
    return load_scene("double-pendulum").with_changes({"stop_time": 0.2})


def make(scene, **more):
    return gym(scene, **{"actions": TORQUE, "observations": OUTPUTS, "reward": tip, **more})


@pytest.mark.parametrize("start", [None, START])
def test_the_checker_of_gymnasium_passes(scene, start):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # infinite and unsymmetrical spaces are the scene's
        check_env(make(scene, start=start), skip_render_check=True)


def test_steps_are_those_of_a_session(scene):
    env = make(scene, steps=2)
    with Session(scene) as sim:
        sim.initialize()
        first, _ = env.reset(seed=0)
        assert first.tolist() == sim.values(OUTPUTS).tolist()
        for torque in (5.0, -3.0, 50.0):
            observation, reward, terminated, truncated, info = env.step(np.array([torque]))
            sim["chain.first_torque"] = min(torque, 20.0)
            sim.step(2)
            assert observation.tolist() == sim.values(OUTPUTS).tolist()
            assert reward == tip(observation, None)
            assert (terminated, truncated, info) == (False, False, {})
    env.close()


@pytest.mark.parametrize("start", [None, START])
def test_an_episode_ends_at_the_stop_time_and_the_same_seed_begins_it_again(scene, start):
    env = make(scene, start=start)
    first, _ = env.reset(seed=4)
    steps = [env.step(np.array([2.0])) for _ in range(20)]
    assert [truncated for _, _, _, truncated, _ in steps] == [False] * 19 + [True]
    again, _ = env.reset(seed=4)
    assert again.tolist() == first.tolist()
    assert [env.step(np.array([2.0]))[0].tolist() for _ in range(20)] == [one[0].tolist() for one in steps]
    other, _ = env.reset(seed=5)
    assert (other.tolist() == first.tolist()) is (start is None)


def test_units_behind_names_are_those_of_spaces_and_arrays(scene):
    actions = {"chain.first_torque [kN.m]": (-0.02, "20 N.m")}
    env = make(scene, actions=actions, observations={"chain.first_angle [deg]": (-360.0, 360.0)}, start=START, reward=tip_of_mass)
    assert (env.action_space.low.tolist(), env.action_space.high.tolist()) == ([-0.02], [0.02])
    assert env.observation_space.high.tolist() == [360.0]
    observation, _ = env.reset(seed=1, options={"chain.start_first_angle": 175.0})
    assert observation == pytest.approx([175.0])
    env.step(np.array([0.01]))
    assert env.session["chain.first_torque"] == pytest.approx(10.0)


def test_a_condition_terminates(scene):
    env = make(scene, terminated=lambda observation: observation[0] < 1.9)
    env.reset()
    assert [env.step(np.array([0.0]))[2] for _ in range(3)] == [True] * 3  # it falls from 1.9


def test_a_step_that_fails_truncates_with_its_reason_and_the_next_episode_is_whole():
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 1.0, "spring.stiffness": 1e9})
    env = gym(scene, actions={"mass.tip_force_x": (-1.0, 1.0)}, observations=["mass.base_x"], reward=tip_of_mass)
    first, _ = env.reset()
    for _ in range(50):
        observation, _, _, truncated, info = env.step(np.array([1.0]))
        if truncated:
            break
    assert "has grown to" in info["failure"]
    assert np.isfinite(observation).all()
    again, _ = env.reset()
    assert again.tolist() == first.tolist()


def tip_of_mass(observation, action):
    """Another reward."""
    return float(observation[0])


def test_a_scene_with_random_parts_takes_its_seed_from_that_of_the_episode():
    scene = load_scene("wind-pump-day").with_changes({"stop_time": 60.0})
    env = gym(scene, actions=[], observations=["wind.speed"], reward=tip_of_mass)

    def winds(seed):
        env.reset(seed=seed)
        return [env.step(np.zeros(0))[0][0] for _ in range(5)]

    assert winds(1) == winds(1)
    assert winds(1) != winds(2)


def test_copies_are_a_vector_environment(scene):
    envs = make(scene, start=START, copies=3)
    observations, _ = envs.reset(seed=7)
    assert observations.shape == (3, 3)
    assert len({row[0] for row in observations.tolist()}) == 3
    alone, _ = make(scene, start=START).reset(seed=8)  # each copy has the next seed
    assert observations[1].tolist() == alone.tolist()
    stepped = envs.step(np.ones((3, 1)))
    assert stepped[0].shape == (3, 3)
    envs.close()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"actions": ["chain.first_torque"]}, "both finite"),
        ({"actions": {"chain.first_torqe": (0.0, 1.0)}}, "Did you mean 'first_torque'"),
        ({"actions": {"chain.first_torque": (1.0, 0.0)}}, "low < high"),
        ({"actions": {"chain.first_torque": 1.0}}, r"\(low, high\)"),
        ({"actions": {"chain.first_torque": ("1 N", "2 N")}}, "a unit of the dimension of N.m"),
        ({"actions": {"chain.first_mass": (0.0, 1.0)}}, "an input that nothing drives"),
        ({"observations": ["chain.first_mass"]}, "an output that is a number"),
        ({"observations": ["chain.first_angle [m]"]}, "a unit of the dimension of rad"),
        ({"start": {"chain.first_angle": 1.0}}, "a parameter, or an input"),
        ({"steps": 0}, "a whole number of macro steps"),
        ({"copies": 0}, "a whole number, 1 at least"),
    ],
)
def test_what_cannot_be_is_one_message_at_once(scene, more, said):
    with pytest.raises(BadInput, match=said):
        make(scene, **more)


def test_an_input_that_is_driven_is_no_action():
    scene = load_scene("mass-on-spring")
    with pytest.raises(BadInput, match=r"connected to mass\.base_x"):
        gym(scene, actions={"spring.second_x": (0.0, 1.0)}, observations=["mass.base_x"], reward=tip_of_mass)
