"""The application with all commands: each module adds its own."""

from __future__ import annotations

from . import (  # noqa: F401 - each adds its commands
    agents,
    bearings,
    catalogue,
    compare,
    estimate,
    explore,
    export,
    fmus,
    instants,
    many,
    new,
    new_scene,
    open_report,
    railway,
    run,
    show,
    studies,
    validate,
)
from .common import app

__all__ = ["app"]
