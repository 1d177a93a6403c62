"""Master algorithms by the name a scene calls them."""

from .gauss_seidel import GaussSeidel
from .iterative import Iterative
from .jacobi import Jacobi
from .master import Master

ALGORITHMS: dict[str, type[Master]] = {"jacobi": Jacobi, "gauss-seidel": GaussSeidel, "iterative": Iterative}

__all__ = ["ALGORITHMS", "Master"]
