"""Machine code that a scene will ask for, compiled on all cores before the scene asks, one kernel after the other, for it.

Processes are forked where that is safe: on Linux, where no other thread runs, which might hold a lock for ever in the copy. They put what
they compile into the cache, which is all that they share. Elsewhere, inside of workers, which have cores of their own to share,
and where little is missing, each entry is compiled when it is asked for.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from itertools import chain
from pathlib import Path
from types import CodeType
from typing import Any

from ...components.core.contract import KernelComponent
from ...components.core.kernels import COMPILED, Kernel
from ..engine.algorithms import Master
from ..scene.scene import Scene
from ..units.component import make
from ..units.interface import Simulator

Wanted = tuple[Any, int, tuple[Any, ...]]  # a kernel, how many times it takes, and its arguments behind them
SECONDS = 1.2e-4  # for a byte of Python's code of all that a kernel calls, on one core of some 3 GHz
WORTH = 2.0  # s that compiling takes in all, from which on a second process pays


def wanted_by(scene: Scene, units: Mapping[str, Simulator], master: Master | None = None) -> list[Wanted]:
    """What runs of a scene call. units: open ones, of which FMUs share the machine code of their components."""
    by_layout = dict[Any, list[Wanted]]()
    for name, kind in scene.kinds.items():
        if kind.component_class is not None and not kind.in_worker:
            component = (units[name].component if name in units else None) or make(name, scene.units[name])
            if isinstance(component, KernelComponent) and (key := component.layout_of_block) not in by_layout:
                by_layout[key] = component.wanted()
    return [*chain(*by_layout.values()), *(master.records.wanted() if master is not None else ())]


def compile_ahead(wanted: Iterable[Wanted], announce: bool = False) -> None:
    """Compile what is not kept, where several processes may; announce: say so on a terminal."""
    if not COMPILED or (cores := _cores()) < 2:
        return
    from ...components.core.kept_kernels import missing

    everything = list(wanted)
    absent = {key: one for one in everything if (key := missing(*one))}
    jobs = _jobs(everything, list(absent.values()))
    seconds = sum(map(cost, (one[0] for one in absent.values())))
    if len(jobs) < 2 or seconds < WORTH:
        return
    processes = min(cores, len(jobs))
    if announce and sys.stderr.isatty():
        names = ", ".join(dict.fromkeys(_owner(kernel) for kernel, *_ in absent.values()))
        about = f"{len(absent)} entries on {processes} cores, about {max(seconds / processes, cost(jobs[0][0][0])):.0f} s"
        print(f"compiling {names}: {about} (once; kept for later runs)", file=sys.stderr)
    _compile(jobs, processes)


def _owner(kernel: Any) -> str:
    return kernel.__module__.rpartition(".")[2].replace("_", " ")


def _jobs(everything: list[Wanted], absent: list[Wanted]) -> list[list[Wanted]]:
    """Entries in the order in which processes take them, the longest first.

    Entries of one kernel share the kernels that they call: one process compiles all of them, unless these are kept already.
    """
    known = {id(kernel) for kernel, *_ in everything} - {id(kernel) for kernel, *_ in absent}
    known |= {id(k) for k, *_ in everything if sum(o[0] is k for o in everything) > sum(o[0] is k for o in absent)}
    jobs = dict[Any, list[Wanted]]()
    for place, one in enumerate(absent):
        jobs.setdefault(place if id(one[0]) in known else one[0], []).append(one)
    return sorted(jobs.values(), key=lambda job: -sum(cost(one[0]) for one in job))


@cache
def cost(kernel: Any) -> float:
    """About how long a kernel takes to compile with all that it calls, s."""
    called, pending = set[Any](), [kernel]
    while pending:
        if (one := pending.pop()) not in called:
            called.add(one)
            pending += [v for n in _names(one.py_func.__code__) if isinstance(v := one.py_func.__globals__.get(n), Kernel)]
    return SECONDS * sum(len(one.py_func.__code__.co_code) for one in called)


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _cores() -> int:
    """How many processes may compile."""
    processes = sys.modules.get("multiprocessing")  # a worker has loaded it
    inside = (processes is not None and processes.parent_process() is not None) or "PYTEST_XDIST_WORKER" in os.environ
    if sys.platform != "linux" or inside or len(list(Path("/proc/self/task").iterdir())) > 1:
        return 1
    return len(os.sched_getaffinity(0))


def _compile(jobs: list[list[Wanted]], processes: int) -> None:
    """Each process takes the number of the next job out of a pipe; what one does not come to is compiled when it is asked for."""
    from numba.core.event import trigger_event

    _ = jobs[0][0][0].dispatcher  # the compiler is loaded once, before there are copies
    queue, end = os.pipe()
    os.write(end, bytes(range(min(len(jobs), 256))))
    os.close(end)
    others = list[int]()
    with trigger_event("numba:compile", data={}):
        try:
            for _ in range(processes - 1):
                if (child := os.fork()) == 0:
                    _work_and_leave(queue, jobs)
                others.append(child)
            _work(queue, jobs)
        except BaseException:
            for child in others:
                os.kill(child, signal.SIGKILL)
            raise
        finally:
            os.close(queue)
            for child in others:
                os.waitpid(child, 0)


def _work(queue: int, jobs: list[list[Wanted]]) -> None:
    from ...components.core.kept_kernels import machine_code

    while number := os.read(queue, 1):
        for kernel, times, arguments in jobs[number[0]]:
            with suppress(Exception):  # it is said where the entry is asked for
                machine_code(kernel, times, arguments)


def _work_and_leave(queue: int, jobs: list[list[Wanted]]) -> None:
    """Of a copy: it ends with the first signal, and leaves all that it shares with this process as it is."""
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        _work(queue, jobs)
    finally:
        os._exit(0)
