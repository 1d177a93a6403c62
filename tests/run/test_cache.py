"""What is kept heals, moves and can be cleared; where nothing can be written, runs work all the same."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from cosimo.components.core import store
from cosimo.components.core.errors import BadInput
from cosimo.fmus import build, loader
from cosimo.orchestrator import cache
from cosimo.orchestrator.harness.many.measures import PointResult
from cosimo.orchestrator.harness.many.store import Store
from cosimo.orchestrator.output import lock_folder, locked
from cosimo.orchestrator.units import folders
from cosimo.tests.commands import exit_code

posix = pytest.mark.skipif(os.name == "nt", reason="owners and modes of POSIX")


@pytest.fixture
def own_cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: whole[: len(whole) // 2],
        lambda whole: b"",
        lambda whole: b"no archive",
        lambda whole: whole[:-30],
        lambda whole: whole[:5000] + bytes(255 - b for b in whole[5000:5010]) + whole[5010:],
    ],
    ids=["half", "empty", "another", "end", "inside"],
)
def test_a_damaged_fmu_is_built_anew(own_cache, damage):
    path = build.built("Pantograph")
    whole, changed = path.read_bytes(), path.stat().st_mtime_ns
    assert build.built("Pantograph").stat().st_mtime_ns == changed
    path.write_bytes(damage(whole))
    assert build.built("Pantograph") == path
    assert path.read_bytes() == whole
    assert sorted(p.name for p in path.parent.iterdir()) == ["Pantograph.fmu", "Pantograph.fmu.seal"]


def test_an_fmu_with_other_content_is_built_anew(own_cache):
    """A sound archive, but not this component: as one that somebody has put there."""
    path = build.built("Pantograph")
    whole = path.read_bytes()
    path.write_bytes(build.built("Catenary").read_bytes())
    assert build.built("Pantograph").read_bytes() == whole


def test_without_a_cache_fmus_are_built_for_the_process(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "file" / "cache"))
    path = build.built("Pantograph")
    assert path.is_file()
    assert path == build.built("Pantograph")
    assert sorted(os.listdir(tmp_path)) == ["file"]


def test_bundles_are_executed_only_where_nobody_else_may_write(own_cache, tmp_path):
    source = tmp_path / "bundle_x"
    source.mkdir()
    (source / "__init__.py").write_text("number = 1\n")
    copy = Path(loader.stable_copy(str(source)))
    assert copy == own_cache / "bundles" / "bundle_x"
    (copy / "__init__.py").write_text("number = 2\n")
    assert Path(loader.stable_copy(str(source))) == copy
    assert (copy / "__init__.py").read_text() == "number = 1\n"
    if os.name != "nt":
        copy.chmod(0o777)
        assert Path(loader.stable_copy(str(source))) == source


@posix
def test_kernels_are_read_only_where_nobody_else_may_write(tmp_path):
    folder = tmp_path / "kernels"
    assert store.private(folder)
    assert folder.stat().st_mode & 0o777 == 0o700
    for mode in (0o720, 0o702, 0o777):
        folder.chmod(mode)
        assert not store.private(folder)


def test_a_content_is_checked_before_it_is_used(tmp_path):
    path = tmp_path / "kept" / "a"
    store.write_kept(path, b"nowhere")  # no error
    assert store.read_kept(path) is None
    path.parent.mkdir()
    store.write_kept(path, b"content")
    assert store.read_kept(path) == b"content"
    for damage in (b"", b"{}", path.read_bytes()[:-1], path.read_bytes() + b" "):
        path.write_bytes(damage)
        assert store.read_kept(path) is None
    store.write_kept(path, b"again")
    assert store.read_kept(path) == b"again"
    assert [p.name for p in path.parent.iterdir()] == ["a"]


def read_file(path):
    return store.read_kept(path)


def read_fmu(path):
    made = []
    store.kept(path.parent.parent.name, path.parent.name, path.name, lambda new: made.append(new) or made_fmu(new))
    return None if made else b"kept"


def made_fmu(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    with store.replaced(path, "wb") as file:
        file.write(b"made: " + path.name.encode())
    return path


def flipped(content):
    return content[: len(content) // 2] + bytes([content[len(content) // 2] ^ 1]) + content[len(content) // 2 + 1 :]


def read_rows(path):
    store_of_rows = Store(path.parent)
    return b"kept" if store_of_rows.size else None


def make_rows(path):
    rows = Store(path.parent)
    rows.append([(1, PointResult("done", path.parent.name))])
    rows.flush()
    return next(path.parent.glob("*.arrow"))


MADE = {  # kinds of what is kept, by the way they are read: how a file of it comes to its place, and how it is read
    "content": (lambda path: store.write_kept(path, path.name.encode()), read_file),
    "fmu": (read_fmu, read_fmu),
    "rows": (make_rows, read_rows),
}
TAMPERED = {
    "another's name": lambda path, other: shutil.copy(other, path),
    "another's name and seal": lambda path, other: [
        shutil.copy(file, path.with_name(path.name + file.name[len(other.name) :]))
        for file in other.parent.glob(f"{other.name}*")
    ],
    "a bit": lambda path, other: path.write_bytes(flipped(path.read_bytes())),
    "half of it": lambda path, other: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "nothing": lambda path, other: path.write_bytes(b""),
    "the group may write": lambda path, other: path.chmod(0o664),
    "all may write": lambda path, other: path.chmod(0o646),
    "another user's": lambda path, other: os.chown(path, 12345, -1),
    "a link to another": lambda path, other: (path.unlink(), path.symlink_to(other)),
    "a pipe": lambda path, other: (path.unlink(), os.mkfifo(path)),
    "a folder": lambda path, other: (path.unlink(), path.mkdir()),
    "no rights": lambda path, other: (path.unlink(), path.symlink_to("/proc/1/mem")),
}


@posix
@pytest.mark.parametrize("how", TAMPERED)
@pytest.mark.parametrize("kind", MADE)
def test_one_rule_for_all_that_is_kept(kind, how, own_cache):
    """Whole, what its place says, and nobody else's: all else is made again, and read without waiting."""
    if how == "another user's" and os.getuid() != 0:
        pytest.skip("only root can give a file away")
    store._aside.cache_clear()
    make, read = MADE[kind]
    folders = [own_cache / "kind" / name for name in ("0123456789abcdef", "fedcba9876543210")]
    paths = [folder / name for folder, name in zip(folders, ("a.fmu", "b.fmu"), strict=True)]
    for k, path in enumerate(paths):
        store.cache_folder("kind", path.parent.name)
        made = make(path)
        paths[k] = made if kind == "rows" else path
    assert all(read(path) for path in paths)
    TAMPERED[how](*paths)
    assert read(paths[0]) is None
    assert read(paths[1])


@posix
@pytest.mark.parametrize("place", [".", "native", "native/0123456789abcdef"])
def test_a_folder_that_others_may_write_is_not_used(place, own_cache, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    first = store.kept("native", "0123456789abcdef", "a.fmu", made_fmu)
    assert first.is_relative_to(own_cache)
    (own_cache / place).chmod(0o777)
    second = store.kept("native", "0123456789abcdef", "a.fmu", made_fmu)
    assert not second.is_relative_to(own_cache)
    assert store.kept("native", "0123456789abcdef", "a.fmu", made_fmu) == second


def test_show_clear_and_prune(own_cache, capsys):
    build.built("Pantograph")
    build.built("Catenary")
    sizes = [p.stat().st_size for p in (own_cache / "fmus").rglob("*.*")]
    main_json(["cache", "--json"])
    shown = {e["kind"]: e for e in json.loads(capsys.readouterr().out)["entries"]}
    assert (shown["fmus"]["files"], shown["fmus"]["size"]) == (4, sum(sizes))
    old = next(own_cache.rglob("Catenary.fmu"))
    for file in old.parent.iterdir():
        os.utime(file, (1e9, 1e9))
    part = own_cache / "fmus" / "x.part"
    part.touch()
    os.utime(part, (time.time() - 7200.0,) * 2)
    mine = own_cache / "mine.txt"
    mine.write_text("kept")
    assert cache.prune(30.0) >= min(sizes)
    assert not old.exists()
    assert not part.exists()
    with pytest.raises(BadInput, match="Did you mean 'fmus'"):
        cache.clear(["fmu"])
    assert cache.clear(["kernels"]) == 0
    main_json(["cache", "clear", "fmus"])
    assert [p for p in own_cache.rglob("*") if p.is_file() and p.name != cache.TIDIED] == [mine]
    for wrong in ("shw", "clear --days 3", "prune fmus", "prune --days -1"):
        end = exit_code("cache", *wrong.split())
        assert end == 2


def main_json(arguments):
    assert exit_code(*arguments) == 0


@posix
def test_folders_of_killed_processes_go_and_those_of_living_ones_stay(tmp_path, monkeypatch):
    dead, young, living, other = (tmp_path / f"{folders.PREFIX}{n}" for n in ("dead", "young", "living", "no"))
    for folder in (dead, young, living):
        (folder / "fmu").mkdir(parents=True)
    other = tmp_path / "something"
    other.mkdir()
    for folder in (dead, living, other):
        os.utime(folder, (1e9, 1e9))
    release = lock_folder(living)
    # another process: locks of one process would not meet
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "from cosimo.orchestrator.units.folders import process_folder\n"
            "import os; p = process_folder(); print(p); assert os.path.isdir(p)",
        ],
        env=os.environ | {"TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    release()
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in (young, living, other))
    assert not Path(done.stdout.strip()).exists()  # its own went with it


@posix
@pytest.mark.first
@pytest.mark.parametrize("letters", ["имя пользователя", "höme", "名前"])
def test_temporary_folders_with_any_letters(letters, tmp_path):
    """pythonfmu's library crashes the process there."""
    place = tmp_path / letters
    place.mkdir()
    program = (
        "from cosimo.orchestrator.run.run import run\nfrom cosimo.orchestrator.systems import load_scene\n"
        "r = run(load_scene('en50318-2002').with_changes({'stop_time': 0.1})); print(r.outcome, r.rows, r.message)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=os.environ | {"TMPDIR": str(place), "NUMBA_DISABLE_JIT": "1"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("done 101"), done.stdout


def test_where_no_folder_has_plain_letters_it_is_said(tmp_path, monkeypatch):
    place = tmp_path / "höme"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    monkeypatch.setattr(folders, "_bases", lambda: iter(()))
    monkeypatch.setattr(folders, "_own", None)
    fmu = shutil.copy(build.built("Pantograph"), tmp_path / "Pantograph.fmu")  # no other test has it unpacked
    with pytest.raises(OSError, match=r"with letters beyond ASCII\. Set TMPDIR"):
        folders.take(str(fmu))


@pytest.mark.full
def test_damaged_byte_code_of_a_bundle_is_noticed(own_cache):
    """Cut, emptied, of another kind: the sources are whole, and the byte code is made anew."""
    program = (
        "from cosimo.orchestrator.run.run import run\nfrom cosimo.orchestrator.systems import load_scene\n"
        "r = run(load_scene('mass-on-spring').with_changes({'stop_time': 0.05})); print(r.outcome, r['mass.base_x'][-1])"
    )

    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX")}

    def result() -> str:
        done = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            check=True,
            env=environment | {"NUMBA_DISABLE_JIT": "1"},
        )
        return done.stdout

    whole = result()
    assert whole.startswith("done ")
    files = [*(own_cache / "bundles").rglob("*.pyc")]
    assert files
    for damage in (lambda b: b[:200], lambda b: b"", lambda b: b[:16] + b"z" * 100, lambda b: b[:16]):
        for file in (own_cache / "bundles").rglob("*.pyc"):
            file.write_bytes(damage(file.read_bytes()))
        assert result() == whole


def test_what_was_never_put_in_place_goes_once_a_day(own_cache, tmp_path):
    (own_cache / "fmus").mkdir(parents=True)
    (own_cache / "bundles" / "tmpabc").mkdir(parents=True)
    (own_cache / "mine").mkdir()
    old, new, mine = own_cache / "fmus" / "abc.part", own_cache / "fmus" / "new.part", own_cache / "mine" / "a.part"
    for path in (old, new, mine):
        path.write_bytes(b"x")
    for path in (old, mine, own_cache / "bundles" / "tmpabc"):
        os.utime(path, (1e9, 1e9))
    cache.tidy_daily()
    assert [path.exists() for path in (old, own_cache / "bundles" / "tmpabc", new, mine)] == [False, False, True, True]
    old.write_bytes(b"x")
    os.utime(old, (1e9, 1e9))
    cache.tidy_daily()
    assert old.exists()
    os.utime(own_cache / cache.TIDIED, (1e9, 1e9))
    cache.tidy_daily()
    assert not old.exists()


def test_a_result_directory_loses_what_a_killed_process_has_not_put_in_place(tmp_path):
    ours, checkpoint, users = tmp_path / ".run.json.abcd_123.part", tmp_path / ".checkpoint.zzzz9999.part", tmp_path / "film.part"
    for path in (ours, checkpoint, users):
        path.write_bytes(b"x")
        os.utime(path, (1e9, 1e9))
    with locked(tmp_path):
        assert [p.exists() for p in (ours, checkpoint, users)] == [False, False, True]
