"""Who reads the numbers of a function: what is kept, or decisions alone.

A number that only comparisons read, such as the largest change in an iteration, or that is only made a whole number of, may have
kinks: they are nobody's but where the decision itself stands at its boundary.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from .grammar import NAME, Function, Instruction, is_floating
from .rules import FLAT, KINKED, PARTIALS, SAME

MOVES = ("phi", "select", "freeze", "bitcast", "insertelement", "extractelement", "shufflevector")  # hand numbers on


def name_of(callee: str) -> str:
    """The name of a function without the types that its name has."""
    return re.sub(r"\.(v\d+)?f64$", "", callee[1:].strip('"').removeprefix("llvm."))


def read(function: Function, sources: Mapping[str, Instruction]) -> tuple[set[str], set[str]]:
    """(names that something else reads than decisions and arithmetic for these, results of such arithmetic).

    sources: the instruction that gives a name.
    """
    known = set[str]()
    others = (i for i in function.body if not (_decides(i) or _computes(i)))
    waiting = [name for i in others for name in re.findall(NAME, i.line)]
    while waiting:
        if (name := waiting.pop()) not in known:
            known.add(name)
            if (source := sources.get(name)) and _computes(source):
                waiting += re.findall(NAME, source.line)
    return known, {i.result for i in function.body if i.result not in known and _computes(i)}


def _decides(i: Instruction) -> bool:
    return i.op in ("fcmp", "fptosi", "fptoui") or name_of(i.callee) in FLAT


def _computes(i: Instruction) -> bool:
    """Whether an instruction makes a number of numbers."""
    name = name_of(i.callee)
    return is_floating(i.type) and (i.op in (*PARTIALS, *MOVES) or SAME.get(name, name) in (*PARTIALS, *KINKED))
