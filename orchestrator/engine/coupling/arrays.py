"""Arrays by their name: their elements among variables, which are called "name[1]", "name[1,2]" ..."""

from __future__ import annotations

from collections.abc import Iterable


def is_element(name: str) -> bool:
    """Whether a variable is called as an element of an array is; "flow [kg]" and "x[1].y" are not."""
    before, bracket, indices = name.rpartition("[")
    return bool(before and bracket) and indices.endswith("]") and all(i.strip().isdigit() for i in indices[:-1].split(","))


def elements(array: str, variables: Iterable[str]) -> dict[tuple[int, ...], str]:
    """Indices -> variable, of all elements of an array; empty where there is no such array."""
    named = {}
    for name in variables:
        if name.startswith(f"{array}[") and name.endswith("]"):
            indices = name[len(array) + 1 : -1].split(",")
            if all(i.strip().isdigit() for i in indices):
                named[tuple(map(int, indices))] = name
    return named


def shape_of(name: str, variables: Iterable[str]) -> str:
    """ "(3)" or "(2, 3)" of an array, "()" of a single variable, "" of what is not among the variables."""
    variables = list(variables)
    if name in variables:
        return "()"
    named = elements(name, variables)
    return f"({', '.join(str(max(axis)) for axis in zip(*named, strict=False))})" if named else ""
