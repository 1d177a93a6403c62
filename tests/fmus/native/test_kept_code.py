"""Machine code of native FMUs on disk: what it follows from decides whether it is taken, and a damaged file never is."""

import importlib.util
import sys

import pytest
from cosimo.components.core import kept_kernels, kernel_cache, kernel_sources
from cosimo.fmus.native import machine_code
from cosimo.fmus.native.build import initialized
from numba.core import event

SOURCE = '''
from cosimo.components.core.stateless import StatelessComponent, stateless_kernels
from cosimo.components.core.kernels import kernel
from cosimo.components.core.variables import input_, integer, output, parameter

FACTOR = {factor}


def kernels_of(power):
    @kernel
    def weighed(t, s, p, e):
        s.y[0] = p.gain * FACTOR * s.u[0, 0] ** power
        return 0

    return stateless_kernels(f"{{__name__}}.{{power}}", weighed)


KERNELS = {{1: kernels_of(1), 2: kernels_of(2)}}


class Weighed(StatelessComponent):
    """A component of one kernel."""

    gain = parameter(2.0, "1", "factor")
    first = input_(3.0, "1", "a number")
    total = output("1", "its product")
    room = integer(1, "numbers in the block that no kernel reads")

    kernels = KERNELS[{power}]

    def shapes(self):
        return {{"unread": self.parameters["room"]}}
'''


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """A function that gives (code, what was done for it: kernels compiled, their code linked) of a component written with a factor."""
    for module in (kernel_sources, kernel_cache):
        monkeypatch.setattr(module, "private_root", lambda: tmp_path)
    done = []
    linked = machine_code._linked
    monkeypatch.setattr(machine_code, "_linked", lambda *a: done.append("linked") or linked(*a))

    def code(factor=2.0, power=1, **parameters):
        file = tmp_path / f"copy{len(list(tmp_path.glob('copy*')))}" / "weighed.py"  # another module, as in another process
        file.parent.mkdir()
        file.write_text(SOURCE.format(factor=factor, power=power))
        monkeypatch.setattr(kept_kernels, "_LOADED", {})
        spec = importlib.util.spec_from_file_location("weighed", file)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "weighed", module)
        spec.loader.exec_module(module)
        component = module.Weighed((), parameters)
        done.clear()
        with event.install_recorder("numba:compile") as kernels:
            text = machine_code.compile_entries(machine_code.source_of(initialized(component)))
        return text, set(done) | ({"compiled"} if kernels.buffer else set())

    return code


def test_other_values_take_the_same_code_and_other_code_is_compiled(compiled):
    first, done = compiled(gain=2.0)
    assert done == {"compiled", "linked"}
    assert compiled(gain=-5.5) == (first, set())
    for other in ({"power": 2}, {"factor": 3.0}):  # another kernel, and a constant of the module
        text, done = compiled(**other)
        assert done == {"compiled", "linked"}, other
        assert text != first, other


def test_another_layout_takes_the_same_kernels(compiled):
    """The arrays behind the unread one are elsewhere."""
    compiled()
    text, done = compiled(room=5)
    assert done == {"linked"}
    assert compiled(room=5) == (text, set())


@pytest.mark.full
def test_damaged_files_are_made_again(compiled, tmp_path):
    compiled()
    for kinds, done in (("*.ll",), {"linked"}), (("*.ll", "*.nb?", "machine/*"), {"compiled", "linked"}):
        for begin in (0, 100):
            for file in (f for kind in kinds for f in tmp_path.rglob(kind)):
                whole = file.read_bytes()
                file.write_bytes(whole[:begin] + b"xy" + whole[begin + 2 :] if begin else whole[:-7])
            text, anew = compiled()
            assert anew == done
            assert compiled() == (text, set())
    assert not list(tmp_path.rglob("*.part"))
