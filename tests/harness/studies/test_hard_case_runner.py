"""The runner of hard cases: reached, limit and margin of claims of known size, and everything that must not pass."""

from __future__ import annotations

import csv
import math
import re

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.hard_cases import (
    AtLeast,
    AtMost,
    BoundedEnergy,
    Ends,
    Falling,
    Finite,
    HardCase,
    InputSignal,
    Invariant,
    Like,
    Reaches,
    Refused,
    jumps,
    ramp,
    sine,
)
from cosimo.orchestrator.harness.studies.hard_cases import HardCases, hard_cases, verdicts
from cosimo.tests.commands import exit_code

TOW = "TowCoupling"  # 500 N/m, 5 N.s/m, 0.5 m; without a state


def one(holds, component=TOW, **more):
    """The verdict of a case with one claim."""
    made = HardCase("Text.", holds if isinstance(holds, Refused) else (holds,), name="name", **more)
    (found,) = verdicts(component, made)
    return found


@pytest.mark.parametrize(("claim", "reached"), [
    (AtMost("stretch", 0.04), 0.02),  # to and fro by 20 mm
    (AtLeast("rear_force", 20.0), 10.0),
    (AtLeast("rear_force", 0.0, low=-11.0), 0.0),
    (Invariant("stretch", 0.1), 0.02),
    (Invariant("stretch", 0.1, value=0.01), 0.03),
    (Invariant("stretch", 2.0, share=True), 1.0),
    (Invariant("stretch", 1e-12, value=lambda t: 0.02 * math.sin(10.0 * t)), 0.0),
    (Ends("stretch", 0.1, value=0.0), 0.02 * math.sin(20.0 * math.pi / 8.0)),
    (Ends("stretch", 2.0, value=0.04, share=True), 0.5),
    (BoundedEnergy(limit=2.0), 1.0),  # from nothing to all
    (Finite(limit=4.0), 1.0),  # 10 N are the nominal force
    (Falling("stretch", 3.0), 2.0),  # as a part of the largest
    (Reaches("stretch", 0.02, high=0.03), 0.01),
    (Reaches("stretch", high=0.01), 0.0),
    (Like("stretch", 0.1, instead={"inputs": {}}), 0.02 * math.sin(20.0 * math.pi / 8.0)),  # which ends without a stretch
    (Like("stretch", 2.0, instead={"run": (math.pi / 4.0, math.pi / 80.0)}, mirror=lambda c: 2.0 * c["stretch"], share=True), 0.5),
    (AtMost(lambda c: c.y, 60.0), 10.0),  # of what they were in every step, not of what they are at the end
])  # fmt: skip
def test_what_a_claim_reaches(claim, reached):
    """A quarter of a turn and then two whole ones, in 40 steps."""
    found = one(claim, inputs={"front_position": sine(0.02, 10.0, 0.5)}, run=(math.pi / 4.0, math.pi / 160.0))
    assert found.reached == pytest.approx(reached, abs=1e-12)
    assert found.limit == claim.limit
    assert found.margin == (claim.limit / found.reached if found.reached else math.inf)
    assert found.holds


def test_a_claim_beyond_its_limit_does_not_hold():
    found = one(AtMost("stretch", 0.01), inputs={"front_position": 0.52})
    assert not found.holds
    assert found.margin == pytest.approx(0.5)
    assert HardCases((found,)).failed == (found,)


def test_courses_follow_time_within_a_step_and_jumps_do_not():
    ends = {}
    for name, course in (
        ("ramp", ramp(1.0)),
        ("jump", jumps(0.0, (0.05, 1.0))),
        ("start", jumps(7.0, (0.0, 2.0))),
        ("held", InputSignal(lambda t: t, smooth=False)),
    ):
        ends[name] = one(Ends("rear_position", 10.0), inputs={"rear_position": course}, run=(0.1, 0.02)).reached
    assert ends == pytest.approx({"ramp": 0.1, "jump": 1.0, "start": 2.0, "held": 0.08})
    found = one(Invariant("rear_position", 10.0), inputs={"rear_position": jumps(7.0, (0.0, 2.0))})
    assert found.reached == 5.0  # it was initialized with 7


def test_a_refusal_in_its_words_and_how_sharp_it_is():
    found = one(Refused("slope", "construction", {"slope_table[1]": 1.5}), "PipeRoute", parameters={"slope_table[1]": 3.0})
    assert found.holds
    assert found.margin == 2.0
    assert "slope_table[1] = 3" in found.message
    back = {"return_time": 29.0}
    assert one(Refused("when the change ends", "initialize"), "ExciterProgram", parameters=back).holds


@pytest.mark.parametrize(("refused", "component", "parameters", "said"), [
    (Refused("quite other words", "initialize"), "ExciterProgram", {"return_time": 29.0}, "at initialize"),
    (Refused("when the change ends", "step"), "ExciterProgram", {"return_time": 29.0}, "at initialize"),
    (Refused("anything", "step"), "ExciterProgram", {}, "nothing is refused"),
    (Refused("when the change ends", "initialize", {"return_time": 28.0}), "ExciterProgram", {"return_time": 29.0},
     "what should be accepted"),
])  # fmt: skip
def test_refusals_that_are_none(refused, component, parameters, said):
    found = one(refused, component, parameters=parameters)
    assert not found.holds
    assert said in found.message


def test_a_run_that_fails_is_a_verdict_with_its_reason():
    found = one(AtMost("stretch", 1.0), inputs={"front_position": jumps(0.5, (0.01, math.nan))})
    assert not found.holds
    assert math.isnan(found.margin)
    assert "not finite" in found.message


def test_a_component_that_does_not_exist_is_refused():
    with pytest.raises(BadInput, match="Did you mean 'TowCoupling'"):
        hard_cases(["TowCouplin"])


def test_command(tmp_path, capsys):
    main_ends(["stability", "--hard-cases", TOW, "-o", str(tmp_path)], 0)
    shown = capsys.readouterr().out
    assert "a rope that runs together" in shown
    with open(tmp_path / "stability.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["component"] for row in rows} == {TOW}
    assert all(float(row["reached"]) <= float(row["limit"]) for row in rows)
    page = (tmp_path / "report.html").read_text()
    assert re.search(r"<td[^>]*>a bar without length", page)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stability", "--hard-cases", "TowCouplin"], "Did you mean 'TowCoupling'"),
        (["stability", "--hard-cases", TOW, "--steps", "3"], "--steps"),
        (["stability"], "one scene"),
        (["stability", "mass-on-spring", "lumped-catenary"], "one scene"),
    ],
)
def test_command_refuses(arguments, message, tmp_path, capsys):
    main_ends([*arguments, "-o", str(tmp_path)], 2)
    assert message in capsys.readouterr().err


def main_ends(arguments, code):
    """The command line ends with this exit code."""
    ended = exit_code(*arguments)
    assert ended == code
