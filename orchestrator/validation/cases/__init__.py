"""All validation cases by name; a case listed here is run by `cosimo validate`."""

from __future__ import annotations

from ..case import Case
from . import catenary_statics, en50318_2002, en50318_2018, en50367, lumped_catenary

CASES: dict[str, Case] = {
    case.name: case for case in (en50318_2002.CASE, en50318_2018.CASE, en50367.CASE, catenary_statics.CASE, lumped_catenary.CASE)
}
