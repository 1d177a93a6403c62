"""Random bad scenes: whatever is written in the place of whatever setting, there is one message and never a traceback."""

import contextlib
import copy
import io
import json
import re
import warnings
from math import isfinite
from pathlib import Path

import pytest
from cosimo import BadInput, read_scene
from cosimo.components.core.measure import bare_number
from cosimo.orchestrator.cli import main
from cosimo.tests.support import two_masses
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

FULL = {
    "title": "two masses",
    **two_masses("gauss-seidel", 1e-2, 1),
    "connections": [
        "b.force -> a.force",
        "a.x_out -> b.position",
        {"source": "a.v_out", "target": "b.velocity", "factor": 1.0, "offset": 0.0, "convert_units": True},
    ],
    "record": {"signals": ["a.x_out", "b.force"], "interval": 0.1, "snapshots": ["p.profile"], "snapshot_interval": 0.5},
    "faults": [
        {"signal": "a.x_out", "kind": "offset", "value": 0.1, "begin": 0.2, "end": 0.4},
        {"signal": "b.velocity", "kind": "freeze", "begin": 0.5},
        {"unit": "b", "kind": "lost", "begin": 0.9},
    ],
    "sweep": {"a": {"k": {"from": 5.0, "to": 10.0, "points": 2}}, "b.k": [900.0, 1000.0]},
    "analysis": {"transient": 0.1, "section": {"signal": "a.x_out", "angle": "a.v_out", "turns": 2}},
}
FULL["units"] = {**FULL["units"], "p": {"component": "cosimo.tests.support:Probe", "parameters": {"length": 2.0}}}
FULL["master"] = {**FULL["master"], "order": ["b", "a", "p"], "bonds": ["a.v_out * b.force"]}
ITERATED = {
    **FULL,
    "units": two_masses()["units"],
    "record": {},
    "master": {
        "algorithm": "iterative",
        "step": 1e-2,
        "iteration": {"tolerance": 1e-9, "max_iterations": 5, "not_converged": "warn"},
    },
}
CONTROLLED = {
    **two_masses(),
    "master": {
        "algorithm": "jacobi",
        "step": 1e-2,
        "events": ["a.x_out"],
        "bonds": ["a.v_out * b.force"],
        "energy_correction": True,
        "control": {"method": "milne", "relative": 1e-3, "absolute": 1e-3, "min_step": 1e-4, "max_step": 0.1},
    },
}
MACHINE = {
    "stop_time": 1.0,
    "master": {"step": 1e-2},
    "units": {
        "p": {
            "component": "Pantograph",
            "preset": "EN 50318:2018",
            "effects": ["contact_loss"],
            "every": 1,
            "isolation": "none",
            "parameters": {"speed": 50.0},
        },
        "sub.f": {"fmu": "no/such.fmu", "interface": "co-simulation", "solver": "CVode", "tolerance": 1e-6},
    },
    "connections": ["sub.f.height -> p.wire_height"],
    "analysis": {"system": "railway", "window": [0.1, 0.9]},
}
TOUCHING = {
    "stop_time": 0.1,
    "master": {"algorithm": "interface-model", "step": 1e-3},
    "units": {n: {"component": "cosimo.tests.support:Mass", "parameters": {"v0": v}} for n, v in (("a", 1.0), ("b", -1.0))},
    "contacts": [
        {
            "name": "touch",
            "law": "unilateral",
            "stiffness": 1e5,
            "damping": 10.0,
            "clearance": 0.01,
            "leader": "first",
            "first": {"force": "a.force", "position": "a.x_out", "velocity": "a.v_out", "inertia": 1.0, "degree": 1},
            "second": {"force": "b.force", "position": "b.x_out", "velocity": "b.v_out", "inertia": 1.0},
        }
    ],
}
SUBSYSTEM = {
    "stop_time": 1.0,
    "master": {"step": 0.1},
    "connections": ["p.profile[1] -> q.length"],
    "units": {
        "sub": {"scene": "lumped-catenary", "parameters": {"pantograph": {"speed": 50.0}}},
        "p": {"component": "cosimo.tests.support:Probe"},
        "q": {"component": "cosimo.tests.support:Probe"},
    },
}
BASES = [FULL, ITERATED, CONTROLLED, MACHINE, TOUCHING, SUBSYSTEM]
WORDS = [
    "",
    " ",
    ".",
    "a",
    "a.",
    ".a",
    "..",
    "->",
    " -> ",
    "a -> b",
    "a.* -> b.*",
    "*.* -> *.*",
    "b.force -> a.force",
    "a.x_out -> a.force",
    "a.x_out -> b.position -> a.force",
    "a.v_out * b.force",
    "a.v_out*",
    "* * *",
    "a.x_out * a.x_out",
    "sub.f",
    "[",
    "p.profile[",
    "p.profile[9]",
    "p.profile",
    "a\nb",
    "\\",
    "%s {}",
    "\0",
    "jacobi",
    "newton",
    "lost",
    "override",
    "none",
    "nan",
    "../..",
    "/",
    ":",
    "os:path",
    "cosimo.tests.support:",
    ":Mass",
    "cosimo.tests.support:Linear",
    "cosimo.tests.support:math",
    "..:x",
    "components",
    "x" * 300,
]
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.sampled_from([0, -1, 1, 2, 10**400, 0.0, -0.0, 1e-300, 5e-324, 1e300, 0.1, 3.0]),
    st.integers(),
    st.floats(),
    st.sampled_from(WORDS),
    st.text(max_size=8),
)
JUNK = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.one_of(st.sampled_from(WORDS), st.text(max_size=5)), inner, max_size=3)
    ),
    max_leaves=4,
)


def places(data, path=()):
    """Paths of all tables, lists and values."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


@st.composite
def scenes(draw):
    """A scene that was good, with up to three settings replaced, removed, moved elsewhere, or added."""
    data = copy.deepcopy(draw(st.sampled_from(BASES)))
    for _ in range(draw(st.integers(1, 3))):
        paths = list(places(data))
        if not paths:
            break
        *path, last = draw(st.sampled_from(paths))
        table = data
        for key in path:
            table = table[key]
        action = draw(st.sampled_from(["replace", "remove", "add", "move"]))
        if action == "remove":
            del table[last]
            continue
        value = draw(JUNK)
        if action == "move":
            source = draw(st.sampled_from(paths))
            value = data
            for key in source:
                value = value[key]
            value = copy.deepcopy(value)
        if action == "add" and isinstance(table, dict):
            last = draw(st.one_of(st.sampled_from([*WORDS, *map(str, paths[0])]), st.text(max_size=5)))
        table[last] = value
    return data


def check(message: str) -> None:
    assert message.isprintable(), message
    assert not re.search(r"pydantic|Input should|Value error|Traceback|object at 0x|type=|input_value", message), message


@settings(max_examples=200)
@given(scenes())
def test_a_scene_is_read_or_refused_with_one_message(data):
    try:
        read_scene(data, "bad")
    except BadInput as error:
        message = str(error)
    else:
        return
    check(message)
    assert message.startswith("bad")


def toml(value: object) -> str:
    """A value in TOML; tables inline."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(str(k))} = {toml(v)}" for k, v in value.items() if v is not None) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(v) for v in value if v is not None) + "]"
    return json.dumps(value) if isinstance(value, str) else repr(value)


def cosimo(*arguments: object) -> tuple[int, str]:
    """(exit code, what was written to stderr)."""
    with (
        contextlib.redirect_stderr(io.StringIO()) as err,
        contextlib.redirect_stdout(io.StringIO()),
        warnings.catch_warnings(action="ignore"),
        pytest.raises(SystemExit) as end,
    ):
        main([str(a) for a in arguments])
    return end.value.code or 0, err.getvalue()


@pytest.mark.parametrize(
    ("place", "value", "named"),
    [
        ("stop_time", 10**400, "stop_time"),
        ("master.step", 5e-324, "at least 1e-12 s"),
        ("units.a.every", 10**400, "every"),
        ("units.a.parameters.k", 10**400, "parameters"),
        ("sweep.b.k", {"from": 0, "to": 10**400, "points": 3}, "from"),
        ("sweep.b.k", {"from": 0, "to": 1, "points": 10**9}, "points"),
        ("units.p", {"fmu": "x" * 300}, "units.p.fmu"),
        ("units.p", {"fmu": "a\0b"}, "units.p.fmu"),
        ("units.p", {"scene": "x" * 300 + ".toml"}, "name too long"),
        ("master.iteration", {"method": "newton"}, "since 0.8"),
        ("master.smoothing", True, "went with 0.8"),
        ("master.control", {"method": "energy"}, "'milne' or 'doubling'"),
        ("connections", [{"source": "b.force"}], "connections[1].target"),
        ("connections", [5], "or a table"),
        ("faults", [{"signal": "a.x_out", "kind": "offset", "value": "1"}], "faults[1].value"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_numbers_and_names_that_nothing_can_hold(place, value, named):
    data = copy.deepcopy(FULL)
    *path, last = place.split(".", 3) if not place.startswith("sweep") else place.split(".", 1)
    table = data
    for key in path:
        table = table[key]
    table[last] = value
    with pytest.raises(BadInput) as caught:
        read_scene(data, "bad", Path.cwd())
    assert named in str(caught.value)
    check(str(caught.value))
    assert len(str(caught.value)) < 1000


# The same examples each time: a dry run takes steps of the scene, which may hold any number of internal steps.
@settings(max_examples=30, derandomize=True, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(scenes())
def test_the_command_line_has_an_exit_code_and_one_message_for_each(tmp_path, data):
    """A scene that is still good is shown without being run, which takes up to fifty of its steps."""
    path = tmp_path / "random.toml"
    path.write_text(
        "\n".join(f"{json.dumps(str(k))} = {toml(v)}" for k, v in data.items() if v is not None),
        encoding="utf-8",
        errors="surrogatepass",
    )
    shown(path)


def shown(path: Path, *options: str) -> None:
    """Show a scene without running it: an exit code, and one message where that is not 0."""
    code, err = cosimo("run", path, "--in-process", "--dry-run", *options)
    lines = err.splitlines()
    assert code in (0, 2, 3), err
    assert all(line.startswith("cosimo: ") for line in lines), err
    assert len([line for line in lines if not line.startswith("cosimo: warning: ")]) == (code != 0), err
    check(" ".join(lines))


OPTIONS = ["--set", "--effects", "--record", "--algorithm", "--step", "--stop"]
MORE_WORDS = [
    "a.k=",
    "a.k=nan",
    "a.k=1e999",
    "a.k=" + "9" * 400,
    "=1",
    "a.=1",
    ".k=1",
    "a.k.x=1",
    "analysis=1",
    "analysis.transient=x",
    "a.x_out,b.force",
    "a.x_out,",
    ",",
    "p.profile[1,2]",
    "p.none",
    "a.none,p.none",
    "1e-400",
    "0x10",
]
TEXTS = st.one_of(st.sampled_from(WORDS + MORE_WORDS), st.text(max_size=8), st.floats().map(str)).filter(
    lambda text: "\0" not in text and not text.startswith("-")
)  # which no shell can hand over, or which name options


@settings(max_examples=30, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.sampled_from(OPTIONS), TEXTS), min_size=1, max_size=3))
def test_options_of_anything_are_taken_or_refused_with_one_message(tmp_path, options):
    path = tmp_path / "good.toml"
    path.write_text("\n".join(f"{key} = {toml(value)}" for key, value in FULL.items()))
    numbers = [(o, v) for o, v in options if o not in ("--step", "--stop") or is_number(v)]  # else a message of the parser's own
    shown(path, *(text for pair in numbers for text in pair))


def is_number(text: str) -> bool:
    try:
        return isfinite(bare_number(text))
    except ValueError:
        return False


@settings(max_examples=50, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(st.one_of(st.binary(max_size=60), st.text(max_size=60).map(lambda s: s.encode("utf-8", "surrogatepass"))))
def test_a_file_of_anything_is_refused_with_one_message(tmp_path, content):
    path = tmp_path / "anything.toml"
    path.write_bytes(content)
    code, err = cosimo("run", path, "--dry-run")
    assert code == 2
    assert err.count("\n") == 1
    check(err.strip())
