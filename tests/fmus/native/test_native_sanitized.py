"""The runtime in C under the address and the undefined-behaviour sanitizer: random calls, right and wrong ones."""

import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest
from cosimo.fmus.native.build import write_sources
from cosimo.tests.fmus.native.support import compiled

HERE, HEADERS = Path(__file__).parent, Path(fmpy.__file__).parent / "c-code"
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc with its sanitizers")


MODELS = [("ServoMotor", ()), pytest.param(("ForearmTendons", ("programme",)), marks=pytest.mark.full)]


@pytest.fixture(params=MODELS, ids=lambda p: p[0])
def host(request, tmp_path):
    """The program of host.c with a model, and the arguments that name the model."""
    found = compiled(*request.param)
    objects = write_sources(tmp_path, found.model, found.objects["linux64"])
    sources = [tmp_path / f for f in ("native.c", "fmi2.c", "fmi3.c", "model.c", *objects)]
    flags = ["-std=c11", "-g", "-O1", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    # the standard's headers: a function that differs from its declaration there does not compile
    command = ["gcc", *flags, "-DCOSIMO_FMI_HEADERS", "-I", HEADERS, HERE / "host.c", *sources, "-o", tmp_path / "host", "-lm"]
    subprocess.run([str(c) for c in command], check=True)
    return tmp_path / "host", found.token, len(found.variables)


@pytest.mark.parametrize("sequences", [300, pytest.param(10_000, marks=pytest.mark.full)])
def test_random_calls_end_in_a_status(host, sequences):
    program, token, variables = host
    done = subprocess.run([program, token, "1", str(sequences), str(variables)], capture_output=True, text=True)

    assert (done.returncode, done.stderr) == (0, ""), done.stdout[-1000:] + done.stderr[-3000:]
    calls, refused, messages = (int(word.split()[0]) for word in done.stdout.split(", "))
    assert calls > 10 * sequences
    assert 0.2 * calls < refused < 0.8 * calls  # both right and wrong ones are in it
    assert messages > 0.3 * refused
