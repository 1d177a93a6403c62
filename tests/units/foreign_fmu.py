"""An FMU of another maker, written in C for these tests."""

import zipfile
from pathlib import Path

import pytest
from cosimo.tests.c_compiler import shared_library

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Foreign" guid="{{1}}">
  <CoSimulation modelIdentifier="foreign" {flags}/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="z" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="y" valueReference="3" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="limit" valueReference="4" causality="parameter" variability="fixed">
      <Real start="1e9" min="0"/></ScalarVariable>
    <ScalarVariable name="longest" valueReference="5" causality="parameter" variability="fixed"><Real start="1e9"/></ScalarVariable>
    <ScalarVariable name="sign" valueReference="5" causality="parameter" variability="fixed"><Integer start="1"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs>
    <Unknown index="2" dependencies=""/><Unknown index="3" dependencies=""/><Unknown index="4" dependencies="1"/>
  </Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="session")
def foreign(tmp_path_factory):
    """flags of the model description -> path of the FMU."""
    folder = tmp_path_factory.mktemp("foreign")
    library = shared_library(folder / "foreign.so", Path(__file__).with_name("foreign.c"))

    def make(flags: str = 'canHandleVariableCommunicationStepSize="true"', platform: str = "linux64") -> str:
        path = folder / f"{abs(hash((flags, platform)))}.fmu"
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("modelDescription.xml", DESCRIPTION.format(flags=flags))
            file.write(library, f"binaries/{platform}/foreign.so")
        return str(path)

    return make
