"""The commands as tools of the Model Context Protocol, for programs that write and run scenes by themselves."""

from __future__ import annotations

import json
import re
import shlex
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from .common import BAD_INPUT, FAILED_CHECK, FAILED_RUN, app

if TYPE_CHECKING:
    from mcp.server import MCPServer

MEANINGS = {
    0: "done",
    FAILED_CHECK: "a check or a validation failed",
    BAD_INPUT: "bad input: nothing was run",
    FAILED_RUN: "the simulation failed or became unstable, or the disk is full; the partial result is kept",
}
REFUSAL = re.compile(
    r"^cosimo: (?!warning: )(?P<place>.+?): got (?P<got>.+?), expected (?P<expected>.+?)\.(?: (?P<remedy>.*))?$", re.M
)
HELP = """Physical components as FMUs, coupled simulations of them, and validation against published tables.
Begin with `list_names` and `show`; change a shipped scene with `values`, or write one with `new_scene`, then `run` it.
A bare number is SI; "250 km/h" has its unit. Each figure has its numerical error: compare differences with it.
Every answer has the exit code, what it means, and for bad input what was expected and what to do."""


@app.command()
def agents(
    folder: Annotated[Path, Option("--folder", help="Directory in which commands run and files are written.")] = Path(),
) -> None:
    """Serve the commands to a program by the Model Context Protocol on standard input and output. Example: cosimo agents --folder work

    Needs the extra `agents`. Tools: list_names, show, scene_schema, new_scene, run, validate, command.
    """
    from ..output import ensure_directory

    server_in(ensure_directory(folder)).run("stdio")


def server_in(folder: Path) -> MCPServer:
    """The server, whose commands run in a directory. Raises `BadInput` where the library is missing."""
    from ..views.data import library

    server = library("mcp.server", "agents", "mcp").MCPServer("cosimo", instructions=HELP)

    async def answer(*arguments: str) -> dict[str, Any]:
        from anyio import run_process

        done = await run_process([sys.executable, "-m", __package__, *arguments], cwd=folder, check=False, input=b"")
        return read(arguments, done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace"))

    @server.tool()
    async def list_names(what: str = "") -> dict[str, Any]:
        """Names and titles of components, fmus, scenes and cases; what: one of these kinds, a system, or a word of a title."""
        return await answer("list", *([what] if what else []), "--json")

    @server.tool()
    async def show(name: str) -> dict[str, Any]:
        """All variables, effects and presets of a component; units and connections of a scene; what a case compares."""
        return await answer("show", name, "--json")

    @server.tool()
    async def scene_schema() -> dict[str, Any]:
        """The JSON schema of a scene file (TOML)."""
        return await answer("schema")

    @server.tool()
    async def new_scene(file: str, components: list[str] | None = None, copy_of: str = "") -> dict[str, Any]:
        """Write a scene file that runs, its units joined by their ports, or a copy of a shipped scene; returns its text.

        file: a new name that ends in .toml. Give either components or copy_of.
        """
        done = await answer("new", "scene", file, *(components or []), *(["--from", copy_of] if copy_of else []))
        if done["exit_code"] == 0:
            done["text"] = (folder / file).read_text(encoding="utf-8")
        return done

    @server.tool()
    async def run(
        scene: str, output: str, values: dict[str, float | str] | None = None, stop: str = "", limits: str = ""
    ) -> dict[str, Any]:
        """Run a scene (a name or a file) with an error estimate, and return its figures with errors; the printed table has the signals.

        output: directory for results and report.  values: unit.parameter -> value.  stop: end of the run, s or with a unit.
        limits: a table that judges the run, such as en50367.
        """
        sets = [part for name, value in (values or {}).items() for part in ("--set", f"{name}={value}")]
        options = [part for name, value in (("--stop", stop), ("--limits", limits)) if value for part in (name, value)]
        done = await answer("run", scene, "--in-process", "-o", output, *sets, *options)
        with suppress(OSError, ValueError):  # a scene without figures, or nothing was run: the printed table has the signals
            done["summary"] = {}
            if done["exit_code"] != BAD_INPUT:
                done["summary"] = json.loads((folder / output / "summary.json").read_bytes())
        return done

    @server.tool()
    async def validate(cases: list[str], output: str) -> dict[str, Any]:
        """Compare cases (names or files) with their tables: each row with limits, error, standing and source."""
        return await answer("validate", *cases, "-o", output, "--json")

    @server.tool()
    async def command(line: str) -> dict[str, Any]:
        """Any other command line of cosimo, as in its documentation: "cosimo gradient SCENE --of FIGURE -o out", "cosimo run --help"."""
        return await answer(*shlex.split(line.strip().removeprefix("cosimo ")))

    return server


def read(arguments: tuple[str, ...], code: int, out: str, messages: str) -> dict[str, Any]:
    """The answer of a command: exit code with its meaning, what was printed, and of a refusal its parts."""
    response: dict[str, Any] = {
        "command": shlex.join(["cosimo", *arguments]),
        "exit_code": code,
        "meaning": MEANINGS.get(code, "stopped"),
        "messages": messages.splitlines(),
    }
    if match := REFUSAL.search(messages):
        response["refusal"] = match.groupdict("")
    try:
        response["printed"] = json.loads(out)
    except ValueError:
        response["printed"] = out
    return response
