"""The application with all commands."""

from __future__ import annotations

from . import (  # noqa: F401 - each adds its commands
    catalogue,
    compare,
    explore,
    fmus,
    many,
    new,
    new_scene,
    railway,
    run,
    show,
    studies,
    validate,
)
from .common import app

__all__ = ["app"]
