"""How the units of a scene are stepped and how values are handed over."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from ...components.core.errors import BadInput
from .algorithms import ALGORITHMS, Abilities
from .model import Model, Positive, Seconds, Truth

FORMER_FEEDTHROUGH = {"fresh": "immediate", "stale": "delayed"}  # spelling until 0.5


class IterationSettings(Model):
    """Of algorithm = "iterative": repeating a macro step until the inputs fit the outputs."""

    tolerance: Positive = Field(default=1e-8, description="largest miss of a coupled signal, relative to its size or nominal")
    max_iterations: Annotated[int, Field(strict=True, ge=1, le=1_000_000)] = Field(
        default=20, description="largest number of iterations of one macro step"
    )
    not_converged: Literal["stop", "warn"] = Field(default="stop", description="reaction to max_iterations without convergence")

    @model_validator(mode="before")
    @classmethod
    def _former_setting(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and "method" in data:
            raise BadInput("method", repr(data["method"]), "no such setting", "All iterate by quasi-Newton since 0.8: remove it.")
        return data


class ControlSettings(Model):
    """The macro step follows an error estimate instead of being fixed."""

    method: Literal["milne", "doubling"] = Field(
        description="milne: predicted against reached inputs, no rollback; doubling: one step against two halves, needs rollback"
    )
    relative: Positive = Field(default=1e-4, description="error allowed in a step, relative to a value")
    absolute: Positive = Field(default=1e-4, description="tolerance relative to the nominal value, for values near zero")
    min_step: Seconds | None = Field(default=None, description="s; default: a thousandth of master.step; all steps are multiples")
    max_step: Seconds | None = Field(default=None, description="s; default: the whole run")

    @field_validator("method", mode="before")
    @classmethod
    def _former_method(cls, value: Any) -> Any:
        if value == "energy":
            raise BadInput("", "'energy'", "'milne' or 'doubling'", "It went with 0.8; 'milne' needs as little of the units.")
        return value

    @model_validator(mode="after")
    def _ordered(self) -> ControlSettings:
        if self.min_step is not None and self.max_step is not None and self.min_step > self.max_step:
            raise BadInput("max_step", f"{self.max_step:g} s", f"at least min_step, {self.min_step:g} s")
        return self


class MasterSettings(Model):
    """The algorithm that steps the units and hands values over."""

    algorithm: Literal[tuple(ALGORITHMS)] = Field(  # type: ignore[valid-type]
        default="gauss-seidel", description="; ".join(f"{name}: {of.text}" for name, of in ALGORITHMS.items())
    )
    step: Seconds = Field(description="macro step, s; with control the first one; the last one is shorter where it does not fit")
    extrapolation: Literal[0, 1, 2] = Field(default=1, description="degree of the inputs' polynomial: held, linear, quadratic")
    moving_places: Literal["linear", "held"] = Field(
        default="linear",
        description=(
            "with extrapolation = 0: places that move on, such as a contact's, follow a line; or are held, as other masters do"
        ),
    )
    feedthrough: Literal["immediate", "delayed"] = Field(
        default="immediate", description="outputs follow their inputs within an instant, or one step later"
    )
    order: tuple[str, ...] = Field(default=(), description="gauss-seidel only: all units in the order of stepping")
    iteration: IterationSettings | None = Field(default=None, description="iterative only")
    control: ControlSettings | None = Field(default=None, description="default: every macro step has the length `step`")
    events: tuple[str, ...] = Field(
        default=(), description="unit.output whose changes of sign are located: a macro step ends there; needs rollback"
    )
    bonds: tuple[str, ...] = Field(
        default=(),
        description=('"a.velocity * b.force": two connected outputs whose product is the power through that pair of connections'),
    )
    energy_correction: Truth = Field(default=False, description="returns at the bonds the energy the coupling made (NEPCE)")

    @model_validator(mode="before")
    @classmethod
    def _former_setting(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and "smoothing" in data:
            raise BadInput(
                "smoothing", repr(data["smoothing"]), "no such setting", "It went with 0.8: remove it, or shorten the step."
            )
        return data

    @field_validator("feedthrough", mode="before")
    @classmethod
    def _former_spelling(cls, value: Any) -> Any:
        if isinstance(value, str) and (new := FORMER_FEEDTHROUGH.get(value)):
            raise BadInput("", repr(value), "'immediate' or 'delayed'", f"Until 0.5 it was called {value!r}: write {new!r}.")
        return value

    @property
    def abilities(self) -> Abilities:
        """What the algorithm does."""
        return ALGORITHMS[self.algorithm]

    @model_validator(mode="after")
    def _options_matter(self) -> MasterSettings:
        for option in sorted({option for of in ALGORITHMS.values() for option in of.options}):
            value, default = getattr(self, option), type(self).model_fields[option].default
            if value != default and option not in self.abilities.options:
                able = " or ".join(f'"{name}"' for name, of in ALGORITHMS.items() if option in of.options)
                raise BadInput(option, f"no effect on {self.algorithm}", "", f"Remove it, or set algorithm = {able}.")
        if self.moving_places == "held" and self.extrapolation != 0:
            raise BadInput("moving_places", "'held'", "'linear' where the inputs are extrapolated", "Remove it.")
        if not self.bonds and self.energy_correction:
            raise BadInput("energy_correction", "true without bonds", "bonds = [...] as well")
        return self
