"""Files of a project that are given to a command of another kind: what they are, and which command reads them."""

from itertools import product
from pathlib import Path

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator import systems
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.many.limits import table_of
from cosimo.orchestrator.harness.many.plan import plan_settings
from cosimo.orchestrator.scene.file_kinds import FILE_KINDS, file_kind
from cosimo.orchestrator.systems.railway import line
from cosimo.tests.commands import exit_code

FILES = {
    "scene.toml": ("scene", "stop_time = 1.0\n[units.a]\n"),
    "line.toml": ("line", "[[sections]]\nspans = [50.0]\n"),
    "case.toml": ("case", 'title = "t"\nscene = "s.toml"\n'),
    "limits.toml": ("table", '[sources]\ns = "t"\n'),
    "plan.toml": ("plan", '[vary]\n"a.b" = [1.0]\n'),
    "fit.toml": ("fit", "[vary]\n[[targets]]\n"),
    "runs.toml": ("fit", "[vary]\n[[runs]]\n"),
    "design.toml": ("design", 'minimise = "a"\n'),
    "droppers.csv": ("CSV", "position [m]\n1\n"),
    "results": ("result", None),
}
READERS = {
    "scene": systems.load_scene,
    "case": lambda path: systems.validate([path], "out"),
    "table": table_of,
    "plan": plan_settings,
    "fit": lambda path: fit(systems.load_scene("mass-on-spring"), path),
    "design": lambda path: design(systems.load_scene("mass-on-spring"), path),
    "line": lambda path: line.read(Path(path), {}),
}
FALL_THROUGH = {("plan", "fit"), ("plan", "design"), ("case", "table")}  # read as such, and refused by what they say


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (_, text) in FILES.items():
        if text is not None:
            (tmp_path / name).write_text(text)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "run.json").write_text("{}")
    return tmp_path


def test_each_kind_is_recognised_and_named_by_every_reader_of_another(folder):
    for (name, (kind, _)), (wanted, read) in product(FILES.items(), READERS.items()):
        assert file_kind(folder / name) == kind
        if kind != wanted and (kind, wanted) not in FALL_THROUGH:
            with pytest.raises(BadInput) as raised:
                read(name)
            message = raised.value
            assert (message.actual, message.expected.partition(" or ")[0]) == (FILE_KINDS[kind][0], FILE_KINDS[wanted][0]), (
                name,
                wanted,
            )
            assert FILE_KINDS[kind][1] in message.remedy


@pytest.mark.parametrize(
    ("command", "name"), [("run", "line.toml"), ("show", "results"), ("check", "plan.toml"), ("open", "case.toml")]
)
def test_commands_say_which_one_reads_it(folder, capsys, command, name):
    assert exit_code(command, name) == 2
    assert FILE_KINDS[FILES[name][0]][1] in capsys.readouterr().err
