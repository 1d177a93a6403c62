"""Parameters of a pantograph from its frequency response, against responses and uncertainties from matrices written down here."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.scene.files import read_toml
from cosimo.orchestrator.systems.railway.frequency_response import (
    FrequencyResponse,
    fit_pantograph,
    parameter_names,
    read_response,
    receptance,
    save,
)

FREQUENCY = np.arange(0.5, 20.01, 0.25)  # Hz
TWO = (7.2, 4200.0, 10.0, 15.0, 50.0, 90.0)  # mass, stiffness, damping from the head to the base: EN 50318:2002
THREE = (7.5, 7000.0, 45.0, 9.0, 15500.0, 0.1, 6.0, 160.0, 100.0)  # the EN 50318:2018 pantograph


def from_matrices(values, frequency=FREQUENCY) -> np.ndarray:
    """[(K + i w C - w² M)^-1]_11 by inverting the matrices."""
    m, k, c = (np.array(values[i::3]) for i in range(3))
    n = m.size

    def chain(elements):
        lower = np.zeros((n, n))
        for i, element in enumerate(elements):
            d = np.zeros(n)
            d[i] = 1.0
            d[i + 1 : i + 2] = -1.0
            lower += element * np.outer(d, d)
        return lower

    return np.array([np.linalg.inv(chain(k) + 1j * w * chain(c) - w**2 * np.diag(m))[0, 0] for w in 2.0 * np.pi * frequency])


def noisy(values, noise: float, seed: int = 2) -> FrequencyResponse:
    draw = np.random.default_rng(seed)
    error = noise * (draw.standard_normal(FREQUENCY.size) + 1j * draw.standard_normal(FREQUENCY.size))
    return FrequencyResponse("made up", FREQUENCY, from_matrices(values) * np.exp(error), None)


def bound(values, noise: float) -> np.ndarray:
    """Least relative standard deviation of each parameter that any method can have (Cramér and Rao), (n,)."""
    columns = []
    for i in range(len(values)):
        sides = [from_matrices([v * (1.0 + s * 1e-5 * (j == i)) for j, v in enumerate(values)]) for s in (1.0, -1.0)]
        slope = np.log(sides[0] / sides[1]) / 2e-5
        columns.append(np.concatenate((slope.real, slope.imag)) / noise)
    J = np.array(columns).T
    return np.sqrt(np.diag(np.linalg.inv(J.T @ J)))


@pytest.mark.parametrize("values", [TWO, THREE])
def test_response_of_the_chain(values):
    named = dict(zip(parameter_names(len(values) // 3), values, strict=True))
    assert np.abs(receptance(FREQUENCY, named) / from_matrices(values) - 1.0).max() < 1e-12


@pytest.mark.parametrize("values", [TWO, THREE])
def test_round_trip_with_noise(values):
    """Every parameter comes back within what five per cent of noise allow, and the fit knows how much that is."""
    least = bound(values, 0.05)
    result = fit_pantograph(noisy(values, 0.05), len(values) // 3)
    names = parameter_names(len(values) // 3)
    assert result.magnitude == pytest.approx(0.05, rel=0.2)
    for name, true, limit in zip(names, values, least, strict=True):
        deviation = result.fit.deviations[result.fit.names.index(name)]
        if limit < 0.2:
            assert name in result.identified
            assert abs(result.values[name] / true - 1.0) < 3.5 * limit
            assert deviation == pytest.approx(limit, rel=0.3)
        else:
            assert name not in result.identified
            low, high = result.ranges[name]
            assert low < true < high
            assert any(m.startswith(f"{name} is not identified") for m in result.messages)
    assert set(result.ranges) == ({"frame_stiffness"} if values is TWO else {"frame_damping"})


def test_a_parameter_that_is_known_makes_the_others_better_known():
    response = noisy(TWO, 0.05)
    free, fixed = fit_pantograph(response, 2), fit_pantograph(response, 2, {"frame_stiffness": 50.0})
    assert fixed.values["frame_stiffness"] == 50.0
    assert not fixed.ranges
    assert fixed.fit.deviations[list(fixed.fit.names).index("head_damping")] <= 1.01 * free.fit.deviations[2]


@pytest.mark.full
def test_three_masses_where_there_are_two_are_warned_of():
    """Data of a chain of two cannot tell the parameters of a third mass."""
    result = fit_pantograph(noisy(TWO, 0.01), 3)
    assert result.ranges
    assert any("not identif" in message for message in result.messages)


@pytest.mark.parametrize(("kind", "power"), [("m/N", 0), ("m/s/N", 1), ("m/s2/N", 2), ("N/m", 0), ("N.s/m", 1), ("kg", 2)])
def test_every_form_of_the_data_is_the_same_response(tmp_path, kind, power):
    exact = from_matrices(TWO)
    motion = exact * (2j * np.pi * FREQUENCY) ** power
    values = motion if kind.endswith("/N") else 1.0 / motion
    path = tmp_path / "head.csv"
    lines = [f"{f!r},{v.real!r},{v.imag!r}" for f, v in zip(FREQUENCY.tolist(), values.tolist(), strict=True)]
    path.write_text("\n".join([f"frequency [Hz],real [{kind}],imaginary [{kind}]", *lines]), encoding="utf-8")
    assert np.abs(read_response(path).receptance / exact - 1.0).max() < 1e-12
    polar = [
        f"{f!r},{abs(v)!r},{float(np.degrees(np.angle(v)))!r},0.05"
        for f, v in zip(FREQUENCY.tolist(), values.tolist(), strict=True)
    ]
    path.write_text("\n".join([f"frequency [Hz],magnitude [{kind}],phase [deg],deviation [1]", *polar]), encoding="utf-8")
    response = read_response(path)
    assert np.abs(response.receptance / exact - 1.0).max() < 1e-12
    assert (response.deviation == 0.05).all()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "header"),
        ("frequency [Hz],real [m/N]\n1,2\n2,3\n3,4\n4,5\n5,6", "imaginary"),
        ("frequency [Hz],real [m],imaginary [m]\n1,2,1\n2,3,1\n3,4,1\n4,5,1\n5,6,1", "m/N"),
        ("frequency [Hz],real [m/N],imaginary [m/N]\n2,2,1\n1,3,1\n3,4,1\n4,5,1\n5,6,1", "rises"),
        (
            "frequency [Hz],real [m/N],imaginary [m/N]\n1,2,1\n2,3,x",
            r"line 3, column 'imaginary \[m/N\]': got 'x', expected a number",
        ),
        ("frequency [Hz],real [m/N],imaginary [m/N]\n1,0,0\n2,3,1\n3,4,1\n4,5,1\n5,6,1", "logarithm"),
        (
            "frequency [Hz],magnitude [m/N],phase [turn]\n1,2,1\n2,3,1\n3,4,1\n4,5,1\n5,6,1",
            r"column 'phase \[turn\]': got unit 'turn', expected .* rad, deg",
        ),
        ("frequency [rad/s],real [m/N],imaginary [m/N]\n1,2,1", "unit 'rad/s', expected a unit of the dimension of Hz"),
        ("frequency,real [m/N],imaginary [m/N]\n1,2,1", r"column 'frequency': got no unit.*'frequency \[Hz\]'"),
        ("frequency [Hz],real [dB],imaginary [dB]\n1,2,1", "unit 'dB'"),
        ("frequency [Hz],magnitude [m/N],phase [deg]\n" + "".join(f"{k},-{k},0\n" for k in range(1, 6)), "levels in dB"),
        (
            "frequency [Hz],real [m/N],imaginary [m/N],deviation [1]\n" + "".join(f"{k},1,1,5\n" for k in range(1, 6)),
            "from 5 to 5, expected relative",
        ),
    ],
)
def test_a_file_that_cannot_be_used_is_one_message(tmp_path, text, expected):
    path = tmp_path / "head.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=expected):
        read_response(path)


def test_what_is_known_has_to_be_a_parameter():
    with pytest.raises(BadInput, match="frame_stiffness"):
        fit_pantograph(noisy(TWO, 0.05), 2, {"frame_stifness": 50.0})
    with pytest.raises(BadInput, match="2 or 3"):
        fit_pantograph(noisy(TWO, 0.05), 4)


def test_the_table_for_a_scene_is_one(tmp_path):
    from cosimo.components.railway.pantograph import Pantograph

    result = fit_pantograph(noisy(TWO, 0.05), 2)
    files = save(result, tmp_path)
    assert [f.name for f in files] == ["pantograph.toml", "fit.csv", "report.html"]
    unit = read_toml(files[0])["units"]["pantograph"]
    pantograph = Pantograph(unit["effects"], unit["parameters"])
    assert pantograph["head_mass"] == pytest.approx(7.2, rel=0.02)
    assert "not identified" in files[0].read_text(encoding="utf-8")
