import sys
from importlib.util import module_from_spec, spec_from_file_location

import pytest
from cosimo.fmus import build as builder
from cosimo.fmus.native import build as native
from cosimo.tests.fmus.driver import HERE, Driven
from fmpy import extract


def probe_class():
    spec = spec_from_file_location("cosimo.components.testing.probe", HERE / "probe_component.py")
    sys.modules[spec.name] = module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Probe


@pytest.fixture(scope="session")
def probe(tmp_path_factory):
    """The FMU of the probe component and its extracted folder."""
    files = builder.sources("core.component") | builder.sources("core.kernels")
    files |= {"testing/__init__.py": b"", "testing/probe.py": (HERE / "probe_component.py").read_bytes()}
    _, members = builder.fmu_members("Probe", probe_class(), "testing.probe", files)
    path = builder.write(members, tmp_path_factory.mktemp("probe") / "Probe.fmu")
    return path, extract(str(path))


@pytest.fixture
def new_probe(probe):
    """Makes instances of the probe; they are freed at the end of the test."""
    made = []

    def make(name="unit"):
        made.append(Driven(*probe, name=name))
        return made[-1]

    yield make
    for unit in made:
        unit.free()


@pytest.fixture
def linked_anew(monkeypatch):
    """No library comes from the cache: the list of what has been linked."""
    linked, made = [], native._linked
    monkeypatch.setattr(native, "_linked", lambda name, *rest: linked.append(name) or made(name, *rest))
    monkeypatch.setattr(native, "kept_object", lambda make, *parts: make())
    return linked
