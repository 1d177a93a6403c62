"""run.json: what is to be known of a run, as typed records. No other file knows the keys of run.json.

A field without a default is always written; one that has its default is left out, and is the default where it is read: an effect that
a scene does not use has no key. A number that is not known is null. Files of earlier versions are read; keys that are unknown go.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

from ..engine.algorithms.energy import BondEnergy
from ..engine.algorithms.initial import InitializationResult
from ..output import write_json
from ..units.fmu_messages import FmuLog

Known = float | None


def known(number: float) -> Known:
    """A number as it is written; None of one that is not finite."""
    return number if isfinite(number) else None


@dataclass(frozen=True, kw_only=True)
class SignalRecord:
    """Error of a signal, in parts of its scale: rms and largest; order: that was observed; coupling, parted, shifted: see `SignalError`."""

    rms: Known
    max: Known
    order: Known
    coupling: Known = None
    parted: bool = False
    shifted: bool = False


@dataclass(frozen=True, kw_only=True)
class WindowsRecord:
    """Windows of a run that were repeated: their begins and their length, s; signals that are slower than one, and that grow in one."""

    begins: tuple[float, ...]
    length: float
    slower: tuple[str, ...]
    growing: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MeshRecord:
    """What meshes make of the errors: fields of `MeshError`; signals: name -> rms."""

    places: tuple[str, ...] = ()
    signals: Mapping[str, Known] = field(default_factory=dict)
    figures: Mapping[str, Known] = field(default_factory=dict)
    kept: bool = False
    not_covered: Mapping[str, str] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class PartRecord:
    """The signal that changes most where one internal setting is refined, and by which share of its scale."""

    signal: str
    difference: Known


@dataclass(frozen=True, kw_only=True)
class Excerpt:
    """A run and its repetition near the instant of their largest difference: a signal at times, s."""

    signal: str
    time: tuple[float, ...]
    run: tuple[float, ...]
    finer: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class ParameterRecord:
    """Standard deviation of a key result by the tolerances; rest: the share that first order leaves out.

    largest: the parameter that matters most.  why: why first order is refused.
    """

    error: Known
    rest: Known
    largest: str | None
    why: str = ""


@dataclass(frozen=True, kw_only=True)
class ParametersRecord:
    """What tolerances make of the key results: fields of `ParameterErrors`."""

    why: str = ""
    deviations: Mapping[str, float] = field(default_factory=dict)
    how: str = ""
    samples: int = 0
    figures: Mapping[str, ParameterRecord] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class VerificationRecord:
    """What repetition has shown of a run: fields of `judgement.record.Verification`; signals: with all that makes their errors."""

    done: bool
    why: str
    step: float = 0.0
    how: str = ""
    runs: int = 0
    signals: Mapping[str, SignalRecord] = field(default_factory=dict)
    figures: Mapping[str, Known] = field(default_factory=dict)
    windows: WindowsRecord | None = None
    quantities: Mapping[str, Mapping[str, Known]] = field(default_factory=dict)
    mesh: MeshRecord = field(default_factory=MeshRecord)
    parts: Mapping[str, PartRecord] = field(default_factory=dict)
    not_refined: Mapping[str, str] = field(default_factory=dict)
    unseen: Mapping[str, float] = field(default_factory=dict)
    inside: Mapping[str, float] = field(default_factory=dict)
    excerpt: Excerpt | None = None
    parameters: ParametersRecord = field(default_factory=ParametersRecord)
    seconds: float = 0.0


@dataclass(frozen=True, kw_only=True)
class RunTiming:
    """Simulated time, and real time for starting, compiling and stepping, s; compilation is in `compile` alone.

    cpu: CPU time of this process for stepping.
    """

    simulated: float
    start: float
    compile: float
    run: float
    cpu: float


@dataclass(frozen=True, kw_only=True)
class UnitRecord:
    """A unit as it was run; walls: what stood around one in a sandbox."""

    kind: str = ""
    title: str = ""
    parameters: Mapping[str, Any]
    walls: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class EffectsRecord:
    """Effects of a unit that were on and off -> why."""

    on: Mapping[str, str]
    off: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class SteppingRecord:
    """Macro steps of a run that chooses them: how many were kept, repeated, ended at an event; shortest and longest choice, s."""

    accepted: int
    rejected: int
    failed: int
    inaccurate: int
    events: int
    restores: int
    shortest: float | None = None
    longest: float | None = None


@dataclass(frozen=True, kw_only=True)
class Counters:
    """What was counted: by the master and its algorithm, by each unit, by steps of chosen length; work: of all, see `run.work`."""

    master: Mapping[str, Any]
    units: Mapping[str, Mapping[str, Any]]
    stepping: SteppingRecord | None = None
    work: float | None = None


@dataclass(frozen=True, kw_only=True)
class Missed:
    """The input that extrapolation has missed most, by a share of its deviation (rms)."""

    input: str
    source: str
    share: float


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Steps at the pace of the clock: durations and lateness, s, as percentiles ("50 %") and as counts between `bins`."""

    steps: int
    late: int
    duration: Mapping[str, float]
    lateness: Mapping[str, float]
    waking: Mapping[str, float]
    bins: tuple[float, ...]
    duration_counts: tuple[int, ...]
    lateness_counts: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class CheckpointsRecord:
    """Checkpoints: one every so many s of real or simulated time, to a folder of this name; the last at t, s."""

    every: float
    to: str
    written: int
    last: float | None


@dataclass(frozen=True, kw_only=True)
class Resumed:
    """Where a run went on from a checkpoint, s."""

    at: float


@dataclass(frozen=True, kw_only=True)
class RunRecord:
    """All that is to be known of a run beside its rows.

    scene: settings of the scene.  outcome: "done", "failed", "unstable" or "stopped", "running" of a run that has not ended; message:
    the reason.  settings: of the master.  signal: that has stopped the run.  accuracy, selection: why a run has its settings, and its
    effects, where a study has chosen them.
    """

    scene: Mapping[str, Any] = field(default_factory=dict)
    outcome: str
    message: str = ""
    warnings: tuple[str, ...] = ()
    units: Mapping[str, UnitRecord] = field(default_factory=dict)
    effects: Mapping[str, EffectsRecord] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    counters: Counters = field(default_factory=lambda: Counters(master={}, units={}))
    initial_values: tuple[InitializationResult, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    timing: RunTiming | None = None
    traceback: str = ""
    signal: str = ""
    missed: Missed | None = None
    energy: Mapping[str, BondEnergy] = field(default_factory=dict)
    real_time: Pace | None = None
    checkpoints: CheckpointsRecord | None = None
    resumed: Resumed | None = None
    fmu_log: Mapping[str, FmuLog] = field(default_factory=dict)
    accuracy: Mapping[str, Any] = field(default_factory=dict)
    selection: Mapping[str, Any] = field(default_factory=dict)
    verification: VerificationRecord = field(default_factory=lambda: VerificationRecord(done=False, why=""))

    def to_json(self) -> dict[str, Any]:
        """The object of run.json."""
        head = {"scene": self.scene, "outcome": self.outcome, "message": self.message, "warnings": self.warnings}
        return head | as_json(self)

    def write(self, path: Path) -> None:
        """Write run.json; raises `OSError`."""
        write_json(path, self.to_json())

    @classmethod
    def read(cls, path: Path) -> RunRecord:
        """What run.json says; raises `OSError` and `ValueError`."""
        from pydantic import ValidationError

        try:
            return _reader().validate_python(json.loads(path.read_text(encoding="utf-8")))
        except ValidationError as error:
            first = error.errors()[0]
            raise ValueError(f"{'.'.join(map(str, first['loc'])) or path.name}: {first['msg']}") from None


@cache
def _reader() -> Any:
    from pydantic import TypeAdapter

    return TypeAdapter(RunRecord)


def as_json(value: Any) -> Any:
    """Records as mappings, without fields that have their defaults."""
    if is_dataclass(value):
        pairs = ((one, getattr(value, one.name)) for one in fields(value))
        return {one.name: as_json(content) for one, content in pairs if content != _default(one)}
    if isinstance(value, Mapping):
        return {key: as_json(content) for key, content in value.items()}
    return [as_json(content) for content in value] if isinstance(value, list | tuple) else value


def _default(one: Field[Any]) -> Any:
    return one.default_factory() if one.default_factory is not MISSING else one.default
