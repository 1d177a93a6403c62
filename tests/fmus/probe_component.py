"""A component that is in no catalogue: every kind of variable, and every way to fail. Packed into a bundle by the tests."""

import numpy as np

from ..core.component import Component, Effect
from ..core.kernels import DONE, NOT_CONVERGED, hold_inputs
from ..core.variables import choice, input_, integer, output, parameter


class Bias(Effect):
    """A constant added to the level."""

    value = parameter(4.0, "N", "added constant", low=-10.0, high=10.0)
    tilt = input_(0.5, "rad", "an input that exists with the effect only")
    seen = output("rad", "the tilt as seen", feedthrough=(".tilt",))


class Needy(Effect):
    """An effect that cannot stand alone."""

    requires = ("bias",)


class Probe(Component):
    """Integral of the signal, and its weighted value.

    x' = signal, level = gain * weights[1] * signal
    """

    title = "Probe of the FMU tests"
    default_stop = 0.1

    bias = Bias
    needy = Needy

    gain = parameter(2.0, "1", "gain", low=0.0, high=10.0)
    count = integer(3, "whole number", low=1, high=9)
    mode = choice("plain", ("plain", "negative"), "sign of the level")
    weights = parameter(1.5, "N/m", "weights", size=2)
    signal = input_(0.0, "m", "signal; 30: no number, 40: exception, 50: failed step", nominal=0.1)
    level = output("N", "weighted signal", feedthrough=("signal",))
    total = output("m.s", "integral of the signal")

    def _initialize(self, t):
        if self.parameters["gain"] == 7.0:
            raise ArithmeticError("gain 7 cannot be initialized")
        self.x = np.zeros(1)
        return DONE

    def _step(self, t, h):
        signal, slope, half_second = self.u[:, 0]
        self.x[0] += h * (signal + h * (slope / 2.0 + h * half_second / 3.0))
        hold_inputs(self.u, h)
        self.refresh()
        if signal == 30.0:
            self.y[1] = np.nan
        if signal == 40.0:
            raise ZeroDivisionError("forty")
        return NOT_CONVERGED if signal == 50.0 else DONE

    def _outputs(self, t):
        p = self.parameters
        sign = -1.0 if p["mode"] == "negative" else 1.0
        self.y[0] = sign * p["gain"] * p["weights[1]"] * self.u[0, 0] + p.get("bias.value", 0.0)
        self.y[1] = self.x[0]
        if "bias" in self.on:
            self.y[2] = self.u[0, 1]
