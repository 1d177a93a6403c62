"""Keys of kept results: a change of whatever a result depends on gives another key, and no other change does."""

import importlib
import sys
import warnings
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus import build
from cosimo.orchestrator import code_digests
from cosimo.orchestrator.harness.journal import Journal
from cosimo.orchestrator.harness.many.measures import Task
from cosimo.orchestrator.harness.studies import chosen, fronts
from cosimo.orchestrator.harness.validation.repeated import mesh_place
from cosimo.orchestrator.judgement import mesh
from cosimo.orchestrator.run import checkpoint, dependence
from cosimo.orchestrator.settings import SceneSettings
from cosimo.orchestrator.settings.plan import KeepSettings, RowsSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import Mass, two_masses

KEYS = {  # of every kind of kept result of a scene, where it is kept
    "checkpoint": lambda scene: checkpoint.header(scene, SimpleNamespace(nodes=()))["digest"],
    "piece": lambda scene: Journal.place(SimpleNamespace(_folder="study"), "trial", scene).file.name,
    "mesh": lambda scene: mesh.kept_errors(scene).file.name,
    "case": lambda scene: mesh_place(SimpleNamespace(name="case"), [scene], [1.0]).file.name,
    "points": lambda scene: Task.of(scene, KeepSettings(), None).base,
    "effects": lambda scene: chosen.kept_choice(scene, 0.01).file.name,
    "front": lambda scene: fronts.kept_front(scene).file.name,
}
ALL = {*KEYS}
FIGURES = {"mesh", "case", "points", "effects", "front"}  # what is computed from rows
SETTINGS = ALL - {"front"}  # which compares them
FILES = {
    "a.fmu": "an FMU",
    "limits.toml": 'title = "Limits"\nmeasures = "own_measures:measured"\nrows = "rows.csv"',
    "rows.csv": "quantity,measure",
    "own_measures.py": "def measured(result): ...",
}
CHANGES = {  # key of a scene -> (another value, the kinds of results that it changes)
    "title": ("Another name of the same", set()),
    "start_time": (0.25, ALL),
    "stop_time": (0.5, ALL),
    "connections": (["b.force -> a.force", "a.x_out -> b.position"], ALL),
    "units.a.component": ("cosimo.tests.run.test_dependence:OtherMass", ALL),
    "units.a.fmu": ("other.fmu", ALL),
    "units.a.signals": ("other.csv", set()),  # its component has the digest of the table in its name
    "units.a.interpolation": ("hold", ALL),
    "units.a.outside": ("hold", ALL),
    "units.a.start": (1.0, ALL),
    "units.a.preset": ("other", ALL),
    "units.a.effects": (["other"], ALL),
    "units.a.parameters": ({"k": 11.0}, ALL),
    "units.a.tolerances": ({"k": 1.0}, ALL),
    "units.a.every": (2, ALL),
    "units.a.isolation": ("process", ALL),
    "units.a.ardupilot": ("127.0.0.1:9002", ALL),
    "units.a.time_limit": (1.0, ALL),
    "units.a.interface": ("model-exchange", ALL),
    "units.a.solver": ("RK45", ALL),
    "units.a.tolerance": (1e-3, ALL),
    "master.algorithm": ("gauss-seidel", SETTINGS),
    "master.step": (0.05, SETTINGS),
    "master.extrapolation": (1, SETTINGS),
    "master.moving_places": ("held", SETTINGS),
    "master.feedthrough": ("delayed", SETTINGS),
    "master.order": (["b", "a"], SETTINGS),
    "master.iteration": ({"max_iterations": 3}, SETTINGS),
    "master.control": ({"method": "milne"}, SETTINGS),
    "master.events": (["a.x_out"], SETTINGS),
    "master.bonds": (["a.v_out * b.force"], SETTINGS),
    "master.energy_correction": (True, SETTINGS),
    "record.signals": (["a.x_out"], ALL),
    "record.interval": (0.1, SETTINGS),
    "record.snapshots": (["a.array"], SETTINGS),
    "record.snapshot_interval": (0.1, SETTINGS),
    "interface": ({"outputs": {"x": "a.x_out"}}, set()),
    "contacts": ([{"name": "c"}], ALL),
    "correlations": ({"a.k, a.c": 0.5}, ALL),
    "faults": ([{"signal": "b.force", "kind": "drop"}], ALL),
    "limits": ("en50367", FIGURES),
    "sweep": ({"a.k": [1.0, 2.0]}, set()),
    "analysis": ({"transient": 0.1}, FIGURES),
    "study.quantities": (["a.x_out, maximum"], FIGURES),
    "study.mesh": (["a.k"], {"front"}),
    "study.monolith": ({"scene": "mass-on-spring"}, {"front"}),
    "study.effects": (["a.other"], {"effects"}),
    "study.stability": ({"a.k": [1.0, 2.0]}, set()),
    "explore": ({"effects": []}, set()),
    "document": ({"author": "A"}, set()),
}


class OtherMass(Mass):
    """Another component by its name."""


@pytest.fixture
def scene():
    return read_scene(two_masses(step=0.02), "masses")


def changed(scene, place, value):
    """The scene with another value at a place, past the checks of scenes where these refuse it by itself."""
    with suppress(BadInput):
        return scene.with_changes({place: value})
    path = place.split(".")
    changed = {"limits": RowsSettings(table=value) if path == ["limits"] else value}.get(path[0], value)
    for k in reversed(range(len(path))):
        owner = scene
        for name in path[:k]:
            owner = owner[name] if isinstance(owner, dict) else getattr(owner, name)
        new = {path[k]: changed}
        changed = {**owner, **new} if isinstance(owner, dict) else owner.model_copy(update=new)
    return changed


def changed_kinds(one, other):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of values that are not of their model's types
        return {kind for kind, key in KEYS.items() if key(one) != key(other)}


def test_every_key_of_a_scene_is_in_the_table(scene):
    known = set()
    for name in SceneSettings.model_fields:
        place, owner = ("units.a", scene.units["a"]) if name == "units" else (name, getattr(scene, name))
        inside = any(key.startswith(f"{place}.") for key in CHANGES)
        known |= {f"{place}.{key}" for key in type(owner).model_fields} if inside else {place}
    assert {*CHANGES} == known


@pytest.mark.parametrize("place", CHANGES)
def test_a_key_changes_what_depends_on_it_and_nothing_else(place, scene, tmp_path, monkeypatch):
    value, kinds = CHANGES[place]
    monkeypatch.chdir(tmp_path)
    Path("other.fmu").write_bytes(b"an FMU")
    assert changed_kinds(scene, changed(scene, place, value)) == kinds


@pytest.mark.parametrize(("file", "kinds"), [("a.fmu", ALL), *((name, FIGURES) for name in FILES if name != "a.fmu")])
def test_the_contents_of_files_count_and_not_their_places(file, kinds, scene, tmp_path, monkeypatch):
    def written(folder, files):
        folder.mkdir()
        for name, text in files.items():
            (folder / name).write_text(text)
        return changed(changed(scene, "units.a.fmu", str(folder / "a.fmu")), "limits", str(folder / "limits.toml"))

    monkeypatch.syspath_prepend(tmp_path / "one")
    one, moved = written(tmp_path / "one", FILES), written(tmp_path / "moved", FILES)
    before = {kind: key(one) for kind, key in KEYS.items()}
    assert changed_kinds(one, moved) == set()
    (tmp_path / "one" / file).write_text({"own_measures.py": "def measured(result): return 1.0"}.get(file, FILES[file] + " "))
    importlib.invalidate_caches()
    assert {kind for kind, key in KEYS.items() if key(one) != before[kind]} == kinds


def test_comments_and_docstrings_of_components_do_not_count(monkeypatch):
    def digest(text):
        monkeypatch.setattr(build, "sources", lambda module: {"x.py": text.encode()})
        return code_digests.code_digest("PlanarLink")

    plain = digest("def f(x):\n    return 2.0 * x\n")
    assert digest('"""A module."""\n\n\ndef f(x):  # twice\n    """Twice."""\n    return 2.0 * x\n') == plain
    assert digest("def f(x):\n    return 2.5 * x\n") != plain


def test_the_code_of_components_and_the_version_of_cosimo_count(scene, monkeypatch):
    for name, value in (("_code", lambda components: "another"), ("version", lambda package: "another")):
        before = {kind: key(scene) for kind, key in KEYS.items()}
        monkeypatch.setattr(dependence, name, value)
        assert all(key(scene) != before[kind] for kind, key in KEYS.items())


OWN = {
    "own_mass.py": "from own_law import stiffness\nfrom cosimo.tests.support import Mass\nimport own_parts.ends\n\n\n"
    "class Own(Mass):\n    pass\n\n\ndef measured(result):\n    import own_later\n",
    "own_law.py": "import numpy\nfrom own_table import rows\n\nstiffness = 2.0\n",
    "own_table.py": "rows = 3\n",
    "own_later.py": "low = 1\n",
    "own_parts/ends.py": "from . import middle\n",
    "own_parts/middle.py": "left = 1\n",
    "own_other.py": "nothing = 1\n",
}


@pytest.mark.parametrize("file", OWN)
def test_modules_that_a_users_own_code_imports_count(file, scene, tmp_path, monkeypatch):
    """Also through others, within functions and packages; a digest is the same before and behind their import."""
    for name, text in OWN.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    own = "own_mass:Own", "own_mass:measured"

    def digests():
        return code_digests.code_digest(own[0]), dependence.source_of(own[1])

    function = dependence.source_of(own[1])
    before = digests()
    assert before[1] == function
    (tmp_path / file).write_text(OWN[file] + "# a comment\n")
    assert digests() == before
    (tmp_path / file).write_text(OWN[file] + "more = 2\n")
    after = digests()
    assert [a != b for a, b in zip(before, after, strict=True)] == [file != "own_other.py"] * 2
    for name in [n for n in sys.modules if n.startswith("own_")]:
        del sys.modules[name]


def test_code_that_no_file_holds_is_another_one_in_another_process(monkeypatch):
    monkeypatch.setattr(code_digests, "component_class", lambda name: int)  # of which `inspect` knows no file, as in a notebook
    before = code_digests.code_digest("__main__:Mass")
    assert code_digests.code_digest("__main__:Mass") == before
    monkeypatch.setattr(code_digests, "_THIS_PROCESS", "another")
    assert code_digests.code_digest("__main__:Mass") != before
