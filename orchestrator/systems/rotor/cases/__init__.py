"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import friswell, jeffcott

CASES = tuple(module.CASE for module in (friswell, jeffcott))
