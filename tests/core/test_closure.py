"""What sources import, kept on disk: found by contents, healed where damaged, complete where two processes write."""

import os
from pathlib import Path

import pytest
from cosimo.components.core import closure
from cosimo.components.core.closure import SourceIndex, imports

SOURCE, EDITED = b"from . import one\nimport two\n", b"from .. import one, three\n"


@pytest.fixture
def parsed(monkeypatch) -> list[bytes]:
    """The sources that were parsed."""
    sources: list[bytes] = []

    def parse(source):
        sources.append(source)
        return imports(source)

    monkeypatch.setattr(closure, "imports", parse)
    return sources


def keep(file: Path | None, *sources: bytes) -> list:
    """What another process finds of sources, which it then keeps."""
    index = SourceIndex(file)
    found = [index.imports(source) for source in sources]
    index.save()
    return found


def test_a_source_is_parsed_once_and_an_edited_one_again(tmp_path, parsed):
    file = tmp_path / "sources.json"
    for expected in ([SOURCE], [SOURCE]):
        assert keep(file, SOURCE) == [imports(SOURCE)]
        assert parsed == expected
    assert keep(file, SOURCE, EDITED) == [imports(SOURCE), imports(EDITED)]
    assert parsed == [SOURCE, EDITED]
    assert [path.name for path in tmp_path.iterdir()] == ["sources.json"]


@pytest.mark.parametrize("damage", [lambda c: c[:-9], lambda c: c[:50] + bytes([c[50] ^ 1]) + c[51:], lambda c: b""])
def test_a_damaged_index_counts_as_missing_and_is_written_anew(tmp_path, parsed, damage):
    file = tmp_path / "sources.json"
    keep(file, SOURCE)
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert keep(file, SOURCE) == [imports(SOURCE)]
    assert parsed == [SOURCE, SOURCE]
    assert file.read_bytes() == whole


def test_what_another_process_has_kept_meanwhile_stays(tmp_path, parsed):
    file = tmp_path / "sources.json"
    one = SourceIndex(file)
    one.imports(SOURCE)
    keep(file, EDITED)
    one.save()
    keep(file, SOURCE, EDITED)
    assert parsed == [SOURCE, EDITED]


def test_where_nothing_can_be_written_sources_are_parsed(tmp_path, parsed):
    for file in (None, tmp_path / "missing" / "sources.json"):
        for _ in range(2):
            assert keep(file, SOURCE) == [imports(SOURCE)]
    assert parsed == 4 * [SOURCE]


def test_the_oldest_go(tmp_path, parsed, monkeypatch):
    monkeypatch.setattr(closure, "INDEXED_SOURCES", 1)
    file = tmp_path / "sources.json"
    keep(file, SOURCE)
    keep(file, EDITED)
    keep(file, EDITED)
    assert parsed == [SOURCE, EDITED]
    keep(file, SOURCE)
    assert parsed == [SOURCE, EDITED, SOURCE]


def write(path: Path, content: bytes, age: float) -> None:
    """A file that was changed so many seconds ago, as far as its time says."""
    path.write_bytes(content)
    then = path.stat().st_mtime - age
    os.utime(path, (then, then))


def test_a_file_that_is_as_it_was_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(closure, "SETTLED", 0)
    path, file = tmp_path / "a.py", tmp_path / "sources.json"
    write(path, SOURCE, 10.0)

    def of_another_process() -> tuple:
        index = SourceIndex(file)
        found = index.read(str(path))
        index.save()
        return found

    first = of_another_process()
    assert first == (closure.digest_of(SOURCE), imports(SOURCE))
    with monkeypatch.context() as patch:
        patch.setattr(closure, "open", None, raising=False)
        assert SourceIndex(file).read(str(path)) == first
    for content in (EDITED, SOURCE + b"#", SOURCE):
        then = path.stat().st_mtime
        path.write_bytes(content)
        os.utime(path, (then, then))  # of the same time, and the last two of other sizes: the system has the time of the change
        assert of_another_process() == (closure.digest_of(content), imports(content))


def test_a_file_that_was_changed_just_now_is_read_again(tmp_path):
    """Within one tick of the clock of files it may change without a sign."""
    path, file = tmp_path / "a.py", tmp_path / "sources.json"
    path.write_bytes(SOURCE)
    index = SourceIndex(file)
    index.read(str(path))
    index.save()
    assert SourceIndex(file)._files == {}


def test_what_a_process_has_seen_of_a_source_is_of_its_content(tmp_path):
    """A helper that is edited and loaded anew has other imports and another digest for all that call it from then on."""
    caller, helper, further = (tmp_path / f"{name}.py" for name in ("caller", "helper", "further"))
    caller.write_text("from .helper import one\n")
    helper.write_text("one = 1\n")
    further.write_text("two = 2\n")
    seen = {}
    before = closure.closure(caller, seen=seen)
    assert before.keys() == {caller, helper}
    helper.write_text("from .further import two as one\n")
    after = closure.closure(caller, seen=seen)
    assert after.keys() == {caller, helper, further}
    assert after[helper] != before[helper]
