"""Model exchange of FMI 3: the same equations behind both versions are bit-identical, and each form of an input is followed.

The FMU is that of `test_model_exchange`, where its results are compared with closed forms; it complains of every call in a
mode that does not allow it.
"""

import math

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import describe, open_unit
from cosimo.tests.units.exchange_fmu import exchange_fmu

H = 0.4  # s
HISTORIES = {
    "ball": ({}, 2.0),
    "ticks": ({"period": 0.03}, 1.0),
    "saw": ({"k": 0.0, "saw": 0.25, "u": 1.0}, 1.0),
    "oscillator": ({"mu": 1.0}, 5.0),
    "end": ({"end": 0.43}, 1.0),
}


def scene(version, parameters, stop=1.0, **unit):
    return {
        "stop_time": stop,
        "master": {"step": 0.1},
        "units": {"f": {"fmu": exchange_fmu(version=version), "parameters": parameters, **unit}},
    }


@pytest.mark.parametrize("name", HISTORIES)
@pytest.mark.parametrize("solver", ["CVode", "RK45"])
def test_both_versions_give_the_same_bits(name, solver):
    parameters, stop = HISTORIES[name]
    two, three = (run(read_scene(scene(v, parameters, stop, solver=solver))) for v in (2, 3))
    assert three.outcome == two.outcome == "done", three.message
    assert three.message == two.message
    assert three.time.tolist() == two.time.tolist()
    for signal in two.columns:
        assert three[signal].tolist() == two[signal].tolist(), signal
    counts = [r.info.counters.units["f"] for r in (two, three)]
    assert counts[0] == counts[1]


def opened(u="scalar", inputs=("u",), outputs=("x",), values=(0.0,), parameters=None, **more):
    """A unit at t = 0."""
    data = {"fmu": exchange_fmu(version=3, u=u), "parameters": parameters or {}, **more}
    unit = open_unit(
        "f", read_scene({"stop_time": 1.0, "units": {"f": data}, "master": {"step": 0.1}}).units["f"], in_process=False
    )
    unit.wire(list(inputs), list(outputs))
    unit.initialize(0.0, list(values))
    unit.start()
    return unit


@pytest.mark.parametrize(("u", "name", "rounding"), [("scalar", "u", 0.0), ("array", "u[1]", 0.0), ("single", "u", 2.0**-24)])
def test_an_input_of_any_form_follows_its_polynomial(u, name, rounding):
    """x' = -2 x + 1 + 2 t + 3 t² has the particular solution 3/4 - t/2 + 3/2 t²; single precision rounds the input only."""
    unit = opened(u, inputs=(name,), parameters={"k": 2.0}, solver="DOP853", tolerance=1e-8 if u == "single" else 1e-12)
    unit.drive([1.0], [2.0], [3.0], H)
    unit.step(0.0, H)
    exact = 0.75 - 0.5 * H + 1.5 * H**2 - 0.75 * math.exp(-2.0 * H)
    assert abs(unit.get()[0] - exact) < (1e-11 if not rounding else 1e-8 + H * 2.28 * rounding)  # u ends at 2.28
    unit.close()


def test_an_input_that_changes_at_instants_changes_in_event_mode():
    unit = opened(inputs=("u", "reversed"), values=(1.0, 0.0), parameters={"k": 0.0}, solver="RK45")
    for k, reversed_ in enumerate((0.0, 1.0, 1.0)):
        unit.drive([1.0, reversed_], None, None, 0.1)
        unit.step(0.1 * k, 0.1)
    assert unit.get()[0] == pytest.approx(-0.1, abs=1e-12)
    unit.close()


def test_states_go_back_and_into_files():
    unit = opened(values=(0.3,), outputs=("x", "h", "bounces"), solver="RK45")
    unit.step(0.0, 0.4)
    state = unit.save()
    packed = unit.pack(state)
    ends = []
    for start in (None, state, unit.unpack(packed)):
        if start is not None:
            unit.restore(start)
        unit.step(0.4, 0.4)
        ends.append(list(unit.get()))
    assert ends[0] == ends[1] == ends[2]
    assert ends[0][2] == 1.0
    unit.close()


def test_derivatives_and_capabilities():
    unit = opened(outputs=("x", "y"), values=(1.0,))
    assert np.array_equal(unit.jacobian(), [[0.0], [1.0]])
    unit.close()
    interface = describe("f", read_scene(scene(3, {})).units["f"])
    assert (interface.gives_jacobian, interface.saves_state, interface.packs_state, interface.may_return_early) == (True,) * 4
