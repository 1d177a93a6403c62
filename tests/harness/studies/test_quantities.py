"""Quantities of interest: values and errors against numbers worked out by hand, and what a scene may not ask for."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.studies.accuracy import Point, judged
from cosimo.orchestrator.harness.studies.quantities import (
    Quantity,
    TimeHistory,
    errors,
    quantities_of,
    quantities_to_judge,
    recording,
)
from cosimo.orchestrator.harness.studies.trial import Trial
from cosimo.orchestrator.run.key_results import STATISTICS
from cosimo.orchestrator.settings.study import QUANTITY_KINDS, wanted
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.units.interface import Signal

TIME = np.linspace(0.0, 4.0, 801)
SCENE = {
    "stop_time": 1.0,
    "master": {"step": 1e-2},
    "record": {"signals": ["m.x_out"]},
    "units": {"m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": 100.0}}},
}


def history(values, time=TIME):
    return TimeHistory(time, {"m.x": values})


def quantity(kind, **more):
    return Quantity(f"m.x, {kind}", "m.x", kind, **{"frequency": 0.0, "transient": 0.0, "nominal": 1.0, **more})


def test_kinds_of_sweeps_are_kinds_of_quantities():
    assert set(STATISTICS) < set(QUANTITY_KINDS)


@pytest.mark.parametrize(
    ("kind", "value"), [("minimum", -1.0), ("maximum", 3.0), ("mean", 1.0), ("standard deviation", np.sqrt(2.0)), ("end", 1.0)]
)
def test_values_of_a_wave(kind, value):
    wave = history(1.0 + 2.0 * np.sin(2.0 * np.pi * TIME))
    assert quantity(kind).value(wave) == pytest.approx(value, abs=2e-3)  # a sample too many of whole periods


def test_an_amplitude_is_that_of_its_frequency_alone():
    wave = history(5.0 + 2.0 * np.sin(2.0 * np.pi * 10.0 * TIME + 0.3) + 7.0 * np.sin(2.0 * np.pi * 25.0 * TIME))
    assert quantity("amplitude at F Hz", frequency=10.0).value(wave) == pytest.approx(2.0, rel=5e-3)
    assert quantity("amplitude at F Hz", frequency=17.5).value(wave) == pytest.approx(0.0, abs=2e-2)


def test_errors_are_shares_of_the_range():
    reference, run = history(np.sin(2.0 * np.pi * TIME)), history(np.sin(2.0 * np.pi * TIME) + 0.02)
    assert quantity("maximum").error(run, reference) == pytest.approx(0.01)
    assert quantity("time history").error(run, reference) == pytest.approx(0.01)


def test_a_low_pass_leaves_what_is_slow_and_measures_it_by_its_standard_deviation():
    slow, fast = 3.0 * np.sin(2.0 * np.pi * 2.0 * TIME), 5.0 * np.sin(2.0 * np.pi * 60.0 * TIME)
    filtered = quantity("time history", cutoff=20.0)
    assert filtered.error(history(slow + fast), history(slow)) < 9.5e-4  # two passes' gain at three times the cut-off: 0.41 / 3^6
    assert filtered.error(history(1.01 * slow), history(slow)) == pytest.approx(0.01, rel=1e-3)
    assert quantity("standard deviation", cutoff=20.0).error(history(1.01 * slow), history(slow)) == pytest.approx(0.01, rel=1e-3)
    assert quantity("maximum", cutoff=20.0).value(history(slow + fast)) == pytest.approx(3.0, rel=3e-3)


def test_a_filtered_signal_does_not_depend_on_how_it_goes_on_beyond_the_ends():
    before, wave = np.where(TIME < 0.02, 30.0, 0.0) + np.where(TIME > 3.98, 30.0, 0.0), np.sin(2.0 * np.pi * TIME)
    assert quantity("time history", cutoff=20.0).error(history(wave + before), history(wave)) < 0.01
    assert quantity("time history").error(history(wave + before), history(wave)) > 0.1


def test_samples_too_far_apart_for_a_filter_have_an_infinite_error():
    coarse = slice(None, None, 8)  # 40 ms
    run = TimeHistory(TIME[coarse], {"m.x": np.sin(TIME[coarse])})
    assert quantity("time history", cutoff=20.0).error(run, history(np.sin(TIME))) == inf


def test_a_constant_signal_is_measured_against_itself_and_zero_against_the_nominal_value():
    assert quantity("end").error(history(np.full_like(TIME, 4.04)), history(np.full_like(TIME, 4.0))) == pytest.approx(0.01)
    zero = history(np.zeros_like(TIME))
    assert quantity("end", nominal=50.0).error(history(np.full_like(TIME, 0.5)), zero) == pytest.approx(0.01)


def test_the_transient_does_not_count():
    late = np.where(TIME < 1.0, 100.0, np.sin(TIME))
    assert quantity("time history", transient=1.0).error(history(late), history(np.sin(TIME))) == 0.0
    assert quantity("time history").error(history(late), history(np.sin(TIME))) > 1.0


def test_a_run_on_other_instants_is_compared_at_its_own():
    coarse = TIME[::7]
    shorter = TimeHistory(np.append(coarse, 4.0), {"m.x": np.append(coarse, 4.0) ** 2})
    assert quantity("time history").error(shorter, history(TIME**2)) < 1e-6  # of 16: chords of 5 ms are off by 6e-6


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
def test_what_an_extreme_between_two_samples_misses(shift):
    """Of a cosine sampled with step h, the peak lies `shift` h behind a sample: 1 - cos(shift h), of a range of 2."""
    h = 0.01
    time = np.arange(201) * h
    wave = TimeHistory(time, {"m.x": np.cos(np.pi * (time - 1.0 - shift * h))})
    expected = 0.5 * (1.0 - np.cos(np.pi * shift * h))
    assert quantity("maximum").between_samples(wave) == pytest.approx(expected, rel=2e-3, abs=1e-12)
    assert quantity("mean").between_samples(wave) == 0.0


def test_angles_are_directions():
    turning = 40.0 * TIME
    wrapped = np.remainder(turning, 2.0 * np.pi)
    angle = quantity("time history", unit="rad")
    assert angle.error(history(turning + 0.01), history(wrapped)) * np.ptp(wrapped) == pytest.approx(0.01, rel=1e-6)
    assert quantity("end", unit="rad").error(history(wrapped), history(turning)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("values", [np.full_like(TIME, np.nan), np.append(TIME[:-1], np.inf)])
def test_what_is_no_number_has_an_infinite_error(values):
    assert quantity("time history").error(history(values), history(np.sin(TIME))) == inf


def test_a_run_that_ends_early_has_an_infinite_error():
    half = TIME[TIME < 2.0]
    assert quantity("maximum").error(history(np.sin(half), half), history(np.sin(TIME))) == inf


def test_without_a_table_course_and_maximum_of_what_is_recorded():
    assert [q.name for q in quantities_of(read_scene(SCENE))] == ["m.x_out, time history", "m.x_out, maximum"]


def _with_flags(names):
    """What `quantities_of` reads of a scene with a signal, a flag and a count, of which these are recorded."""
    outputs = {n: Signal(n, "1", kind=kind) for n, kind in (("x", "real"), ("stuck", "boolean"), ("jumps", "integer"))}
    coupling = SimpleNamespace(signals=[("m", n) for n in names], interfaces={"m": SimpleNamespace(outputs=outputs)})

    def scene(*asked):
        study, analysis = SimpleNamespace(quantities=asked), SimpleNamespace(transient=0.0)
        split = {f"m.{n}": ("m", n) for n in outputs}.__getitem__
        return SimpleNamespace(name="s", coupling=coupling, study=study, analysis=analysis, split=split)

    return scene


def test_flags_and_counts_are_quantities_only_where_a_scene_asks():
    scene = _with_flags(["x", "stuck", "jumps"])
    assert [q.name for q in quantities_of(scene())] == ["m.x, time history", "m.x, maximum"]
    asked = quantities_of(scene("m.stuck, mean", "m.jumps, end"))
    assert [q.name for q in asked] == ["m.stuck, mean", "m.jumps, end"]
    stuck = TimeHistory(TIME, {"m.stuck": np.where(TIME < 1.0, 1.0, 0.0)})
    assert asked[0].value(stuck) == pytest.approx(0.25, abs=1e-3)  # the share of the time
    with pytest.raises(BadInput, match="no recorded signal that is a physical one"):
        quantities_to_judge(_with_flags(["stuck"])())


def test_a_run_without_an_effect_is_compared_in_what_it_has():
    quantities = [quantity("maximum"), Quantity("m.e.force, end", "m.e.force", "end", 0.0, 0.0, 1.0)]
    full = TimeHistory(TIME, {"m.x": np.sin(TIME), "m.e.force": np.cos(TIME)})
    assert list(errors(quantities, history(np.sin(TIME)), full)) == ["m.x, maximum"]
    point, run = Point("without e", "effect", 1e-3, {}, ""), Trial("done", "", time=TIME, columns={"m.x": np.sin(TIME)})
    one = judged(point, run, quantities, full, {})
    assert (one.outcome, one.error) == ("done", 0.0)
    assert one.reason == "without m.e.force, end, which it does not have"
    none = judged(point, run, quantities[1:], full, {})
    assert (none.outcome, none.reason) == ("refused", "has none of the quantities: m.e.force, end")


def test_a_scene_names_its_quantities_and_records_what_they_need():
    scene = read_scene(
        {**SCENE, "study": {"quantities": ["m.v_out, amplitude at 1.5 Hz", "m.x_out, end"]}, "analysis": {"transient": 0.25}}
    )
    first, second = quantities_of(scene)
    assert (first.name, first.kind, first.frequency) == ("m.v_out, amplitude at 1.5 Hz", "amplitude at F Hz", 1.5)
    assert (second.name, second.transient) == ("m.x_out, end", 0.25)
    assert recording(scene).record.signals == ("m.x_out", "m.v_out")
    assert recording(read_scene(SCENE)).record.signals == ("m.x_out",)


def test_an_element_of_an_array_may_be_a_quantity():
    assert wanted("unit.matrix[1,2], maximum")[:2] == ("unit.matrix[1,2]", "maximum")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("m.x_out", "unit.output, kind"),
        ("m.x_out, maximun", "maximum"),
        ("m.x_out, amplitude at -3 Hz", "positive frequency"),
        ("m.x_ot, end", "x_out"),
    ],
)
def test_bad_quantities_are_refused_when_the_scene_is_read(text, words):
    with pytest.raises(BadInput, match=words):
        read_scene({**SCENE, "study": {"quantities": [text]}})


def test_a_map_has_two_axes_at_most():
    table = {f"m.{p}": [1.0, 2.0] for p in ("m", "k", "c")}
    with pytest.raises(BadInput, match="one or two"):
        read_scene({**SCENE, "study": {"stability": table}})


def test_errors_by_name():
    scene = load_scene("mass-on-spring")
    names = [q.name for q in quantities_of(scene)]
    wave = TimeHistory(TIME, {q.signal: np.cos(TIME) for q in quantities_of(scene)})
    assert errors(quantities_of(scene), wave, wave) == dict.fromkeys(names, 0.0)


def test_a_scene_may_filter_its_quantities():
    first, second = quantities_of(
        read_scene({**SCENE, "study": {"quantities": ["m.x_out, time history below 20 Hz", "m.v_out, maximum below 12.5 Hz"]}})
    )
    assert (first.name, first.kind, first.cutoff) == ("m.x_out, time history below 20 Hz", "time history", 20.0)
    assert (second.kind, second.cutoff, second.frequency) == ("maximum", 12.5, 0.0)


@pytest.mark.parametrize("text", ["m.x, amplitude at 5 Hz below 20 Hz", "m.x, end below zero Hz", "m.x, end below -1 Hz"])
def test_a_filter_needs_a_frequency_and_a_kind_of_the_whole_signal(text):
    with pytest.raises(BadInput):
        wanted(text)


def test_a_run_shorter_than_the_ends_of_its_filter_is_refused():
    with pytest.raises(BadInput, match="more than 2 s"):
        quantities_to_judge(read_scene({**SCENE, "study": {"quantities": ["m.x_out, time history below 2 Hz"]}}))
