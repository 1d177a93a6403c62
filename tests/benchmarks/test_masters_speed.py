"""Scenes under this master and under those of others: speed, error and the largest step that holds, from one package each.

FMUs wired again as an SSP package, native ones and a pair of pythonfmu, which others step by Jacobi's scheme with held inputs. Here the
scene has its own scheme as well. Each run of another's is a process of its own. What is not installed has no row;
`COSIMO_INTEROP_PYTHON` as in tests/interop. The error is that of all signals at ten instants, over their ranges, from this master's run
with an eighth of the macro step; a step holds where this error is below a half.
"""

from importlib.util import find_spec

import numpy as np
import pytest
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.harness.other_masters import as_other_masters
from cosimo.orchestrator.opened.native import initial_inputs, with_native_fmus
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.interop.masters import PROGRAMS, run_in

pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(own_target() != "linux64", reason="the masters are installed and compared on Linux"),
]
LOOKS, TURNS, LONGEST = 10, 3, 64  # times the scene's step
HOLDS = 0.5  # error of a step that holds
SCENES = {  # s, native FMUs
    "mass-on-spring": (20.0, False),
    "en50318-2002": (2.0, True),
    "rov-station-keeping": (20.0, True),
    "rotor-run-up": (0.05, True),
    "wind-pump-start": (20.0, True),
}
OURS = {"cosimo, held inputs": as_other_masters, "cosimo, as shipped": lambda scene: scene}


class Pair:
    """One scene cut short: its package, and its converged signals at ten instants."""

    def __init__(self, name, folder):
        stop, self.native = SCENES[name]
        self.scene = load_scene(name).with_changes({"stop_time": stop, "record.interval": stop / LOOKS})
        self.step = self.scene.master.step
        self.package = write(
            with_native_fmus(self.scene) if self.native else self.scene, folder / f"{name}.ssp", initial_inputs(self.scene)
        )
        outputs = {f"{unit}.{name}" for unit, interface in self.scene.coupling.interfaces.items() for name in interface.outputs}
        self.signals = [name for name in run(self.scene, native=self.native).columns if name in outputs]
        self.converged, _ = self.here(self.scene.with_changes({"master.step": self.step / 8.0}))
        self.range = np.maximum(np.ptp(self.converged, axis=0), 1e-12 * np.abs(self.converged).max(axis=0) + 1e-300)

    def here(self, scene):
        """Signals at ten instants, (10, signals), and seconds of stepping; NaN behind the end of a run that failed."""
        result = run(scene, native=self.native)
        instants = np.linspace(0.1, 1.0, LOOKS) * self.scene.stop_time
        rows = np.searchsorted(result.time, instants - 0.5 * self.step)
        values = np.column_stack([np.append(np.asarray(result[n], dtype=float), np.nan) for n in self.signals])
        return values[np.minimum(rows, len(values) - 1)], result.info.timing.cpu

    def there(self, master, step):
        """The same from a master of others."""
        outputs = {f"{u}.{n}": (u, n, s.kind) for u, i in self.scene.coupling.interfaces.items() for n, s in i.outputs.items()}
        every = round(self.scene.stop_time / step) // LOOKS
        return run_in(master, self.package, step, LOOKS, every, [outputs[n] for n in self.signals])

    def error(self, values):
        off = np.abs(values - self.converged) / self.range
        return float(np.sqrt(np.mean(off**2))) if np.isfinite(off).all() else np.inf


def attempt(pair, simulated, step):
    """(error, seconds) of a run; an infinite error where the master ended with one of its own."""
    try:
        values, seconds = simulated(step)
    except AssertionError:
        return np.inf, np.inf
    return pair.error(values), seconds


@pytest.mark.parametrize("name", SCENES)
def test_speed_error_and_stability(name, tmp_path, told):
    pair = Pair(name, tmp_path)
    rates, errors = {}, {}
    masters = {
        label: lambda step, of=of: pair.here(of(pair.scene.with_changes({"master.step": step}))) for label, of in OURS.items()
    }
    masters |= {
        master: lambda step, who=master: pair.there(who, step) for master, (module, _) in PROGRAMS.items() if find_spec(module)
    }
    for master, simulated in masters.items():
        (errors[master], seconds), step = min(attempt(pair, simulated, pair.step) for _ in range(TURNS)), pair.step
        rates[master] = pair.scene.stop_time / pair.step / seconds
        while (
            step < LONGEST * pair.step
            and round(pair.scene.stop_time / step) % LOOKS == 0
            and attempt(pair, simulated, step)[0] < HOLDS
        ):
            step *= 2.0
        longest = 0.5e3 * step if step > pair.step else "none"
        error = f"{100.0 * errors[master]:.2g} %" if errors[master] < HOLDS else "does not hold"
        told(
            "masters",
            f"`{name}`, {master}",
            steps_a_second=rates[master],
            error=error,
            **{"longest step that holds, ms": longest},
        )
    others = set(masters) - set(OURS)
    assert errors["cosimo, as shipped"] < 0.5 * min((errors[m] for m in others), default=np.inf)
    assert rates["cosimo, held inputs"] > 0.5 * rates.get("libcosim", 0.0)
