"""Whirl frequencies, critical speeds and onset speeds against closed forms and an independent program."""

import math

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.elements import solid_disk
from cosimo.components.rotor.modal import campbell, critical_speeds, eigenvalues, modes
from scipy.optimize import brentq

NO_DISKS = {f"disks.{n}[{k}]": 0.0 for n in ("mass", "polar_inertia", "diametral_inertia") for k in (1, 2)}


def onset_speed(matrices, low: float, high: float) -> float:
    """Speed between `low` (stable) and `high` (unstable) at which the first mode loses its damping, rad/s."""
    return float(brentq(lambda speed: eigenvalues(matrices, speed).real.max(), low, high, xtol=1e-9, rtol=1e-13))


def matrices(effects, **parameters):
    rotor = BeamRotor(effects, parameters)
    rotor.initialize(0.0)
    return rotor.matrices()


def friswell():
    rotor = BeamRotor(preset="Friswell 5.9.1")
    rotor.initialize(0.0)
    return rotor.matrices()


# rad/s; ROSS 2.3.0 on the same six elements, its lateral modes (it also lists an axial one at 650.41)
ROSS = {
    0.0: [86.65811435, 86.65811435, 274.31285391, 274.31285391, 716.78631221, 716.78631221],
    1000.0: [86.35403439, 86.95403012, 268.86180486, 279.62769254, 687.1181497, 746.02959115],
    4000.0: [85.389467, 87.7958637, 251.78460413, 294.71333087, 600.17936195, 827.07536193],
}


@pytest.mark.known_answers(BeamRotor="linear_supports")
@pytest.mark.parametrize("rpm", ROSS)
def test_friswells_example_has_the_frequencies_of_an_independent_program(rpm):
    found = modes(friswell(), rpm * math.pi / 30.0, 6)
    np.testing.assert_allclose(found.frequency, ROSS[rpm], rtol=1e-8)  # printed digits; both solve the same matrices
    np.testing.assert_allclose(found.decay, 0.0, atol=1e-6)
    if rpm:
        assert found.direction.tolist() == [-1, 1, -1, 1, -1, 1]


def test_critical_speeds_are_where_a_frequency_meets_the_speed():
    m = friswell()
    found = critical_speeds(m)
    np.testing.assert_allclose(found[:5], [86.4078, 86.9042, 260.5175, 288.6168, 563.3356], rtol=1e-5)
    for speed in found[:5]:
        assert np.abs(modes(m, speed).frequency - speed).min() <= 1e-7 * speed
    # the third forward mode flees from the line: no frequency of the first six meets it between 570 and 900 rad/s
    assert not ((found > 570.0) & (found < 900.0)).any()
    assert modes(m, 900.0, 6).frequency[5] > 900.0
    assert critical_speeds(m, order=2.0)[0] == pytest.approx(86.53 / 2.0, rel=2e-3)  # half of the frequency near 43 rad/s


def overhung(speed: float, stiffness: np.ndarray, mass: float, polar: float, diametral: float) -> np.ndarray:
    """Frequencies of a disk at the end of a massless clamped shaft, with q = (z, tilt) exp(i w t) in complex notation:

    det [[k11 - m w², k12], [k12, k22 - I_d w² + I_p speed w]] = 0
    """
    (k11, k12), (_, k22) = stiffness
    polynomial = np.polyadd(np.polymul([-mass, 0.0, k11], [-diametral, polar * speed, k22]), [-(k12**2)])
    return np.sort(np.abs(np.roots(polynomial).real))


@pytest.mark.known_answers(BeamRotor="gyroscopic")
@pytest.mark.parametrize("speed", [0.0, 200.0, 2000.0])
def test_gyroscopic_splitting_of_an_overhung_disk(speed):
    """A massless shaft, clamped at one end, with a disk at the other."""
    length, diameter = 0.4, 0.03
    disk = solid_disk(0.3, 0.0, 0.02, 7810.0)
    m = matrices(
        ["gyroscopic", "disks"],
        length=length,
        outer_diameter=diameter,
        density=1e-3,
        element=0.1,
        watched_position=length,
        **{
            **NO_DISKS,
            "disks.position[1]": length,
            "disks.mass[1]": disk.mass,
            "disks.polar_inertia[1]": disk.polar_inertia,
            "disks.diametral_inertia[1]": disk.diametral_inertia,
        },
    )
    m.stiffness[range(4), range(4)] += 1e12  # the clamp
    EI, nu = 211e9 * math.pi / 64.0 * diameter**4, 0.5 * 211.0 / 81.2 - 1.0
    shear = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu) * 81.2e9 * math.pi / 4.0 * diameter**2
    compliance = [[length**3 / (3.0 * EI) + length / shear, length**2 / (2.0 * EI)], [length**2 / (2.0 * EI), length / EI]]
    exact = overhung(speed, np.linalg.inv(compliance), disk.mass, disk.polar_inertia, disk.diametral_inertia)
    # the clamp is 1e-5 as soft as the first element; the shaft's mass, 3e-7 kg, is 3e-8 of the disk's
    np.testing.assert_allclose(modes(m, speed, 4).frequency, exact, rtol=1e-5)
    if speed:
        assert exact[3] / exact[2] > 1.1 + 0.001 * speed


def test_campbell_diagram_splits_with_the_speed():
    m = friswell()
    speeds = np.linspace(0.0, 500.0, 11)
    frequency, direction = campbell(m, speeds, 6)
    assert frequency.shape == direction.shape == (11, 6)
    assert (np.diff(frequency[:, 1::2], axis=0) > 0.0).all()  # forward modes stiffen
    assert (np.diff(frequency[:, 0::2], axis=0) < 0.0).all()
    np.testing.assert_allclose(frequency[0, ::2], frequency[0, 1::2], rtol=1e-9)  # rounding
    assert not direction[0].any()  # pairs at rest: any mixture of two is a mode
    assert (direction[1:] == [-1, 1, -1, 1, -1, 1]).all()
    np.testing.assert_allclose(modes(m, -300.0, 6).frequency, modes(m, 300.0, 6).frequency, rtol=1e-10)
    assert modes(m, -300.0, 6).direction.tolist() == [1, -1, 1, -1, 1, -1]  # forward is from x to y, not with the rotation


def test_modes_that_are_overdamped_at_some_speeds_leave_gaps_in_the_diagram():
    """Dampers of 1e4 N.s/m at the journals: how many of the rotor's modes oscillate depends on the speed."""
    damping = {f"linear_supports.damping_{axis}[{k}]": 1e4 for axis in "xy" for k in (1, 2)}
    m = matrices(["gyroscopic", "linear_supports"], element=1.5, watched_position=0.0, **damping)
    speeds = np.array([0.0, 3e3, 3e4])
    oscillating = [modes(m, speed).frequency.size for speed in speeds]
    assert oscillating == [4, 8, 8]  # at rest x and y are alike: pairs of real eigenvalues
    frequency, direction = campbell(m, speeds, 8)
    assert frequency.shape == direction.shape == (3, 8)
    assert (np.isfinite(frequency).sum(axis=1) == oscillating).all()
    assert not direction[np.isnan(frequency)].any()


def test_modes_of_anisotropic_supports_at_rest_have_no_direction():
    m = matrices(["disks", "linear_supports"], **{"linear_supports.stiffness_x[1]": 5e5, "linear_supports.stiffness_x[2]": 5e5})
    assert not modes(m, 0.0, 4).direction.any()


def test_a_damped_mode_decays_as_the_energy_says():
    """Decay rate of a lightly damped mode, phi' C phi / (2 phi' M phi), from modes without damping."""
    damping = {f"linear_supports.damping_{axis}[{k}]": 20.0 for axis in "xy" for k in (1, 2)}
    undamped, damped = matrices(["disks", "linear_supports"]), matrices(["disks", "linear_supports"], **damping)
    shape = modes(undamped, 0.0, 6).shape.real
    expected = [s @ damped.damping @ s / (2.0 * s @ damped.mass @ s) for s in shape.T]
    np.testing.assert_allclose(modes(damped, 0.0, 6).decay, expected, rtol=1e-3)  # second order in the damping ratio, 0.3 to 1 %


def test_onset_speed_of_the_jeffcott_rotor_on_a_beam():
    """Internal damping eta k, external c at the disk: neutral at w_0 (1 + c / (eta k)); the external damper is a third support.

    The shaft is massless, pinned at its ends; a damper at the disk stands for the external damping.
    """
    length, diameter, eta, external = 1.0, 0.03, 1e-4, 30.0
    EI = 211e9 * math.pi / 64.0 * diameter**4
    section_shear = 81.2e9 * math.pi / 4.0 * diameter**2 * 0.886
    k = 1.0 / (length**3 / (48.0 * EI) + length / (4.0 * section_shear))
    half = {"linear_supports.position[1]": 0.0, "linear_supports.position[2]": length}
    pinned = {f"linear_supports.stiffness_{axis}[{i}]": 1e13 for axis in "xy" for i in (1, 2)}
    m = matrices(
        ["disks", "internal_damping", "linear_supports"],
        length=length,
        outer_diameter=diameter,
        density=1e-3,
        watched_position=0.5,
        element=0.5,
        **{**half, **pinned, **NO_DISKS, "disks.position[1]": 0.5, "disks.mass[1]": 20.0, "internal_damping.time_constant": eta},
    )
    m.damping[4, 4] += external  # x and y of the middle node
    m.damping[5, 5] += external
    critical = math.sqrt(k / 20.0)
    onset = critical * (1.0 + external / (eta * k))
    assert onset_speed(m, 0.5 * onset, 2.0 * onset) == pytest.approx(onset, rel=1e-3)  # kappa to three digits, rest below
    assert eigenvalues(m, 0.9 * onset).real.max() < 0.0 < eigenvalues(m, 1.1 * onset).real.max()
