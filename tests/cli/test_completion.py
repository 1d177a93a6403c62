"""What a shell completes, through the scripts of Typer."""

import shutil
import subprocess
import sys

import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.cli.application import app
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import NAMES, cases


@pytest.fixture
def offers(monkeypatch, capsys):
    """What bash gets for words behind `cosimo`, of which the last one is incomplete."""

    def ask(*words: str) -> list[str]:
        line = " ".join(["cosimo", *words])
        for key, value in {"_COSIMO_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words))}.items():
            monkeypatch.setenv(key, value)
        with pytest.raises(SystemExit):
            app([], prog_name="cosimo")
        return capsys.readouterr().out.split()

    return ask


def test_names_of_everything(offers):
    assert set(offers("build", "")) == set(CATALOGUE)
    assert set(scene_files()) <= set(offers("run", ""))
    assert set(offers("list", "")) == {"components", "fmus", "scenes", "cases", *NAMES}
    offered = set(offers("validate", ""))
    assert offered <= {"papers", *cases()}
    assert len(offered) > 40
    assert {"Pantograph", "en50318-2002"} <= set(offers("show", ""))
    assert offers("ru") == ["run"]
    assert "--step" in offers("run", "en50318-2002", "--st")


def test_parameters_effects_and_presets_of_a_scene(offers, tmp_path):
    assert offers("run", "en50318-2002", "--set", "pantograph.bump") == [
        "pantograph.bump_stops.stiffness=",
        "pantograph.bump_stops.travel=",
    ]
    assert offers("run", "--in-process", "en50318-2002", "--effects", "pantograph.bu") == ["pantograph.bump_stops"]
    assert offers("run", "--stop", "2", "en50318-2002", "--preset", "pantograph=DSA2") == ["pantograph=DSA250"]
    own = tmp_path / "own.toml"
    own.write_text('units.p.component = "Pantograph"\n')
    assert "p.speed=" in offers("run", str(own), "--set", "p.")
    assert offers("run", str(tmp_path / "missing.toml"), "--set", "p") == []


def test_scene_files_are_offered(offers, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "mill").mkdir()
    (tmp_path / "mill" / "a.ssp").touch()
    assert offers("run", "mi") == ["mill/", "mine.toml"]
    assert offers("run", "./mi") == ["./mill/", "./mine.toml"]
    assert offers("run", "mill/") == ["mill/a.ssp"]


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_a_shell_gets_its_completions_without_the_compiler():
    """As a key press calls it; scenes are listed without Numba and SciPy."""
    code = (
        "import atexit, sys; sys.argv[0] = 'cosimo'; from cosimo.orchestrator.cli import main\n"
        "atexit.register(lambda: print(*{m.split('.')[0] for m in sys.modules}, file=sys.stderr)); main()"
    )
    script = (
        f'cosimo() {{ {sys.executable} -c "{code}" "$@"; }}\n'
        "COMP_WORDS=(cosimo run en50318-2002-int); COMP_CWORD=2\n"
        'COMPREPLY=( $( env_words="${COMP_WORDS[*]}"; COMP_WORDS="$env_words" COMP_CWORD=$COMP_CWORD '
        '_COSIMO_COMPLETE=complete_bash cosimo ) )\necho "${COMPREPLY[@]}"'
    )
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["en50318-2002-interface-model"], done.stderr
    assert set(done.stderr.split()) & {"numba", "scipy", "plotly", "pandas"} == set()
