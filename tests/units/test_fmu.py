"""FMUs as units: one of another maker, written in C for these tests, and our own given by path."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus.build import built
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import open_unit

STEP = 0.1  # s
H2, H3 = STEP**2, STEP**3


def scene(fmu: str, parameters=None, degree: int = 1, **more) -> dict:
    return {
        "stop_time": 1.0,
        "connections": ["p.time -> f.u"],
        "units": {"p": {"component": "cosimo.tests.support:Probe"}, "f": {"fmu": fmu, "parameters": parameters or {}}},
        "master": {"algorithm": "jacobi", "step": STEP, "extrapolation": degree},
        **more,
    }


@pytest.mark.parametrize("flags", ["", 'canInterpolateInputs="true"'])
def test_every_kind_of_input_gets_the_right_impulse(foreign, flags):
    """Input t, exact but for the first step, where it is held at 0: the integral misses h²/2, whatever the FMU can."""
    result = run(read_scene(scene(foreign(flags))))
    assert result["f.x"][-1] == pytest.approx(0.5 - H2 / 2, rel=1e-13)  # rounding of ten steps
    assert result.info.settings["held_at_mean"] == ([] if flags else ["f"])


@pytest.mark.parametrize("flags", ["", 'canInterpolateInputs="true"'])
def test_quadratic_input_gets_the_right_impulse(foreign, flags):
    """Input t² from a falling mass: held, then linear, in the first steps, which miss h³/3 and 5/6 h³."""
    falling = {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 0.0, "force": 2.0}}
    data = scene(foreign(flags), degree=2, connections=["m.x_out -> f.u"])
    data["units"]["m"] = falling
    assert run(read_scene(data))["f.x"][-1] == pytest.approx(1 / 3 - 7 / 6 * H3, rel=1e-13)


def test_an_fmu_that_interpolates_follows_the_input_within_the_step(foreign):
    """z is the integral of x: exact for a linear input, while a held mean would add h³/12 in each step."""
    exact = 1 / 6 - H3 / 6 - (1 - STEP) * H2 / 2
    assert run(read_scene(scene(foreign('canInterpolateInputs="true"'))))["f.z"][-1] == pytest.approx(exact, rel=1e-13)
    assert run(read_scene(scene(foreign(""))))["f.z"][-1] == pytest.approx(exact + 9 * H3 / 12, rel=1e-13)


def test_declared_dependencies_make_outputs_fresh(foreign):
    result = run(read_scene(scene(foreign(), {"sign": -1})))
    # one rounding each in the FMU and here; p's clock differs from the tick by one more
    np.testing.assert_allclose(result["f.y"], result["f.x"] - result["p.time"], atol=4e-16)


def test_a_discarded_step_names_unit_time_and_log(foreign):
    result = run(read_scene(scene(foreign(), {"limit": 0.1})))
    assert result.outcome == "failed"
    # x = (t² - h²)/2 is 0.075 at 0.4 s and 0.12 at 0.5 s
    assert "f failed at t = 0.4 s: the FMU discarded the call" in result.message
    assert "log: x = 0.120 is above the limit" in result.message
    assert result.time[-1] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("parameters", "named"),
    [
        ({"limt": 1.0}, ["'limt'", "'limit'"]),
        ({"limit": -1.0}, ["limit = -1.0", "[0, inf]"]),
        ({"limit": float("nan")}, ["limit = nan", "finite"]),
        ({"limit": "high"}, ["'high'", "Real"]),
        ({"sign": 0.5}, ["sign = 0.5", "Integer"]),
        ({"sign": True}, ["sign = True", "Integer"]),
        ({"x": 1.0}, ["'x'"]),
    ],
)
def test_bad_parameters(foreign, parameters, named):
    with pytest.raises(BadInput) as caught:
        read_scene(scene(foreign(), parameters))
    assert str(caught.value).startswith("scene: units.f.parameters: ")
    assert [part for part in named if part not in str(caught.value)] == []


def test_fixed_step_fmus_refuse_a_shorter_last_step(foreign):
    data = scene(foreign(""), stop_time=1.05)
    with pytest.raises(BadInput, match=r"master\.step.*f cannot make the last one shorter"):
        read_scene(data)


def test_an_fmu_for_another_platform_is_bad_input(foreign):
    loaded = read_scene(scene(foreign(platform="win64")))
    with pytest.raises(BadInput, match=r"units\.f\.fmu: .* with libraries for win64 alone"):
        run(loaded)


def test_own_fmu_by_path_equals_the_component():
    def pantograph(**unit):
        return {
            "stop_time": 0.1,
            "units": {
                "p": {
                    **unit,
                    "effects": ["contact_loss", "bump_stops"],
                    "parameters": {"bump_stops.travel": 0.02, "wire_height": 0.01},
                }
            },
            "master": {"step": 1e-3},
        }

    by_path, here = (
        run(read_scene(pantograph(fmu=str(built("Pantograph"))))),
        run(read_scene(pantograph(component="Pantograph")), in_process=True),
    )
    assert by_path.columns.keys() == here.columns.keys()
    for name in here.columns:
        assert by_path[name].tobytes() == here[name].tobytes()
    assert by_path.info.effects == here.info.effects


def test_effects_of_an_fmu_are_checked():
    fmu = {"fmu": str(built("Pantograph"))}
    for unit, named in [
        ({"effects": ["contact_los"]}, "'contact_loss'"),
        ({"parameters": {"bump_stops.travel": 0.1}}, "Switch on the effect 'bump_stops'"),
        ({"parameters": {"effects.contact_loss": True}}, "List effects"),
    ]:
        with pytest.raises(BadInput, match=named):
            read_scene({"stop_time": 1.0, "units": {"p": {**fmu, **unit}}, "master": {"step": 0.1}})


@pytest.mark.parametrize("in_process", [True, False])
def test_a_restored_unit_repeats_its_step_to_the_last_bit(in_process):
    loaded = read_scene({"stop_time": 1.0, "units": {"p": {"component": "Pantograph"}}, "master": {"step": 0.1}})
    unit = open_unit("p", loaded.units["p"], in_process=in_process)
    unit.wire(["wire_height"], ["contact_force", "head_velocity"])
    unit.initialize(0.0, [0.0])
    unit.start()
    unit.drive([0.001], [0.5], [20.0], 1e-3)
    unit.step(0.0, 1e-3)
    state, repeated = unit.save(), []
    for _ in range(2):
        unit.restore(state)
        unit.drive([0.002], [0.1], None, 1e-3)
        unit.step(1e-3, 1e-3)
        repeated.append(unit.get())
    unit.close()
    assert repeated[0] == repeated[1]
    assert repeated[0][1] != 0.0
