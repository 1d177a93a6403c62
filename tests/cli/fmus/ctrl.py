"""A spring as a plain pythonfmu slave."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Ctrl(Fmi2Slave):
    """force = -8 x"""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = self.v = self.force = 0.0
        for name in ("x", "v"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Real("force", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.force = -8.0 * self.x
        return True
