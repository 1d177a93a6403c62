"""Rotors that nothing holds, on stiff bearings, of extreme sizes, and coupled with bearings in units of their own."""

import math

import numpy as np
import pytest
from cosimo.components.rotor.beam import BeamRotor
from cosimo.components.rotor.jeffcott import JeffcottRotor
from cosimo.components.rotor.modal import critical_speeds, eigenvalues, modes
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import initialized
from cosimo.tests.systems.rotor.linear_bearing import MOTION

FRISWELL = ("gyroscopic", "disks", "linear_supports")


SOFT = {f"linear_supports.stiffness_{axis}[{k}]": 0.0 for axis in "xy" for k in (1, 2)}


def started(effects, **parameters) -> BeamRotor:
    return initialized(BeamRotor(effects, parameters))


@pytest.mark.full
@pytest.mark.parametrize("element", [0.25, 0.05])
def test_a_free_rotor_has_four_motions_without_frequency(element):
    rotor = started(("disks", "linear_supports"), element=element, **SOFT)
    values = np.sort(np.abs(eigenvalues(rotor.matrices(), 0.0)))
    # 8 zero eigenvalues; as double roots they show rounding's square root, 1e-8 of the largest
    assert (values[:8] < 1e-6 * values[-1]).all()
    assert values[8] > 100.0
    assert modes(rotor.matrices(), 0.0).frequency.min() == pytest.approx(values[8], rel=1e-8)


@pytest.mark.full
@pytest.mark.parametrize("element", [0.25, 0.05])
def test_a_free_rotor_precesses_and_has_critical_speeds(element):
    rotor = started(("disks", "gyroscopic"), element=element)
    m = rotor.matrices()
    tilt = np.zeros(m.mass.shape[0])  # of the whole about its centre of mass, in the plane of x
    tilt[0::4], tilt[3::4] = rotor.nodes, 1.0
    move = np.zeros_like(tilt)
    move[0::4] = 1.0
    tilt -= (tilt @ m.mass @ move) / (move @ m.mass @ move) * move
    other = np.zeros_like(tilt)
    other[1::4], other[2::4] = tilt[0::4], -tilt[3::4]
    rigid = abs(tilt @ m.gyroscopic @ other) / (tilt @ m.mass @ tilt)  # polar over diametral inertia
    found = modes(m, 100.0)
    # a rigid rotor's free precession; the shaft bends under it by (11 / 459)², 6e-4
    assert found.frequency[0] == pytest.approx(100.0 * rigid, rel=1e-3)
    assert found.direction[0] == 1
    speeds = critical_speeds(m)
    assert speeds[0] == pytest.approx(399.2, abs=0.2)
    for speed in speeds[:2]:
        assert np.abs(modes(m, speed).frequency - speed).min() <= 1e-7 * speed  # rounding


@pytest.mark.full
@pytest.mark.parametrize("stiffness", [1e9, 1e12])
@pytest.mark.parametrize("h", [1e-3, 1e-2, 0.1])
def test_stiff_bearings_through_the_port_at_large_macro_steps(stiffness, h):
    """The node on 1e9 N/m has a frequency of 1e4 rad/s and more: plain force coupling ends at a few 10 us."""
    rotor = BeamRotor(("gyroscopic", "disks", "unbalance", "gravity", "bearing_a", "bearing_b"))
    fixed = started(
        (*FRISWELL, "unbalance", "gravity"),
        **{f"linear_supports.stiffness_{axis}[{k}]": stiffness for axis in "xy" for k in (1, 2)},
    )
    for port in "ab":
        for element in (1, 7):
            rotor.set(f"bearing_{port}.stiffness[{element}]", stiffness)
    rotor.initialize(0.0)
    n = round(0.2 / h)
    for k in range(n):
        rotor.step(k * h, h)
        fixed.step(k * h, h)
    # the same springs in the same matrix, added in another order: rounding of 1e12 N/m beside 1e8 N/m over 4000 steps
    np.testing.assert_allclose(rotor.y[:6], fixed.y[:6], rtol=1e-6, atol=1e-10)
    assert abs(rotor["displacement_y"]) < 2e-3
    assert abs(rotor["bearing_a.displacement_y"]) < 1e3 / stiffness


@pytest.mark.full
def test_ten_million_turns_of_the_angle_do_not_drift():
    """1e5 macro steps of 100 turns and a quarter: the angle stays in [0, 2 pi), and the rounding does not add up one way."""
    rotor = JeffcottRotor(parameters={"start_speed": 2.0 * math.pi * 100.25, "damping": 0.0, "stiffness": 0.0, "substep": 1.0})
    rotor.initialize(0.0)
    for k in range(100_000):
        rotor.step(float(k), 1.0)
    # w d has 630 rad in a double of 1e-13: 1e5 times that if all one way; it is the rounded speed that counts
    error = (rotor["angle"] + math.pi) % (2.0 * math.pi) - math.pi
    assert abs(error) < 1e-8
    assert 0.0 <= rotor["angle"] < 2.0 * math.pi


@pytest.mark.full
@pytest.mark.parametrize("mass", [1e4, 1e7])
def test_a_huge_disk_on_a_thin_shaft(mass):
    """The lowest frequency is that of the disk's mass on shaft and supports; high gyroscopic coupling stays stable."""
    inertia = 0.1 * mass
    numbers = {
        "disks.mass[1]": mass,
        "disks.mass[2]": 0.0,
        "disks.polar_inertia[1]": 2.0 * inertia,
        "disks.polar_inertia[2]": 0.0,
        "disks.diametral_inertia[1]": inertia,
        "disks.diametral_inertia[2]": 0.0,
        "disks.position[1]": 0.75,
        "disks.position[2]": 0.0,
        "watched_position": 0.75,
    }
    rotor = started((*FRISWELL, "unbalance"), start_speed=1000.0, **numbers, **{"unbalance.moment[1]": mass * 1e-6})
    m = rotor.matrices()
    middle = 4 * int(np.abs(rotor.nodes - 0.75).argmin())
    unit = np.zeros(m.mass.shape[0])
    unit[middle] = 1.0
    stiffness = 1.0 / np.linalg.solve(m.stiffness, unit)[middle]
    expected = math.sqrt(stiffness / mass)
    # the shaft's 23 kg: half of them or less move with the disk
    assert np.abs(eigenvalues(m, 1000.0).imag - expected).min() <= 23.0 / mass * expected
    before = rotor.energy()
    rotor.step(0.0, 1.0)
    # the unbalance of a disk far above its critical speed: it turns about its centre of mass, 1 um away, after a start from rest
    # within the first instants of which the disk drifts with e w = 1 mm/s
    assert before == 0.0
    assert abs(complex(rotor["velocity_x"], rotor["velocity_y"])) < 4e-3
    assert np.isfinite(rotor.x).all()


@pytest.mark.full
def test_very_short_elements():
    """500 elements of 3 mm in a shaft of 50 mm diameter: the same frequencies and, to rounding of 1e13 N/m, the same sag."""
    coarse = started((*FRISWELL, "gravity"), element=0.05)
    fine = started((*FRISWELL, "gravity"), element=0.003)
    assert fine.nodes.size >= 501
    # sag: exact at the nodes but for the distributed load's work on the element's own shape, fourth order
    assert fine["displacement_y"] == pytest.approx(coarse["displacement_y"], rel=1e-5)
    before = fine["displacement_y"]
    for k in range(20):
        fine.step(k * 1e-3, 1e-3)
    assert fine["displacement_y"] == pytest.approx(before, rel=1e-6)
    assert abs(fine["displacement_x"]) < 1e-9


TIME_CONSTANT = 1e-5  # s, damping over stiffness of the linear bearings


def coupled(step, tangent, extrapolation=0, stiffness=1e8, substep=1e-5, steps=200):
    """A rotor on two spring-dampers as units of their own, Jacobi; it starts straight under a sudden unbalance."""
    rotor = {
        "component": "BeamRotor",
        "effects": ["disks", "gyroscopic", "unbalance", "bearing_a", "bearing_b"],
        "parameters": {"substep": substep},
    }
    bearing = {
        "component": "cosimo.tests.systems.rotor.linear_bearing:LinearBearing",
        "effects": ["tangent"] * tangent,
        "parameters": {"k": stiffness, "d": stiffness * TIME_CONSTANT},
    }
    connections = [f"rotor.bearing_{p}.{n} -> {p}.{n}" for p in "ab" for n in MOTION]
    names = ["force_x", "force_y"]
    names += [f"{n}[{k}]" for n in ("stiffness", "damping") for k in range(1, 26)] if tangent else []
    connections += [f"{p}.{'tangent.' * tangent}{n} -> rotor.bearing_{p}.{n}" for p in "ab" for n in names]
    return run(
        read_scene(
            {
                "title": "Rotor on two spring-dampers",
                "stop_time": steps * step,
                "connections": connections,
                "units": {"rotor": rotor, "a": bearing, "b": bearing},
                "master": {"algorithm": "jacobi", "step": step, "extrapolation": extrapolation},
                "record": {"signals": ["rotor.displacement_x", "rotor.displacement_y", "rotor.bearing_a.displacement_x"]},
            }
        ),
        in_process=True,
    )


@pytest.mark.full
@pytest.mark.parametrize(("share", "stable"), [(0.9, True), (1.2, False)])
def test_plain_force_coupling_ends_at_twice_the_time_constant_of_the_bearing(share, stable):
    """Held forces: H < 2 d/k; the other limit, 2 m/d, is that of the end node's 0.2 kg or more: 400 us."""
    result = coupled(share * 2.0 * TIME_CONSTANT, tangent=False, substep=2e-6, steps=5000)
    grown = result.outcome != "done" or np.abs(result.columns["rotor.bearing_a.displacement_x"]).max() > 1e-3
    assert grown != stable


@pytest.mark.full
@pytest.mark.parametrize("extrapolation", [0, 1, 2])
@pytest.mark.parametrize("stiffness", [1e8, 1e9])
def test_tangent_coupling_is_the_monolithic_rotor_at_any_macro_step(stiffness, extrapolation):
    """A hundred times the plain coupling's limit, with the result of supports inside the rotor."""
    step = 200.0 * TIME_CONSTANT
    result = coupled(step, True, extrapolation, stiffness)
    inside = {
        f"linear_supports.{n}_{axis}[{k}]": v
        for axis in "xy"
        for k in (1, 2)
        for n, v in (("stiffness", stiffness), ("damping", stiffness * TIME_CONSTANT))
    }
    rotor = started(("disks", "gyroscopic", "unbalance", "linear_supports"), substep=1e-5, **inside)
    for k in range(200):
        rotor.step(k * step, step)
    # the same matrix, but for the order of additions: rounding of 1e9 N/m beside 1e8 N/m over 40 000 steps
    assert result.columns["rotor.displacement_x"][-1] == pytest.approx(rotor["displacement_x"], rel=1e-6)
    assert result.columns["rotor.displacement_y"][-1] == pytest.approx(rotor["displacement_y"], rel=1e-6)


@pytest.mark.full
def test_deep_groove_bearings_need_their_tangent_at_the_scenes_macro_step():
    """Two and four times the limit 2 d/k = 50 us of plain coupling; the tangent's error there is below 3 and 15 per cent."""
    effects = ["gyroscopic", "disks", "unbalance", "gravity", "linear_supports", "bearing_a", "bearing_b"]
    constant = {
        "units.rotor.effects": effects,
        "stop_time": 0.3,
        "record": {"signals": ["rotor.bearing_a.displacement_x", "rotor.bearing_a.displacement_y"]},
    }
    scene = load_scene("rotor-run-up")
    parameters = {n: v for n, v in scene.units["rotor"].parameters.items() if not n.startswith("run_up")}
    constant["units.rotor.parameters"] = parameters | {"start_speed": 500.0, "substep": 1e-5}
    tangent = scene.with_changes(constant)
    reference = run(tangent.with_changes({"master.step": 2e-5}), in_process=True)
    name = "rotor.bearing_a.displacement_y"
    for step, tolerance in ((1e-4, 0.03), (2e-4, 0.15)):
        result = run(tangent.with_changes({"master.step": step}), in_process=True)
        expected = np.interp(result.time, reference.time, reference[name])
        difference = np.abs(result[name] - expected)[result.time > 0.1]  # after the start, from rest
        assert difference.max() <= tolerance * np.ptp(reference[name]), step
    sides = {"rotor.bearing_a": "left", "rotor.bearing_b": "right"}
    plain = tangent.with_changes(
        {
            "connections": [c for port, side in sides.items() for c in (f"{port}.* -> {side}.*", f"{side}.* -> {port}.*")],
            "units.left.effects": ["damping"],
            "units.right.effects": ["damping"],
            "rotor.start_fall": 1e-5,
            "master.step": 1e-4,
        }
    )
    assert run(plain, in_process=True).outcome != "done"


@pytest.mark.full
@pytest.mark.parametrize("disk", [0.3, 0.57])
@pytest.mark.parametrize("clearance", [-10e-6, 0.0, 10e-6, 60e-6, 190e-6])
def test_a_rotor_that_only_its_bearings_hold_finds_its_place(clearance, disk):
    """From no contact at all into the balls, within the master's sweeps: the bearings' forces carry the weight."""
    result = run(
        load_scene("rotor-run-up").with_changes(
            {
                "stop_time": 1e-4,
                "left.diametral_clearance": clearance,
                "right.diametral_clearance": clearance,
                "rotor.disks.position": [disk, 0.0],
                "record": {"signals": ["left.force_x", "left.force_y", "right.force_x", "right.force_y"]},
            }
        ),
        in_process=True,
    )
    assert result.info.counters.master["initial_sweeps"] <= 20
    left, right = ([result.columns[f"{side}.force_{axis}"][0] for axis in "xy"] for side in ("left", "right"))
    shaft = 7810.0 * math.pi / 4.0 * 0.03**2 * 0.6 * 9.81
    disk_weight = 8.0 * 9.81
    # what the master leaves over of its residual of 1e-9 and less
    assert left[1] + right[1] == pytest.approx(shaft + disk_weight, rel=1e-6)
    assert left[0] + right[0] == pytest.approx(0.0, abs=1e-6 * disk_weight)
    assert right[1] - left[1] == pytest.approx(disk_weight * (disk - 0.3) / 0.25, abs=0.05 * disk_weight)  # but for moments
