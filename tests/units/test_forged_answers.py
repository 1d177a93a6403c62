"""Answers that a hostile unit forges: each is refused with the unit's name, and what is let through is shown as it is."""

from __future__ import annotations

import math
import pickle
import resource
import struct
import sys
from pathlib import Path

import msgpack
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import open_unit
from cosimo.orchestrator.units.answers import read_warnings
from cosimo.orchestrator.units.channel import LARGEST, Code
from cosimo.orchestrator.units.interface import SimulationEnded
from cosimo.orchestrator.verified_file import packed
from cosimo.tests.units import forged

ROOT = Path(__file__).resolve().parents[2]
REFUSED = "something else than answers came from its worker process"
NAN, ESCAPE = math.nan, "\x1b]0;owned\x07\u202e"


def answer(code: int, content: bytes) -> bytes:
    return b"A" + bytes([code]) + content


def data(value) -> bytes:
    return answer(Code.DATA, msgpack.packb(value))


def failed(*values) -> bytes:
    return answer(Code.FAILED, msgpack.packb(values))


def numbers(*values: float, code: int = Code.VALUES) -> bytes:
    return answer(code, struct.pack(f"{len(values)}d", *values))


def head(mark: int = -1, number: int = -1, length: int = 24, code: int = Code.VALUES) -> bytes:
    return b"H" + struct.pack("=qqQB", mark, number, length, code)


NESTED = b"\x91" * 500_000 + b"\xc0"
FORGED = {  # name: request it answers, the answer
    "no content": (Code.STEP, answer(Code.VALUES, b"")),
    "an output too few": (Code.STEP, numbers(NAN, 1.0)),
    "an output too many": (Code.STEP, numbers(NAN, 1.0, 1.0, 1.0)),
    "half a number": (Code.STEP, answer(Code.VALUES, bytes(20))),
    "numbers in the place of outputs": (Code.STEP, numbers(NAN, 1.0, 1.0, code=Code.NUMBERS)),
    "data in the place of outputs": (Code.STEP, data([1.0, 1.0])),
    "an unknown code": (Code.STEP, answer(200, bytes(24))),
    "an event at infinity": (Code.STEP, numbers(math.inf, 1.0, 1.0)),
    "an event before the step": (Code.STEP, numbers(-1.0, 1.0, 1.0)),
    "an event after the step": (Code.STEP, numbers(0.2, 1.0, 1.0)),
    "another mark": (Code.STEP, head(mark=7)),
    "the number of an earlier answer": (Code.STEP, head(number=1)),
    "the number of a later answer": (Code.STEP, head(number=99)),
    "a gigabyte announced": (Code.STEP, head(length=1 << 30)),
    "2^63 bytes announced": (Code.STEP, head(length=1 << 63)),
    "two answers at once": (Code.STEP, b"D2"),
    "ten thousand answers at once": (Code.STEP, b"D10000"),
    "a pickle": (Code.STEP, answer(Code.FAILED, pickle.dumps(StepFailed("u", 0.0, "x")))),
    "an unknown failure": (Code.STEP, failed("SystemExit", 0.0, "x", "")),
    "a failure without a kind": (Code.STEP, failed()),
    "a failure at no time": (Code.STEP, failed("StepFailed", NAN, "x", "")),
    "a failure at a text": (Code.STEP, failed("StepFailed", "x", "x", "")),
    "a failure for a number": (Code.STEP, failed("StepFailed", 0.0, 1, "")),
    "a failure with too much": (Code.STEP, failed("StepFailed", 0.0, *"abcdefgh")),
    "a failure in nested lists": (Code.STEP, failed("StepFailed", 0.0, [["x"]], "")),
    "a failure not in UTF-8": (Code.STEP, answer(Code.FAILED, b"\x94\xaaStepFailed\xcb" + bytes(8) + b"\xa1\xff\xa0")),
    "a failure of megabytes": (Code.STEP, failed("StepFailed", 0.0, "x" * (2 << 20), "")),
    "an end in the future": (Code.STEP, failed("SimulationEnded", 1e9)),
    "an extension type": (Code.STEP, answer(Code.FAILED, msgpack.packb(msgpack.ExtType(5, b"x")))),
    "warnings in warnings": (Code.STEP, answer(Code.WARNED, packed([Code.WARNED, packed([Code.VALUES, bytes(24), "x"]), "x"]))),
    "a thousand warnings": (Code.STEP, answer(Code.WARNED, packed([Code.VALUES, bytes(24), *["x"] * 1000]))),
    "warnings with a text for a code": (Code.STEP, answer(Code.WARNED, packed(["x", b"", "x"]))),
    "warnings of numbers": (Code.STEP, answer(Code.WARNED, packed([Code.VALUES, bytes(24), 1]))),
    "a list of parameters": ("open", data([1.0])),
    "an unknown parameter": ("open", data({"trouble": "none", "gold": 1.0})),
    "walls that it claims": ("open", data({"walls": "bubblewrap"})),
    "a parameter that is a list": ("open", data({"when": [1.0]})),
    "a parameter that is a table": ("open", data({"when": {"a": 1.0}})),
    "a parameter without a value": ("open", data({"when": None})),
    "a number for a name": ("open", data({1: 1.0})),
    "control characters in a name": ("open", data({f"when[{ESCAPE}]": 1.0})),
    "a list of 2^32 elements": ("open", answer(Code.DATA, b"\xdd\xff\xff\xff\xff")),
    "a table of 2^32 elements": ("open", answer(Code.DATA, b"\xdf\xff\xff\xff\xff")),
    "a text of 2^32 bytes": ("open", answer(Code.DATA, b"\x81\xa4when\xdb\xff\xff\xff\xff")),
    "lists nested too deep": ("open", answer(Code.DATA, NESTED)),
    "a million empty tables": ("open", answer(Code.DATA, b"\xdd\x00\x0f\x42\x40" + b"\x80" * 1_000_000)),
    "bytes behind the end": ("open", answer(Code.DATA, b"\x80\x80")),
    "a text too few": ("read_texts", data([])),
    "a text too many": ("read_texts", data(["x", "y"])),
    "a number for a text": ("read_texts", data([1.0])),
    "an array of objects for a text": ("read_texts", data([np.array([{}], dtype=object).dumps()])),
    "an answer to a request that asks for none": ("wire", data({"a": 1})),
    "a row of numbers too short": (Code.READ, numbers(code=Code.NUMBERS)),
    "a row of numbers too long": (Code.READ, numbers(1.0, 2.0, code=Code.NUMBERS)),
    "derivatives of another shape": (Code.JACOBIAN, numbers(1.0, 2.0, 3.0, code=Code.NUMBERS)),
    "derivatives as an array of objects": (Code.JACOBIAN, answer(Code.NUMBERS, np.array([{}, {}], dtype=object).dumps())),
    "a state longer than any": (Code.STATE, head(length=LARGEST + 1, code=Code.BYTES)),
    "outputs for a state": (Code.STATE, numbers(NAN, 1.0, 1.0)),
}
COUNTERS = {  # counters are asked for at the end: where the answer is none, they are missing
    "a negative count": data({"steps": -1}),
    "half a step": data({"steps": 0.5}),
    "a list of counters": data([1, 2]),
    "a count for a list": data({"steps": [1]}),
}
HELD_UP = {
    "no answer": (Code.STEP, b"S"),
    "no answer, and a process that keeps the pipes": (Code.STEP, b"L"),
    "an answer in drops": (Code.STEP, b"B"),
    "no reading": (Code.STATE, b"S1"),
    "no reading, and a process that keeps the pipes": (Code.STATE, b"L1"),
}
CUT = {"an end inside the head": b"T5", "an end inside the content": b"T30"}


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """A function that opens a unit whose worker forges one answer."""
    program = tmp_path / "python"
    program.write_text(f"#!{sys.executable} -IS\n" + Path(forged.__file__).read_text())
    program.chmod(0o700)
    units = []

    def open_forged(request, content: bytes, limit: float = 30.0):
        (tmp_path / "answer").write_bytes(content)
        monkeypatch.setenv("FORGED_REQUEST", str(request))
        monkeypatch.setenv("FORGED_ANSWER", str(tmp_path / "answer"))
        unit = {"component": "cosimo.tests.units.troubled:Troubled", "isolation": "process", "time_limit": limit}
        settings = read_scene({"stop_time": 1.0, "master": {"step": 0.1}, "units": {"u": unit}}).units["u"]
        monkeypatch.setattr(sys, "executable", str(program))
        units.append(open_unit("u", settings, in_process=True))
        return units[-1]

    yield open_forged
    for unit in units:
        unit.close()


def used(unit) -> list[float]:
    """All that a run asks a unit for; its outputs."""
    unit.wire(["driven"], ["steps", "process"])
    unit.initialize(0.0, [0.0])
    unit.start()
    read_texts, read = unit.text_reader(["text"]), unit.reader(["other"])
    unit.drive([0.0], None, None, 0.1)
    unit.step(0.0, 0.1)
    unit.get()
    assert (read_texts(), read(), unit.jacobian().tolist(), unit.pack(unit.save())) == (["x"], [1.0], [[1.0], [1.0]], b"state")
    return list(unit.get())


def test_an_honest_worker_is_not_refused(opened):
    unit = opened("nothing", b"")
    assert used(unit) == [1.0, 1.0]
    assert unit.work()["requests"] > 10
    assert unit.parameters() == {}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_answer_is_refused_with_the_name_of_the_unit(name, opened):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises((StepFailed, BadInput), match=REFUSED) as refused:
        used(opened(*FORGED[name]))
    assert "u" in (refused.value.unit if isinstance(refused.value, StepFailed) else refused.value.where)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000  # kB


@pytest.mark.parametrize("name", CUT)
def test_an_answer_that_is_cut_is_the_end_of_the_process(name, opened):
    with pytest.raises(StepFailed, match="its worker process ended itself with code 0"):
        used(opened(Code.STEP, CUT[name]))


@pytest.mark.parametrize("name", COUNTERS)
def test_counters_that_are_none_are_left_out(name, opened):
    unit = opened("work", COUNTERS[name])
    used(unit)
    assert [*unit.work()] == ["requests"]


@pytest.mark.parametrize("name", HELD_UP)
def test_a_conversation_that_is_held_up_ends_at_the_limit_in_both_directions(name, opened):
    request, content = HELD_UP[name]
    unit = opened(request, content, limit=0.5)

    def converse():
        used(unit)
        unit.set_texts(["x" * 1_000_000])  # more than a pipe holds
        unit.get()

    with pytest.raises(StepFailed, match=r"no answer within 0\.5 s; its worker process was ended"):
        converse()
    with pytest.raises(StepFailed, match="its worker process has ended"):
        unit.set_texts(["y"])


def test_the_documentation_states_the_count():
    count = len(FORGED) + len(CUT) + len(COUNTERS) + len(HELD_UP)
    assert f"{count} forged answers" in (ROOT / "docs" / "foreign-files.md").read_text()


@pytest.mark.parametrize(
    ("forgery", "kind"),
    [
        (failed("StepFailed", 0.0, ESCAPE + "\nlog", ESCAPE), StepFailed),
        (failed("BadInput", 0.0, ESCAPE, ESCAPE, ESCAPE, ESCAPE), BadInput),
        (failed("SimulationEnded", 0.05), SimulationEnded),
    ],
)
def test_control_characters_of_a_failure_are_made_visible(forgery, kind, opened):
    with pytest.raises(kind) as error:
        used(opened(Code.STEP, forgery))
    assert str(error.value).replace("\n", "").isprintable()


def test_control_characters_of_warnings_are_made_visible():
    assert read_warnings(packed([Code.GET, b"x", ESCAPE])) == (Code.GET, b"x", [r"\x1b]0;owned\x07\u202e"])


def test_arrays_of_objects_are_not_sent():
    with pytest.raises(TypeError, match="neither number, text, array, list nor mapping"):
        packed([np.array([{}], dtype=object)])
