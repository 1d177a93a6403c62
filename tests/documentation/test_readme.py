"""What README and documentation show works as it stands: commands in their order, Python, scenes, links.

The lines that install, the first command behind them and the one that starts this suite are left to .ci/run, which runs exactly
them. A command that several pages show is run once. One that only runs a shipped scene, with the options that the README has, or
validates shipped cases, is left to tests/systems/test_as_shipped.py, which does so with all scenes and cases by their commands, and the
page of the railway to tests/harness/explore/test_explore_page.py.

Commands of the README run in a shell, those of the other pages in this process, where the libraries and the kernels are loaded once:
a process of its own for each of a hundred takes half a second to start and as much to load kernels.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import cases, load_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.short_run import full_but

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
GENERATED = ROOT / "docs" / "generated"  # by a build of the site, from the declarations
PAGES = sorted(p for p in (ROOT / "docs").rglob("*.md") if not p.is_relative_to(GENERATED))
NEED_ZIG = ("cosimo explore", "wasm32", "fmi3.fmu give-away")  # parts of commands that make or unpack WebAssembly
BY_CI = ("pip install .", "cosimo validate en50318-2002", 'pip install -e ".[test]"', "pytest")


def name_of(page: Path) -> str:
    """Of a page, below the root."""
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path, language: str) -> list[str]:
    """A page's code blocks in a language, in their order."""
    text = page.read_text(encoding="utf-8")
    return [code for name, code in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL) if name == language]


def commands(page: Path) -> list[str]:
    """The lines of the bash blocks, without remarks behind "  #"; a line that ends in a backslash goes on in the next."""
    text = "".join(blocks(page, "bash")).replace("\\\n", " ")
    return [line for raw in text.splitlines() if (line := re.sub(r"(^|\s\s)#.*", "", raw).strip())]


def shown(language: str) -> list:
    """All blocks in a language: those of the README in every run, those of the other pages in the complete one."""
    of_pages = [
        pytest.param(code, id=f"{name_of(page)}-{k}", marks=pytest.mark.full)
        for page in PAGES
        for k, code in enumerate(blocks(page, language))
    ]
    return [*(pytest.param(code, id=f"README.md-{k}") for k, code in enumerate(blocks(README, language))), *of_pages]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """One working directory for all commands of a page: later ones use what earlier ones have written."""
    made: dict[str, Path] = {}
    return lambda page: made.setdefault(page, tmp_path_factory.mktemp("page"))


def shell(command: list[str] | str, folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """The command as a reader runs it, with this environment's programs; `more`: of the environment."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return subprocess.run(
        command,
        shell=isinstance(command, str),
        cwd=folder,
        env={**os.environ, "PATH": path, **more},
        capture_output=True,
        text=True,
        timeout=600,
    )


def test_the_readme_shows_commands_python_and_a_scene():
    assert len(README.read_text(encoding="utf-8").splitlines()) < 200
    assert sum(c.startswith("cosimo ") for c in commands(README)) >= 3
    assert blocks(README, "python")
    assert any("[master]" in text for text in blocks(README, "toml"))
    assert set(BY_CI) <= set(commands(README))
    assert commands(README)[:2] == [*BY_CI[:2]]  # and .ci/run tries the second one as a user
    assert f"\n    {BY_CI[1]}\n" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def shown_commands() -> list[tuple[str, str]]:
    """(page, command) of all that is run: a command where it is shown first."""
    first: dict[str, str] = {}
    for page in (README, *PAGES):
        for command in commands(page):
            first.setdefault(command, name_of(page))
    return [
        (page, command)
        for command, page in first.items()
        if command not in BY_CI and not (page != README.name and elsewhere(command))
    ]


def elsewhere(command: str) -> bool:
    """Whether a command does nothing but what another test has it do."""
    shipped = {
        r"cosimo run ([\w-]+) --in-process(?: -o out)?": scene_files(),
        r"cosimo validate ([\w-]+(?: [\w-]+)*) -o out": cases(),
        r"cosimo explore ([\w-]+) -o \S+": ["en50318-2002"],
    }
    return any((plain := re.fullmatch(form, command)) and {*plain[1].split()} <= {*names} for form, names in shipped.items())


def of_cosimo(page: str, command: str) -> list[str]:
    """The arguments of a command that needs no shell and no process of its own, else none."""
    if page == README.name or not command.startswith("cosimo ") or command.startswith("cosimo cache"):
        return []
    words = shlex.shlex(command, posix=True, punctuation_chars=True)
    words.whitespace_split = True  # `a=b` is a word, `;` and `>` are words of their own unless quoted
    words = list(words)
    plain = words == shlex.split(command, comments=True) and not re.search(r"[$`*?]", command)
    assert plain, f"{command}: a shell does more with it than to part words"
    return words[1:]


@pytest.mark.parametrize(("page", "command"), full_but([(name_of(README), "cosimo list")], shown_commands()))
def test_commands(page, command, folders, monkeypatch, capsys):
    if any(word in command for word in NEED_ZIG) and find_spec("ziglang") is None:
        pytest.skip("zig is not installed (extra 'native')")
    if arguments := of_cosimo(page, command):
        monkeypatch.chdir(folders(page))
        monkeypatch.setattr(sys, "path", [*sys.path])  # a command adds its working directory
        code = exit_code(*arguments)
        printed, errors = capsys.readouterr()
    else:
        own = {"COSIMO_CACHE": str(folders(page) / "cache")} if command.startswith("cosimo cache") else {}  # not what others use
        done = shell(command, folders(page), **own)
        code, printed, errors = done.returncode, done.stdout, done.stderr
    assert code == 0, printed + errors
    assert "Traceback" not in errors
    for option in re.findall(r"(?:-o|--output|--output-file) (\S+)", command):
        assert (folders(page) / option).exists()


@pytest.mark.parametrize("source", shown("python"))
def test_python(source, tmp_path):
    if "import control" in source and find_spec("control") is None:
        pytest.skip("python-control is not installed (extra 'control')")
    if "--native" in source and find_spec("ziglang") is None:
        pytest.skip("zig is not installed (extra 'native')")
    done = shell([sys.executable, "-c", source], tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("text", shown("toml"))
def test_scenes(text, tmp_path):
    """Every piece is TOML, and a whole scene runs."""
    if not {"stop_time", "units", "master"} <= tomllib.loads(text).keys():
        return
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    assert run(scene.with_changes({"stop_time": 0.1}), in_process=True).outcome == "done"


@pytest.mark.parametrize("page", [README, *PAGES], ids=name_of)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    here = [page.parent / link for link in links]
    assert [str(p) for p in here if not p.exists() and not p.resolve().is_relative_to(GENERATED)] == []


@pytest.mark.parametrize("page", [p for p in PAGES if p != ROOT / "docs" / "index.md"], ids=name_of)
def test_every_page_is_reached_from_the_index(page):
    indices = [ROOT / "docs" / "index.md", *({page.parent / "index.md"} - {page})]  # a folder may have its own
    assert any(
        f"({page.relative_to(index.parent).as_posix()})" in index.read_text(encoding="utf-8")
        for index in indices
        if index.is_file() and page.is_relative_to(index.parent)
    )


def test_every_scene_and_component_is_in_the_documentation_of_its_system():
    """As an entry of a table of the page that has the system's name; motors that several systems use on any page."""
    pages = {page.stem: page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "systems").glob("*.md")}
    everywhere = "".join(pages.values())
    scenes = [(file.parent.parent.name, name) for name, file in scene_files().items()]
    components = [(component_class(name).system, name) for name in CATALOGUE]
    missing = [
        f"docs/systems/{s}.md: no row | `{n}` |" for s, n in scenes + components if f"| `{n}` |" not in pages.get(s, everywhere)
    ]
    assert missing == []
    table = README.read_text(encoding="utf-8")
    assert [s for s in pages if f"(docs/systems/{s}.md)" not in table] == []
    assert {s for s, _ in scenes} <= pages.keys()
