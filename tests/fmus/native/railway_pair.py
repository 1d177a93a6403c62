"""The railway pair as native FMUs in a host that is a C program, and the same calls of the components in process."""

import subprocess
import zipfile
from pathlib import Path

from cosimo.fmus.native.build import built
from cosimo.fmus.native.machine_code import TARGETS
from cosimo.orchestrator.opened.native import makers
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.fmus.native.machines import environment, program
from fmpy import read_model_description

SCENE = "en50318-2002"
PORTS = {
    "pantograph": ("wire_height", "contact_force", "contact_position"),
    "catenary": ("contact_force", "contact_position", "wire_height"),
}


def arguments(folder: Path, target: str = "linux64") -> list[str]:
    """Library, GUID and value references of both units, for the host."""
    words: list[str] = []
    make = makers(load_scene(SCENE))
    for unit, ports in PORTS.items():
        path = str(built(type(make[unit]()).__name__, make[unit], [target]))
        description = read_model_description(path)
        references = {v.name: v.valueReference for v in description.modelVariables}
        name = description.coSimulation.modelIdentifier + TARGETS[target].suffix
        with zipfile.ZipFile(path) as file:
            library = file.extract(f"binaries/{TARGETS[target].folder2}/{name}", folder / unit)
        words += [library, description.guid, ",".join(str(references[p]) for p in ports)]
    return words


def run_host(folder: Path, h: float, steps: int, passes: int, target: str = "linux64") -> tuple[list[float], list[list[float]]]:
    """(last outputs, durations in us: mean, 99.99th percentile, longest, of the clock and of the processor), PATH empty."""
    command = [*program("railway.c", folder, target), *arguments(folder, target), repr(h), str(steps), str(passes)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment(target, folder), check=False)
    assert done.returncode == 0, done.stderr
    outputs, *durations = done.stdout.splitlines()
    return [float.fromhex(word) for word in outputs.split()], [[float(word) for word in line.split()] for line in durations]


def in_process(h: float, steps: int) -> list[float]:
    """Wire height, contact force and contact position after the same calls of the components."""
    made = {unit: make() for unit, make in makers(load_scene(SCENE)).items()}
    pantograph, catenary = made["pantograph"], made["catenary"]
    for component in made.values():
        component.initialize(0.0)
    for k in range(steps):
        pantograph.set("wire_height", catenary["wire_height"])
        pantograph.step(k * h, h)
        for port in PORTS["catenary"][:2]:
            catenary.set(port, pantograph[port])
        catenary.step(k * h, h)
    return [catenary["wire_height"], pantograph["contact_force"], pantograph["contact_position"]]
