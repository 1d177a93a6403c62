"""Three applications: a satellite's panel unfolds, an arm follows set points, a jaw crusher turns; each beside a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad, solve_ivp

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene, load_scene
from .special_case import NAME

OPEN = 0.5 * math.pi  # rad, way of the panel to its stop
CRANK, JAW, TOGGLE, PIVOT = 0.012, 1.085, 0.455, (-0.45, -0.815)  # m
SETTLED = 2.0  # s, of the arm
GRAVITY = 9.81  # m/s²


@dataclass(frozen=True)
class Panelled:
    """A panel on a fixed hub: kg, m, N.m/rad, N.m, N.m.s/rad; its spring is relaxed 180° on."""

    mass: float
    length: float
    stiffness: float
    friction: float
    damping: float

    @property
    def inertia(self) -> float:
        """About the hinge, of a uniform panel, kg m²."""
        return self.mass * self.length**2 / 3.0

    def rate(self, angle: float) -> float:
        """Without the damper, rad/s: of the spring's energy less that of friction."""
        energy = self.stiffness * (math.pi * angle - 0.5 * angle**2) - self.friction * angle
        return math.sqrt(2.0 * energy / self.inertia)

    def at_stop(self) -> tuple[float, float]:
        """(time, rate) at the stop, s and rad/s: without the damper by quadrature, with it by SciPy's integration."""
        if self.damping == 0.0:
            # angle = s² takes away the infinite integrand at the start
            time = quad(
                lambda s: (
                    2.0 * s / self.rate(s * s)
                    if s > 0.0
                    else 2.0 / math.sqrt(2.0 * (self.stiffness * math.pi - self.friction) / self.inertia)
                ),
                0.0,
                math.sqrt(OPEN),
            )[0]
            return time, self.rate(OPEN)

        def rates(t: float, x: np.ndarray) -> list[float]:
            return [x[1], (self.stiffness * (math.pi - x[0]) - self.friction - self.damping * x[1]) / self.inertia]

        def reached(t: float, x: np.ndarray) -> float:
            return float(x[0]) - OPEN

        reached.terminal = True  # type: ignore[attr-defined]
        solution = solve_ivp(rates, (0.0, 100.0), [0.0, 0.0], events=reached, rtol=1e-10, atol=1e-12)
        return float(solution.t[-1]), float(solution.y[1, -1])


PANELS = {
    "panel": Panelled(5.0, 0.8, 0.25, 0.08, 0.0), "damped panel": Panelled(5.0, 0.8, 0.25, 0.08, 1.2),
    "wing": Panelled(20.0, 1.8, 0.5, 0.2, 0.0), "damped wing": Panelled(20.0, 1.8, 0.5, 0.2, 6.0),
    "small wing": Panelled(0.3, 0.3, 0.03, 0.005, 0.0),
}  # fmt: skip


def scenes() -> dict[str, Scene]:
    """Panels on fixed hubs, and the three scenes by their names."""
    return {"panels": _panels(), **{n: load_scene(n) for n in ("satellite-panel", "two-link-manipulator", "jaw-crusher")}}


def measure(runs: Runs) -> Evidence:
    """Deployments of fixed and free hubs, tracking of the arm, and kinematics of the crusher."""
    measured: dict[str, float] = {}
    for k, (name, panel) in enumerate(PANELS.items()):
        time, rate = _reached(runs["panels"], f"p{k}", OPEN, 1.0)
        closed_time, closed_rate = panel.at_stop()
        measured |= {
            f"time.{name}": time,
            f"rate.{name}": rate,
            f"time.over.{name}": time / closed_time,
            f"rate.over.{name}": rate / closed_rate,
        }
        measured[f"margin.{name}"] = panel.stiffness * OPEN / panel.friction
    measured |= _free(runs["satellite-panel"]) | _tracking(runs["two-link-manipulator"]) | _crusher(runs["jaw-crusher"])
    result = runs["panels"]
    closed = np.array([jaw_pose(a) for a in np.linspace(0.0, 2.0 * math.pi, 200).tolist()])
    drawn = {
        "t": result.time,
        "ways": {n: np.minimum(np.degrees(result[f"p{k}.relative_angle"]), 90.0) for k, n in enumerate(PANELS)},
        "stops": {"closed form at the stop": ([p.at_stop()[0] for p in PANELS.values()], [90.0] * len(PANELS))},
        "jaw": {"closed form": (1e3 * closed[:, 1], 1e3 * closed[:, 2])},
    }
    return Evidence(measured, data=drawn)


def _panels() -> Scene:
    """Panels side by side on hubs that nothing moves."""
    units = {
        f"p{k}": unit(
            "TwoLinkChain",
            effects=["springs", "viscous", "stick_friction"],
            first_inertia=1e12,
            second_centre=0.0,
            second_inertia=p.inertia,
            viscous={"first": 0.0, "second": p.damping},
            springs={"second_stiffness": p.stiffness, "second_rest": math.pi},
            stick_friction={"first_level": 0.0, "second_level": p.friction},
        )
        for k, p in enumerate(PANELS.values())
    }
    record = {"signals": [f"{panel}.{s}" for panel in units for s in ("relative_angle", "relative_rate")]}
    return build_scene(units, stop_time=14.0, step=2e-3, name=NAME, title="Panels on fixed hubs", record=record)


def _reached(result: Result, unit: str, angle: float, sign: float) -> tuple[float, float]:
    """(time, rate) at which the joint first reaches an angle, between the samples."""
    way = sign * (np.asarray(result[f"{unit}.relative_angle"]) - angle)
    k = int(np.argmax(way >= 0.0))
    share = float(-way[k - 1] / (way[k] - way[k - 1]))
    rates = np.abs(result[f"{unit}.relative_rate"])
    times = result.time
    return float(times[k - 1] + share * (times[k] - times[k - 1])), float(rates[k - 1] + share * (rates[k] - rates[k - 1]))


def _free(result: Result) -> dict[str, float]:
    """Turn of a free hub while its panel goes from 180° to 90°, by the run and by the integral of the momentum."""
    measured = {}
    for hub in ("damped", "undamped"):
        time, _ = _reached(result, hub, OPEN, -1.0)
        measured[f"hub.{hub}"] = math.degrees(float(np.interp(time, result.time, result[f"{hub}.first_angle"])))
        momentum = np.abs(result[f"{hub}.angular_momentum"]).max()
        measured[f"momentum.{hub}"] = float(momentum / (10.0 * np.abs(result[f"{hub}.first_rate"]).max()))
    measured["hub.closed"] = math.degrees(turned_hub(5.0, 0.8, 100.0, 10.0, 0.5))
    return measured


def turned_hub(panel: float, length: float, hub: float, inertia: float, arm: float) -> float:
    """Turn of a free hub, rad, while a uniform panel swings from 180° to 90°: momentum stays zero, whatever the spring."""
    series, own, centre = panel * hub / (panel + hub), panel * length**2 / 12.0, 0.5 * length

    def share(angle: float) -> float:
        coupling, second = series * arm * centre * math.cos(angle), own + series * centre**2
        return (coupling + second) / (inertia + series * arm**2 + 2.0 * coupling + second)

    return quad(share, OPEN, math.pi)[0]


def _tracking(result: Result) -> dict[str, float]:
    late = result.time >= SETTLED
    measured = {}
    for axis in ("outer", "inner"):
        errors = np.asarray(result[f"controller.{axis}_error"])[late]
        measured[f"tracking.{axis}"] = float(np.sqrt(np.mean(errors**2)))
    # power of the motors against friction, dampers and the change of energy
    t = result.time
    given = _work(result, "shoulder", "arm.first_rate") + _work(result, "elbow", "arm.relative_rate")
    first, second = result["arm.first_rate"], result["arm.relative_rate"]
    lost = 2.29 * first**2 + 7.2 * np.abs(first) + 0.175 * second**2 + 1.7 * np.abs(second)
    gained = result["arm.mechanical_energy"][-1] - result["arm.mechanical_energy"][0]
    measured["balance"] = float((np.trapezoid(lost, t) + gained) / given)
    return measured


def _work(result: Result, motor: str, rate: str) -> float:
    """Work of a motor, J: between the samples of its voltage, at which the torque jumps, that falls with the rate alone."""
    torque, speed, p = result[f"{motor}.torque"], result[rate], result.scene.units[motor].parameters
    constant, resistance = float(p["constant"]), float(p["resistance"])
    ends = torque[:-1] - constant**2 / resistance * np.diff(speed)
    return float(np.sum(np.diff(result.time) * (torque[:-1] * speed[:-1] + ends * speed[1:])) / 2.0)


def jaw_pose(crank: float) -> tuple[float, float, float]:
    """(angle of the jaw, rad, place of its lower end, m) at an angle of the eccentric: two circles that cross."""
    x, y = CRANK * math.sin(crank), -CRANK * math.cos(crank)
    dx, dy = PIVOT[0] - x, PIVOT[1] - y
    distance = math.hypot(dx, dy)
    along = (JAW**2 - TOGGLE**2 + distance**2) / (2.0 * distance)
    across = math.sqrt(JAW**2 - along**2)
    foot_x = x + (along * dx - across * dy) / distance
    foot_y = y + (along * dy + across * dx) / distance
    return math.atan2(foot_x - x, y - foot_y), foot_x, foot_y


def _crusher(result: Result) -> dict[str, float]:
    turn = result["eccentric.angle"]
    whole = turn <= 2.0 * math.pi * math.floor(turn[-1] / (2.0 * math.pi))
    closed = np.array([jaw_pose(float(a)) for a in turn])
    places = np.column_stack([result[f"jaw.{n}"] for n in ("angle", "tip_x", "tip_y")])
    rates = result["eccentric.rate"][whole]
    return {
        "jaw.swing": math.degrees(float(np.ptp(places[whole, 0]))), "jaw.x": 1e3 * float(np.ptp(places[whole, 1])),
        "jaw.y": 1e3 * float(np.ptp(places[whole, 2])),
        "jaw.error": 1e3 * float(np.abs(places - closed)[:, 1:].max()),
        "flywheel": 100.0 * float(np.ptp(rates) / np.mean(rates)), "speed": float(np.mean(rates)) * 60.0 / (2.0 * math.pi),
    }  # fmt: skip
