"""Components whose runs misbehave on purpose, and what tests of many runs share."""

import os
import signal
import time

from cosimo.components.core.variables import output, parameter
from cosimo.tests.support import OfTime


class Doubler(OfTime):
    """Gives twice its parameter, after a pause; may end its process, once or whenever it is run."""

    value = parameter(1.0, "m", "what is doubled")
    pause = parameter(0.0, "s", "real time that a step takes")
    fatal = parameter(-1.0, "m", "the value with which it kills its process")
    fatal_once = parameter(-1.0, "m", "the value with which it does so as long as the file KILLED_ONCE is missing")
    twice = output("m", "two times the value")

    def _step(self, t, h):
        time.sleep(self.parameters["pause"])
        once = self.parameters["value"] == self.parameters["fatal_once"] and not os.path.exists(os.environ["KILLED_ONCE"])
        if once:
            open(os.environ["KILLED_ONCE"], "w").close()
        if once or self.parameters["value"] == self.parameters["fatal"]:
            os.kill(os.getpid(), signal.SIGKILL)
        return super()._step(t, h)

    def _outputs(self, t):
        self.y[:] = 2.0 * self.parameters["value"]


def scene(**parameters):
    """A scene of one step with a `Doubler`, as plain data."""
    unit = {"component": "cosimo.tests.harness.many.points:Doubler", "parameters": parameters}
    return {"stop_time": 1.0, "units": {"d": unit}, "master": {"step": 1.0}}


def last_and_first(result):
    """An own measure."""
    return {"last": result["d.twice"][-1], "rows": result.time.size}


def a_third(result):
    """An own measure that is one number."""
    return result["d.twice"][-1] / 3.0


def fails(result):
    """An own measure that raises."""
    raise KeyError("nothing")


class Formula(OfTime):
    """Gives closed forms of its parameters."""

    a = parameter(0.0, "1", "first number")
    b = parameter(0.0, "1", "second number")
    linear = output("1", "2 a + b")
    parabola = output("1", "(a - 1)² + (b - 2)²")
    total = output("1", "a + b")

    def _outputs(self, t):
        a, b = self.parameters["a"], self.parameters["b"]
        self.y[:] = 2.0 * a + b, (a - 1.0) ** 2 + (b - 2.0) ** 2, a + b


def formula(**parameters):
    """A scene of one step with a `Formula`, as plain data."""
    unit = {"component": "cosimo.tests.harness.many.points:Formula", "parameters": parameters}
    return {"stop_time": 1.0, "units": {"f": unit}, "master": {"step": 1.0}}
