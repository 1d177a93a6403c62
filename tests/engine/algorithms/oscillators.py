"""Two masses cut in three ways, masters that start with an exact past, and the matrix of one macro step.

    m1 x1'' = -k1 x1 - c1 x1' + f      m2 x2'' = -k2 x2 - c2 x2' - f      f = kc (x2 - x1) + cc (x2' - x1')

"FF": both masses get the force, which a unit without states computes from both motions. "FD": the first mass gets the force,
the second owns the coupling spring and gets the motion of the first. "DD": both own the coupling and get each other's motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms import Master, master_of
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.settings import IterationSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import open_unit
from cosimo.tests.support import Linear
from scipy.linalg import expm

HERE = "cosimo.tests.engine.algorithms.oscillators"


class Feedthrough(Linear):
    """x' = a x + b u, y = c x + d u."""

    a = parameter(-0.9, "1/s", "decay")
    b = parameter(0.5, "1/s", "gain of the input")
    c = parameter(3.0, "1", "gain of the state in the output")
    d = parameter(1.0, "1", "gain of the input in the output")
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "output", feedthrough=("u_in",))
    x_out = output("1", "state")

    def matrices(self):
        p = self.parameters
        return np.array([[p["a"]]]), np.array([[p["b"]]]), np.array([[p["c"]], [1.0]]), np.array([[p["d"]], [0.0]]), [1.0]


class Accelerated(Linear):
    """A mass on a spring that gets a force, with its acceleration; displaced by 1 m at the start."""

    m = parameter(0.45, "kg", "mass")
    k = parameter(0.5, "N/m", "spring to the ground")
    force = input_(0.0, "N", "force")
    x_out = output("m", "position")
    a_out = output("m/s2", "acceleration", feedthrough=("force",))

    def matrices(self):
        A = np.array([[0.0, 1.0], [-self.parameters["k"] / self.parameters["m"], 0.0]])
        B = np.array([[0.0], [1.0 / self.parameters["m"]]])
        return A, B, np.vstack(([1.0, 0.0], A[1])), np.vstack(([0.0], B[1])), [1.0, 0.0]


class Carried(Linear):
    """A mass on a spring that goes where it is taken: the force on what takes it along."""

    m = parameter(0.55, "kg", "mass")
    k = parameter(0.5, "N/m", "spring to the ground")
    position = input_(0.0, "m", "position")
    acceleration = input_(0.0, "m/s2", "acceleration")
    force = output("N", "force on the other part", feedthrough=("position", "acceleration"))

    def matrices(self):
        p = self.parameters
        return np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((1, 0)), np.array([[-p["k"], -p["m"]]]), np.zeros(0)


class Between(Linear):
    """Spring and damper between two ends, without a state: the force on the first end."""

    kc = parameter(100.0, "N/m", "stiffness")
    cc = parameter(0.01, "N.s/m", "damping")
    x1 = input_(0.0, "m", "position of the first end")
    v1 = input_(0.0, "m/s", "velocity of the first end")
    x2 = input_(0.0, "m", "position of the second end")
    v2 = input_(0.0, "m/s", "velocity of the second end")
    force = output("N", "force on the first end", feedthrough=("x1", "v1", "x2", "v2"))

    def matrices(self):
        k, c = self.parameters["kc"], self.parameters["cc"]
        return np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((1, 0)), np.array([[-k, -c, k, c]]), np.zeros(0)


class OneSided(Between):
    """The same for ends that can part: no force while the first has not passed the second, and never a pull."""

    kc = parameter(1e6, "N/m", "stiffness")
    cc = parameter(0.0, "N.s/m", "damping")

    def _step(self, t, h):
        status = super()._step(t, h)
        self._outputs(t)
        return status

    def _outputs(self, t):
        super()._outputs(t)
        self.y[0] = min(self.y[0], 0.0) if self.u[0, 0] > self.u[0, 2] else 0.0


@dataclass(frozen=True)
class TwoMasses:
    """The parameters, and (x1, v1, x2, v2) at t = 0; by default case 1 of the LIM oscillator (fgonzalezLIM/cosim-benchmarks)."""

    m1: float = 1.0
    m2: float = 1.0
    k1: float = 10.0
    kc: float = 100.0
    k2: float = 1000.0
    c1: float = 0.01
    cc: float = 0.01
    c2: float = 0.01
    start: tuple[float, float, float, float] = (0.0, 100.0, 0.0, -100.0)

    @property
    def whole(self) -> np.ndarray:
        """Matrix of the uncut system, (4, 4)."""
        k1, kc, k2, c1, cc, c2, m1, m2 = self.k1, self.kc, self.k2, self.c1, self.cc, self.c2, self.m1, self.m2
        return np.array(
            [
                [0, 1, 0, 0],
                [-(k1 + kc) / m1, -(c1 + cc) / m1, kc / m1, cc / m1],
                [0, 0, 0, 1],
                [kc / m2, cc / m2, -(k2 + kc) / m2, -(c2 + cc) / m2],
            ]
        )

    def exact(self, t: float) -> np.ndarray:
        """(x1, v1, x2, v2) at t."""
        return expm(self.whole * t) @ np.array(self.start)

    def scene(self, split: str, step: float, stop: float = 1.0, **master) -> dict:
        """Scene data of a split."""
        mass = {"component": "cosimo.tests.support:Mass"}
        first = {**mass, "parameters": {"m": self.m1, "k": self.k1, "c": self.c1, "x0": self.start[0], "v0": self.start[1]}}
        second = {**mass, "parameters": {"m": self.m2, "k": self.k2, "c": self.c2, "x0": self.start[2], "v0": self.start[3]}}
        coupling = {"kc": self.kc, "cc": self.cc}
        owner = {"component": "cosimo.tests.support:Oscillator"}
        units = {
            "FF": {"a": first, "b": second, "f": {"component": f"{HERE}:Between", "parameters": coupling}},
            "FD": {"a": first, "b": {**owner, "parameters": second["parameters"] | coupling}},
            "DD": {
                "a": {**owner, "parameters": first["parameters"] | coupling},
                "b": {**owner, "parameters": second["parameters"] | coupling},
            },
        }[split]
        motion = ["a.x_out -> b.position", "a.v_out -> b.velocity"]
        connections = {
            "FF": [
                "f.force -> a.force",
                {"source": "f.force", "target": "b.force", "factor": -1.0},
                "a.x_out -> f.x1",
                "a.v_out -> f.v1",
                "b.x_out -> f.x2",
                "b.v_out -> f.v2",
            ],
            "FD": ["b.force -> a.force", *motion],
            "DD": [*motion, "b.x_out -> a.position", "b.v_out -> a.velocity"],
        }[split]
        return {"stop_time": stop, "connections": connections, "units": units, "master": {"step": step, **master}}


STATES = [("a", "x_out"), ("a", "v_out"), ("b", "x_out"), ("b", "v_out")]
TIGHT = IterationSettings(tolerance=1e-11, max_iterations=60)


def open_master(scene: dict, watched=STATES, iteration: IterationSettings | None = None) -> Master:
    """The master of a scene with its units in this process, initialized."""
    checked = read_scene(scene)
    if iteration is not None and checked.master.algorithm == "iterative":
        checked = read_scene({**scene, "master": {**scene["master"], "iteration": iteration.model_dump()}})
    units = {name: open_unit(name, settings, in_process=True) for name, settings in checked.units.items()}
    master = master_of(checked, units, resolve_coupling(checked), watched)
    master.initialize(0.0)
    return master


def give_samples(node, rows, step: float) -> None:
    """Samples of a node's inputs, `step` apart, in the place of those it has; rows: (samples, inputs), the oldest first."""
    links, samples = node.link_records, node.sample_records
    samples["samples"], samples["h1"], samples["h2"] = len(rows), step, step
    for name, row in zip(("present", "before", "earlier"), rows[::-1], strict=False):
        links[name] = row


def give_past(master: Master, exact, step: float, degree: int) -> None:
    """Exact inputs at 0, -step, ... instead of the one sample a run starts with; `exact(t)`: (unit, output) -> value."""
    for node in master.nodes:
        rows = [[link.factor * exact(-k * step)[link.source] + link.offset for link in node.links] for k in range(degree, -1, -1)]
        give_samples(node, rows, step)


def step_matrix(scene: dict) -> np.ndarray:
    """What one macro step does to all states and kept inputs of a linear scene, column by column."""
    master = open_master(scene, (), TIGHT)
    degree, step = scene["master"].get("extrapolation", 1), scene["master"]["step"]
    components = [node.unit.component for node in master.nodes]
    sizes = [(c.x.size, len(node.links) * (degree + 1)) for c, node in zip(components, master.nodes, strict=True)]
    n = sum(map(sum, sizes))

    def write(state: np.ndarray) -> None:
        parts = np.split(state, np.cumsum([k for pair in sizes for k in pair])[:-1])
        for node, component, x, samples in zip(master.nodes, components, parts[::2], parts[1::2], strict=True):
            component.x = x.copy()
            rows = samples.reshape(degree + 1, -1)
            give_samples(node, rows, step)
            component.u[:] = 0.0
            component.u[0, component.input_positions([link.target[1] for link in node.links])] = rows[-1]
            component.refresh()
            node.read()

    def read() -> np.ndarray:
        rows = []
        for node, component in zip(master.nodes, components, strict=True):
            kept = [node.link_records[name] for name in ("earlier", "before", "present")][2 - degree :]
            rows += [component.x, *kept]
        return np.concatenate(rows)

    columns = []
    for unit in np.eye(n):
        write(unit)
        master.step(0.0, step)
        columns.append(read())
    return np.array(columns).T


def radius(scene: dict) -> float:
    """Largest absolute eigenvalue of one macro step: above 1 the coupling grows."""
    return float(np.abs(np.linalg.eigvals(step_matrix(scene))).max())
