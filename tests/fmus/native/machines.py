"""C programs for a target, and how they run on this machine: by themselves, Windows' under Wine, ARM's under QEMU."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest
from cosimo.fmus.native.build import own_target
from cosimo.tests.c_compiler import compile_c

HEADERS = Path(fmpy.__file__).parent / "c-code"
HERE = Path(__file__).parent
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")  # Debian's package libc6-arm64-cross


def _wine() -> list[str]:
    found = next((path for path in (shutil.which("wine64"), "/usr/lib/wine/wine64") if path and Path(path).exists()), None)
    return [found] if found else []


def _qemu() -> list[str]:
    found = shutil.which("qemu-aarch64")
    return [found, "-L", str(ARM_LIBRARIES)] if found and ARM_LIBRARIES.is_dir() else []


RUNNERS = {"win64": _wine(), "linux-arm64": _qemu()}
NEEDS = {"win64": "Wine", "linux-arm64": "qemu-aarch64, ARM's C library (libc6-arm64-cross)"}
# a target that this machine is not; its programs run where the emulator and the compiler for it are installed
OTHERS = [pytest.param(target, marks=pytest.mark.skipif(not RUNNERS[target] or find_spec("ziglang") is None,
                                                        reason=f"needs {NEEDS[target]} and the compiler of the extra `native`"))
          for target in RUNNERS]  # fmt: skip


def program(source: str, folder: Path, target: str = "linux64", *more: str) -> list[str]:
    """The command that runs the compiled program of a source beside this file."""
    result = folder / (Path(source).stem + (".exe" if target == "win64" else ""))
    own = target == own_target()
    flags = ["-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", *more, "-I", str(HEADERS)]
    libraries = [] if target == "win64" else ["-ldl", "-lm"]
    compile_c(result, *flags, HERE / source, *libraries, target=target)
    return [str(result)] if own else [*RUNNERS[target], str(result)]


def environment(target: str, folder: Path) -> dict[str, str]:
    """What the emulator of a target needs; nothing of this process."""
    wine = {"WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all", "HOME": str(folder)}
    return {"PATH": ""} | (wine if target == "win64" else {})
