"""Who feeds whom in a scene: connections, contacts, bonds and faults as one checked graph, before anything runs."""

from .graph import Endpoint, Link
from .resolve import Coupling, resolve_coupling

__all__ = ["Coupling", "Endpoint", "Link", "resolve_coupling"]
