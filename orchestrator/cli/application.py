"""The application with all commands."""

from __future__ import annotations

from . import catalogue, compare, fmus, many, new, new_scene, railway, run, show, studies, validate  # noqa: F401 - each adds its commands
from .common import app

__all__ = ["app"]
