"""What a report says of itself: an authority keeps it, and others cite it."""

from __future__ import annotations

from pydantic import Field

from .model import Model


class DocumentSettings(Model):
    """Texts of the first page of a report, each as it is to be printed. No result depends on them."""

    title: str = Field(default="", description="title of the report; default: title of the scene")
    object: str = Field(default="", description="what was simulated: a line, a vehicle, a machine")
    author: str = Field(default="", description="who answers for the report")
    organisation: str = Field(default="", description="company, office or institute")
    number: str = Field(default="", description="number of the report")
    date: str = Field(default="", description="date of the report; default: the day on which the report is written")
