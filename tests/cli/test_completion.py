"""What a shell completes, and that it does so without importing components or Typer."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from itertools import pairwise

import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.cli import completion, completion_sources, main
from cosimo.orchestrator.cli.application import app
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.tests.architecture.test_light_imports import HEAVY


@pytest.fixture(scope="module")
def made():
    return completion_sources.names(), completion_sources.commands()


@pytest.fixture
def names(made, tmp_path, monkeypatch):
    """Names of the catalogue, with all answers kept in a cache of its own."""
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))
    completion.keep(*made)
    return made[0]


def question(shell, *words):
    """What the script of a shell sets: words behind `cosimo`, the last one incomplete."""
    line = " ".join(["cosimo", *words])
    return {"_COSIMO_COMPLETE": f"complete_{shell}", "COMP_WORDS": line, "COMP_CWORD": str(len(words)),
            "_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args",
            "_TYPER_COMPLETE_WORD_TO_COMPLETE": words[-1]}


def test_names_of_everything(names):
    assert set(names["components"]) == set(CATALOGUE)
    assert set(names["scenes"]) == set(scene_files())
    assert completion.components("Pan") == ["Pantograph"]
    assert "en50318-2002" in completion.scenes("en50")
    assert completion.kinds_and_systems("ro") == ["rotor", "rov"]


def test_parameters_effects_and_presets_of_a_scene(names, tmp_path):
    assert completion.parameters(["en50318-2002"], "pantograph.bump") == [
        "pantograph.bump_stops.stiffness=", "pantograph.bump_stops.travel="]
    assert [*completion.offers(["run", "--in-process", "en50318-2002", "--effects"], "pantograph.bu")] == [
        "pantograph.bump_stops"]
    assert [*completion.offers(["run", "--stop", "2", "en50318-2002"], "--preset=pantograph=DSA2")] == ["pantograph=DSA250"]
    assert [*completion.offers(["run", "en50318-2002", "--preset", "="], "pantograph=DSA2")] == ["pantograph=DSA250"]
    assert completion.presets(["Pantograph"], "DSA2") == ["DSA250"]
    own = tmp_path / "own.toml"
    own.write_text('units.p.component = "Pantograph"\n')
    assert "p.speed=" in completion.parameters([str(own)], "p.")
    assert completion.parameters([str(tmp_path / "missing.toml")], "p") == []


def test_scene_files_are_offered(names, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "mill").mkdir()
    (tmp_path / "mill" / "a.ssp").touch()
    assert completion.scenes("mi") == ["mill/", "mine.toml"]
    assert completion.scenes("./mi") == ["./mill/", "./mine.toml"]
    assert completion.scenes("mill/") == ["mill/a.ssp"]


@pytest.mark.parametrize("words", [
    ("ru",), ("run", "en50"), ("run", "--set", "a.b=1", "--s"), ("run", "--step", "1", "--s"), ("run", "a", ""),
    ("run", "a", "--step", ""), ("run", "--", "en5"), ("--",), ("railway", ""), ("railway", "line", "--"),
    ("stability", "a", "b", "en50318-2002-int"), ("nonsense", "")])
def test_the_quick_answer_is_that_of_typer(words, names, monkeypatch, capsys):
    """Typer answers from the commands themselves, which takes it half a second."""
    for key, value in question("bash", *words).items():
        monkeypatch.setenv(key, value)
    main()
    ours = capsys.readouterr().out
    with pytest.raises(SystemExit):
        app([], prog_name="cosimo")
    assert ours == capsys.readouterr().out


@pytest.mark.parametrize(("shell", "words", "answer"), [
    ("zsh", ("run", "--pre"), """_arguments '*: :(("--preset":"Published parameters of a scene''s component, instead"""),
    ("zsh", ("list", "ro"), """_arguments '*: :(("rotor"\n"rov"))'\n"""),
    ("zsh", ("list", "nothing"), "_files\n"),
    ("fish", ("sch",), "schema\tThe JSON schema of scene files"), ("fish", ("list", "ro"), "rotor\nrov\n"),
    ("powershell", ("sch",), "schema:::The JSON schema of scene files"), ("pwsh", ("list", "ro"), "rotor::: \nrov::: \n"),
])
def test_formats_of_other_shells(shell, words, answer, names, monkeypatch, capsys):
    """Those that the scripts of Typer take apart."""
    for key, value in question(shell, *words).items():
        monkeypatch.setenv(key, value)
    main()
    assert capsys.readouterr().out.startswith(answer)


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_a_shell_gets_its_completions(names):
    """The installed script of Typer in a real bash, as a key press calls it."""
    code = "from cosimo.orchestrator.cli import main; main()"
    script = (f'cosimo() {{ {sys.executable} -c "{code}" "$@"; }}\n'
              'COMP_WORDS=(cosimo run en50318-2002 --set pantograph.bump); COMP_CWORD=4\n'
              'COMPREPLY=( $( env_words="${COMP_WORDS[*]}"; COMP_WORDS="$env_words" COMP_CWORD=$COMP_CWORD '
              '_COSIMO_COMPLETE=complete_bash cosimo ) )\necho "${COMPREPLY[@]}"')
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["pantograph.bump_stops.stiffness=", "pantograph.bump_stops.travel="], done.stderr


def test_kept_answers_import_neither_components_nor_typer(names):
    code = ("import sys\nfrom cosimo.orchestrator.cli import main\nmain()\n"
            "print(*{m.split('.')[0] for m in sys.modules}, file=sys.stderr)\n"
            "print(*(m for m in sys.modules if m.startswith('cosimo.')), file=sys.stderr)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True,
                          env={**os.environ, **question("bash", "run", "en50318-2002", "--set", "pantograph.bump")})
    assert done.stdout.split() == ["pantograph.bump_stops.stiffness=", "pantograph.bump_stops.travel="]
    modules = set(done.stderr.split())
    assert modules & (HEAVY | {"typer", "logging"}) == set()
    assert {m for m in modules if m.startswith("cosimo.")} == {
        "cosimo.orchestrator", "cosimo.orchestrator.cli", "cosimo.orchestrator.cli.completion", "cosimo.components",
        "cosimo.components.core", "cosimo.components.core.folders"}


def test_answers_are_made_anew_after_a_change(tmp_path, monkeypatch):
    """Of what is written, of a file that comes, and of one whose old time of change is put back."""
    for source in completion.SOURCES:
        (tmp_path / source / "deeper").mkdir(parents=True)
    monkeypatch.setattr(completion, "ROOT", str(tmp_path))
    file = tmp_path / "components" / "deeper" / "a.py"
    file.write_text("x = 1\n")
    states = [completion._state()]
    before = file.stat()
    file.write_text("x = 2\n")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    states.append(completion._state())
    (tmp_path / "orchestrator" / "systems" / "new.toml").touch()
    states.append(completion._state())
    file.unlink()
    states.append(completion._state())
    assert all(a != b for a, b in pairwise(states))
    assert completion._state() == states[-1]


@pytest.mark.parametrize("damage", ["{", "[]", '{"state": ["of another version"], "names": {}, "commands": {}}'])
def test_damage_and_other_versions_heal(damage, names, made, tmp_path, monkeypatch, capsys):
    (kept,) = (tmp_path / "cache" / "completion").iterdir()
    whole = kept.read_text()
    kept.write_text(damage)
    assert not completion.is_current()
    monkeypatch.setattr(completion_sources, "names", lambda: made[0])
    for key, value in question("bash", "list", "ro").items():
        monkeypatch.setenv(key, value)
    main()
    assert capsys.readouterr().out.split() == ["rotor", "rov"]
    assert [*(tmp_path / "cache" / "completion").iterdir()] == [kept]
    assert kept.read_text() == whole


def test_a_cache_that_cannot_be_written_costs_time_only(names, made, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "file" / "below"))
    assert not completion.is_current()
    completion.keep(*made)
    assert completion.kinds_and_systems("ro") == ["rotor", "rov"]
