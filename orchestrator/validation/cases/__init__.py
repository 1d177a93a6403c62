"""All validation cases by name; a case listed here is run by `cosimo validate`."""

from __future__ import annotations

from ..case import Case

CASES: dict[str, Case] = {}
