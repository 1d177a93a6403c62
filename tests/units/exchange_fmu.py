"""The FMU of exchange.c, compiled for tests: for model exchange only, of FMI 2.0, and behind exchange3.c of FMI 3.0."""

from __future__ import annotations

import atexit
import shutil
import zipfile
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

import fmpy
from cosimo.tests.c_compiler import shared_library

HERE = Path(__file__).parent
REALS = ("u", "x", "k", "h", "v", "e", "y", "period", "saw", "limit", "end", "crash", "mu", "rest")
PARAMETERS = {
    "k": "1",
    "e": "0.7",
    "period": "1e9",
    "saw": "1e9",
    "limit": "1e9",
    "end": "1e9",
    "crash": "1e9",
    "mu": "0",
    "rest": "0",
}
WHOLES = ("bounces", "ticks", "passages", "resets")
CAPABILITIES = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true"'
CAPABILITIES3 = (
    'canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true" '
    'needsCompletedIntegratorStep="true"'
)
WHOLE, SINGLE = 50, 200  # first value references of wholes and of the input of single precision in FMI 3
BINARIES = {2: "linux64", 3: "x86_64-linux"}


def _variables(bare: bool) -> list[str]:
    found = ['<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>']
    found += [
        f'<ScalarVariable name="{n}" valueReference="{REALS.index(n)}" causality="output"><Real/></ScalarVariable>'
        for n in ("x", "h", "v", "y")
    ]
    if not bare:
        found += [
            f'<ScalarVariable name="der({n})" valueReference="{100 + k}" causality="local">'
            f'<Real derivative="{2 + k}"/></ScalarVariable>'
            for k, n in enumerate("xhv")
        ]
    found += [
        f'<ScalarVariable name="{n}" valueReference="{REALS.index(n)}" causality="parameter" variability="fixed">'
        f'<Real start="{start}"/></ScalarVariable>'
        for n, start in PARAMETERS.items()
    ]
    found += [
        f'<ScalarVariable name="{n}" valueReference="{k}" causality="output" variability="discrete"><Integer/></ScalarVariable>'
        for k, n in enumerate(WHOLES)
    ]
    return [
        *found,
        '<ScalarVariable name="reversed" valueReference="4" causality="input" variability="discrete">'
        '<Boolean start="false"/></ScalarVariable>',
    ]


def _description2(bare: bool, capabilities: str) -> str:
    variables = _variables(bare)
    names = [v.split('"')[1] for v in variables]
    outputs = [
        f'<Unknown index="{names.index(n) + 1}" dependencies="{1 if n == "y" else ""}"/>' for n in ("x", "h", "v", "y", *WHOLES)
    ]
    rates = [f'<Unknown index="{k}"/>' for k, n in enumerate(names, 1) if n.startswith("der(")]
    derivatives = f"<Derivatives>{''.join(rates)}</Derivatives>" if rates else ""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Exchange" guid="{{exchange}}" numberOfEventIndicators="{1 if bare else 2}">
  <ModelExchange modelIdentifier="exchange" {capabilities}/>
  <ModelVariables>{"".join(variables)}</ModelVariables>
  <ModelStructure><Outputs>{"".join(outputs)}</Outputs>{derivatives}
    <InitialUnknowns>{"".join([*outputs, *rates])}</InitialUnknowns></ModelStructure>
</fmiModelDescription>"""


def _description3(bare: bool, capabilities: str, u: str) -> str:
    """`u`: "scalar", "array" (of one element) or "single" (precision)."""
    kind, reference = ("Float32", SINGLE) if u == "single" else ("Float64", 0)
    inside = '<Dimension start="1"/>' if u == "array" else ""
    variables = [f'<{kind} name="u" valueReference="{reference}" causality="input" start="0">{inside}</{kind}>']
    variables += [f'<Float64 name="{n}" valueReference="{REALS.index(n)}" causality="output"/>' for n in ("x", "h", "v", "y")]
    if not bare:
        variables += [
            f'<Float64 name="der({n})" valueReference="{100 + k}" causality="local" derivative="{REALS.index(n)}"/>'
            for k, n in enumerate("xhv")
        ]
    variables += [
        f'<Float64 name="{n}" valueReference="{REALS.index(n)}" causality="parameter" variability="fixed" start="{start}"/>'
        for n, start in PARAMETERS.items()
    ]
    variables += [f'<Int32 name="{n}" valueReference="{WHOLE + k}" causality="output"/>' for k, n in enumerate(WHOLES)]
    variables += [f'<Boolean name="reversed" valueReference="{WHOLE + 4}" causality="input" start="false"/>']
    outputs = [(REALS.index(n), reference if n == "y" else "") for n in ("x", "h", "v", "y")]
    structure = [f'<Output valueReference="{k}" dependencies="{d}"/>' for k, d in outputs]
    structure += [f'<Output valueReference="{WHOLE + k}" dependencies=""/>' for k in range(len(WHOLES))]
    structure += [] if bare else [f'<ContinuousStateDerivative valueReference="{100 + k}"/>' for k in range(3)]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Exchange" instantiationToken="{{exchange}}">
  <ModelExchange modelIdentifier="exchange" {capabilities}/>
  <ModelVariables>{"".join(variables)}</ModelVariables>
  <ModelStructure>{"".join(structure)}</ModelStructure>
</fmiModelDescription>"""


@lru_cache
def exchange_fmu(bare: bool = False, capabilities: str | None = None, version: int = 2, u: str = "scalar") -> str:
    """Path of the FMU; `bare`: without continuous states; `version`: of FMI; `u`: form of its real input in FMI 3."""
    folder = Path(mkdtemp(prefix="exchange-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    headers = Path(fmpy.__file__).parent / "c-code"
    sources = [HERE / name for name in (("exchange.c",) if version == 2 else ("exchange3.c", "exchange3_absent.c"))]
    shared_library(folder / "exchange.so", "-O1", f"-I{headers}", *(["-DBARE"] if bare else []), *sources)
    if capabilities is None:
        capabilities = CAPABILITIES if version == 2 else CAPABILITIES3
    path = folder / "exchange.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(
            "modelDescription.xml", _description2(bare, capabilities) if version == 2 else _description3(bare, capabilities, u)
        )
        file.write(folder / "exchange.so", f"binaries/{BINARIES[version]}/exchange.so")
    return str(path)
