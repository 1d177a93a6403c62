"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import chain_closed_forms, gimbal_closed_forms, link_split, paper_two_links

CASES = tuple(module.CASE for module in (chain_closed_forms, gimbal_closed_forms, link_split, paper_two_links))
