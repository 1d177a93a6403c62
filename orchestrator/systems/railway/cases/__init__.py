"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import catenary_statics, en50318_2002, en50318_2018, en50367, lumped_catenary, paper_pantograph

CASES = (
    en50318_2002.CASE,
    en50318_2018.AC_SIMPLE,
    en50318_2018.AC_STITCHED,
    en50318_2018.DC_SIMPLE,
    en50367.CASE,
    catenary_statics.CASE,
    lumped_catenary.CASE,
    paper_pantograph.CASE,
)
