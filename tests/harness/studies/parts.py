"""A component whose effects are of sizes that are known: total = t + the sum of size * t over those that are on."""

from __future__ import annotations

from cosimo.components.core.component import Effect
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import input_, output, parameter
from cosimo.tests.support import OfTime


class Big(Effect):
    """Far above any tolerance."""

    size = parameter(0.5, "1", "slope")


class Medium(Effect):
    """Above 1 %."""

    size = parameter(0.02, "1", "slope")


class Small(Effect):
    """Below 1 %, but not together with the next."""

    size = parameter(0.008, "1", "slope")


class Smaller(Effect):
    """Below 1 %."""

    size = parameter(0.007, "1", "slope")


class Needy(Effect):
    """Nothing by itself; cannot be without the big one."""

    requires = ("big",)
    seen = output("1", "always 1")


class Rival(Effect):
    """Another form of the medium one."""

    excludes = ("medium",)
    size = parameter(0.03, "1", "slope")


class Port(Effect):
    """What comes from elsewhere."""

    slope = input_(0.1, "1", "slope")


class Load(Effect):
    """What a scene has, or has not."""

    explicit_only = True
    size = parameter(0.2, "1", "slope")


class Broken(Effect):
    """Cannot start."""

    size = parameter(0.1, "1", "slope")


class Parts(OfTime):
    """The sum of its parts."""

    title = "sum of known parts"
    big, medium, small, smaller, needy = Big, Medium, Small, Smaller, Needy
    rival, port, load, broken = Rival, Port, Load, Broken
    total = output("1", "the sum")

    def _initialize(self, t: float) -> int:
        if "broken" in self.on:
            raise BadInput(self.name, "the broken one", "none")
        return DONE

    def _outputs(self, t: float) -> None:
        slopes = [v for n, v in self.parameters.items() if n.endswith(".size")]
        if "port" in self.on:
            slopes.append(self.get("port.slope"))
        self.y[self._output_index["total"]] = t * (1.0 + sum(slopes))
        if "needy" in self.on:
            self.y[self._output_index["needy.seen"]] = 1.0
