"""Records of faulty ball bearings as an accelerometer gives them, labelled, in the layout of public sets.

Individuals differ in the size and place of their defect, clearance and damping; each runs at several loads and speeds. An
individual is in one part of the split only, with all its records: a classifier that knows an individual again learns nothing of
its fault.

Sensor path: acceleration a of the inner ring along the load -> structure with one resonance between bearing and sensor,
y'' + 2 ζ ω y' + ω² y = ω² a -> anti-aliasing filter and sampling (polyphase FIR) -> sensitivity -> white noise at a given ratio
of signal to noise. The layouts of Case Western Reserve University and Paderborn are recalled, not read. A broken cage lets one
ball run ahead of its place or behind; in the class "combined_cage" there is a pit in the outer race as well, since cage faults
seldom come alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...harness.sweep import Sweep, sweep
from ...output import ensure_directory, write_table
from ...scene.scene import Scene
from ...units.component import make
from .. import load_scene

RPM = 2.0 * math.pi / 60.0
CLASSES: Mapping[str, tuple[str, ...]] = {  # label -> defects of the component
    "healthy": (),
    "outer": ("outer_defect",),
    "inner": ("inner_defect",),
    "ball": ("ball_defect",),
    "cage": ("cage_fault",),
    "combined": ("outer_defect", "inner_defect"),
    "combined_cage": ("outer_defect", "cage_fault"),
}
CONDITIONS = ((1797.0, 400.0), (1772.0, 700.0), (1750.0, 1000.0), (1730.0, 1300.0))  # rpm of CWRU (recalled), N (our choice)
DIAMETER = (0.18e-3, 0.53e-3)  # m, of defects: 7 to 21 thousandths of an inch, as in the CWRU set (recalled)
DEPTH = (5e-6, 50e-6)  # m
OFFSET = (math.radians(3.0), math.radians(12.0))  # rad, of a ball, either way; 16.5 degrees are free (our choice)
CLEARANCE = (2e-6, 10e-6)  # m, radial
DAMPING = (800.0, 2500.0)  # N.s/m (our choice)
STEP, TRANSIENT = 2e-5, 0.3  # s
SHORTEST, LONGEST = 0.25, 600.0  # s, of a record: with bins of 4 Hz or less the lines of defects can be looked for
SHARES = {"train": 0.6, "validation": 0.2, "test": 0.2}
SIGNAL = "bearing.acceleration_x"
LAYOUTS = ("cwru", "paderborn")
RUN_UP = 0.4  # of the speed, from which a run-up starts


@dataclass(frozen=True)
class Sensor:
    """rate: Hz.  resonance: Hz, with its damping ratio.  sensitivity: V per m/s².  snr: dB, of every record."""

    rate: float = 12_000.0
    resonance: float = 3_000.0
    damping_ratio: float = 0.05
    sensitivity: float = 0.0102  # 100 mV/g
    snr: float = 30.0

    def record(self, acceleration: np.ndarray, rate: float, rng: np.random.Generator) -> np.ndarray:
        """Voltages (m,) of an acceleration (n,) in m/s² at `rate` Hz, which is above twice the sensor's own."""
        from scipy.signal import bilinear, lfilter, resample_poly

        omega = 2.0 * math.pi * self.resonance
        warped = 2.0 * rate * math.tan(0.5 * omega / rate)  # so that the resonance stays where it is
        b, a = bilinear([warped**2], [1.0, 2.0 * self.damping_ratio * warped, warped**2], rate)
        structure = lfilter(b, a, acceleration - acceleration.mean())
        up, down = int(self.rate), round(rate)
        common = math.gcd(up, down)
        volts = self.sensitivity * resample_poly(structure, up // common, down // common)
        noise = volts.std() * 10.0 ** (-self.snr / 20.0)
        return volts + noise * rng.standard_normal(volts.size)


@dataclass(frozen=True)
class Record:
    """What one file holds. number: of the record.  individual: of the bearing.  part: of the split.  run_up: to the speed.

    rpm: 1/min.  load: N.  diameter, depth, clearance: m.  damping: N.s/m.  position: of the pit, rad.  offset: of a ball from its
    place in the cage, rad.
    """

    number: int
    label: str
    individual: int
    part: str
    rpm: float
    load: float
    run_up: bool
    diameter: float
    depth: float
    clearance: float
    damping: float
    position: float
    offset: float


def planned(individuals: int, seed: int, run_up: bool, conditions: int = len(CONDITIONS)) -> list[Record]:
    """All records: individuals of every class, each at the first `conditions`; the same seed, the same records."""
    if individuals < 3:
        raise BadInput("--individuals", str(individuals), "3 or more of each class, one for each part of the split")
    if not 1 <= conditions <= len(CONDITIONS):
        raise BadInput("--conditions", str(conditions), f"1 to {len(CONDITIONS)} speeds and loads")
    rng = np.random.default_rng(seed)
    records: list[Record] = []
    for k, label in enumerate(CLASSES):
        parts = _parts(individuals, rng)
        for j in range(individuals):
            diameter, depth, clearance, damping = (float(rng.uniform(*r)) for r in (DIAMETER, DEPTH, CLEARANCE, DAMPING))
            position = float(rng.uniform(-0.5, 0.5))  # rad, in the loaded zone of the outer race
            offset = float(rng.choice((-1.0, 1.0)) * rng.uniform(*OFFSET))
            pit = any(d != "cage_fault" for d in CLASSES[label])
            for rpm, load in CONDITIONS[:conditions]:
                for up in (False, True) if run_up else (False,):
                    records.append(
                        Record(
                            len(records),
                            label,
                            k * individuals + j,
                            parts[j],
                            rpm,
                            load,
                            up,
                            diameter if pit else 0.0,
                            depth if pit else 0.0,
                            clearance,
                            damping,
                            position if pit else 0.0,
                            offset if "cage_fault" in CLASSES[label] else 0.0,
                        )
                    )
    return records


def _parts(individuals: int, rng: np.random.Generator) -> list[str]:
    """The part of the split of every individual of a class: one at least in each."""
    held = max(1, round(SHARES["test"] * individuals))
    parts = ["test"] * held + ["validation"] * held + ["train"] * (individuals - 2 * held)
    return [parts[i] for i in rng.permutation(individuals)]


def point(record: Record, component: Any) -> dict[str, Any]:
    """A record as values of a plan: effects and parameters of the bearing."""
    p: dict[str, Any] = component.parameters
    speed = record.rpm * RPM
    effects, parameters = (
        ["clearance"],
        {"load": record.load, "damping": record.damping, "clearance.radial_clearance": record.clearance, "substep": STEP},
    )
    if record.run_up:
        effects.append("speed_ramp")
        parameters |= {"speed": RUN_UP * speed, "speed_ramp.acceleration": (1.0 - RUN_UP) * speed, "speed_ramp.duration": 1.0}
    else:
        parameters["speed"] = speed
    pitch, ball = p["pitch_diameter"], p["ball_diameter"]
    for defect in CLASSES[record.label]:
        effects.append(defect)
        if defect == "cage_fault":
            parameters["cage_fault.offset"] = record.offset
            continue
        radius = {"outer_defect": 0.5 * (pitch + ball), "inner_defect": 0.5 * (pitch - ball), "ball_defect": 0.5 * ball}[defect]
        parameters |= {
            f"{defect}.depth": record.depth,
            f"{defect}.width": record.diameter / radius,
            f"{defect}.position": record.position,
        }
    return {"units.bearing.effects": effects, "units.bearing.parameters": parameters}


def base_scene(duration: float) -> Scene:
    """A 6205, the drive-end bearing of the CWRU rig, without what the records differ in."""
    return load_scene("outer-ring-defect").with_changes(
        {
            "title": "records of ball bearings",
            "units.bearing.preset": "6205",
            "units.bearing.effects": ["clearance"],
            "units.bearing.parameters": {},
            "stop_time": TRANSIENT + duration,
            "master.step": STEP,
            "record.signals": [SIGNAL],
            "study.quantities": [],
            "analysis.transient": TRANSIENT,
        }
    )


def bearing_of(scene: Scene) -> Any:
    """The bearing of such a scene, not initialized."""
    return make("bearing", scene.units["bearing"])


def fault_data(
    directory: str | Path,
    *,
    individuals: int = 5,
    duration: float = 1.0,
    seed: int = 1,
    run_up: bool = False,
    conditions: int = len(CONDITIONS),
    sensor: Sensor | None = None,
    layout: str = "cwru",
    jobs: int | None = 1,
    scheduler: str = "",
    progress: bool = False,
) -> tuple[list[Record], Sweep]:
    """Write the data set into a directory: a .mat file a record in folders train, validation and test, and labels.csv.

    `duration`: s of every record. `conditions`: how many of `CONDITIONS`. Records whose run has failed are left out;
    they are in the sweep's table with their reasons.
    Raises `BadInput`.
    """
    chosen = sensor or Sensor()
    _check(chosen, layout, duration)
    scene, records = base_scene(duration), planned(individuals, seed, run_up, conditions)
    component = bearing_of(scene)
    points = [point(r, component) for r in records]
    plan = {
        "method": "list",
        "vary": {name: [p[name] for p in points] for name in points[0]},
        "keep": {"signals": [SIGNAL], "summary": False},
    }
    folder = ensure_directory(directory)
    runs = sweep(scene, plan, folder / "runs", jobs=jobs, scheduler=scheduler, progress=progress)
    if runs.stopped is not None:
        return [], runs
    written = []
    for record, (_, acceleration) in zip(records, runs.signals(SIGNAL), strict=True):
        if acceleration.size:
            rng = np.random.default_rng([seed, record.number])
            x = chosen.record(acceleration, 1.0 / STEP, rng)[int(TRANSIENT * chosen.rate) :]
            _write(folder, record, x, layout, chosen)
            written.append(record)
    _labels(folder, written)
    return written, runs


def _check(sensor: Sensor, layout: str, duration: float) -> None:
    rate = 1.0 / STEP
    if layout not in LAYOUTS:
        raise BadInput("--layout", repr(layout), "one of " + ", ".join(LAYOUTS))
    if not (sensor.rate == int(sensor.rate) and 1000.0 <= sensor.rate <= rate):
        raise BadInput("--rate", f"{sensor.rate:g} Hz", f"a whole number of Hz from 1000 to {rate:g}")
    if not 10.0 < sensor.resonance < 0.4 * rate:
        raise BadInput("--resonance", f"{sensor.resonance:g} Hz", f"between 10 and {0.4 * rate:g} Hz")
    if not SHORTEST <= duration <= LONGEST:
        raise BadInput("--duration", f"{duration:g} s", f"{SHORTEST:g} to {LONGEST:g} s")


def _write(folder: Path, record: Record, x: np.ndarray, layout: str, sensor: Sensor) -> None:
    from scipy.io import savemat

    where = ensure_directory(folder / record.part)
    speed = record.rpm
    if layout == "cwru":  # variables X097_DE_time and X097RPM of 097.mat
        name = f"X{record.number:03d}"
        content: dict[str, Any] = {f"{name}_DE_time": x[:, None], f"{name}RPM": np.array([[speed]])}
    else:  # one structure of the file's name, whose Y lists signals with Name and Data
        name = name_of(record, layout)
        y = np.array([("vibration_1", x[None, :]), ("speed", np.array([[speed]]))], dtype=[("Name", object), ("Data", object)])
        content = {name: {"Info": {"SamplingRate": sensor.rate}, "Y": y[None, :]}}
    savemat(where / f"{name_of(record, layout)}.mat", content, do_compression=True)


def name_of(record: Record, layout: str) -> str:
    """Of the record's file, without its suffix."""
    if layout == "cwru":
        return f"{record.number:03d}"
    return f"N{record.rpm / 100.0:02.0f}_F{record.load / 100.0:02.0f}_{record.label}{record.individual:03d}_{record.number:03d}"


def _labels(folder: Path, records: list[Record]) -> Path:
    names = list(Record.__dataclass_fields__)
    rows = [tuple("yes" if v is True else "no" if v is False else v for v in (getattr(r, n) for n in names)) for r in records]
    units = {
        "diameter": "m",
        "depth": "m",
        "clearance": "m",
        "damping": "N.s/m",
        "position": "rad",
        "offset": "rad",
        "load": "N",
        "rpm": "1/min",
    }
    return write_table(folder, "labels.csv", [f"{n}, {units[n]}" if n in units else n for n in names], rows)
