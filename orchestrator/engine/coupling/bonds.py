"""Power bonds: two connected outputs whose product is the power that goes through their connections."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isclose

from ....components.core.errors import BadInput
from ....components.core.measure import BASES, parse
from ...units import Interface
from .graph import Endpoint, Link

WATT = parse("W").exponents
ANGLE = BASES.index("rad")  # N.m times rad/s is a power as well


@dataclass(frozen=True)
class Bond:
    """A pair of connections in opposite directions. Power is positive where it goes into the unit named first.

    `given[k]` is an output of one unit, and `links[k]` takes it to the other one. Each unit sees the power of its own output and
    of the input that it was given instead of the other's output.
    """

    text: str
    given: tuple[Endpoint, Endpoint]
    links: tuple[Link, Link]
    watts: float  # W into the first unit for the product of the two outputs' numbers


def bond(text: str, given: tuple[Endpoint, Endpoint], interfaces: Mapping[str, Interface], links: Iterable[Link]) -> Bond:
    """The bond between two outputs; raises `BadInput` where they are not connected both ways or make no power."""
    where, (first, second) = f"master.bonds: {text!r}", given
    one, other = _link(where, first, second[0], links), _link(where, second, first[0], links)
    sizes, exponents = [], [0] * len(BASES)
    measures = [interfaces[u].outputs[n].unit for u, n in given]
    for measure in measures:
        sizes.append(_size(measure))
        exponents = [e + m for e, m in zip(exponents, parse(measure or "1", where).exponents, strict=True)]
    exponents[ANGLE] = 0
    if all(measures) and tuple(exponents) != WATT:
        raise BadInput(
            where,
            f"a product in {' times '.join(measures)}",
            "a power",
            "Name velocity and force, angular speed and torque, voltage and current.",
        )
    gains = [
        link.factor * _size(interfaces[link.target[0]].inputs[link.target[1]].unit) / size
        for link, size in zip((one, other), sizes, strict=True)
    ]
    if not isclose(abs(gains[0]), abs(gains[1])):  # within rounding of the conversions between units of measure
        raise BadInput(
            where,
            f"connections with factors {one.factor:g} and {other.factor:g}",
            "the same gain both ways; one side would give another power than the other gets",
        )
    return Bond(text, given, (one, other), sizes[0] * sizes[1] * gains[1])


def _size(measure: str) -> float:
    return parse(measure).factor if measure else 1.0


def _link(where: str, output: Endpoint, unit: str, links: Iterable[Link]) -> Link:
    both = [link for link in links if link.source == output and link.target[0] == unit]
    if len(both) != 1:
        raise BadInput(where, f"{'.'.join(output)}, which feeds {len(both) or 'no'} inputs of {unit}", "one connection each way")
    if both[0].offset or not both[0].factor:
        raise BadInput(
            where,
            f"factor {both[0].factor:g} and offset {both[0].offset:g} on the way from {'.'.join(output)}",
            "a factor other than 0 and no offset",
        )
    return both[0]
