"""Stiff contacts between two units: the law, and what the master needs to know of the bodies that touch."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from .model import UNIT_NAME, Model, Number, Positive

Endpoint = Annotated[str, Field(pattern=r"\S\.\S")]


class SideSettings(Model):
    """One of the bodies. Position, velocity, acceleration and force count in the same direction, the same for both bodies."""

    force: Endpoint = Field(description="unit.input that gets the contact's force")
    position: Endpoint = Field(description="unit.output")
    velocity: Endpoint | None = Field(default=None, description="unit.output; needed with inertia, and with damping of the law")
    acceleration: Endpoint | None = Field(
        default=None, description="unit.output, with inertia only: the other forces are then known at once, not by their effect"
    )
    compliance: Endpoint | None = Field(
        default=None, description="unit.output: what the position leaves out, in series with the law, m/N"
    )
    inertia: Positive | None = Field(default=None, description="kg the contact sets in motion, 1/(d acceleration / d force)")
    impedance: Positive | None = Field(default=None, description="or N.s/m, of a body that answers a force by a velocity: a wire")
    degree: Literal[0, 1, 2] | None = Field(
        default=None, description="of the polynomial of the other forces on the body; default: master.extrapolation"
    )

    @model_validator(mode="after")
    def _one_model(self) -> SideSettings:
        if (self.inertia is None) == (self.impedance is None):
            raise BadInput(
                "", "neither inertia nor impedance" if self.inertia is None else "both inertia and impedance", "one of them"
            )
        if self.inertia is not None and self.velocity is None:
            raise BadInput("velocity", "none", "the output with the velocity; a body with inertia needs it")
        if self.acceleration is not None and self.inertia is None:
            raise BadInput("acceleration", repr(self.acceleration), "none for a body with impedance", "Remove it.")
        return self


class ContactSettings(Model):
    """A contact: indentation = first position - second position - clearance; the first body presses against the second.

    The force pushes the second body in the direction its position counts, the first one in the opposite one. Every algorithm
    has the law; "interface-model" alone makes use of the bodies' inertia or impedance, of `degree` and of `leader`.
    """

    name: Annotated[str, Field(pattern=UNIT_NAME)] = Field(description="the contact's name; its outputs: force, indentation")
    law: Literal["spring", "unilateral", "hertz"] = Field(
        description=("spring: k g + d g'; unilateral: the same, but never pulling; hertz: k g^1.5 (1 + d g') where g > 0")
    )
    stiffness: Positive = Field(description="N/m; of hertz N/m^1.5")
    damping: Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)] = Field(
        default=0.0, description="N.s/m; of hertz s/m"
    )
    clearance: Number = Field(default=0.0, description="m")
    leader: Literal["first", "second"] | None = Field(
        default=None,
        description=(
            "the body that steps first; the other gets the force that follows from its answer, and what the leader has missed is "
            "handed over in the next step. Default: both at once, with the same force"
        ),
    )
    first: SideSettings
    second: SideSettings

    @model_validator(mode="after")
    def _rates_known(self) -> ContactSettings:
        for label, side in (("first", self.first), ("second", self.second)):
            if self.damping and side.velocity is None:
                raise BadInput(f"{label}.velocity", "none", "the output with the velocity; a law with damping needs it")
        return self
