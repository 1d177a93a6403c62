"""What each master algorithm is and does, as data: scenes, checks and studies go by this and ask for no name.

A new algorithm is a file with its class, and a line here.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Abilities:
    """Of one algorithm.

    place: its class, below `engine.algorithms`.  text: for whom chooses.
    options: settings of [master] that it knows, of those that others do not.
    sequential: units step one after the other, in an order that a scene may give, and later ones know what earlier ones reached.
    rollback: steps of units that feed one another are repeated: they have to save their state.
    reduces_contacts: the law of a contact is solved inside the step, between bodies reduced to their inertia.
    rates: units may step at rates of their own.
    """

    place: str
    text: str
    options: tuple[str, ...] = ("feedthrough",)
    sequential: bool = False
    rollback: bool = False
    reduces_contacts: bool = False
    rates: bool = False


ALGORITHMS: dict[str, Abilities] = {
    "jacobi": Abilities("jacobi:Jacobi", "all units at once", rates=True),
    "gauss-seidel": Abilities(
        "gauss_seidel:GaussSeidel", "each with what those before it gave", ("feedthrough", "order"), sequential=True, rates=True
    ),
    "iterative": Abilities(
        "iterative:Iterative", "steps repeated until inputs fit outputs, needs rollback", ("iteration",), rollback=True
    ),
    "interface-model": Abilities("interface_model:InterfaceModel", "contacts solved inside the step", reduces_contacts=True),
}
