"""Which output feeds which input: connections, contacts, bonds and faults of a scene as one graph, checked before a run."""

from .connections import expanded_connection
from .graph import Endpoint, Link
from .resolve import Coupling, resolve_coupling

__all__ = ["Coupling", "Endpoint", "Link", "expanded_connection", "resolve_coupling"]
