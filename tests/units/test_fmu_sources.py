"""FMUs that hold their sources and no library for this machine: compiled where a compiler is, refused with the reason where not."""

import sys
import zipfile

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.settings import UnitSettings
from cosimo.orchestrator.units import fmu_sources, open_unit
from cosimo.tests.c_compiler import c_compiler
from cosimo.tests.units.native import SOURCES, description

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the models are made for Linux")
FILES = ("fmi{}.c", "absent{}.c")
PREFIX = '#ifndef FMI2_FUNCTION_PREFIX\n#define FMI2_FUNCTION_PREFIX bouncing_ball_\n#endif\n#define MODEL "bouncing_ball.h"\n'


def built(fmi, listed=(), definition='"bouncing_ball.h"', more=""):
    """A buildDescription.xml, or the list of a model description of FMI 2."""
    if fmi == 2:
        return "<SourceFiles>" + "".join(f'<File name="{name}"/>' for name in listed) + "</SourceFiles>"
    files = "".join(f'<SourceFile name="{name}"/>' for name in listed)
    return (
        f'<fmiBuildDescription fmiVersion="3.0"><BuildConfiguration modelIdentifier="bouncing_ball"><SourceFileSet language="C99">'
        f'{files}<PreprocessorDefinition name="MODEL" value=\'{definition}\'/><IncludeDirectory name="models"/>{more}'
        "</SourceFileSet></BuildConfiguration></fmiBuildDescription>"
    )


@pytest.fixture
def pack(tmp_path):
    """Writes an FMU of the bouncing ball with its sources, and libraries for others."""

    def pack(fmi, listed=None, **build):
        files = [name.format(fmi) for name in FILES] if listed is None else listed
        text = description("bouncing_ball", fmi, 'canHandleVariableCommunicationStepSize="true"')
        if fmi == 2:
            head, _, tail = text.partition("<CoSimulation")
            attributes, _, rest = tail.partition("/>")
            text = f"{head}<CoSimulation{attributes}>{built(2, files)}</CoSimulation>{rest}"
        path = tmp_path / "ball.fmu"
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("modelDescription.xml", text)
            file.writestr("binaries/win64/bouncing_ball.dll", b"MZ")
            file.writestr("binaries//", b"")
            for name in FILES:
                source = (SOURCES / name.format(fmi)).read_text(encoding="utf-8")
                file.writestr(f"sources/{name.format(fmi)}", (PREFIX if fmi == 2 else "") + source)
            for header in ("model.h", "bouncing_ball.h", "nothing.h"):
                file.write(SOURCES / header, f"sources/{'models/' if fmi == 3 else ''}{header}")
            if fmi == 3:
                file.writestr("sources/buildDescription.xml", built(3, files, **build))
        return UnitSettings(fmu=str(path))

    return pack


@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_are_compiled_once_and_run(pack, fmi, monkeypatch):
    c_compiler()
    settings = pack(fmi)
    for _ in range(2):
        unit = open_unit("ball", settings, in_process=True)
        unit.close()
        monkeypatch.setattr(fmu_sources, "_compiled", None)  # the second time it is in the cache


REFUSED = {
    "Windows alone": ([], {}, "libraries for win64 alone"),
    "C++": (["ball.cpp"], {}, "source file 'ball.cpp'"),
    "a file that is not there": (["absent.c"], {}, "without its source file 'absent.c'"),
    "outside": (["../fmi3.c"], {}, "source file '../fmi3.c'"),
    "a library": (None, {"more": '<Library name="lapack"/>'}, "want the library 'lapack'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_compiled_is_told(pack, name):
    listed, build, part = REFUSED[name]
    with pytest.raises(BadInput, match=r"units\.ball\.fmu") as raised:
        open_unit("ball", pack(3, listed, **build), in_process=True)
    assert part in str(raised.value)


def test_sources_that_do_not_compile_give_the_first_error(pack):
    c_compiler()
    with pytest.raises(BadInput, match=r"do not compile: .*error"):
        open_unit("ball", pack(3, definition='"absent.h"'), in_process=True)


def test_without_a_compiler_the_message_names_the_extra(pack, monkeypatch):
    monkeypatch.setattr("cosimo.fmus.native.build.find_spec", lambda name: None)
    monkeypatch.setattr("cosimo.fmus.native.build.shutil.which", lambda name: None)
    with pytest.raises(BadInput, match=r"no compiler for its sources.*cosimo\[native\]"):
        open_unit("ball", pack(3), in_process=True)
