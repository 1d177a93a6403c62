"""Macro steps per second of two small FMUs under this master and under others, and of trivial components in process.

The FMUs are plain pythonfmu slaves. Every master runs in a process of its own on one core, in turns; the best of several
turns counts. COSIMO_INTEROP_PYTHON names a Python that has the extra `interop` where the one of the tests has not.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.stateless import StatelessComponent, stateless_kernels
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.interop.masters import surroundings

HERE = Path(__file__).parent
STEPS, TURNS = 10_000, 5
INTEROP = os.environ.get("COSIMO_INTEROP_PYTHON", sys.executable)
PEERS = {
    "cosimo": sys.executable,
    "recording": sys.executable,
    "ctypes": sys.executable,
    "fmpy": sys.executable,
    "ecos": INTEROP,
    "libcosim": INTEROP,
}
NAMES = {
    "cosimo": "cosimo",
    "recording": "cosimo, every output of every step recorded",
    "ctypes": "loop of ctypes calls in Python",
    "fmpy": "methods of FMPy's FMU classes",
    "ecos": "Ecos",
    "libcosim": "libcosim",
}


@pytest.fixture(scope="module")
def rates(tmp_path_factory, told):
    """Macro steps per second by master; None for one that cannot run here."""
    from pythonfmu.builder import FmuBuilder

    folder = tmp_path_factory.mktemp("fmus")
    fmus = [str(FmuBuilder.build_FMU(HERE / "fmus" / f"{name}.py", dest=folder)) for name in ("msd", "ctrl")]
    found, reached = {}, {}
    for _ in range(TURNS):
        for who, python in PEERS.items():
            done = subprocess.run(
                [python, HERE / "peers.py", who, *fmus, str(STEPS)], capture_output=True, text=True, env=surroundings()
            )
            if done.returncode == 0 and done.stdout.strip():
                rate, place = done.stdout.split()[-2:]
                found[who], reached[who] = max(found.get(who, 0.0), float(rate)), float(place)
    for who in PEERS:
        told("small pair", NAMES[who], macro_steps_a_second=found.get(who, "not here"))
    assert all(abs(place - reached["ctypes"]) < 1e-12 for place in reached.values())
    return found


def test_faster_than_a_bare_loop_of_ctypes_calls(rates):
    assert rates["cosimo"] > 1.2 * rates["ctypes"]


def test_faster_than_fmpy(rates):
    assert rates["cosimo"] > 2.0 * rates["fmpy"]


def test_faster_than_libcosim(rates):
    if "libcosim" not in rates:
        pytest.skip("needs the extra interop")
    assert rates["cosimo"] > 5.0 * rates["libcosim"]


def test_faster_than_ecos_on_one_core(rates):
    if "ecos" not in rates:
        pytest.skip("needs the extra interop")
    assert rates["cosimo"] > rates["ecos"]


def test_recording_every_output_of_every_step_adds_under_a_fifth(rates):
    """Of the time of the same run; it reads five outputs instead of three, which is most of what it adds."""
    assert rates["cosimo"] < 1.2 * rates["recording"]


@kernel
def halve(t, s, p, e):
    s.y[0] = 0.5 * s.u[0, 0]
    return DONE


class KernelGain(StatelessComponent):
    """Half of its input."""

    title = "gain"
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "half of it")
    kernels = stateless_kernels(__name__, halve)


class Gain(Component):
    """Half of its input, by Python in its step."""

    title = "gain"
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "half of it")

    def _initialize(self, t):
        return DONE

    def _step(self, t, h):
        self.y[0] = 0.5 * self.u[0, 0]
        return DONE

    def _outputs(self, t):
        self.y[0] = 0.5 * self.u[0, 0]


@pytest.mark.parametrize("record", [{"signals": ["a.y_out"], "interval": 20.0}, {}], ids=["one row", "all rows"])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("name", "steps", "least"), [("Gain", 20_000, 500_000), ("KernelGain", 200_000, 5_000_000)])
def test_steps_of_trivial_units_a_second(name, steps, least, algorithm, degree, record, told):
    """Two of them, by CPU time of stepping; the longer run is that in which what happens once a run does not count."""
    gain = {"component": f"cosimo.tests.benchmarks.test_master_speed:{name}"}
    scene = read_scene(
        {
            "stop_time": 1e-3 * steps,
            "connections": ["a.y_out -> b.u_in", "b.y_out -> a.u_in"],
            "units": {"a": gain, "b": gain},
            "record": record,
            "master": {"algorithm": algorithm, "step": 1e-3, "extrapolation": degree},
        }
    )
    rate = 2 * steps / min(run(scene, in_process=True).info.timing.cpu for _ in range(TURNS))
    told(
        "trivial units",
        f"`{name}`, {algorithm}, {'all rows' if not record else 'one row'}",
        **{f"degree {degree}": f"{rate:.3g}"},
    )
    assert rate > least
