"""A mass on spring and damper as a plain pythonfmu slave: it takes a force and an outer one."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Msd(Fmi2Slave):
    """x'' = force + u - 2 x - 0.5 x', with steps of the symplectic Euler method."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.f = self.u = self.v = self.a = self.e = 0.0
        self.x = 1.0
        for name in ("f", "u"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x", "v", "a", "e"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.a = self.f - 2.0 * self.x - 0.5 * self.v + self.u
        self.v += step_size * self.a
        self.x += step_size * self.v
        self.e = self.v * self.v
        return True
