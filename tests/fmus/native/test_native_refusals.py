"""What has no native form is refused by name, with the line that prevents it; what is missing is one message."""

import os
import subprocess
import sys

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.core.kernels import kernel
from cosimo.components.core.stateless import StatelessComponent
from cosimo.components.core.variables import input_, output, parameter
from cosimo.fmus.native import build
from cosimo.fmus.native.image import compiled_with_image


class Sum(StatelessComponent):
    """A base for components that are refused."""

    gain = parameter(2.0, "1", "factor")
    first = input_(1.0, "1", "a number")
    second = input_(2.0, "1", "a number")
    total = output("1", "a sum")


class Whole(Sum):
    """An array expression allocates."""

    def _outputs(self, t):
        self.y[:] = self.u[0, :1] + self.u[0, 1:]


class Remembering(Sum):
    """An attribute that a step replaces is no cell of the block."""

    def _initialize(self, t):
        self._last = np.zeros(1)
        return super()._initialize(t)

    def _outputs(self, t):
        self._last = self.u[0] * 1.0
        self.y[0] = self._last[0]


class Printing(Sum):
    """A statement that is no arithmetic."""

    def _outputs(self, t):
        with open(os.devnull):
            self.y[0] = 0.0


@kernel
def add(u, y, scratch):
    """An array that is made in a kernel."""
    y[0] = np.sum(u * 2.0) + scratch[0]


class Allocating(Sum):
    """Its kernel allocates."""

    def _initialize(self, t):
        self._work = np.zeros(1)
        return super()._initialize(t)

    def _outputs(self, t):
        add(self.u[0], self.y, self._work)


@pytest.mark.parametrize(("cls", "words"), [
    (Whole, ["NRT_", "test_native_refusals.py, line"]),
    (Remembering, ["_last", "test_native_refusals.py, line"]),
    (Printing, ["With", "test_native_refusals.py, line"]),
    (Allocating, ["NRT_", "in add", "test_native_refusals.py, line"]),
])  # fmt: skip
def test_a_component_without_native_form_is_refused_with_what_prevents_it(cls, words):
    with pytest.raises(BadInput) as caught:
        compiled_with_image(cls)
    assert caught.value.where == cls.__name__
    assert all(word in str(caught.value) for word in words), str(caught.value)


class Limited(Sum):
    """Hooks with what most of them have: counting, conditions fixed at build, another method, a failure with a message."""

    settings = ("plain",)

    def _initialize(self, t):
        self._limit, self._names = 10.0, list(self.settings)
        return super()._initialize(t)

    def _outputs(self, t):
        p, *_ = self.arguments
        value = self._weighted(p.gain)
        if "other" in self._names:
            self.y[:] = self._names
        if value > self._limit:
            where = "above" if value > 20.0 else "at"
            raise StepFailed(self.name, t, f"a sum of {value:g} is {where} the limit", "Reduce the inputs")
        self.y[0] = value

    def _weighted(self, gain):
        return gain * (self.u[0, 0] + self.u[0, 1])


def test_hooks_are_translated_with_their_messages():
    _, code, image = compiled_with_image(Limited)
    assert code.messages == ("a sum of ... is ... the limit. Reduce the inputs",)
    assert not image.bound_inputs
    assert not image.bound_time


def test_a_missing_compiler_is_one_message(monkeypatch):
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    monkeypatch.setattr(build.shutil, "which", lambda name: None)
    for target in build.TARGETS:
        with pytest.raises(BadInput, match=rf"no C compiler for {target}.*pip install 'cosimo\[native\]'"):
            build.compiler(target)
    with pytest.raises(BadInput, match="linux64"):
        build.compiler("linux46")


@pytest.mark.parametrize(("arguments", "words"), [
    (["build", "PlanarLink", "--fmi", "3"], "--fmi without --native"),
    (["build", "PlanarLink", "--native", "--fmi", "1"], "--fmi: '1'"),
    (["build", "PlanarLink", "--native", "--target", "linux46"], "did you mean 'linux64'"),
    (["build", "PlanarLink", "--native", "--target", "linux-arm46"], "did you mean 'linux-arm64'"),
    (["build", "PlanarLynk", "--native"], "PlanarLink"),
    (["build", "--native", "--scene", "no-such-scene"], "no-such-scene"),
])  # fmt: skip
def test_bad_input_of_the_command_is_one_message(arguments, words):
    done = subprocess.run([sys.executable, "-m", "cosimo.orchestrator.cli", *arguments], capture_output=True, text=True)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
