"""The lumped catenary of a line: where it may stand for the line, and where not."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo import BadInput, load_scene
from cosimo.components.railway.lumped import SpanFit
from cosimo.orchestrator.systems.railway.lumped_domain import ERRORS, LumpedDomain, domain_text, lumped_domain
from cosimo.tests.commands import exit_code


def test_the_domain_ends_at_the_first_speed_outside():
    errors = {name: np.array([0.01, -0.2, 0.02]) for name in ERRORS} | {"mean": np.zeros(3), "uplift": np.full(3, 0.5)}
    domain = LumpedDomain(
        "made up", 100.0, SpanFit({}, 0.0, 0.0, 0.0), False, load_scene("lumped-catenary"), np.array([10.0, 20.0, 30.0]), errors
    )
    assert domain.up_to("std", 0.1) == 10.0  # what agrees again beyond an error is chance
    assert domain.up_to("mean", 0.1) == 30.0
    assert np.isnan(domain.up_to("uplift", 0.1))
    assert domain_text(domain, "uplift", 0.1) == "not at 10 km/h"
    assert "highest" in domain_text(domain, "mean", 0.1)
    assert "highest" not in domain_text(replace(domain), "std", 0.1)


def test_several_pantographs_are_refused_before_anything_runs():
    with pytest.raises(BadInput, match="a scene with one"):
        lumped_domain(load_scene("two-pantographs"), [100.0])
    with pytest.raises(BadInput, match="positive speeds"):
        lumped_domain(load_scene("en50318-2002"), [0.0])


@pytest.mark.full
def test_lumped_and_distributed_agree_where_nothing_moves_quickly(tmp_path):
    """As the train gets slower, the uplift tends to the static one, which was fitted; waves and droppers are lost at speed."""
    domain = lumped_domain(load_scene("en50318-2002"), [10.0, 250.0])
    assert domain.errors["uplift"][0] < domain.fit.rms  # the stiffness's own misfit is mostly beside the supports
    assert domain.errors["uplift"][1] > 4.0 * domain.errors["uplift"][0]
    assert np.abs(domain.errors["mean"]).max() < 0.01
    assert domain.errors["std_5_20"][1] < -0.5
    files = domain.save(tmp_path)
    again = load_scene(files[0])
    assert again.units["catenary"].component == "LumpedCatenary"
    assert len(files[1].read_text(encoding="utf-8").splitlines()) == 3


def test_commands_refuse_what_they_cannot_use(capsys, tmp_path):

    for arguments, message in (
        (("lumped", "en50318-2002", "--speeds", "5 km/h,x"), "--speeds: got 'x'"),
        (("lumped", "en50318-2002", "--speeds", "160"), "160 km/h or 160 m/s?"),
        (("fit-pantograph", str(tmp_path / "none.csv")), "none.csv"),
        (("fit-pantograph", "x.csv", "--fix", "head_mass=heavy"), "head_mass"),
        (("fit-pantograph", "x.csv", "--fix", "head_mass=7 N"), "dimension of kg"),
    ):
        assert exit_code("railway", *arguments, "-o", str(tmp_path / "out")) == 2
        assert message in capsys.readouterr().err
