"""Slip of the cage against a scalar balance solved by SciPy, closed forms of run-up, limits and the balance of power."""

import math

import numpy as np
import pytest
from cosimo import StepFailed, read_scene
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems.bearings.figures import blocks
from cosimo.orchestrator.systems.bearings.records import bearings
from cosimo.orchestrator.systems.bearings.summary import summary
from scipy.optimize import brentq

Z, D, DM = 9, 11.1e-3, 53.5e-3
KAPPA = 0.5 * (1.0 - D / DM)
MU, SLIDING, CAGE, DENSITY = 0.05, 0.1, 1.4e-5, 7800.0
MASS = DENSITY * math.pi * D**3 / 6.0
ON = ("ball_inertia", "cage_slip")
MASSLESS = {"ball_inertia.density": 1e-9}  # kg/m³


def land(viscosity: float) -> float:
    """Petroff: wall shear eta v/c on the area pi d b, at the radius d/2, N.m.s."""
    radius, width, gap = 0.03, 3e-3, 2e-4
    return viscosity * radius / gap * 2.0 * math.pi * radius * width * radius


def oil(cage: float, ring: float, viscosity: float) -> float:
    """Torque that holds balls and cage, N.m: at the land, and on nine spheres on the circle."""
    sphere = 0.5 * 10.0 * math.pi / 4.0 * D**2 * (cage * DM / 2.0) ** 2
    return land(viscosity) * (cage - ring) + math.copysign(Z * sphere * DM / 2.0, cage)


def steady(load: float, speed: float, guide: str, viscosity: float) -> float:
    """Speed of the cage, rad/s, under a load of each ball, N."""

    def left(cage: float) -> float:
        traction = MU * load * math.tanh((KAPPA * speed - cage) * DM / SLIDING)
        return Z * traction * DM - oil(cage, speed if guide == "inner" else 0.0, viscosity)

    return brentq(left, *sorted((-0.1 * speed, 1.1 * speed)), xtol=1e-12, rtol=1e-14)


def running(given: dict[str, float | str], h: float = 0.05, steps: int = 100, effects: tuple[str, ...] = ON) -> DeepGrooveBearing:
    """The bearing after some steps under inputs that stay."""
    bearing = DeepGrooveBearing(effects, given)
    bearing.initialize(0.0)
    for k in range(steps):
        bearing.step(k * h, h)
    return bearing


@pytest.mark.interpreted
@pytest.mark.known_answers(DeepGrooveBearing="cage_slip")
@pytest.mark.parametrize("guide", ["outer", "inner"])
@pytest.mark.parametrize(("axial", "speed"), [(1e-5, 1000.0), (1.6e-5, -1000.0), (6e-5, 300.0)])
def test_the_steady_cage_is_that_of_a_scalar_balance(axial, speed, guide):
    given = MASSLESS | {"displacement_z": axial, "speed": speed, "cage_slip.guide": guide}
    bearing = running(given)
    contacts = [BallGeometry(Z, D, DM).contact(race, 2.06e11 / (1.0 - 0.3**2)).stiffness for race in ("inner", "outer")]
    approach = math.hypot(0.04 * D, axial) - 0.04 * D
    load = (approach / sum(k ** (-2.0 / 3.0) for k in contacts)) ** 1.5  # of each ball, by Hertz
    expected = steady(load, speed, guide, 0.03)
    assert bearing["cage_slip.cage_speed"] == pytest.approx(expected, rel=1e-8)
    assert bearing["cage_slip.slip"] == pytest.approx(1.0 - expected / (KAPPA * speed), rel=1e-6, abs=1e-8)
    if axial == 1e-5 and guide == "outer":
        assert bearing["cage_slip.slip"] > 0.2  # it skids


@pytest.mark.interpreted
def test_centrifugal_force_goes_with_the_cages_own_speed_and_takes_its_drive():
    bearing = running({"displacement_z": 1.8e-5, "speed": 1200.0})
    cage = bearing["cage_slip.cage_speed"]
    assert bearing["ball_inertia.centrifugal_force"] == pytest.approx(MASS * cage**2 * DM / 2.0, rel=1e-12)
    load = abs(bearing["force_z"]) / math.sin(bearing["ball_inertia.inner_angle"]) / Z
    assert cage == pytest.approx(steady(load, 1200.0, "outer", 0.03), rel=1e-8)
    assert cage < 0.98 * running(MASSLESS | {"displacement_z": 1.8e-5, "speed": 1200.0})["cage_slip.cage_speed"]


@pytest.mark.interpreted
def test_a_run_up_by_oil_alone_is_an_exponential_of_order_two():
    given = {"diametral_clearance": 2e-5, "cage_slip.drag_density": 0.0, "cage_slip.start_slip": 1.0, "cage_slip.guide": "inner"}
    rate = land(0.03) / (1.4 * Z * MASS * DM**2 / 4.0 + CAGE)
    wanted = 400.0 * (1.0 - math.exp(-0.5 * rate))
    errors = [running(given | {"speed": 400.0}, 0.5 / n, n)["cage_slip.cage_speed"] - wanted for n in (10, 20, 40)]
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx([4.0, 4.0], abs=0.2)
    assert abs(errors[-1]) < 1e-4 * wanted


@pytest.mark.interpreted
def test_a_run_up_by_a_film_far_from_its_limit_is_an_exponential():
    given = MASSLESS | {"displacement_z": 6e-5, "speed": 200.0, "cage_slip.drag_density": 0.0, "cage_slip.viscosity": 0.0}
    bearing = running(given | {"cage_slip.sliding": 1e5, "cage_slip.start_slip": 1.0}, 1e-3, 100)
    load = abs(bearing["force_z"]) / math.sin(math.atan2(6e-5, 0.04 * D))
    rate = DM**2 * MU * load / 1e5 / CAGE
    assert bearing["cage_slip.cage_speed"] == pytest.approx(KAPPA * 200.0 * (1.0 - math.exp(-0.1 * rate)), rel=1e-6)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    "limit",
    [{"cage_slip.sliding": 1e-12, "cage_slip.traction": 1e3}, {"cage_slip.viscosity": 0.0, "cage_slip.drag_density": 0.0}],
)
def test_without_drag_or_with_a_grip_without_bound_there_is_no_slip(limit):
    given = {"displacement_z": 6e-5, "speed": 700.0}
    slipping, rolling = running(given | limit, 1e-3), running(given, 1e-3, effects=("ball_inertia",))
    assert slipping["cage_slip.cage_speed"] == pytest.approx(KAPPA * 700.0, rel=1e-13)
    for name in ("force_z", "cage_angle", "max_ball_load", "ball_inertia.centrifugal_force"):
        assert slipping[name] == pytest.approx(rolling[name], rel=1e-11)


@pytest.mark.interpreted
@pytest.mark.parametrize(("guide", "axial"), [("outer", 2e-5), ("inner", 4e-5)])
def test_the_shaft_gives_what_becomes_heat(guide, axial):
    bearing = running({"displacement_z": axial, "speed": 1000.0, "cage_slip.guide": guide}, 1.0)
    shaft = KAPPA * bearing["cage_slip.drive"] * 1000.0  # traction at the radius of the inner race
    if guide == "inner":
        shaft += land(0.03) * (1000.0 - bearing["cage_slip.cage_speed"]) * 1000.0
    assert bearing["cage_slip.power"] == pytest.approx(shaft, rel=1e-9)
    assert bearing["cage_slip.drive"] == pytest.approx(-bearing["cage_slip.drag"], rel=1e-9)


@pytest.mark.interpreted
def test_a_ball_that_stands_passes_more_of_the_inner_race_and_turns_no_more():
    """The cage stands, without load and oil: a pit of the inner ring meets a ball with the speed of the ring."""
    given = {"diametral_clearance": 2e-5, "speed": 100.0, "cage_slip.start_slip": 1.0, "cage_slip.drag_density": 0.0}
    standing = running(given | {"cage_slip.viscosity": 0.0, "ball_defect.width": 1.0}, 1e-3, 5, (*ON, "ball_defect"))
    assert list(standing.x) == [pytest.approx(0.5), 0.0, 0.0, 0.0]
    width, kept = {"inner_defect.width": 0.15}, {"cage_slip.viscosity": 0.0}
    rolls = given | width | kept | {"cage_slip.start_slip": 0.0}
    with pytest.warns(UserWarning, match="a ball passes inner_defect in 1.2 macro steps"):
        assert running(rolls, 2e-3, 1, (*ON, "inner_defect"))["loaded_balls"] == 0
    with pytest.raises(StepFailed, match="inner_defect"):
        running(given | width | kept, 2e-3, 1, (*ON, "inner_defect"))


@pytest.mark.interpreted
@pytest.mark.parametrize("recorded", [True, False])
def test_lines_of_defects_follow_the_cages_own_speed_where_it_is_known(recorded, tmp_path):
    (tmp_path / "place.csv").write_text("time [s],x [m],y [m]\n0,1e-6,-6.1e-6\n1,1e-6,-6.1e-6\n")
    parameters = {"diametral_clearance": 1e-5, "speed": 1000.0, "cage_slip.viscosity": 0.1, "cage_slip.start_slip": 0.75}
    signals = ["place.x", "place.y", "b.cage_slip.slip", "b.cage_slip.cage_speed", "b.inner_angle", *["b.cage_angle"] * recorded]
    scene = {
        "title": "Light load",
        "stop_time": 0.2,
        "units": {
            "b": {"component": "DeepGrooveBearing", "effects": list(ON), "parameters": parameters},
            "place": {"signals": str(tmp_path / "place.csv")},
        },
        "connections": ["place.x -> b.displacement_x", "place.y -> b.displacement_y"],
        "master": {"step": 1e-3},
        "record": {"signals": signals},
        "analysis": {"system": "bearings", "transient": 0.15},
    }
    result = run(read_scene(scene, "light"), in_process=True)
    (record,) = bearings(result)
    own = result["b.cage_slip.cage_speed"][result.time >= 0.15].mean()
    assert own < 0.9 * KAPPA * 1000.0
    cage = (own if recorded else KAPPA * 1000.0) / (2.0 * math.pi)
    turns = 1000.0 / (2.0 * math.pi)
    wanted = {"cage": cage, "outer": Z * cage, "inner": Z * (turns - cage), "ball": cage * (DM / D + 1.0)}
    assert dict(record.frequencies) == pytest.approx(wanted, rel=1e-3)
    texts = " ".join(row.text for row in summary(result))
    assert ("from the speeds of shaft and cage" in texts, "without the slip of the cage" in texts) == (recorded, not recorded)
    assert any("Slip of the cage" in str(block) for block in blocks(result))
