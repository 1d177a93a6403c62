"""The FMU of exchange.c, compiled for tests: for model exchange only, of FMI 2.0."""

from __future__ import annotations

import atexit
import shutil
import subprocess
import sys
import zipfile
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

import fmpy
import pytest

HERE = Path(__file__).parent
REALS = ("u", "x", "k", "h", "v", "e", "y", "period", "saw", "limit", "end", "crash", "mu", "rest")
PARAMETERS = {"k": "1", "e": "0.7", "period": "1e9", "saw": "1e9", "limit": "1e9", "end": "1e9", "crash": "1e9",
              "mu": "0", "rest": "0"}
WHOLES = ("bounces", "ticks", "passages", "resets")
CAPABILITIES = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true"'


def _variables(bare: bool) -> list[str]:
    found = ['<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>']
    found += [f'<ScalarVariable name="{n}" valueReference="{REALS.index(n)}" causality="output"><Real/></ScalarVariable>'
              for n in ("x", "h", "v", "y")]
    if not bare:
        found += [f'<ScalarVariable name="der({n})" valueReference="{100 + k}" causality="local">'
                  f'<Real derivative="{2 + k}"/></ScalarVariable>' for k, n in enumerate("xhv")]
    found += [f'<ScalarVariable name="{n}" valueReference="{REALS.index(n)}" causality="parameter" variability="fixed">'
              f'<Real start="{start}"/></ScalarVariable>' for n, start in PARAMETERS.items()]
    found += [f'<ScalarVariable name="{n}" valueReference="{k}" causality="output" variability="discrete"><Integer/>'
              '</ScalarVariable>' for k, n in enumerate(WHOLES)]
    return [*found, '<ScalarVariable name="reversed" valueReference="4" causality="input" variability="discrete">'
                    '<Boolean start="false"/></ScalarVariable>']


@lru_cache
def exchange_fmu(bare: bool = False, capabilities: str = CAPABILITIES) -> str:
    """Path of the FMU; `bare`: without continuous states."""
    if shutil.which("cc") is None or sys.platform != "linux":
        pytest.skip("needs Linux and a C compiler")
    folder = Path(mkdtemp(prefix="exchange-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    headers = Path(fmpy.__file__).parent / "c-code"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-w", f"-I{headers}", *(["-DBARE"] if bare else []), "-o",
                    folder / "exchange.so", HERE / "exchange.c"], check=True)
    variables = _variables(bare)
    names = [v.split('"')[1] for v in variables]
    outputs = [f'<Unknown index="{names.index(n) + 1}" dependencies="{1 if n == "y" else ""}"/>'
               for n in ("x", "h", "v", "y", *WHOLES)]
    rates = [f'<Unknown index="{k}"/>' for k, n in enumerate(names, 1) if n.startswith("der(")]
    derivatives = f"<Derivatives>{''.join(rates)}</Derivatives>" if rates else ""
    description = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Exchange" guid="{{exchange}}" numberOfEventIndicators="{1 if bare else 2}">
  <ModelExchange modelIdentifier="exchange" {capabilities}/>
  <ModelVariables>{''.join(variables)}</ModelVariables>
  <ModelStructure><Outputs>{''.join(outputs)}</Outputs>{derivatives}
    <InitialUnknowns>{''.join([*outputs, *rates])}</InitialUnknowns></ModelStructure>
</fmiModelDescription>"""
    path = folder / "exchange.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("modelDescription.xml", description)
        file.write(folder / "exchange.so", "binaries/linux64/exchange.so")
    return str(path)
