"""A component of one's own: declared with mistakes, packed as an FMU, run by its name wherever a name goes."""

import subprocess
import sys
import zipfile

import pytest
from cosimo import BadInput, build_scene, component_class, load_scene
from cosimo.fmus.build import build
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write

HELPER = "TWO = 2.0\n"
SPRING = '''
import numpy as np

from cosimo import (
    StatelessComponent, input_, kernel, output, parameter, stateless_kernels,
)
import cosimo
from cosimo.components.core.kernels import DONE
from {helper} import TWO


class Spring(StatelessComponent):
    """F = 2 k x."""

    title = "Spring"
    stiffness = parameter(100.0, "N/m", "stiffness", low=0.0)
    deflection = input_(0.1, "m", "deflection")
    force = output("N", "force", feedthrough=("deflection",))

    def shapes(self):
        assert cosimo.Component in type(self).__mro__
        return super().shapes()


@kernel
def outputs(t, s, p, e):
    s.y[0] = TWO * p.stiffness * s.u[0, 0]
    return DONE


Spring.kernels = stateless_kernels(__name__, outputs)
'''
RUN = """
import fmpy, sys
assert not [m for m in sys.modules if m == "cosimo"]
print(float(fmpy.simulate_fmu(sys.argv[1], start_values={"deflection": 0.2}, stop_time=0.01, output_interval=0.005)["force"][-1]))
assert not [m for m in sys.modules if m == "cosimo" or m.startswith("cosimo.")]
"""


@pytest.fixture
def module(tmp_path, monkeypatch, request):
    """Writes modules of these names into a folder on the path; names are unique to the test."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def written(stem: str, text: str) -> str:
        file = tmp_path / f"{stem.replace('.', '/')}.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        return stem

    yield written
    for name in [m for m, loaded in sys.modules.items() if str(getattr(loaded, "__file__", "")).startswith(str(tmp_path))]:
        del sys.modules[name]


@pytest.mark.parametrize("package", ["", "mechanics."])
def test_an_own_class_is_an_fmu_that_needs_no_cosimo(module, tmp_path, package):
    module(f"{package}numbers_of_{len(package)}", HELPER)
    name = module(f"{package}springs_{len(package)}", SPRING.format(helper=f"{package}numbers_of_{len(package)}"))
    path = build(f"{name}:Spring", tmp_path / "out")
    assert path.name == "Spring.fmu"
    assert path.read_bytes() == build(component_class(f"{name}:Spring"), tmp_path / "again").read_bytes()
    with zipfile.ZipFile(path) as file:
        own = [n.partition("/own/")[2] for n in file.namelist() if "/own/" in n]
        assert not [n for n in file.namelist() if "railway" in n]
    assert f"{name.replace('.', '/')}.py" in own
    assert len([n for n in own if "numbers" in n]) == 1
    done = subprocess.run([sys.executable, "-I", "-c", RUN, str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[-1]) == 40.0  # 2 * 100 N/m * 0.2 m


def test_an_own_class_goes_wherever_a_name_goes(module, tmp_path):
    module("numbers_of_names", HELPER)
    name = module("springs_of_names", SPRING.format(helper="numbers_of_names")) + ":Spring"
    scene = load_scene(name)
    assert (scene.title, list(scene.units)) == ("Spring", ["spring"])
    assert run(scene.with_changes({"stop_time": 0.01}), in_process=True)["spring.force"][-1] == 20.0
    packed = write(build_scene({"a": name}, stop_time=1.0, step=0.1), tmp_path / "own.ssp")
    with zipfile.ZipFile(packed) as file:
        assert "resources/Spring.fmu" in file.namelist()
    assert list(load_scene("TorqueMotor").units) == ["torque_motor"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("import pandas", "an import of 'pandas'"),
        ("from cosimo import run", "names that components use"),
        ("from cosimo.orchestrator.run.run import run", "public names or of its components"),
        ("import numpy, cosimo", "an import statement of its own"),
    ],
)
def test_what_an_fmu_could_not_import_is_refused(module, tmp_path, line, words):
    name = module(
        "refused_imports",
        f"from cosimo import StatelessComponent\nif False:\n    {line}\n\n\nclass Part(StatelessComponent):\n    title = 'a'\n",
    )
    with pytest.raises(BadInput, match=words):
        build(f"{name}:Part", tmp_path)


HEAD = "from cosimo import Component, Effect, Preset, input_, integer, output, parameter\n\n\nclass Part(Component):\n"


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        ("mass = parameter(1.0, 'kgg', 'mass')", "unit 'kgg'"),
        ("mass = parameter(1.0, '', 'mass')", "unit ''"),
        ("mass = parameter(-1.0, 'kg', 'mass', low=0.0)", "starts at -1.0"),
        ("mass = parameter(1.0, 'kg', 'mass', low=2.0, high=1.0)", "low at or below high"),
        ("mass = parameter((1.0, 2.0), 'kg', 'mass', size=3)", "size=2"),
        ("step = parameter(1.0, 'kg', 'mass')", "no method of Component"),
        (
            "force = output('N', 'force', feedthrough=('place',))\n    position = input_(0.0, 'm', 'place')",
            "feedthrough of 'place'",
        ),
        (
            "presets = {'a': Preset({'mas': 1.0}, 'book', 'unconfirmed')}\n    mass = parameter(1.0, 'kg', 'mass')",
            "Did you mean 'mass'",
        ),
    ],
)
def test_a_mistake_in_a_declaration_has_file_and_line(module, declared, words):
    stem = "mistaken_" + str(abs(hash(declared)))
    file = module(stem, f"{HEAD}    {declared}\n")
    with pytest.raises(BadInput) as caught:
        component_class(f"{file}:Part")
    assert f"{stem}.py:5: " in str(caught.value)
    assert words in str(caught.value)
    assert "Traceback" not in str(caught.value)


def test_errors_of_a_module_have_file_and_line(module):
    with pytest.raises(BadInput, match=r"SyntaxError: .*broken_part\.py:2\)"):
        component_class(module("broken_part", "a = 1\nb = (\n") + ":Part")
    with pytest.raises(BadInput, match=r"ZeroDivisionError: .*dividing_part\.py:3\)"):
        component_class(module("dividing_part", "\n\na = 1 / 0\n") + ":Part")
    with pytest.raises(BadInput, match="belongs into PYTHONPATH"):
        component_class("no_such_module_anywhere:Part")


def test_every_class_of_the_catalogue_passes_the_check_of_declarations():
    from cosimo.components.catalogue import CATALOGUE
    from cosimo.components.core.declaration import check_declaration

    for name in CATALOGUE:
        check_declaration(component_class(name))
