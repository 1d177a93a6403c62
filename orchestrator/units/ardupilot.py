"""An autopilot as a unit: ArduPilot's software in the loop by its JSON interface over UDP.

The autopilot sends pulses of its servos as binary packets, the physics answers with the vehicle's motion as a line of JSON, and so
on in lockstep: the autopilot's clock is the time that it is told. A step sends the motion at its end and waits for the next packet.

    packet   uint16 magic (18458 with 16 pulses, 29569 with 32), uint16 frame rate in Hz, uint32 frame count, uint16 pulses in us
    answer   {"timestamp", "imu": {"gyro", "accel_body"}, "position", "velocity", "quaternion"}: north, east, down; ahead, starboard, down

accel_body is what accelerometers show, the acceleration less that of gravity: here the mean over a step, of the velocities at its
ends. Source: libraries/SITL/examples/JSON/readme.md of the repository ArduPilot/ardupilot, read.
"""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ...components.core.errors import BadInput, StepFailed
from ...components.core.measure import STANDARD_GRAVITY
from ...components.core.rotation import to_body, to_world
from .interface import PortValues, Simulator

PACKETS = {18458: struct.Struct("<HHI16H"), 29569: struct.Struct("<HHI32H")}  # by their magic
CHANNELS = 32
MOTION = {
    "position_north": "m",
    "position_east": "m",
    "depth": "m",
    "quaternion_w": "1",
    "quaternion_x": "1",
    "quaternion_y": "1",
    "quaternion_z": "1",
    "surge": "m/s",
    "sway": "m/s",
    "heave": "m/s",
    "roll_rate": "rad/s",
    "pitch_rate": "rad/s",
    "yaw_rate": "rad/s",
}
NEUTRAL, HALF_RANGE = 1500.0, 400.0  # us; a pulse of 1100 to 1900 us is a command of -1 to 1, as of the usual thrusters
PATIENCE = 30.0  # s; an autopilot without an answer repeats its packet after 10 s
LARGEST = 2048  # bytes that are read of a packet


def address_of(text: str, where: str) -> tuple[str, int]:
    """Host and port of "127.0.0.1:9002"; raises `BadInput`."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise BadInput(where, repr(text), "host and port to listen on", 'As in "127.0.0.1:9002".')
    return host, int(port)


class ArduPilot(Simulator):
    """The autopilot's commands as outputs, `command[1]` to `command[32]`, and the vehicle's motion as inputs.

    A packet that was sent again is answered again; what is no packet, another sender, a restarted autopilot, and one that is silent
    for longer than `patience`, in s, end the run.
    """

    kind = "autopilot"

    def __init__(self, name: str, where: str, address: tuple[str, int], patience: float):
        self.name, self.where, self.address, self.patience = name, where, address, patience
        self.link: socket.socket | None = None
        self.partner: Any = None
        self.count, self.answer, self.steps = -1, b"", 0
        self.commands = [0.0] * CHANNELS
        self.inputs: tuple[str, ...] = ()
        self.values: list[float] = []
        self.velocity = (0.0, 0.0, 0.0)  # m/s, of the step before, north, east, down
        self.counters = {"packets": 0, "repeated packets": 0, "lost packets": 0, "frame rate": 0}

    # -- packets ---------------------------------------------------------------------------------------------------------
    def _receive(self, t: float) -> None:
        """The next packet; raises `StepFailed` where none comes, or what comes is none."""
        assert self.link is not None
        while True:
            try:
                data, sender = self.link.recvfrom(LARGEST)
            except TimeoutError:
                remedy = "Start it with --model JSON:ADDRESS of this machine, or lengthen time_limit"
                reason = f"no packet on {self.address[0]}:{self.address[1]} within {self.patience:g} s of an autopilot"
                raise StepFailed(self.name, t, reason, remedy) from None
            except OSError as error:
                raise StepFailed(self.name, t, f"the autopilot cannot be heard ({error.strerror})") from None
            magic = struct.unpack_from("<H", data)[0] if len(data) > 1 else 0
            if magic not in PACKETS or len(data) != PACKETS[magic].size:
                expected = " or ".join(f"{s.size} bytes that begin with {m}" for m, s in PACKETS.items())
                raise StepFailed(self.name, t, f"a packet of {len(data)} bytes that begins with {magic}; expected {expected}")
            if self.partner not in (None, sender):
                raise StepFailed(
                    self.name, t, f"a packet from {sender}, while {self.partner} flies the vehicle", "End one of them"
                )
            _, rate, count, *pulses = PACKETS[magic].unpack(data)
            if self.partner is not None and count == self.count:  # it has not heard the answer
                self.counters["repeated packets"] += 1
                self._send()
                continue
            if count < self.count:
                reason = f"frame {count} behind frame {self.count}: the autopilot has started again"
                raise StepFailed(self.name, t, reason, "Start the run again")
            if self.partner is not None:
                self.counters["lost packets"] += count - self.count - 1
            self.partner, self.count = sender, count
            self.counters["packets"] += 1
            self.counters["frame rate"] = rate
            for i, pulse in enumerate(pulses):  # 0: the channel gives none
                self.commands[i] = max(-1.0, min((pulse - NEUTRAL) / HALF_RANGE, 1.0)) if pulse else 0.0
            return

    def _send(self) -> None:
        assert self.link is not None
        if self.answer:
            self.link.sendto(self.answer, self.partner)

    def _motion(self, t: float, h: float) -> bytes:
        """The answer at t, s, behind a step of h, s; 0: none was made."""
        m = dict(zip(self.inputs, self.values, strict=True))
        q = tuple(m[f"quaternion_{a}"] for a in "wxyz")
        velocity = to_world(*q, m["surge"], m["sway"], m["heave"])
        mean = [(v - before) / h if h else 0.0 for v, before in zip(velocity, self.velocity, strict=True)]
        self.velocity = velocity
        message = {
            "timestamp": t,
            "imu": {
                "gyro": [m["roll_rate"], m["pitch_rate"], m["yaw_rate"]],
                "accel_body": list(to_body(*q, mean[0], mean[1], mean[2] - STANDARD_GRAVITY)),
            },
            "position": [m["position_north"], m["position_east"], m["depth"]],
            "velocity": list(velocity),
            "quaternion": list(q),
        }
        return f"\n{json.dumps(message)}\n".encode()

    # -- a unit ------------------------------------------------------------------------------------------------------------
    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        """All of the motion is to be connected: what is not told would be 0 for the autopilot."""
        if missing := [n for n in MOTION if n not in inputs]:
            raise BadInput(
                self.where, f"{', '.join(missing)} without a connection", "the whole motion", 'As "hull.* -> autopilot.*".'
            )
        self.inputs, self.get = tuple(inputs), self.reader(outputs)
        self.values = [0.0] * len(inputs)

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        places = [int(n.partition("[")[2].rstrip("]")) - 1 for n in names]
        return lambda: [self.commands[k] for k in places]

    def initialize(self, t: float, values: PortValues) -> None:
        """Wait for an autopilot; repeated, it has been heard already."""
        self.values = [float(v) for v in values]
        if self.link is not None and not self.steps:
            return
        self.close()
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.link.settimeout(self.patience)
        try:
            self.link.bind(self.address)
        except OSError as error:
            where = f"{self.address[0]}:{self.address[1]}"
            raise BadInput(self.where, f"{where}, which cannot be listened on ({error.strerror})", "a free port") from None
        self.partner, self.count, self.answer, self.steps = None, -1, b"", 0
        self._receive(t)

    def start(self) -> None:
        """The initial motion stands: velocities are counted from it."""
        self._motion(0.0, 0.0)

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        """The motion at the end of the coming step."""
        self.values = [float(v) for v in values]
        for terms, power in ((slopes, h), (quadratic, h * h)):
            if terms is not None:
                self.values = [v + power * float(term) for v, term in zip(self.values, terms, strict=True)]

    def step(self, t: float, h: float) -> None:
        """Tell the motion, and wait for what the autopilot makes of it."""
        self.answer = self._motion(t + h, h)
        self.steps += 1
        self._send()
        self._receive(t + h)

    def update(self, values: PortValues) -> None:
        """Commands follow packets alone."""
        self.values = [float(v) for v in values]

    def save(self, reuse: Any = None) -> Any:
        """Nothing: an autopilot does not go back, and its interface says so."""
        return None

    def restore(self, state: Any) -> None:
        raise StepFailed(self.name, 0.0, "an autopilot cannot go back to an earlier state")

    def pack(self, state: Any) -> bytes:
        raise StepFailed(self.name, 0.0, "the state of an autopilot cannot be kept")

    def unpack(self, packed: bytes) -> Any:
        raise StepFailed(self.name, 0.0, "the state of an autopilot cannot be kept")

    def parameters(self) -> dict[str, Any]:
        return {}

    def work(self) -> Mapping[str, float]:
        return dict(self.counters)

    def close(self) -> None:
        if self.link is not None:
            self.link.close()
            self.link = None
