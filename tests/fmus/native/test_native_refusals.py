"""What has no native form is refused by name, with the line that prevents it; what is missing is one message."""

import math
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.stateless import StatelessComponent, stateless_kernels
from cosimo.components.core.variables import input_, output, parameter
from cosimo.fmus.native import build
from cosimo.fmus.native.build import initialized
from cosimo.fmus.native.machine_code import compile_entries, source_of
from cosimo.tests.support import OfTime
from fmpy import simulate_fmu


class Sum(StatelessComponent):
    """A base for components that are refused."""

    gain = parameter(2.0, "1", "factor")
    first = input_(1.0, "1", "a number")
    second = input_(2.0, "1", "a number")
    total = output("1", "a sum")


@kernel
def weigh(t, s, p, e):
    """What `Weighed` gives."""
    s.y[0] = p.gain * (s.u[0, 0] + s.u[0, 1])
    return DONE


class Weighed(Sum):
    """A sum that has a native form."""

    kernels = stateless_kernels(f"{__name__}.Weighed", weigh)


@kernel
def add(t, s, p, e):
    """An array that is made in a kernel."""
    s.y[0] = np.sum(s.u[0] * 2.0)
    return DONE


class Allocating(Sum):
    """Its kernel allocates."""

    kernels = stateless_kernels(__name__, add)


@kernel
def factorial(t, s, p, e):
    """A function that has no rule for its derivative."""
    s.y[0] = math.lgamma(s.u[0, 0])
    return DONE


class Factorial(Sum):
    """It has a native form, and no derivative."""

    kernels = stateless_kernels(f"{__name__}.Factorial", factorial)


class Plain(OfTime):
    """Python in its steps."""

    first = input_(1.0, "1", "a number")
    total = output("1", "a sum")

    def _outputs(self, t):
        self.y[0] = self.u[0, 0]


@pytest.mark.parametrize(("version", "flag"), [(2, "providesDirectionalDerivative"), (3, "providesDirectionalDerivatives")])
def test_an_fmu_without_derivatives_says_so_and_runs(version, flag, tmp_path):
    for cls, said in ((Weighed, "true"), (Factorial, "false")):
        path = build.pack(build.library(cls.__name__, cls, [build.own_target()]), tmp_path, version)
        with zipfile.ZipFile(path) as file:
            assert f'{flag}="{said}"' in file.read("modelDescription.xml").decode()
    assert simulate_fmu(str(path), stop_time=0.1)["total"][-1] == math.lgamma(1.0)


@pytest.mark.parametrize(("cls", "words"), [
    (Plain, ["plain Python", "docs/extending.md"]),
    (Allocating, ["NRT_", "in add", "test_native_refusals.py, line"]),
])  # fmt: skip
def test_a_component_without_native_form_is_refused_with_what_prevents_it(cls, words):
    with pytest.raises(BadInput) as caught:
        compile_entries(source_of(initialized(cls())))
    assert caught.value.where == cls.__name__
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_refusal_is_the_same_again(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path))
    texts = []
    for _ in range(2):
        with pytest.raises(BadInput) as caught:
            compile_entries(source_of(initialized(Allocating())))
        texts.append(str(caught.value))
    assert texts[0] == texts[1]
    assert "test_native_refusals.py, line" in texts[0]


def test_a_missing_compiler_is_one_message(monkeypatch):
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    monkeypatch.setattr(build.shutil, "which", lambda name: None)
    for target in build.TARGETS:
        with pytest.raises(BadInput, match=rf"no C compiler for {target}.*pip install 'cosimo\[native\]'"):
            build.compiler(target)
    with pytest.raises(BadInput, match="linux64"):
        build.compiler("linux46")


@pytest.mark.parametrize(("arguments", "words"), [
    (["build", "PlanarLink", "--fmi", "3"], "no effect without --native"),
    (["build", "PlanarLink", "--native", "--fmi", "1"], "--fmi: got '1'"),
    (["build", "PlanarLink", "--native", "--target", "linux46"], "Did you mean 'linux64'"),
    (["build", "PlanarLink", "--native", "--target", "linux-arm46"], "Did you mean 'linux-arm64'"),
    (["build", "PlanarLynk", "--native"], "PlanarLink"),
    (["build", "--native", "--scene", "no-such-scene"], "no-such-scene"),
])  # fmt: skip
def test_bad_input_of_the_command_is_one_message(arguments, words):
    done = subprocess.run([sys.executable, "-m", "cosimo.orchestrator.cli", *arguments], capture_output=True, text=True)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
