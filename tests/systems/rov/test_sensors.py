"""Sensors: the exact truth of their instants without errors, and errors by statistics in closed form."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rov.controller import NAVIGATION
from cosimo.components.rov.sensors import FIRST, HOUR, RovSensors
from cosimo.tests.support import initialized
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, kstest, norm

SURE = 1e-4  # share of right models that a test would refuse; the seeds are fixed
STEP = 0.02
EVERY = {"usbl_every": 1, "depth_every": 1, "dvl_every": 1}
TURNED = Rotation.from_euler("ZYX", [0.7, -0.4, 0.3])
ATTITUDE = dict(zip([f"quaternion_{n}" for n in "xyzw"], TURNED.as_quat(), strict=True))


def sensors(effects=(), inputs=(), **parameters) -> RovSensors:
    component = RovSensors(effects, parameters)
    for name, value in dict(inputs).items():
        component[name] = value
    return initialized(component)


def samples(component: RovSensors, count: int) -> np.ndarray:
    """Outputs at the start and after each of some steps, (count + 1, outputs)."""
    rows = [component.y.copy()]
    for k in range(count):
        component.step(k * STEP, STEP)
        rows.append(component.y.copy())
    return np.array(rows)


def errors(component: RovSensors, count: int) -> np.ndarray:
    """Errors of the twelve axes, (count + 1, 12), of a vehicle that rests at `ATTITUDE`."""
    y = samples(component, count)
    q = Rotation.from_quat(y[:, [4, 5, 6, 3]])
    return np.hstack([y[:, :3], y[:, 7:13], (TURNED.inv() * q).as_rotvec()])


def none(effect: str, **kept: float) -> dict[str, float]:
    """All numbers of an effect at 0 but some."""
    numbers = [v.name for v in RovSensors.effects[effect].variables if v.causality.value == "parameter" and v.unit != "1"]
    return {f"{effect}.{n}": kept.get(n, 0.0) for n in numbers}


def test_a_sample_is_the_truth_of_its_instant_and_holds():
    """Each at its own rate, of inputs that move within a step."""
    component = sensors(
        inputs={n: 0.1 * k for k, n in enumerate(NAVIGATION)}, period=0.01, usbl_every=40, depth_every=2, dvl_every=5
    )
    truth = lambda t: 0.1 * np.arange(13) + (1.0 + np.arange(13)) * t  # noqa: E731
    every = np.array([40, 40, 2, 1, 1, 1, 1, 5, 5, 5, 1, 1, 1])
    assert (component.y == [0.1 * k for k in range(13)]).all()  # bits
    for k in range(50):
        t = 0.02 * k
        component.u[0], component.u[1] = truth(t), 1.0 + np.arange(13)
        component.step(t, 0.02)
        number = 2 * (k + 1)
        np.testing.assert_allclose(component.y, truth(0.01 * every * (number // every)), rtol=0.0, atol=3e-14)
    held = sensors(inputs=ATTITUDE)
    assert [held[f"measured_{n}"] for n in ATTITUDE] == list(ATTITUDE.values())


@pytest.mark.known_answers(RovSensors="noise")
def test_noise_is_normal_white_and_of_its_deviation():
    n = 3000
    deviation = {"usbl": 0.2, "depth": 0.01, "dvl": 0.02, "rate": 2e-3, "attitude": 5e-3}
    e = errors(sensors(("noise",), ATTITUDE, **EVERY, **none("noise", **deviation)), n)
    scaled = e / np.repeat(list(deviation.values()), [2, 1, 3, 3, 3])
    squares = (scaled**2).sum(axis=0)
    low, high = chi2.ppf([0.5 * SURE / 12, 1.0 - 0.5 * SURE / 12], n + 1)
    assert ((squares > low) & (squares < high)).all()  # attitude: turns of 0.005 rad about fixed axes add up to 1e-5 of them
    assert all(kstest(column, norm.cdf).pvalue > SURE for column in scaled.T)
    bound = norm.ppf(1.0 - SURE / 24) / np.sqrt(n)
    assert np.abs((scaled[1:] * scaled[:-1]).mean(axis=0)).max() < bound  # from sample to sample
    across = scaled.T @ scaled / n
    assert np.abs(across - np.diag(across.diagonal())).max() < norm.ppf(1.0 - SURE / 132) / np.sqrt(n)  # from axis to axis
    other = errors(sensors(("noise",), ATTITUDE, **EVERY, **none("noise", **deviation), **{"noise.seed": 2}), 3)
    assert (other[1:] != e[1:4]).all()


@pytest.mark.known_answers(RovSensors="bias")
def test_a_bias_walks_as_it_says():
    """Increments of N(0, walk² T / 1 h) at each sensor's own interval T, and a start of N(0, deviation²) over seeds."""
    n, walks = 2000, {"usbl_walk": 0.3, "depth_walk": 0.02, "dvl_walk": 5e-3, "rate_walk": 1e-3, "attitude_walk": 0.02}
    e = errors(sensors(("bias",), ATTITUDE, usbl_every=4, depth_every=2, dvl_every=1, **none("bias", **walks)), 4 * n)
    for axis, every in zip(range(12), [4, 4, 2, *[1] * 9], strict=True):
        walk = list(walks.values())[0 if axis < 2 else 1 if axis < 3 else (axis - 3) // 3 + 2]
        steps = np.diff(e[::every, axis])[:n] / (walk * np.sqrt(every * STEP / HOUR))
        low, high = chi2.ppf([0.5 * SURE / 12, 1.0 - 0.5 * SURE / 12], n)
        assert low < (steps**2).sum() < high
        assert np.abs((steps[1:] * steps[:-1]).mean()) < norm.ppf(1.0 - SURE / 24) / np.sqrt(n)
    starts = np.array([sensors(("bias",), **{"bias.seed": s, "bias.depth": 0.5})["measured_depth"] for s in range(300)])
    assert kstest(starts / 0.5, norm.cdf).pvalue > SURE


@pytest.mark.known_answers(RovSensors="dropout")
def test_losses_have_their_share_and_length():
    """Bursts are geometric: share and mean length of a two-state chain; a lost sample keeps the value before."""
    n, share, length = 8000, 0.25, 4.0
    component = sensors(("dropout",), **EVERY, **{"dropout.dvl": share, "dropout.dvl_length": length, "dropout.usbl": 0.0})
    values, lost = [], []
    for k in range(n):
        component["surge"] = float(k)
        component.step(k * STEP, STEP)
        values.append(component["measured_surge"])
        lost.append(component["dropout.dvl_lost"] > 0.5)
        assert component["dropout.usbl_lost"] == 0.0
    lost, values = np.array(lost), np.array(values)
    assert (values[~lost] == np.flatnonzero(~lost)).all()
    assert (values[1:][lost[1:]] == values[:-1][lost[1:]]).all()
    memory = 1.0 - 1.0 / length - share / (length * (1.0 - share))  # correlation from sample to sample
    spread = np.sqrt(share * (1.0 - share) * (1.0 + memory) / (1.0 - memory) / n)
    assert lost.mean() == pytest.approx(share, abs=4.0 * spread)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], lost.astype(int), [0]))))
    lengths = edges[1::2] - edges[::2]
    assert lengths.mean() == pytest.approx(length, abs=4.0 * np.sqrt(length * (length - 1.0) / lengths.size))


def test_bursts_that_no_chain_has_are_refused():
    with pytest.raises(BadInput, match="Lengthen the bursts"):
        sensors(("dropout",), **{"dropout.imu": 0.6, "dropout.imu_length": 1.0})
    sensors(("dropout",), **{"dropout.imu": 0.6, "dropout.imu_length": 1.5})


def test_axes_of_a_sensor_stand_together():
    assert FIRST == (0, 2, 3, 6)
    with_all = sensors(("noise", "bias", "dropout"))
    state = with_all.save()
    with_all.step(0.0, STEP)
    once = with_all.y.copy()
    with_all.restore(state)
    with_all.step(0.0, STEP)
    assert (with_all.y == once).all()  # numbers by count: a repeated step repeats them
