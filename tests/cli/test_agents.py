"""The commands as tools of the Model Context Protocol: a client of the protocol's own library calls each of them."""

from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path

import pytest
from cosimo import BadInput
from cosimo.orchestrator.cli import agents

mcp = pytest.importorskip("mcp")
RECIPES = re.findall(
    r"^- .*: `cosimo (.*)`$", (Path(__file__).parents[2] / "docs" / "llms.txt").read_text(encoding="utf-8"), re.M
)


def told(folder, *calls):
    """Answers of a server to tools with their arguments, one after the other."""

    async def ask():
        async with mcp.Client(agents.server_in(folder)) as client:
            return [(await client.call_tool(name, arguments)).structured_content for name, arguments in calls]

    return asyncio.run(ask())


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    folder = tmp_path_factory.mktemp("agent")
    run = {"scene": "spring.toml", "output": "out", "values": {"spring.stiffness": 100.0}, "stop": "200 ms"}
    wrong = {"scene": "spring.toml", "output": "none", "values": {"spring.stifness": 1.0}}
    listed, scene, done, refused, line = told(
        folder,
        ("list_names", {"what": "scenes"}),
        ("new_scene", {"file": "spring.toml", "copy_of": "mass-on-spring"}),
        ("run", run),
        ("run", wrong),
        ("command", {"line": "cosimo show nobody --json"}),
    )
    return folder, listed, scene, done, refused, line


def test_a_scene_is_found_copied_and_run_with_errors(answers):
    folder, listed, scene, done, *_ = answers
    assert "mass-on-spring" in {entry["name"] for entry in listed["printed"]["scenes"]}
    assert scene["text"] == (folder / "spring.toml").read_text(encoding="utf-8")
    assert (done["exit_code"], done["meaning"]) == (0, "done")
    assert re.search(r"mass\.base_x .* mm .* 0\.\d+ %", done["printed"])  # with its error
    assert done["summary"] == {}
    assert (folder / "out" / "report.html").is_file()


def test_bad_input_says_what_to_do_and_runs_nothing(answers):
    folder, *_, refused, line = answers
    assert refused["exit_code"] == 2
    assert refused["refusal"] == {
        "place": "spring: spring",
        "got": "variable 'stifness'",
        "expected": "a variable of CompliantJoint",
        "remedy": "Did you mean 'stiffness'?",
    }
    assert not (folder / "none").exists()
    assert line["refusal"]["expected"] == "a component, a scene or a case"


def test_tools_of_the_protocol_have_texts_and_types(tmp_path):
    async def tools():
        async with mcp.Client(agents.server_in(tmp_path)) as client:
            return (await client.list_tools()).tools

    listed = {tool.name: tool for tool in asyncio.run(tools())}
    assert set(listed) == {"list_names", "show", "scene_schema", "new_scene", "run", "validate", "command"}
    assert all(tool.description for tool in listed.values())
    assert listed["run"].input_schema["required"] == ["scene", "output"]


@pytest.mark.full
def test_another_process_serves_on_standard_output(tmp_path):
    async def ask():
        server = mcp.StdioServerParameters(
            command=sys.executable, args=["-m", "cosimo.orchestrator.cli", "agents", "--folder", str(tmp_path)]
        )
        async with mcp.Client(server) as client:
            run = {"scene": "friction-drive-step", "output": "step", "stop": "0.1"}
            cases = {"cases": ["catenary-statics"], "output": "out"}
            return [(await client.call_tool(*call)).structured_content for call in (("run", run), ("validate", cases))]

    done, answer = asyncio.run(ask())
    figures = [row for row in done["summary"].values() if isinstance(row, dict) and "value" in row]
    assert figures
    assert any(row["error"] is not None for row in figures)
    assert answer["printed"]["cases"][0]["outcome"] == "passed"
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.full
def test_the_recipes_for_programs_are_command_lines_of_the_tool(tmp_path):
    """Each is run as a page's command by tests/documentation; here: that the tool takes its words as a shell does."""
    assert len(RECIPES) > 10
    quick = [line for line in RECIPES if line.startswith(("run en50318-2002 --dry-run", "new scene"))]
    for line, answer in zip(quick, told(tmp_path, *(("command", {"line": f"cosimo {line}"}) for line in quick)), strict=True):
        assert answer["exit_code"] == 0, line
    assert (tmp_path / "my-scene.toml").is_file()


def test_a_missing_library_is_one_message(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mcp.server", None)
    with pytest.raises(BadInput, match=r"agents: got no mcp in this Python, expected .* pip install mcp"):
        agents.server_in(tmp_path)
