"""The contract's own rules: names of kernel tuples, limits, effects that need or exclude each other."""

from importlib import import_module
from pkgutil import walk_packages

import numpy as np
import pytest
from cosimo import components
from cosimo.components.catalogue import CATALOGUE
from cosimo.components.core.component import Component, Effect, Preset
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import choice, input_, integer, output, parameter
from cosimo.components.railway.catenary import Catenary


class Wind(Effect):
    """Test effect."""

    speed = parameter(3.0, "m/s", "speed of the wind", low=0.0)
    gust = input_(0.0, "m/s", "gust on top")


class Sail(Effect):
    """Test effect that needs wind."""

    requires = ("wind",)
    pull = output("N", "pull of the sail", feedthrough=(".pull",))


class Rain(Effect):
    """Test effect that excludes sails."""

    excludes = ("sail",)


class Boat(Component):
    """Test component."""

    wind, sail, rain = Wind, Sail, Rain
    mass = parameter(5.0, "kg", "mass", low=1.0, high=10.0)
    mast = parameter((1.0, 2.0), "m", "height of a mast", size=2)
    crew = integer(2, "people on board", low=0, high=9)
    hull = choice("round", ("round", "flat"), "shape of the hull")
    push = input_(0.5, "N", "push")
    drift = output("m", "drift")


def test_kernel_tuples_are_told_apart_by_their_bare_names():
    """Numba looks at class name, field names and types only; several effects have the same fields."""
    modules = [import_module(m.name) for m in walk_packages(components.__path__, "cosimo.components.")]
    found = {c for m in modules for c in vars(m).values() if isinstance(c, type)}
    tuples = {c for c in found if issubclass(c, tuple) and hasattr(c, "_fields")}
    tuples |= {c.Values for c in found if issubclass(c, Component | Effect) and hasattr(c, "Values")}
    tuples |= {c.Present for c in found if issubclass(c, Component) and hasattr(c, "Present")}
    assert len(tuples) > len(CATALOGUE)
    assert len({c.__name__ for c in tuples}) == len(tuples)


def test_declaration_order_and_arrays():
    boat = Boat(["wind", "sail"])
    assert list(boat.parameters) == ["mass", "mast[1]", "mast[2]", "crew", "hull", "wind.speed"]
    assert boat.inputs == ("push", "wind.gust")
    assert boat.outputs == ("drift", "sail.pull")
    assert Boat.variables["sail.pull"].feedthrough == ("sail.pull",)
    values, (wind, sail, rain) = boat._declared_arguments()
    assert values.mast.tolist() == [1.0, 2.0]
    assert values.hull == 0
    assert wind._asdict() == {"u": 1, "speed": 3.0}
    assert sail._asdict() == {"y": 1}
    assert Boat(["rain"])._declared_arguments()[1].rain._asdict() == {"on": True}
    assert rain is None


class Rig:
    """Test mix-in: what a component without it has not."""

    sail = Sail
    mast = parameter((3.0, 4.0), "m", "height of a mast of the rig", size=2)
    drift = output("m", "drift of the rig")


class Ketch(Rig, Boat):
    """Test component that inherits from a component and a mix-in, declares a variable anew and drops one."""

    mass = parameter(8.0, "kg", "mass of the ketch", low=1.0, high=10.0)
    crew = None
    heel = output("rad", "angle of heel")
    presets = {"heavy": Preset({"mass": 10.0}, "a choice", "computed")}


class Yawl(Ketch):
    """Test component that inherits all it has."""

    presets = {"light": Preset({"mass": 1.0}, "a choice", "computed")}


def test_variables_effects_and_presets_are_inherited_in_the_order_of_method_resolution():
    yawl = Yawl(["wind", "sail"], preset="heavy")
    assert list(yawl.parameters) == ["mass", "mast[1]", "mast[2]", "hull", "wind.speed"]
    assert (yawl["mass"], yawl["mast[1]"]) == (10.0, 3.0)
    assert yawl.outputs == ("drift", "heel", "sail.pull")
    assert Yawl.variables["drift"].text == "drift of the rig"
    assert list(Yawl.effects) == list(Boat.effects)
    assert Yawl.Values._fields == ("mass", "mast", "hull")
    assert list(Yawl.presets) == ["heavy", "light"]
    assert list(Boat.variables) != list(Yawl.variables)


def test_off_is_absent():
    boat = Boat()
    assert not any(name.startswith(("wind", "sail", "rain")) for name in (*boat.parameters, *boat.inputs, *boat.outputs))
    with pytest.raises(BadInput, match="needs the effect 'wind'"):
        boat.set("wind.speed", 2.0)


@pytest.mark.parametrize(
    ("effects", "parameters", "message"),
    [
        (["wnd"], {}, "Did you mean 'wind'"),
        (["sail"], {}, "needs 'wind'"),
        (["wind", "sail", "rain"], {}, "exclude each other"),
        ([], {"mas": 3.0}, "Did you mean"),
        ([], {"mass": 0.5}, r"\[1, 10\] kg"),
        ([], {"mass": "five"}, "a number in kg"),
        ([], {"mass": float("nan")}, r"\[1, 10\]"),
        ([], {"mass": True}, "a number"),
        ([], {"crew": 1.5}, "a whole number"),
        ([], {"hull": "square"}, "one of round, flat"),
    ],
)
def test_bad_input_is_one_message(effects, parameters, message):
    with pytest.raises(BadInput, match=message):
        Boat(effects, parameters, name="boat")


class Overloaded(Boat):
    """Its start divides, overflows or inverts what has no inverse."""

    load = parameter(0.0, "1", "what is too much")

    def _initialize(self, t):
        load = self.parameters["load"]
        np.linalg.inv(np.diag([1.0, load]))
        return int(1.0 / (load - 1.0) * load**4)


@pytest.mark.parametrize("load", [0.0, 1.0, 1e300])
def test_numbers_that_cannot_be_computed_with_are_bad_input(load):
    with pytest.raises(BadInput, match=r"boat: .*parameters and inputs of a usual size"):
        Overloaded(parameters={"load": load}, name="boat").initialize(0.0)


def test_unit_strings_are_checked_where_they_are_declared():
    with pytest.raises((BadInput, RuntimeError)) as caught:  # Python 3.11 wraps what __set_name__ raises
        type("Bad", (Component,), {"x": parameter(0.0, "Newton", "wrong")})
    assert "Newton" in str(caught.value) + str(caught.value.__cause__)


def test_preset_sets_effects_and_parameters():
    catenary = Catenary(["wire_profile"], {"spans": 4}, preset="EN 50318:2018 AC simple")
    assert catenary["span_length"] == 55.0
    assert catenary["spans"] == 4
    assert {"pre_sag", "wire_profile"} <= set(catenary.on)
    with pytest.raises(BadInput, match="Did you mean 'EN 50318:2018 AC simple'"):
        Catenary(preset="EN 50318:2018 AC simpel")


class Named(Component):
    """Names of variables, and one that is also something of every component."""

    mass = parameter(2.0, "kg", "mass")
    gains = parameter((1.0, 2.0), "1", "gains", size=2)
    kind = choice("soft", ("soft", "hard"), "kind")
    force = input_(3.0, "N", "force")
    area = output("m2", "areas", size=2)
    x = output("m", "position")
    speed = output("m/s", "velocity")

    def _initialize(self, t):
        self.x = np.array([self.force / self.mass])  # the state
        return DONE

    def _outputs(self, t):
        self.area, self.speed = self.gains, 7.0


def test_values_are_had_by_name_and_outputs_set():
    assert Named.mass is Named.own_variables[0]
    one = Named(parameters={"mass": 4.0, "kind": "hard"})
    assert (one.mass, one.kind, one.force, one.gains.tolist()) == (4.0, "hard", 3.0, [1.0, 2.0])
    one.initialize(0.0)
    assert one.x.tolist() == [0.75]  # not the output of this name
    assert one.y.tolist() == [1.0, 2.0, 0.0, 7.0]
    assert (one.area.tolist(), one.speed) == ([1.0, 2.0], 7.0)
    one.set("force", 8.0)
    assert one.force == 8.0
    one.mass = 5.0  # a name of its own, as before
    assert (one.mass, one.parameters["mass"]) == (5.0, 4.0)


def test_memory_is_laid_out_when_it_is_needed_with_what_was_set_until_then():
    line = Catenary(["moving_window"])
    assert line.get("element") == line["element"] == 0.4
    assert line["contact_position"] == Catenary.variables["contact_position"].start
    assert "block" not in vars(line)
    line.set("element", 0.8)
    assert "block" not in vars(line)
    line.set("contact_position", 5.0)
    before = Catenary(["moving_window"])
    assert line.x.size < before.x.size  # longer elements
    assert line.u[0, line.input_positions(["contact_position"])[0]] == 5.0
    with pytest.raises(AttributeError, match="no attribute 'other'"):
        line.other  # noqa: B018
