"""Machine code of native FMUs on disk: what it follows from decides whether it is taken, and a damaged file never is."""

import importlib.util
import sys

import pytest
from cosimo.components.core import kernel_cache
from cosimo.fmus.native import machine_code
from cosimo.fmus.native.build import initialized

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

    kernels = KERNELS[{power}]
'''


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """A function that gives (code, whether it was compiled) of a component written with a factor."""
    monkeypatch.setattr(kernel_cache, "private_root", lambda: tmp_path)
    done = []
    monkeypatch.setattr(machine_code, "_linked", lambda *a, linked=machine_code._linked: done.append(1) or linked(*a))

    def code(factor=2.0, power=1, **parameters):
        file = tmp_path / f"copy{len(list(tmp_path.glob('copy*')))}" / "weighed.py"  # another module, as in another process
        file.parent.mkdir()
        file.write_text(SOURCE.format(factor=factor, power=power))
        spec = importlib.util.spec_from_file_location("weighed", file)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "weighed", module)
        spec.loader.exec_module(module)
        component = module.Weighed((), parameters)
        before = len(done)
        return machine_code.compile_entries(machine_code.source_of(initialized(component))), len(done) > before

    return code


def test_other_values_take_the_same_code_and_other_code_is_compiled(compiled):
    first, anew = compiled(gain=2.0)
    assert anew
    assert compiled(gain=-5.5) == (first, False)
    for other in ({"power": 2}, {"factor": 3.0}):  # another kernel, and a constant of the module
        text, anew = compiled(**other)
        assert anew, other
        assert text != first, other


@pytest.mark.full
def test_a_damaged_file_is_compiled_again(compiled, tmp_path):
    compiled()
    (file,) = (tmp_path / "native").glob("*.ll")
    whole = file.read_bytes()
    for damaged in (whole[:-7], whole[:100] + b"xy" + whole[102:]):
        file.write_bytes(damaged)
        text, anew = compiled()
        assert anew
        assert compiled() == (text, False)
    assert not list((tmp_path / "native").glob("*.part"))
