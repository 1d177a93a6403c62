"""The railway pair as native FMUs in a host that is a C program, and the same calls of the components in process."""

import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.native import makers, native_fmus
from cosimo.orchestrator.systems import load_scene
from fmpy import read_model_description

HEADERS = Path(fmpy.__file__).parent / "c-code"
SCENE = "en50318-2002"
PORTS = {"pantograph": ("wire_height", "contact_force", "contact_position"),
         "catenary": ("contact_force", "contact_position", "wire_height")}
possible = own_target() == "linux64" and shutil.which("cc") is not None


def arguments(folder: Path) -> list[str]:
    """Library, GUID and value references of both units, for the host."""
    words: list[str] = []
    fmus = native_fmus(load_scene(SCENE))
    for unit, ports in PORTS.items():
        description = read_model_description(fmus[unit].path)
        references = {v.name: v.valueReference for v in description.modelVariables}
        with zipfile.ZipFile(fmus[unit].path) as file:
            library = file.extract(f"binaries/linux64/{description.coSimulation.modelIdentifier}.so", folder / unit)
        words += [library, description.guid, ",".join(str(references[p]) for p in ports)]
    return words


def host(folder: Path) -> Path:
    """The compiled program of railway.c."""
    source, program = Path(__file__).with_name("railway.c"), folder / "railway"
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-I", str(HEADERS)]
    subprocess.run(["cc", *flags, str(source), "-o", str(program), "-ldl"], check=True)
    return program


def run_host(program: Path, words: list[str], h: float, steps: int, passes: int) -> tuple[list[float], list[list[float]]]:
    """(last outputs, durations in us: mean, 99.99th percentile, longest, of the clock and of the processor), PATH empty."""
    command = [str(program), *words, repr(h), str(steps), str(passes)]
    done = subprocess.run(command, capture_output=True, text=True, env={"PATH": ""}, check=False)
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
