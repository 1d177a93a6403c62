"""The railway pair in a host that is a C program, with an empty environment: no Python is near."""

import pytest
from cosimo.tests.fmus.native.railway_pair import arguments, host, in_process, possible, run_host

pytestmark = [pytest.mark.full, pytest.mark.skipif(not possible, reason="needs Linux and a C compiler")]


def test_a_host_in_c_gives_the_bits_of_the_components_in_process(tmp_path):
    outputs, durations = run_host(host(tmp_path), arguments(tmp_path), 1e-3, 500, 2)
    assert outputs == in_process(1e-3, 500)
    assert all(0.0 < mean <= longest for mean, _, longest in durations)
