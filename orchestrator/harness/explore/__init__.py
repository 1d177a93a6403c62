"""A scene as a page to play with: one file, which computes the scene in the browser."""

from .figures import LiveFigure
from .page import explore_page

__all__ = ["LiveFigure", "explore_page"]
