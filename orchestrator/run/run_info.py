"""What run.json says of a run: scene, effects, settings, counters, versions, and the time that compilation took."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Mapping
from functools import cache, partial
from time import perf_counter, process_time
from typing import Any

from ...components.core.kernels import WHEN_LOADED
from ...fmus.versions import distribution
from ..engine.algorithms import Master
from ..engine.coupling import Coupling
from ..scene.scene import Scene
from ..units import Simulator
from .run_record import Counters, EffectsRecord, RunRecord, UnitRecord

PACKAGES = ("cosimo", "numpy", "scipy", "numba", "fmpy", "pythonfmu")
COMPILATION = "numba:compile"  # event of Numba's, around what is not in its cache on disk


@cache
def _version(package: str) -> str:
    """Of an installed package. The line of its file is read: to parse all of the file takes longer than a short run."""
    installed = distribution(package)
    head = (installed.read_text("METADATA") or installed.read_text("PKG-INFO") or "").partition("\n\n")[0]
    lines = [line for line in head.splitlines() if line.startswith("Version:")]
    return lines[0].partition(":")[2].strip() if lines else installed.version


class CompileTime:
    """Seconds that Numba compiles while this context is open, in this process: kernels of components and of their FMUs.

    What is taken from Numba's cache on disk costs no compilation. Worker processes compile for themselves, unseen.
    """

    def __init__(self, *, announce: bool = False):
        """`announce`: tell on a terminal that the first compilation has started."""
        self.spent = 0.0, 0.0  # real and CPU time, s
        self._depth, self._since, self._announce = 0, (0.0, 0.0), announce
        self._unregister: Callable[[], None] | None = None

    @property
    def seconds(self) -> float:
        """Real time of compiling, s."""
        return self.spent[0]

    def __enter__(self) -> CompileTime:
        if "numba.core.event" in sys.modules:
            self._listen()
        else:
            WHEN_LOADED.append(self._loaded)
        return self

    def _loaded(self, done: bool) -> None:
        """The compiler will be loaded, or is."""
        if done:
            self._leave()
            self._listen()
        else:
            self._enter()

    def _listen(self) -> None:
        from numba.core import event

        compile_time = self

        class Listener(event.Listener):
            def on_start(self, event: Any) -> None:
                compile_time._enter()

            def on_end(self, event: Any) -> None:
                compile_time._leave()

        listener = Listener()
        event.register(COMPILATION, listener)
        self._unregister = partial(event.unregister, COMPILATION, listener)

    def __exit__(self, *_: object) -> None:
        if self._loaded in WHEN_LOADED:
            WHEN_LOADED.remove(self._loaded)
        if self._unregister is not None:
            self._unregister()

    def _enter(self) -> None:
        """A kernel compiles those that it calls: only the outermost one is timed."""
        if self._depth == 0:
            self._since = perf_counter(), process_time()
            if self._announce and not self.seconds and sys.stderr.isatty():
                print("compiling (once; kept for later runs)", file=sys.stderr)
        self._depth += 1

    def _leave(self) -> None:
        self._depth -= 1
        if self._depth == 0:
            (real, cpu), (since, cpu_since) = self.spent, self._since
            self.spent = real + perf_counter() - since, cpu + process_time() - cpu_since


def describe_run(
    scene: Scene, coupling: Coupling, units: Mapping[str, Simulator], master: Master, outcome: str, message: str
) -> RunRecord:
    """The record of a run beside its timing and its warnings."""
    interfaces = coupling.interfaces
    driven = {link.target[0] for link in coupling.links}
    undeclared = [n for n, i in interfaces.items() if any(s.feedthrough is None for s in i.outputs.values())]
    return RunRecord(
        scene=scene.info(),
        outcome=outcome,
        message=message,
        units={
            n: UnitRecord(kind=unit.kind, title=interfaces[n].title, parameters=unit.parameters(), walls=tuple(unit.walls))
            for n, unit in units.items()
        },
        effects={
            n: EffectsRecord(
                on={e: why for e, why in i.effects.items() if why},
                off={e: "not named in the scene" for e, why in i.effects.items() if not why},
            )
            for n, i in interfaces.items()
        },
        settings={
            **scene.master.model_dump(mode="json"),
            "undriven_inputs": list(coupling.undriven),
            "held_at_mean": sorted(n for n in driven if interfaces[n].input_degree < scene.master.extrapolation),
            "undeclared_dependencies": undeclared,
        },
        counters=Counters(master=master.counters(), units={n: unit.work() for n, unit in units.items()}),
        initial_values=tuple(master.initialization),
        versions={"python": platform.python_version(), **{p: _version(p) for p in PACKAGES}},
    )


def flattened(value: Any, prefix: str = "") -> list[tuple[str, str]]:
    """Nested settings as rows of dotted name and text."""
    if isinstance(value, Mapping):
        return [row for key, v in value.items() for row in flattened(v, f"{prefix}.{key}" if prefix else str(key))]
    if isinstance(value, list | tuple):
        if any(isinstance(v, Mapping) for v in value):
            return [row for i, v in enumerate(value, 1) for row in flattened(v, f"{prefix}[{i}]")]
        return [(prefix, ", ".join(str(v) for v in value) or "none")]
    return [(prefix, f"{value:.6g}" if isinstance(value, float) else str(value))]
