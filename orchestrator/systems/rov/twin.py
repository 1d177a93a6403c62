"""A twin of the underwater vehicle: its estimate in real time, beside the vehicle's FMUs in a second process, over UDP.

python -m cosimo.orchestrator.systems.rov.twin --lost-at 6 --stop 10

The vehicle loses a vertical thruster at an instant that its twin is not told. The twin knows neither the current nor what is lost:
it estimates them, and the wrench of whatever pushes the hull beside what the model has. If this wrench is none, and is that of a
thruster which no longer pushes, it tells which one.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from socket import AF_INET, SOCK_DGRAM, socket
from time import perf_counter, sleep
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...estimation.live import Present
from ...scene.scene import Scene
from ...session.session import Session
from .. import load_scene

SCENE, LOST = "rov-thruster-failed", 4  # the thruster that fails
SENSORS = {
    "hull.position_north": 0.02,
    "hull.position_east": 0.02,
    "hull.depth": 5e-3,
    "hull.roll": 3e-3,
    "hull.pitch": 3e-3,
}  # noise
EVERY = 5  # macro steps from measurement to measurement
SEA = {"current.speed": 0.25, "controller.set_north": 0.5}  # as it is, and where the vehicle is told to go
WALKS = {"force_z": 1.0, "moment_x": 0.1, "moment_y": 0.2}  # N, N·m; after 1 s
ALARM = 25.0  # chi square of the wrench, 3 numbers: 1.5e-5 of right models are beyond it
MESSAGE = struct.Struct(f"<{1 + len(SENSORS)}d")  # time, measurements
PATIENCE = 300.0  # s, until the first message: FMUs are built and kernels compiled meanwhile


def plan() -> dict[str, Any]:
    """What the twin measures, and what it does not know."""
    wrench = {f"hull.external.{n}": {"deviation": 0.05, "walk": w} for n, w in WALKS.items()}
    current = {"current.speed": {"deviation": 0.1}, "current.direction": {"deviation": 0.4}}
    return {"measured": [{"signal": n, "noise": s} for n, s in SENSORS.items()], "estimated": current | wrench}


def model(stop: float) -> Scene:
    """The vehicle as its twin knows it: without a fault, in another current."""
    scene = load_scene(SCENE)
    effects = [*scene.units["hull"].effects, "external"]
    changes = {
        "controller.set_north": SEA["controller.set_north"],
        "stop_time": stop,
        "faults": [],
        "units.hull.effects": effects,
    }
    return scene.with_changes(changes)


def real(stop: float, lost_at: float) -> Scene:
    """The vehicle as it is; its controller is told nothing of the loss."""
    fault = {"signal": f"thruster_{LOST}.thrust", "kind": "override", "value": 0.0, "begin": lost_at}
    return load_scene(SCENE).with_changes({**SEA, "stop_time": stop, "faults": [fault]})


def measured(sim: Session, seed: int, paced: bool) -> Iterator[tuple[float, ...]]:
    """(time, measurements) of a vehicle until its end, with noise; paced: no faster than real time."""
    rng, noise, began = np.random.default_rng(seed), np.array(list(SENSORS.values())), perf_counter()
    sim.initialize()
    while not sim.done:
        sim.step(EVERY)
        sleep(max(began + sim.time - perf_counter(), 0.0) if paced else 0.0)
        yield sim.time, *(sim.values(list(SENSORS)) + noise * rng.standard_normal(noise.size)).tolist()


def vehicle(port: int, stop: float, lost_at: float, seed: int) -> None:
    """Send what the sensors of the vehicle show to a port of this machine; the vehicle's units are FMUs."""
    with Session(real(stop, lost_at), in_process=False) as sim, socket(AF_INET, SOCK_DGRAM) as link:
        for message in measured(sim, seed, paced=True):
            link.sendto(MESSAGE.pack(*message), ("127.0.0.1", port))


@dataclass(frozen=True)
class Alarm:
    """time: s, of the measurement.  chi_square: of the wrench.  thruster: which one is lost, 0: none.  thrust: N, that is missing."""

    time: float
    chi_square: float
    thruster: int
    thrust: float
    now: Present


def columns(sim: Session) -> np.ndarray:
    """Wrench of 1 N of each thruster as the plan has it, (3, 6)."""
    r, d = ([sim[f"hull.thruster_{kind}{axis}"] for axis in "xyz"] for kind in ("", "direction_"))
    moment = np.cross(np.transpose(r), np.transpose(d))
    return np.stack([d[2], moment[:, 0], moment[:, 1]])


def alarm(now: Present, per_thrust: np.ndarray) -> Alarm:
    """Whether something pushes that the model does not have, and which thruster explains it best by pushing no longer."""
    names = [f"hull.external.{n}" for n in WALKS]
    wrench, inverse = np.array([now[n].value for n in names]), np.linalg.inv(now.covariance(names))
    chi_square = float(wrench @ inverse @ wrench)
    size = np.einsum("ik,ij,jk->k", per_thrust, inverse, per_thrust)
    thrust = -(per_thrust.T @ inverse @ wrench) / size  # least squares, of each alone
    best = int(np.argmax(thrust**2 * size))
    return Alarm(now.time, chi_square, best + 1 if chi_square > ALARM else 0, float(thrust[best]), now)


class Twin:
    """The estimate of a vehicle, which messages take on. sim: the session that it is.  busy: s, that this has taken.  used: messages."""

    def __init__(self, stop: float):
        self.sim, self.busy, self.used = Session(model(stop)), 0.0, 0
        self.sim.estimate(plan())
        self._per_thrust = columns(self.sim)

    def take(self, message: Sequence[float]) -> Alarm:
        """What a message tells: time, measurements."""
        began = perf_counter()
        now = self.sim.assimilate(message[0], dict(zip(SENSORS, message[1:], strict=True)))
        self.busy, self.used = self.busy + perf_counter() - began, self.used + 1
        return alarm(now, self._per_thrust)

    def close(self) -> None:
        """Close its scene."""
        self.sim.close()


@dataclass(frozen=True)
class Outcome:
    """first: alarm of a lost thruster, None for none.  last: answer.  sent, used: messages.  share: of real time that the twin has worked.

    lag: s, from the last message to its answer.
    """

    first: Alarm | None
    last: Alarm
    sent: int
    used: int
    share: float
    lag: float


def demonstrate(stop: float, lost_at: float, seed: int = 0) -> Outcome:
    """A vehicle in a second process and its twin in this one; raises `BadInput` for a loss that is not within the run."""
    if not 0.0 < lost_at < stop:
        raise BadInput("twin: --lost-at", f"{lost_at:g} s", f"a time within the run, between 0 and {stop:g} s")
    twin = Twin(stop)
    with socket(AF_INET, SOCK_DGRAM) as link:
        link.bind(("127.0.0.1", 0))
        link.settimeout(PATIENCE)
        arguments = [
            f"--{k}={v}" for k, v in {"port": link.getsockname()[1], "stop": stop, "lost-at": lost_at, "seed": seed}.items()
        ]
        with subprocess.Popen([sys.executable, "-m", __spec__.name, *arguments]) as other:
            first, lag = None, 0.0
            while True:
                message = MESSAGE.unpack(link.recv(MESSAGE.size))
                arrived = perf_counter()
                last = twin.take(message)
                first, lag = first or (last if last.thruster else None), perf_counter() - arrived
                if message[0] >= stop - 1e-9:
                    break
            other.wait()
    twin.close()
    sent = round(stop / (EVERY * model(stop).master.step))
    return Outcome(first, last, sent, twin.used, twin.busy / stop, lag)


def main(arguments: Sequence[str] | None = None) -> None:
    """Both, or the vehicle alone, which sends to a port."""
    parser = argparse.ArgumentParser(prog=f"python -m {__spec__.name}", description="Twin of an underwater vehicle, over UDP.")
    parser.add_argument("--lost-at", type=float, default=6.0, help="s, when a thruster stops")
    parser.add_argument("--stop", type=float, default=10.0, help="s, the end")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    parser.add_argument("--port", type=int, default=0, help="the vehicle alone, which sends to this port")
    given = parser.parse_args(arguments)
    if given.port:
        vehicle(given.port, given.stop, given.lost_at, given.seed)
        return
    outcome = demonstrate(given.stop, given.lost_at, given.seed)
    if (first := outcome.first) is not None:
        print(f"t = {first.time:.2f} s: thruster {first.thruster} has stopped, {first.time - given.lost_at:.2f} s after it did")
    print(outcome.last.now)
    print(f"{outcome.used} of {outcome.sent} messages; the twin has worked for {outcome.share:.0%} of the time")


if __name__ == "__main__":
    main()
