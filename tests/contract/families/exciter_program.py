"""Program of a pipe robot's exciter."""

from __future__ import annotations

from cosimo.tests.contract.families import Facts

FACTS: dict[str, Facts] = {
    "ExciterProgram": Facts(
        small={"start_amplitude": 10.0},
        moving=frozenset({"*"}),
        plain=((), {"start_amplitude": 10.0}, 20),
    ),
}
