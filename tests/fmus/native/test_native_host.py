"""The railway pair in a host that is a C program, with an empty environment: no Python is near."""

from importlib.util import find_spec

import pytest
from cosimo.tests.fmus.native.railway_pair import WINE, arguments, host, in_process, possible, run_host

pytestmark = [pytest.mark.full, pytest.mark.skipif(not possible, reason="needs Linux and a C compiler")]


def test_a_host_in_c_gives_the_bits_of_the_components_in_process(tmp_path):
    outputs, durations = run_host(host(tmp_path), arguments(tmp_path), 1e-3, 500, 2)
    assert outputs == in_process(1e-3, 500)
    assert all(0.0 < mean <= longest for mean, _, longest in durations)


@pytest.mark.skipif(WINE is None or find_spec("ziglang") is None, reason="needs Wine and the compiler of the extra `native`")
def test_windows_libraries_give_the_same_numbers(tmp_path):
    """Another mathematics library: last digits may differ."""
    environment = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "HOME": str(tmp_path)}
    outputs, _ = run_host(host(tmp_path, "win64"), arguments(tmp_path, "win64"), 1e-3, 500, 1, **environment)
    assert outputs == pytest.approx(in_process(1e-3, 500), rel=1e-12)
