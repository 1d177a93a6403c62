"""Energy that appears from nowhere at a power bond."""

from __future__ import annotations

from ..engine.algorithms.energy import EnergyAccount
from .thresholds import ENERGY


def energy_warnings(account: EnergyAccount) -> list[str]:
    """What a user should know of the energy that the coupling has made."""
    return [f"the coupling made {created:.3g} J at the bond {bond.text}, {100.0 * abs(created) / exchanged:.0f} % of the "
            "energy that went through it. Reduce master.step, or switch on master.energy_correction"
            for bond, created, exchanged in zip(account.bonds, account.created, account.exchanged, strict=True)
            if abs(created) > ENERGY * exchanged]
