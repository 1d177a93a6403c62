"""How the energy of a component changes along its own equations."""

from collections.abc import Callable

import numpy as np
from cosimo import Component


def energy_rate(unit: Component, derivatives: Callable[..., object], d: float = 1e-6) -> tuple[float, np.ndarray]:
    """dE/dt, W, and dx/dt (n,) at the present time, state and inputs, which stay: central differences of the energy over 2 d, s."""
    x, t, dx, energies = unit.x.copy(), unit.t, np.zeros(unit.x.size), []
    derivatives(t, x, unit.u[0], dx, *unit.arguments)
    for ahead in (d, -d):
        unit.x[:], unit.t = x + ahead * dx, t + ahead
        energies.append(unit.energy())
    unit.x[:], unit.t = x, t
    return (energies[0] - energies[1]) / (2.0 * d), dx
