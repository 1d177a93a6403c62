"""The public interface: every name loads, none is heavy before it is asked for."""

from __future__ import annotations

import subprocess
import sys

import cosimo
import pytest
from cosimo.components.public_names import PLACE
from cosimo.tests.support import two_masses


@pytest.mark.parametrize("name", cosimo.__all__)
def test_every_public_name_loads_and_says_what_it_is(name):
    assert (getattr(cosimo, name).__doc__ or "").strip()
    assert name in dir(cosimo)
    assert name in (cosimo.__doc__ or "") or name == "component_class"


def test_all_is_what_the_table_of_places_holds():
    assert sorted([*cosimo._PLACE, *PLACE]) == sorted(cosimo.__all__)


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = cosimo.no_such_name


def test_a_scene_from_data_is_run_and_reported(tmp_path):
    result = cosimo.run(cosimo.read_scene(two_masses()), in_process=True)
    assert result.outcome == "done"
    assert cosimo.write_report(result, tmp_path).stat().st_size > 10_000


def test_the_package_loads_nothing_heavy():
    code = "import sys, cosimo; print([m for m in ('numpy', 'numba', 'scipy', 'pydantic', 'plotly', 'fmpy') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
