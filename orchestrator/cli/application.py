"""The application with all commands: each module adds its own."""

from __future__ import annotations

from . import catalogue, compare, explore, fmus, many, new, new_scene, open_report, railway, run, show, studies, validate  # noqa: F401 - each adds its commands
from .common import app

__all__ = ["app"]
