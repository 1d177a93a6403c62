"""Components and scenes as modules of WebAssembly, run under Node and compared with the process.

Machine code has the same operations in the same order; functions of the mathematics library differ in last digits, by up to four
units. What these may do to a solution is measured in process, by a start that is moved by as much.
"""

import re
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from cosimo.components.bearings.loads import TOLERANCE
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.fmus.native.build import library, own_target
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene_fmu import scene_library
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.contract.configurations import Configuration, compatible, small
from cosimo.tests.documentation.test_readme import ROOT, blocks
from cosimo.tests.fmus.native.support import SHARE, in_process, opened
from cosimo.tests.fmus.native.web_assembly import NODE, alone, inexact_functions, needs_node, stepped
from cosimo.tests.short_run import ONE_A_SYSTEM

pytestmark = [needs_node, pytest.mark.skipif(own_target() != "linux64", reason="compares with Linux on x86-64")]
STEPS, DIFFERENCE, LAST_DIGITS = 200, 1e-12, 4 * 2.0**-52
ITERATED = {"AngularContactConductance": TOLERANCE}  # an equilibrium that is known to a tolerance, however it is reached
MOVED = {"Thruster": 5.0, "TwoLinkChain": 5.0}  # shares of the inputs where there is a dead band, or friction that sticks


def every_effect():
    """Configurations in which each effect of each component is on at least once, as many together as go together."""
    for name in CATALOGUE:
        cls = component_class(name)
        left = dict.fromkeys(cls.effects)
        on = compatible(cls)
        yield Configuration(name, on, small(name, on))
        while left := {e: None for e in left if e not in on}:
            on = compatible(cls, left)
            yield Configuration(name, on, small(name, on))


EVERY = [
    pytest.param(c, id=c.label, marks=() if c.component == "PlanarLink" else pytest.mark.full)
    for c in every_effect()
    if c.component in (*ONE_A_SYSTEM, "PlanarLink")
]


@pytest.mark.parametrize("configuration", EVERY)
def test_a_component_with_all_its_effects(configuration, tmp_path):
    as_in_process(configuration, tmp_path)


def as_in_process(configuration, tmp_path):
    """A component as WebAssembly does what it does in process, to what inexact functions make of the last digits."""
    found, component = library(configuration.component, configuration.make, ["wasm32"]), configuration.make()
    h = component.default_step
    share = MOVED.get(configuration.component, SHARE)
    expected = in_process(component, h, STEPS, share)
    assert expected.shape[1] == 0 or np.ptp(expected, axis=0).any(), "nothing moves: the comparison would say nothing"
    numbers = alone(found, tmp_path, h, STEPS, restored=STEPS // 2, share=share)
    functions = inexact_functions(found.component)
    size = np.maximum(np.abs(expected).max(axis=0, initial=0.0), 1e-300)
    differences = np.abs(numbers - expected) / size
    print(f"{configuration.label}: {differences.max(initial=0.0):.1e}, calls {', '.join(sorted(functions)) or 'no function'}")
    if not functions:
        assert not differences.any()
    elif (differences > (least := ITERATED.get(configuration.component, DIFFERENCE))).any():
        disturbed = configuration.make()
        begin = disturbed.initialize

        def moved(t):
            begin(t)
            disturbed.x += LAST_DIGITS * np.maximum(np.abs(disturbed.x), 1.0)
            disturbed.u[0] *= 1.0 + LAST_DIGITS

        disturbed.initialize = moved
        grown = np.abs(in_process(disturbed, h, STEPS, share) - expected) / size
        print(f"  in process the last digits of the start become {grown.max():.1e}")
        assert (differences.max(axis=0) <= np.maximum(least, grown.max(axis=0))).all()


def recorded(scene, library, steps):
    """(names, columns) of the outputs that a library of the scene has, from its run in process."""
    reference = run(scene.with_changes({"stop_time": steps * scene.master.step, "record.interval": None}), in_process=True)
    names = [v.scalar.name for v in library.variables if v.role == "OUTPUT" and v.scalar.name in reference.columns]
    assert len(names) > 2
    return names, np.column_stack([np.asarray(reference[name]) for name in names])


def test_a_scene_without_functions_is_bit_identical(tmp_path):
    scene = load_scene("mass-on-spring")
    found = scene_library(scene, ["wasm32"])
    names, expected = recorded(scene, found, 1000)
    numbers = stepped(found, tmp_path, scene.master.step, 1000, names, restored=471)
    np.testing.assert_array_equal(numbers, expected)


@pytest.mark.full
def test_the_railway_scene_goes_on_with_the_bits_of_the_process(tmp_path):
    """Only its initialization calls functions of the mathematics library: its state comes from the FMU for Linux."""
    scene = load_scene("en50318-2002")
    found = scene_library(scene, ["linux64", "wasm32"])
    names, expected = recorded(scene, found, 2000)
    fmu, _ = opened(found, tmp_path, 3)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    state = fmu.serializeFMUState(fmu.getFMUState())
    fmu.freeInstance()
    numbers = stepped(found, tmp_path, scene.master.step, 2000, names, state=state)
    np.testing.assert_array_equal(numbers, expected)
    own = stepped(found, tmp_path, scene.master.step, 2000, names)
    assert (np.abs(own - expected).max(axis=0) <= DIFFERENCE * np.abs(expected).max(axis=0)).all()


def test_the_host_gets_messages(tmp_path):
    found = library("PlanarLink", lambda: component_class("PlanarLink")(()), ["wasm32"])
    with pytest.raises(AssertionError, match=r"3 logStatusError: set: mass = -1, expected .*\n.*fmi3SetFloat64: status 3"):
        stepped(found, tmp_path, 1e-3, 1, ["angle"], values={"mass": -1.0})


def test_the_host_of_the_documentation(tmp_path):
    (host,) = blocks(ROOT / "docs" / "give-away.md", "js")
    command = [
        sys.executable,
        "-m",
        "cosimo.orchestrator.cli",
        "build",
        "mass-on-spring",
        "--native",
        "--target",
        "wasm32",
        "-o",
        ".",
    ]
    refused = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert "--fmi 3" in refused.stderr
    subprocess.run([*command, "--fmi", "3"], cwd=tmp_path, check=True)
    with zipfile.ZipFile(tmp_path / "mass-on-spring.fmi3.fmu") as file:
        file.extractall(tmp_path)
    (tmp_path / "host.mjs").write_text(host)
    done = subprocess.run([NODE, "host.mjs"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    end = run(load_scene("mass-on-spring").with_changes({"stop_time": 1.0, "record.interval": None}), in_process=True)
    assert float(re.search(r"base_x = (\S+)", done.stdout).group(1)) == np.asarray(end["mass.base_x"])[-1]
