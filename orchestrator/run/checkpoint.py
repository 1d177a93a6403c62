"""Checkpoints: files from which an interrupted run goes on, bit-identical to a run that was not interrupted.

A file holds numbers and texts only: the states of the units as their own bytes, what the master extrapolates from, and where the
rows recorded so far are: parts of the result directory, by their number and one digest. So neither memory nor file grow with the
run. Rows of a run without a result directory are in memory, and in the file. Which objects they belong to is known from the
scene, which must be the same, so that nothing in a file is ever executed, and only the fields of these objects are filled. A
digest of the content shows damage.
"""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from math import floor
from pathlib import Path
from typing import Any, Protocol

from ...components.core.errors import BadInput
from ...fmus.versions import version
from ..engine.algorithms.master import Master
from ..engine.stepping.loop import BatchObserver, Needs
from ..opened.open_scene import Course
from ..scene.scene import Scene
from ..units import Interface
from ..verified_file import DamagedFile, read_verified, write_verified
from .dependence import depends_on
from .run_record import CheckpointsRecord

FORMAT = "cosimo checkpoint 7"
STATE = "tick", "master", "stepping", "inputs"  # of `Course.pack`
CONTENT = {"format", "version", "name", "digest", "t", "kinds", *STATE, "parts"}


class Part(Protocol):
    """What takes part in a run and has a state of its own, of numbers, texts, arrays and lists and mappings of them."""

    def state(self) -> Any:
        """Everything the rest of the run depends on."""

    def set_state(self, state: Any) -> None:
        """Go on from a `state`."""


@dataclass(frozen=True)
class Checkpoint:
    """A file that was read, and fits the scene."""

    folder: Path  # of the file
    t: float
    kinds: Mapping[str, str]  # of the units, by name
    state: Mapping[str, Any]
    parts: Mapping[str, Any]


def check_wish(every: float | None, to: str | Path | None, scene: Scene, interfaces: Mapping[str, Interface]) -> None:
    """Raises `BadInput` for checkpoints that cannot be written, or never would be."""
    if (every is None) != (to is None):
        raise BadInput(
            "checkpoint_every" if to is None else "checkpoint_to",
            f"{every if to is None else repr(str(to))} alone",
            "both an interval and a file for checkpoints",
        )
    if every is None or to is None:
        return
    if not 0.0 < every < scene.duration:
        raise BadInput("checkpoint_every", f"{every:g} s", f"a time within the run, which lasts {scene.duration:g} s")
    folder = Path(to).resolve().parent
    if Path(to).is_dir() or not folder.is_dir() or not os.access(folder, os.W_OK):
        raise BadInput("checkpoint_to", repr(str(to)), "a file in a directory that can be written")
    unable = [name for name, interface in interfaces.items() if not (interface.saves_state and interface.packs_state)]
    if unable:
        raise BadInput("checkpoint_every", f"{every:g} s", f"units whose state can go to a file; {', '.join(unable)} cannot")


NEAR = 1e-9  # of an interval: rounding of a time that is far from 0


class Checkpoints(BatchObserver):
    """Writes a checkpoint at the first macro step not before each multiple of `every` (s), over the one before.

    It changes no step. A file appears as a whole or not at all. Where it cannot be written, the run warns once and goes on.
    """

    def __init__(self, path: Path, every: float, course: Course, parts: Mapping[str, Part]):
        self.path, self.every, self.written, self.last = path, every, 0, 0.0
        self._file = path.absolute()  # wherever a unit goes
        self._course, self._loop, self._parts = course, course.stepping, parts
        scene = course.open_scene.scene
        self._header = header(scene, course.master)
        self._start, self._due, self._failed = scene.start_time, scene.start_time + every, False

    def resumed(self, t: float) -> None:
        """The run goes on from here."""
        self._due = self._start + (floor((t - self._start) / self.every + NEAR) + 1.0) * self.every

    def __call__(self, tick: int, t: float) -> None:
        if t >= self._due and tick < self._loop.end:
            self.resumed(t)
            self.write()

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`."""
        clock = self._loop.clock
        return Needs(unseen=max(int((self._due - clock.time(tick)) / clock.seconds(length)) - 1, 0))

    def write(self) -> None:
        """Write what stands now, between two steps; a temporary file takes the place of the old one when it is complete."""
        t, state = self._loop.clock.time(self._loop.tick), self._course.save()
        parts = {name: part.state() for name, part in self._parts.items()}
        try:
            write_verified(self._file, self._header | self._course.pack(state) | {"t": t, "parts": parts})
        except OSError as error:
            if not self._failed:
                warnings.warn(
                    f"the checkpoint at t = {t:.9g} s could not be written to {self.path.name}: {error.strerror}", stacklevel=2
                )
            self._failed = True
            return
        finally:
            state.release()
        self.written, self.last = self.written + 1, t

    def report(self) -> CheckpointsRecord:
        """What was written."""
        return CheckpointsRecord(every=self.every, to=self.path.name, written=self.written, last=self.last)


def header(scene: Scene, master: Master) -> dict[str, Any]:
    """What a checkpoint says of where it comes from."""
    return {
        "format": FORMAT,
        "version": version("cosimo"),
        "name": scene.name,
        "digest": depends_on(scene),
        "kinds": _kinds(master),
    }


def read_checkpoint(path: Path, scene: Scene) -> Checkpoint:
    """The checkpoint in a file; raises `BadInput` where it is none, or one of another scene, version or damaged."""
    where, shown = "resume", repr(str(path))
    try:
        content = read_verified(path)
    except PermissionError as error:
        if error.errno != errno.EPERM:
            raise BadInput(where, shown, "a checkpoint that can be read", f"{error.strerror}.") from None
        remedy = "Where you trust who wrote it, copy it, and take it from others: chmod go-w."
        raise BadInput(where, f"{shown}: {error.strerror}", "a checkpoint that nobody else can have written", remedy) from None
    except OSError as error:
        raise BadInput(where, shown, "a checkpoint that can be read", f"{error.strerror or error}.") from None
    except DamagedFile:
        raise BadInput(where, shown, "a checkpoint that is not damaged", "Its digest does not fit its content.") from None
    except ValueError:
        content = None  # which `checkpoint_of` refuses: there is none with a digest
    return checkpoint_of(content, scene, where, shown, path.resolve().parent)


def checkpoint_of(content: Any, scene: Scene, where: str, shown: str, folder: Path) -> Checkpoint:
    """The checkpoint that was read; raises `BadInput` where it is none, or one of another scene or version."""
    try:
        whole = content["format"] == FORMAT and isinstance(content["tick"], int) and not CONTENT - content.keys()
    except Exception:  # written by something else, with a digest that fits
        whole = False
    if not whole:
        raise BadInput(where, shown, "a checkpoint that cosimo has written")
    if content["version"] != version("cosimo"):
        raise BadInput(where, f"{shown}, of cosimo {content['version']}", f"one of this version, {version('cosimo')}")
    if content["digest"] != depends_on(scene):
        raise BadInput(
            where,
            f"{shown}, of another scene or other settings ({content['name']})",
            f"a checkpoint of {scene.name} as it is now",
        )
    return Checkpoint(folder, content["t"], content["kinds"], {key: content[key] for key in STATE}, content["parts"])


def restore(checkpoint: Checkpoint, course: Course, parts: Mapping[str, Part], where: str = "resume") -> None:
    """Put a scene, just initialized, and parts where they were; `BadInput` for units of another kind, or a damaged file."""
    try:
        _restore(checkpoint, course, parts, where)
    except BadInput:
        raise
    except Exception as error:  # units and parts raise what they like for data that is not theirs
        raise BadInput(
            where, f"content that does not fit the scene ({type(error).__name__}: {error})", "a checkpoint that is not damaged"
        ) from None


def _restore(checkpoint: Checkpoint, course: Course, parts: Mapping[str, Part], where: str) -> None:
    kinds = _kinds(course.master)
    for name, kind in checkpoint.kinds.items():
        if kinds[name] != kind:
            raise BadInput(
                where,
                f"a checkpoint of a run with {name} as {kind!r}",
                f"the same kind, here {kinds[name]!r}",
                "Components run as FMUs or in process in both runs.",
            )
    now = course.save()
    _check_like(course.pack(now), checkpoint.state, "a state")
    now.release()
    state = course.unpack(checkpoint.state)
    course.restore(state)
    state.release()
    for name, part in parts.items():
        part.set_state(checkpoint.parts.get(name))


def _kinds(master: Master) -> dict[str, str]:
    return {node.unit.name: node.unit.kind for node in master.nodes}


def _check_like(template: Any, data: Any, where: str) -> None:
    """Raises `ValueError` where data have other fields than a template, or values of another type."""
    if template is None:  # which stands for whatever comes later
        return
    if isinstance(template, float) and isinstance(data, int):
        return
    if type(data) is not type(template):
        raise ValueError(f"{data!r} in the place of {where}")
    if isinstance(template, dict):
        if data.keys() != template.keys():
            raise ValueError(f"fields of {where} are {', '.join(template)}, not {', '.join(map(str, data))}")
        for key, item in template.items():
            _check_like(item, data[key], key)
    elif isinstance(template, list | tuple):
        for one, other in zip(template, data, strict=False):
            _check_like(one, other, where)
