"""Who feeds whom in a scene: connections, contacts, bonds and faults as one checked graph, before anything runs."""

from .graph import Endpoint, Link
from .settling import Coupling, settle

__all__ = ["Coupling", "Endpoint", "Link", "settle"]
