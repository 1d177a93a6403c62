"""Every structural parameter of the catalogue says whether it is a mesh, and if not, what it is."""

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.declaration import check_declaration
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import MESHES, STRUCTURAL, Kind, integer, parameter
from cosimo.tests.support import Mass

FOUND = {
    ("Catenary", "element"): "shorter",
    ("BeamRotor", "element"): "shorter",
    ("Tether", "segments"): "more",
    ("WaterCurrent", "spectrum.components"): "random",
    ("Catenary", "gusts.components"): "random",
    ("Pantograph", "lift_fluctuation.components"): "random",
    ("Pantograph", "wire_unevenness.components"): "random",
}


def structural():
    for name in CATALOGUE:
        for variable in component_class(name).variables.values():
            if variable.structural:
                yield name, variable


def test_every_structural_parameter_says_whether_it_is_a_mesh():
    """A count says what it counts: "a count" alone is what a declaration without a word gets."""
    silent = [
        f"{n}.{v.name}" for n, v in structural() if not v.mesh and v.kind is Kind.INTEGER and v.structural == STRUCTURAL[v.kind]
    ]
    assert silent == []
    assert {(n, v.name): v.mesh for n, v in structural() if v.mesh} == FOUND
    seeds = [f"{n}.{v.name}" for n, v in structural() if v.name.endswith("seed") != (v.structural == "a seed")]
    assert seeds == []


@pytest.mark.parametrize(
    "wrong", [integer(3, "parts", mesh="finer"), parameter((1.0, 2.0), "m", "lengths", size=2, mesh="shorter")]
)
def test_a_mesh_that_cannot_be_meant_is_refused(wrong):
    with pytest.raises(BadInput, match="mesh"):
        check_declaration(type("Wrong", (Mass,), {"wrong": wrong}))


def test_a_mesh_is_structural():
    assert parameter(1.0, "m", "longest element", mesh="shorter").structural == MESHES["shorter"]
