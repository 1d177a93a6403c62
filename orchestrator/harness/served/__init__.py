"""Scenes of any units, FMUs of others among them, in the browser: a local process holds the session, a page moves its inputs."""

from .application import serve

__all__ = ["serve"]
