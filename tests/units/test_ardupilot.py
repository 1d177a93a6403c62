"""The autopilot's interface against a partner in this process that replays packets: what it is told, and what it may not do."""

import json
import socket
import struct
from threading import Thread

import numpy as np
import pytest
from cosimo import run
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.judgement.dry_run import not_executed
from cosimo.orchestrator.systems import read_scene
from scipy.spatial.transform import Rotation

STEP, STEPS = 0.02, 25


def packet(count: int, pulses=(), channels: int = 16, magic: int = 0) -> bytes:
    filled = [*pulses, *[1500] * (channels - len(pulses))]
    return struct.pack(f"<HHI{channels}H", magic or {16: 18458, 32: 29569}[channels], 50, count, *filled)


class Partner(Thread):
    """Sends the packets one after the other, each when it has heard an answer to the one before."""

    def __init__(self, packets):
        super().__init__(daemon=True)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            self.address = free.getsockname()
        self.packets, self.answers, self.last = packets, [], b""
        self.ended = False
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.link.settimeout(0.02)

    def run(self):
        with self.link:
            before = b""
            for data in self.packets:
                self.link.sendto(data, self.address)
                while not self.ended:
                    try:
                        answer = self.link.recv(4096)
                    except (TimeoutError, ConnectionRefusedError):
                        if not self.answers:  # the vehicle does not listen yet
                            self.link.sendto(data, self.address)
                        continue
                    if answer != self.last or data == before:  # else an answer to the first packet, which was sent more than once
                        self.answers.append(answer.decode())
                        self.last, before = answer, data
                        break


def scene(partner, steps=STEPS, **unit):
    host, port = partner.address
    return read_scene(
        {
            "title": "A vehicle under an autopilot",
            "stop_time": STEP * steps,
            "connections": [
                "hull.* -> autopilot.*",
                *(f"autopilot.command[{k}] -> thruster_{k}.command" for k in (1, 4)),
                *(f"thruster_{k}.thrust -> hull.thrust[{k}]" for k in (1, 4)),
            ],
            "units": {
                "thruster_1": {"component": "Thruster"},
                "thruster_4": {"component": "Thruster"},
                "hull": {
                    "component": "RovHull",
                    "effects": ["added_mass", "coriolis", "linear_drag", "restoring"],
                    "parameters": {"start_yaw": 0.4, "start_pitch": 0.2, "start_yaw_rate": 0.3, "start_depth": 2.0},
                },
                "autopilot": {"ardupilot": f"{host}:{port}", **unit},
            },
            "master": {"step": STEP, "extrapolation": 0, "order": ["thruster_1", "thruster_4", "hull", "autopilot"]},
        },
        "flown",
    )


def flown(packets, steps=STEPS, **unit):
    partner = Partner(packets)
    made = scene(partner, steps, **unit)
    partner.start()
    result = run(made, in_process=True)
    partner.ended = True
    partner.join(5.0)
    return result, partner


def test_motion_and_commands_go_in_lockstep():
    pulses = [[1500 + 10 * (k % 7), 0, 0, 1900 if k > 3 else 1080] for k in range(STEPS + 1)]
    result, partner = flown([packet(k + 100, p) for k, p in enumerate(pulses)])
    assert result.outcome == "done", result.message
    told = [json.loads(answer) for answer in partner.answers]
    assert all(answer[0] == answer[-1] == "\n" for answer in partner.answers)
    assert [t["timestamp"] for t in told] == pytest.approx(result.time[1:], abs=1e-12)
    np.testing.assert_array_equal(result["autopilot.command[1]"], [(p[0] - 1500) / 400 for p in pulses])
    np.testing.assert_array_equal(result["autopilot.command[4]"], [1.0 if k > 3 else -1.0 for k in range(STEPS + 1)])
    names = {"position": ("position_north", "position_east", "depth"), "quaternion": [f"quaternion_{a}" for a in "wxyz"]}
    for key, signals in names.items():
        np.testing.assert_array_equal([t[key] for t in told], np.array([result[f"hull.{n}"][1:] for n in signals]).T)
    rates = np.array([result[f"hull.{n}_rate"] for n in ("roll", "pitch", "yaw")]).T
    np.testing.assert_array_equal([t["imu"]["gyro"] for t in told], rates[1:])
    turn = Rotation.from_quat(np.array([result[f"hull.quaternion_{a}"] for a in "xyzw"]).T)
    velocity = turn.apply(np.array([result[f"hull.{n}"] for n in ("surge", "sway", "heave")]).T)
    np.testing.assert_allclose([t["velocity"] for t in told], velocity[1:], atol=1e-14)
    shown = turn[1:].inv().apply(np.diff(velocity, axis=0) / STEP - [0.0, 0.0, 9.80665])
    np.testing.assert_allclose([t["imu"]["accel_body"] for t in told], shown, atol=1e-10)
    assert result.info.verification.why == "the run cannot be repeated: an autopilot flies once"
    assert result.info.counters.units["autopilot"]["packets"] == STEPS + 1


def test_packets_of_32_channels_sent_again_and_lost():
    """A packet that comes twice is answered twice with the same; counts that are left out are counted."""
    packets = [packet(k, [1700], channels=32) for k in (0, 1, 2, 5)]
    packets[2:2] = [packets[1]]
    result, partner = flown(packets, steps=3)
    assert result.outcome == "done", result.message
    assert partner.answers[2] == partner.answers[1]
    counters = result.info.counters.units["autopilot"]
    assert counters["repeated packets"] >= 1
    assert counters["lost packets"] == 2
    assert result["autopilot.command[1]"][-1] == 0.5


@pytest.mark.parametrize(
    ("packets", "words"),
    [
        ([packet(0), b"hello"], "a packet of 5 bytes that begins with 25960; expected 40 bytes that begin with 18458"),
        ([packet(0), packet(1)[:-2]], "a packet of 38 bytes"),
        ([packet(0), packet(1, magic=18457)], "begins with 18457"),
        ([packet(7), packet(3)], "frame 3 behind frame 7: the autopilot has started again"),
        ([packet(0), packet(1), b""], "a packet of 0 bytes"),
    ],
)
def test_what_is_no_packet_ends_the_run(packets, words):
    result, _ = flown(packets, time_limit=2.0)
    assert result.outcome == "failed"
    assert words in result.message


def test_a_silent_partner_ends_the_run():
    result, _ = flown([packet(0), packet(1)], time_limit=0.3)
    assert result.outcome == "failed"
    assert "within 0.3 s of an autopilot" in result.message
    assert result.time[-1] == pytest.approx(STEP)  # what was flown is kept


def test_what_cannot_be_flown_is_refused():
    partner = Partner([])
    with pytest.raises(BadInput, match="no parameters"):
        scene(partner, parameters={"rate": 400.0}).coupling  # noqa: B018
    with pytest.raises(BadInput, match="host and port"):
        scene(partner).with_changes({"units.autopilot.ardupilot": "9002"}).coupling  # noqa: B018
    connections = ["hull.surge -> autopilot.surge", "autopilot.command[1] -> thruster_1.command"]
    with pytest.raises(BadInput, match="heave, roll_rate, pitch_rate, yaw_rate without a connection"):
        run(scene(partner).with_changes({"connections": connections}), in_process=True)


def test_looking_at_a_scene_waits_for_nobody():
    assert not_executed(scene(Partner([]))) == ["autopilot"]
