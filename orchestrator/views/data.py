"""Results as data of pandas and xarray, with units of measure and where they come from."""

from __future__ import annotations

import json
from collections.abc import Iterable
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ...components.core.errors import BadInput
from . import Recorded

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def to_pandas(result: Recorded, signals: Iterable[str] | None = None) -> pd.DataFrame:
    """Columns over the index "time", s. attrs: "units" by column, and what `to_xarray` has as attributes of the data set.

    Raises `BadInput` where pandas is missing, or for a signal that was not recorded.
    """
    pandas = library("pandas")
    names = result.signals(signals)
    frame = pandas.DataFrame({n: result[n] for n in names}, index=pandas.Index(result.time, name="time"), columns=names)
    frame.attrs = {"units": {n: result.measures.get(n, "") for n in names}, **_provenance(result)}
    return frame


def to_xarray(result: Recorded, signals: Iterable[str] | None = None) -> xr.Dataset:
    """Signals over "time", each with `units` and `long_name`; snapshots as arrays over their own times and indices from 1.

    Attributes of the data set: title, outcome, message, warnings, versions, and all of run.json as text in "run". With `signals`
    only those, and no snapshots but those that it names. Raises `BadInput` where xarray is missing, or for an unknown signal.
    """
    xarray = library("xarray")
    wanted = None if signals is None else list(signals)
    arrays = [n for n in result.snapshots if wanted is None or n in wanted]
    names = result.signals(None if wanted is None else [n for n in wanted if n not in arrays])
    data: dict[str, Any] = {n: ("time", result[n], _attributes(result, n)) for n in names}
    coordinates: dict[str, Any] = {"time": ("time", result.time, {"units": "s", "long_name": "simulated time"})}
    for name in arrays:
        snapshot, (times, places) = result.snapshots[name], (f"{name}.time", f"{name}.index")
        data[name if name not in data else f"{name}.snapshots"] = ((times, places), snapshot.values, _attributes(result, name))
        coordinates[times] = (times, snapshot.time, {"units": "s", "long_name": "times of the snapshots"})
        coordinates[places] = (places, np.arange(1, snapshot.values.shape[1] + 1))
    return xarray.Dataset(data, coordinates, _provenance(result))


def library(name: str, wanted_by: str = "", package: str = "") -> Any:
    """A library that cosimo can do without, or a module of a package.

    Raises `BadInput`, whose place is `wanted_by` or "to_name", where it is missing.
    """
    package = package or name
    try:
        return import_module(name)
    except ImportError:
        where = wanted_by or f"to_{name}"
        raise BadInput(where, f"no {package} in this Python", "an installed library", f"pip install {package}.") from None


def _attributes(result: Recorded, name: str) -> dict[str, str]:
    """Unit of measure, and what the signal is where its component says so."""
    unit, variable = result.scene.split(name)
    text = ""
    with suppress(BadInput, KeyError):  # an FMU; a component whose module is not here; a unit that the run has added
        cls = result.scene.kinds[unit].component_class
        text = next((v.text for n, v in cls.variables.items() if variable in (n, n.partition("[")[0])), "") if cls else ""
    measure = result.measures.get(name, result.measures.get(f"{name}[1]", ""))
    return {"units": measure, "long_name": text or name}


def _provenance(result: Recorded) -> dict[str, Any]:
    info = result.info
    return {
        "title": result.scene.title or result.scene.name,
        "scene": result.scene.name,
        "outcome": result.outcome,
        "message": result.message,
        "warnings": list(info.warnings),
        "versions": ", ".join(f"{n} {v}" for n, v in info.versions.items()),
        "run": json.dumps(info.to_json(), default=str),
    }
