"""The application with all commands."""

from __future__ import annotations

from . import (  # noqa: F401 - each adds its commands
    accuracy,
    answers,
    cache,
    catalogue,
    dataset,
    effects,
    many,
    new,
    packing,
    railway,
    run,
    schema,
    show,
    stability,
    validate,
)
from .common import app

__all__ = ["app"]
