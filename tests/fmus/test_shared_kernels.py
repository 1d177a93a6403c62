"""FMUs made from Python and cosimo itself share the machine code of kernels with the same sources, whatever the package."""

import re
import zipfile
from pathlib import Path

import pytest
from cosimo.fmus.build import built, sources
from cosimo.tests.fmus.driver import run_script

RUN = """
import gc, sys
from cosimo.tests.fmus.driver import Driven

def rows(path, name, port, steps=20):
    unit = Driven(path).start()
    answers = []
    for k in range(steps):
        unit.set({port: 1e-3 * k})
        assert unit.step(k * 1e-3, 1e-3) == 0, unit.log
        answers += unit.reals([name])
    unit.free()
    return answers

def counts(path):
    kernels = [o for o in gc.get_objects() if type(o).__name__ == "Kernel" and o.__module__.startswith(package(path))]
    return sys.modules[package(path) + ".components.core.kernels"].compiled_from_cache(*kernels)

def package(path):
    import re, zipfile
    with zipfile.ZipFile(path) as file:
        return next(m.split("/")[1] for m in file.namelist() if m.startswith("resources/bundle_"))

def show(path, name, port):
    answers = rows(path, name, port)
    print(*counts(path), *(a.hex() for a in answers))

arguments = iter(sys.argv[1:])
for path, name, port in zip(arguments, arguments, arguments):
    show(path, name, port)
"""
PANTOGRAPH = ("contact_force", "wire_height")


def renamed(path, folder):
    """The FMU with another package, as a rebuild has it after an edit that no kernel sees."""
    with zipfile.ZipFile(path) as source:
        old = next(m for m in (re.match(r"resources/bundle_([0-9a-f]{16})/", n) for n in source.namelist()) if m)[1]
        new = "e" * len(old)
        copy = folder / Path(path).name
        with zipfile.ZipFile(copy, "w") as target:
            for member in source.namelist():
                content = source.read(member)
                if member.startswith("resources/") and not member.startswith("resources/pythonfmu/"):
                    content = content.replace(old.encode(), new.encode())
                if member.endswith("/slave.py"):
                    content += b"\n# edited\n"
                target.writestr(member.replace(old, new), content)
    return copy


def runs(cache, *units):
    """(hits, misses, outputs) of each unit, all in one new process; a unit: FMU, output, input."""
    lines = run_script(RUN, *(word for unit in units for word in unit), COSIMO_CACHE=cache, NUMBA_CACHE_DIR=cache / "kernels")
    return [(int(words[0]), int(words[1]), words[2:]) for words in map(str.split, lines)]


def compiles_nothing(run, answers):
    hits, misses, given = run
    assert hits > 0
    assert misses == 0
    assert given == answers


@pytest.mark.full
def test_a_rebuilt_fmu_compiles_nothing(tmp_path):
    first, second = built("Pantograph"), renamed(built("Pantograph"), tmp_path)
    ((hits, misses, answers),) = runs(tmp_path / "cache", (first, *PANTOGRAPH))
    assert (hits, misses > 0) == (0, True)
    assert len(set(answers)) > 10
    (again,) = runs(tmp_path / "cache", (second, *PANTOGRAPH))
    compiles_nothing(again, answers)


IN_PROCESS = """
from cosimo.components.railway.pantograph import Pantograph

pantograph = Pantograph()
pantograph.initialize(0.0)
pantograph.step(0.0, 1e-3)
"""


def test_what_was_compiled_in_process_serves_the_fmu(tmp_path):
    """A run as FMUs is verified in process: neither compiles what the other has."""
    cache = tmp_path / "cache"
    run_script(IN_PROCESS, COSIMO_CACHE=cache, NUMBA_CACHE_DIR=cache / "kernels")
    ((hits, misses, _),) = runs(cache, (built("Pantograph"), *PANTOGRAPH))
    assert (hits > 0, misses) == (True, 0)


@pytest.mark.full
def test_two_packages_with_the_same_kernels_in_one_process(tmp_path):
    first, second = built("Pantograph"), renamed(built("Pantograph"), tmp_path)
    ((_, misses, alone),) = runs(tmp_path / "alone", (second, *PANTOGRAPH))
    compiled, loaded = runs(tmp_path / "cache", (first, *PANTOGRAPH), (second, *PANTOGRAPH))
    assert compiled == (0, misses, alone)
    compiles_nothing(loaded, alone)
    for order in ((first, second), (second, first)):
        for run in runs(tmp_path / "cache", *((path, *PANTOGRAPH) for path in order)):
            compiles_nothing(run, alone)


PAIRS = """
from typing import NamedTuple
from ..core.kernels import kernel, kernel_tuple

@kernel_tuple
class Pair(NamedTuple):
    a: float
    b: float

@kernel
def swapped(p):
    return Pair(p.b, {factor} * p.a)

@kernel
def total(p):
    q = swapped(p)
    return q.a + q.b
"""
CALL = """
import sys
from cosimo.fmus.loader import import_part, load_package

for folder in sys.argv[1:]:
    pairs = import_part(load_package(folder) + ".components.own.pairs", "pairs")
    given = pairs.Pair(1.0, 2.0)
    result = pairs.swapped(given)
    assert type(result) is pairs.Pair, type(result)
    counted = sys.modules[pairs.kernel.__module__].compiled_from_cache
    own = counted(pairs.swapped)
    print(pairs.total(given), *result, *counted(pairs.total), *own)
"""


def package(folder, digit, factor):
    """A package as FMUs have it, with kernels of a module of its own."""
    place = folder / f"bundle_{16 * digit}"
    files = {f"components/{path}": content for path, content in sources("core.kernels").items()}
    files |= {"__init__.py": b"", "components/own/__init__.py": b""}
    files["components/own/pairs.py"] = PAIRS.format(factor=factor).encode()
    for path, content in files.items():
        (place / path).parent.mkdir(parents=True, exist_ok=True)
        (place / path).write_bytes(content)
    return place


def called(cache, *folders):
    """Of each package in one process: results of both kernels, (hits, misses) of `total` and of `swapped`."""
    lines = run_script(CALL, *folders, COSIMO_CACHE=cache, NUMBA_CACHE_DIR=cache / "kernels")
    split = [line.split() for line in lines]
    return [([*map(float, words[:3])], tuple(map(int, words[3:5])), tuple(map(int, words[5:]))) for words in split]


def test_kernels_that_make_objects_of_their_package_stay_its_own(tmp_path):
    """`swapped` gives Python an object of a class of its package: that machine code is of no use in another."""
    one, other = (package(tmp_path, digit, 3.0) for digit in "ab")
    numbers, found, missed = [5.0, 2.0, 3.0], (1, 0), (0, 1)
    assert called(tmp_path / "cache", one, other) == [(numbers, missed, missed), (numbers, found, missed)]
    assert called(tmp_path / "cache", other, one) == [(numbers, found, found)] * 2


def test_packages_with_other_kernels_of_the_same_names_keep_their_own(tmp_path):
    one, other, third = (package(tmp_path, digit, factor) for digit, factor in zip("abc", (3.0, 4.0, 4.0), strict=True))
    called(tmp_path / "cache", one)
    called(tmp_path / "cache", third)
    for order in ((one, other, third), (third, other, one)):
        expected = [[5.0, 2.0, 3.0] if folder == one else [6.0, 2.0, 4.0] for folder in order]
        runs = called(tmp_path / "cache", *order)
        assert [numbers for numbers, *_ in runs] == expected
        assert [total for _, total, _ in runs] == [(1, 0)] * 3
