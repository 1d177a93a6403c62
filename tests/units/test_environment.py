"""A library that leaves another rounding mode, or flushes small numbers to zero, changes no number of anybody else."""

import ctypes

import numpy as np
import pytest
from cosimo import read_scene, run
from cosimo.orchestrator.units import environment
from cosimo.tests.units.native import STATE, native_fmu

MODES = [0x400, 0x800, 0xC00, 0x0]  # downward, upward, to zero on x86; the last one is to the nearest


def others(fmi, isolation, rounding, algorithm="jacobi"):
    """The FMU between units of every kind, two of which it feeds."""
    units = {
        "first": {"fmu": native_fmu("van_der_pol", 2)},
        "spring": {"component": "CompliantJoint", "parameters": {"stiffness": 3.0, "damping": 0.1}},
        "f": {"fmu": native_fmu("told", fmi), "isolation": isolation, "parameters": {"rounding": rounding}},
        "second": {"fmu": native_fmu("van_der_pol", 3, STATE[3])},
        "sum": {"fmu": native_fmu("integrator", fmi)},
        "tail": {"fmu": native_fmu("dahlquist", 2), "parameters": {"k": 9.0}},
    }
    master = {"algorithm": algorithm, "step": 0.1, "extrapolation": 2}
    connections = ["f.now -> sum.u", "first.x0 -> spring.second_x"]
    data = {"stop_time": 8.0, "units": units, "connections": connections, "master": master}
    return run(read_scene(data), in_process=True, verify="no")


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("fmi", "isolation"), [(2, "none"), (3, "none"), (2, "process")])
def test_no_bit_of_others_follows_the_environment_of_an_fmu(fmi, isolation, algorithm):
    plain = others(fmi, isolation, 0, algorithm)
    for rounding in (1, 2, 3):
        changed = others(fmi, isolation, rounding, algorithm)
        assert changed.outcome == "done"
        for name in plain.columns:
            assert changed[name].tobytes() == plain[name].tobytes(), (name, rounding)
    assert set(plain["f.third"][1:]) == {1.0 / 3.0}


def test_the_environment_of_the_start_comes_back():
    """Each of what a library may leave, where the C library can set it."""
    if not environment.CELLS:
        pytest.skip("no fesetenv on this machine")
    library = ctypes.CDLL("libm.so.6")
    one, little, below = (np.array(x) for x in (1.0, 2.0**-60, 5e-324))
    for mode in MODES:
        if library.fesetround(mode) == 0:
            environment.restore()
            assert (one + little, one - little) == (1.0, 1.0)
    words = (ctypes.c_uint32 * 64)()
    library.fegetenv(words)
    if ctypes.sizeof(ctypes.c_void_p) == 8 and words[7] & 0x1F80 == 0x1F80:  # the control word of SSE
        for flush in (0x8000, 0x40):
            words[7] |= flush
            library.fesetenv(words)
            environment.restore()
            assert below * 1.0 > 0.0
            assert np.array(2.0**-1022) * 0.5 > 0.0
