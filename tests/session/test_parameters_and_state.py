"""Where a scene stands is its parameters and its state: both go with a saved state, whatever has written them meanwhile."""

import cosimo
import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.components.catalogue import component_class
from cosimo.tests.session.test_session import MASS
from cosimo.tests.units.exchange_fmu import exchange_fmu
from cosimo.tests.units.foreign_fmu import foreign as foreign_fixture
from cosimo.tests.units.native import STATE, native_fmu

foreign = foreign_fixture
KERNELS = {  # scene: a parameter, two of its values, an output, macro steps
    "en50318-2002": ("pantograph.static_force", (100.0, 160.0), "pantograph.contact_force", 40),
    "double-pendulum": ("chain.start_first_angle", (0.3, 0.4), "chain.tip_x", 40),
    "mass-on-spring": ("spring.stiffness", (90.0, 400.0), "mass.base_x", 40),
}


def stepped(sim, steps):
    """All outputs behind each of some steps."""
    names = [f"{u}.{n}" for u, i in sim.scene.coupling.interfaces.items() for n, s in i.outputs.items() if not s.is_text]
    rows = []
    for _ in range(steps):
        sim.step()
        rows.append(sim.values(names))
    return np.array(rows).tobytes()


def begun(sim, name, value):
    sim.reset()
    sim[name] = value
    sim.initialize()


@pytest.mark.parametrize("scene", ["en50318-2002", "double-pendulum", "mass-on-spring"])
def test_a_state_has_the_parameters_that_it_was_saved_with(scene):
    """Also where others have been set, stepped with, saved and asked for meanwhile, in any order."""
    name, (one, two), _, n = KERNELS[scene]
    with cosimo.open(scene) as sim, cosimo.open(scene) as never_left, cosimo.open(scene) as other:
        for session, value in ((sim, one), (never_left, one), (other, two)):
            begun(session, name, value)
            session.step(n)
        state = sim.save()
        expected, of_other = stepped(never_left, n), stepped(other, n)
        assert expected != of_other
        begun(sim, name, two)
        sim.step(n)
        there = sim.save()
        sim.step(3)
        for wanted, value, way in ((state, one, expected), (there, two, of_other), (state, one, expected)):
            sim.restore(wanted)
            assert sim[name] == value
            assert sim.scene.units[name.partition(".")[0]].parameters[name.partition(".")[2]] == value
            assert sim.time == sim.scene.start_time + n * sim.scene.master.step
            assert stepped(sim, n) == way
        begun(sim, name, two)  # in the middle of nothing, and before the start
        sim.reset()
        sim.restore(state)
        assert stepped(sim, n) == expected
        sim.reset()  # with the parameters that were restored
        assert sim[name] == one
        sim.initialize()
        sim.step(n)
        assert stepped(sim, n) == expected


def test_bytes_of_a_state_are_of_its_own_parameters():
    name, (one, two), _, n = KERNELS["mass-on-spring"]
    with cosimo.open("mass-on-spring") as sim, cosimo.open("mass-on-spring") as other:
        begun(sim, name, one)
        sim.step(n)
        state = sim.save()
        content = bytes(state)
        expected = stepped(sim, n)
        begun(sim, name, two)
        sim.step(n)
        assert bytes(state) == content
        with pytest.raises(BadInput, match="of another scene or other settings"):
            sim.restore(content)
        other[name] = one
        other.restore(content)
        assert stepped(other, n) == expected


def test_parameters_are_what_they_were_set_to_at_once():
    with cosimo.open("mass-on-spring") as sim:
        sim.initialize()
        for value in (90.0, 400.0):
            sim.reset()
            sim["spring.stiffness"] = value
            assert sim["spring.stiffness"] == sim.scene.units["spring"].parameters["stiffness"] == value
            assert sim.scene.with_changes({}).units["spring"].parameters["stiffness"] == value


def test_a_recording_goes_on_with_other_parameters():
    name, (one, two), signal, n = KERNELS["mass-on-spring"]
    with cosimo.open("mass-on-spring") as sim:
        begun(sim, name, one)
        sim.step(n)
        state = sim.save()
        begun(sim, name, two)
        sim.record()
        sim.step(n + 5)
        sim.restore(state)
        way = [sim[signal]]
        for _ in range(4):
            sim.step()
            way.append(sim[signal])
        result = sim.result()
        assert result.time[-1] == sim.time
        assert result[signal][-4:].tolist() == way[1:]


@pytest.mark.parametrize("kind", ["plain Python", "FMI 2", "FMI 3", "model exchange", "worker", "no state"])
def test_units_that_are_opened_anew_for_a_parameter_take_bytes_alone(kind, foreign):
    """Written, stepped, saved, another one written, back: as a session that never left; FMUs without states are refused."""
    tables = {
        "FMI 2": ({"fmu": native_fmu("integrator", 2, STATE[2])}, "u"),
        "FMI 3": ({"fmu": native_fmu("integrator", 3, STATE[3])}, "u"),
        "model exchange": ({"fmu": exchange_fmu(), "interface": "model-exchange"}, "k"),
        "worker": ({"fmu": native_fmu("integrator", 2, STATE[2]), "isolation": "process"}, "u"),
        "no state": ({"fmu": foreign()}, "u"),
    }
    table, parameter = tables.get(kind, ({"component": MASS}, "k"))
    scene = read_scene({"stop_time": 2.0, "units": {"a": table}, "master": {"step": 0.125}})
    name = f"a.{parameter}"
    with cosimo.open(scene) as sim, cosimo.open(scene) as never_left:
        for session in (sim, never_left):
            session[name] = 2.0
            session.initialize()
            session.step(2)
        if kind == "no state":
            with pytest.raises(BadInput, match="units that can save their state"):
                sim.save()
            return
        state = sim.save()
        content = bytes(state)
        assert bytes(never_left.save()) == content  # where it is packed the solver of a model exchange begins anew
        expected = stepped(never_left, 4)
        begun(sim, name, 5.0)
        sim.step(3)
        if parameter == "k":  # which the units were opened with
            with pytest.raises(BadInput, match="units that were closed"):
                sim.restore(state)
            with pytest.raises(BadInput, match="units that were closed"):
                bytes(state)
            with pytest.raises(BadInput, match="of another scene or other settings"):
                sim.restore(content)
            begun(sim, name, 2.0)
        sim.restore(content)
        assert sim[name] == 2.0
        assert stepped(sim, 4) == expected


def test_a_state_of_before_an_estimate_is_that_of_the_scene():
    from cosimo.tests.estimation.test_live import SIGNAL, TRUTH, opened, plan

    with opened() as sim, opened() as never_left:
        for session in (sim, never_left):
            session.initialize()
            session.step(3)
        state, stiffness, expected = sim.save(), sim["spring.stiffness"], stepped(never_left, 5)
        sim.reset()
        sim.estimate(plan())
        for k, t in enumerate(TRUTH.times[:8]):
            sim.assimilate(float(t), {SIGNAL: 0.3 * (-1) ** k})
        found = sim["spring.stiffness"]
        assert found != stiffness
        assert sim.scene.units["spring"].parameters["stiffness"] == found
        sim.reset()
        sim.restore(state)
        assert sim["spring.stiffness"] == stiffness
        assert stepped(sim, 5) == expected


def test_a_component_that_stands_where_another_one_does_has_its_parameters():
    cls = component_class("Catenary")
    one, other = (cls(parameters={"contact_wire_mass": mass}) for mass in (1.35, 1.5))
    for component in (one, other):
        component.initialize(0.0)
    one.stand(other.block.memory.copy())
    assert one["contact_wire_mass"] == 1.5
    for component in (one, other):
        component.step(0.0, 1e-3)
    assert one.save() == other.save()
    one.set("contact_wire_mass", 1.35)  # what it had before, of which arrays are kept
    one.stable_step()
    one.initialize(0.0)
    fresh = cls(parameters={"contact_wire_mass": 1.35})
    fresh.initialize(0.0)
    assert one.save() == fresh.save()
