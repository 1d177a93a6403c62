"""Programs and libraries in C for the tests: by the compiler that builds native FMUs, which the extra `test` brings."""

import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus.native.build import compiler, compiler_environment, own_target


def c_compiler(target: str = "") -> list[str]:
    """The command for a target, this machine if none is given; the test is skipped where there is none."""
    try:
        return compiler(target or own_target())
    except BadInput as error:
        pytest.skip(f"needs a C compiler: {error}")


AS_NATIVE = (
    "-O2",
    "-s",
)  # as native FMUs: with others zig makes its libraries once more, 20 s of CPU without -O2, 5 s without -s


def compile_c(result: Path, *arguments: object, target: str = "") -> Path:
    """Compile to `result`; arguments as those of cc, paths among them."""
    command = [*c_compiler(target), *AS_NATIVE, *map(str, arguments), "-o", str(result)]
    subprocess.run(command, check=True, env=compiler_environment())
    return result


def shared_library(result: Path, *arguments: object) -> Path:
    """Compile a library as the FMUs of other makers hold it, for Linux: these tests open it."""
    if not sys.platform.startswith("linux"):
        pytest.skip("the libraries of these FMUs are made for Linux")
    # -fno-sanitize: what an FMU of the tests does wrong, it does as a release of another maker would; zig traps it otherwise
    return compile_c(result, "-shared", "-fPIC", "-w", "-fno-sanitize=all", *arguments)
