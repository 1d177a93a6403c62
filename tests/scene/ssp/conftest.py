from pathlib import Path

import pytest
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.c_compiler import shared_library
from cosimo.tests.scene.ssp import systems


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The compiled adder."""
    return shared_library(tmp_path_factory.mktemp("adder") / "adder.so", Path(__file__).with_name("adder.c"))


@pytest.fixture
def folder(tmp_path, library):
    """A folder with FMUs: adder.fmu without units of measure, metres.fmu (u and y in m), mixed.fmu (u in mm, y in m)."""
    systems.fmu(tmp_path / "adder.fmu", library)
    systems.fmu(tmp_path / "metres.fmu", library, "m", "m")
    systems.fmu(tmp_path / "mixed.fmu", library, "mm", "m")
    return tmp_path


@pytest.fixture
def load(folder):
    """Writes an .ssd file into the folder and reads the scene; the file must be valid against the schema."""

    def read(text: str, valid: bool = True):
        if valid:
            systems.validated(text)
        path = folder / "test.ssd"
        path.write_text(text, encoding="utf-8")
        return load_scene(path)

    return read
