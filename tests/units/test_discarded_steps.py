"""What becomes of a step that an FMU discards: shorter ones take its place where the FMU tells where it is or can go back."""

import numpy as np
import pytest
from cosimo import read_scene, run
from cosimo.tests.units.native import EVENTS, STATE, native_fmu

WAYS = [(2, "none"), (3, "none"), (2, "process"), (3, "process")]
ONE_LENGTH = 'canHandleVariableCommunicationStepSize="false"'


def scene(fmu, isolation="none", **parameters):
    """The FMU, and beside it one that nothing may change."""
    return read_scene(
        {
            "stop_time": 1.0,
            "units": {
                "f": {"fmu": fmu, "isolation": isolation, "parameters": parameters},
                "other": {"fmu": native_fmu("van_der_pol", 2, STATE[2])},
            },
            "master": {"step": 0.1},
        }
    )


def of_discarded(result) -> list[str]:
    return [warning for warning in result.info.warnings if "discarded" in warning]


@pytest.mark.parametrize("strict", [0, 1])
@pytest.mark.parametrize(("fmi", "isolation"), WAYS)
def test_discarded_steps_are_made_in_shorter_ones(fmi, isolation, strict):
    """A strict FMU of FMI 2 goes back to where the step began; others are where they were."""
    fmu = native_fmu("told", fmi, STATE[fmi] if strict else "")
    whole, parts = (run(scene(fmu, isolation, longest=longest, strict=strict), verify="no") for longest in (1e9, 0.03))
    assert (parts.outcome, parts.message) == ("done", "")
    np.testing.assert_allclose(parts["f.length"][1:], 0.025, rtol=1e-12)  # of the last of four steps
    for name in ("f.now", "other.x0", "other.x1"):
        assert parts[name].tobytes() == whole[name].tobytes()
    (text,) = of_discarded(parts)
    assert text == "f: 10 steps that the FMU discarded were tried again with shorter ones, down to 0.025 s"
    counters = parts.info.counters.units["f"]
    assert (counters["steps"], counters["discarded"], counters["shortest"]) == (10, 10, pytest.approx(0.025))
    assert not of_discarded(whole)
    assert "discarded" not in whole.info.counters.units["f"]


@pytest.mark.parametrize("isolation", ["none", "process"])
@pytest.mark.parametrize("flags", ["", 'canInterpolateInputs="true"'])
def test_inputs_of_shorter_steps_are_those_of_the_macro_step(foreign, flags, isolation):
    """Input t², extrapolated by parabolas, of which x is the integral and z that of x."""

    def integral(longest):
        units = {
            "m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 0.0, "force": 2.0}},
            "f": {
                "fmu": foreign(f'canHandleVariableCommunicationStepSize="true" {flags}'),
                "isolation": isolation,
                "parameters": {"longest": longest},
            },
        }
        master = {"algorithm": "jacobi", "step": 0.1, "extrapolation": 2}
        return run(
            read_scene({"stop_time": 1.0, "connections": ["m.x_out -> f.u"], "units": units, "master": master}), verify="no"
        )

    whole, parts = integral(1e9), integral(0.04)
    assert parts.info.counters.units["f"]["discarded"] == 10
    np.testing.assert_allclose(parts["f.x"], whole["f.x"], rtol=1e-13)
    if flags:
        np.testing.assert_allclose(parts["f.z"], whole["f.z"], rtol=1e-13)


def test_a_step_goes_on_from_where_the_fmu_got():
    """That of FMI 2 refuses to, as it has no state to go back to: its words and those of the discarded step are told."""
    went_on = run(scene(native_fmu("moody", 3), discard_at=0.35), verify="no")
    assert went_on.outcome == "done"
    np.testing.assert_allclose(went_on["f.now"], went_on.time, rtol=1e-15)
    assert of_discarded(went_on) == ["f: 1 step that the FMU discarded was tried again with shorter ones, down to 0.1 s"]
    refused = run(scene(native_fmu("moody", 2), discard_at=0.35), verify="no")
    assert refused.outcome == "failed"
    assert "f failed at t = 0.3 s: the FMU reported an error, after a step that it had discarded" in refused.message
    assert "log: call of a function in a mode that does not allow it" in refused.message


def test_a_discarded_step_is_no_event():
    """Events around it are where they were; an early return inside of the step is one."""
    result = run(scene(native_fmu("moody", 3, f"{EVENTS} {STATE[3]}"), discard_at=0.34, early_at=0.37), verify="no")
    assert result.outcome == "done"
    assert np.abs(result.time[:, None] - [0.37]).min() < 1e-6
    assert len(result.time) == 12


REFUSED = [
    (2, "", {"strict": 1, "longest": 0.03}, "no shorter step was tried: it tells no last successful time and cannot restore"),
    (2, ONE_LENGTH, {"longest": 0.03}, "no shorter step was tried: canHandleVariableCommunicationStepSize is false"),
    (3, ONE_LENGTH, {"longest": 0.03}, "no shorter step was tried: canHandleVariableCommunicationStepSize is false"),
    (2, STATE[2], {"longest": 1e-6}, "the FMU discarded the call; so it did with 12 shorter steps, down to 2.44e-05 s"),
    (3, "", {"longest": 1e-6}, "the FMU discarded the call; so it did with 12 shorter steps, down to 2.44e-05 s"),
    (3, 'fixedInternalStepSize="0.1"', {"longest": 0.03}, "the FMU discarded the call; its fixed internal step is 0.1 s"),
]


def test_what_cannot_be_made_shorter_says_why():
    for fmi, flags, parameters, words in REFUSED:
        result = run(scene(native_fmu("told", fmi, flags), **parameters), verify="no")
        assert result.outcome == "failed"
        assert words in result.message, result.message


def test_shorter_steps_are_multiples_of_a_fixed_internal_step():
    result = run(scene(native_fmu("told", 3, 'fixedInternalStepSize="0.02"'), longest=0.05), verify="no")
    assert result.outcome == "done"
    assert result.info.counters.units["f"]["shortest"] == pytest.approx(0.04)


@pytest.mark.parametrize("fmi", [2, 3])
def test_step_control_repeats_the_step_of_all_units(fmi):
    units = {
        "f": {"fmu": native_fmu("told", fmi, STATE[fmi]), "parameters": {"longest": 0.03}},
        "g": {"fmu": native_fmu("integrator", 2, STATE[2])},
    }
    master = {"step": 0.1, "control": {"method": "doubling"}}
    result = run(read_scene({"stop_time": 1.0, "units": units, "connections": ["f.now -> g.u"], "master": master}), verify="no")
    assert result.outcome == "done"
    assert "discarded" not in result.info.counters.units["f"]
    assert result.info.counters.stepping.failed > 0
