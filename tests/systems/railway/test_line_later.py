"""Lines at another temperature, and with worn wires: closed forms of strings."""

import csv

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import in_python
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.line.later import line_at, tension_of
from cosimo.components.railway.line.table import read_line
from cosimo.orchestrator.cli.application import app
from cosimo.tests.support import initialized
from typer.testing import CliRunner

EA, ALPHA, WEIGHT, TENSION = 11.64e6, 1.7e-5, 24.84, 16e3


def table(spans, contact="tension = 1.0, mass = 1e-6", mass=WEIGHT / 9.81, gap=5.5, fixed="messenger"):
    wires = {"contact_wire": contact, "messenger": f"tension = {TENSION}, mass = {mass}"}
    wires[fixed] += f", fixed = true, axial_stiffness = {EA}"
    return (
        "[[sections]]\n"
        + "\n".join(f"{name} = {{ {keys} }}" for name, keys in wires.items())
        + f"""
droppers = {{ stiffness = 1e7, first = {gap}, gap = {gap} }}
support.system_height = 3.0
spans = {spans}
"""
    )


def at(text, change=0.0, worn=0.0):
    return line_at(read_line(text), Catenary()._declared_arguments()[0], change, worn)


def root(function, low, high):
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(middle) > 0.0 else (middle, high)
    return low


def state(change, excess, curvature):
    """Tension where T / EA - excess curvature(T)² has changed by - alpha change, N; excess: at rest, m/m."""
    held = TENSION / EA - excess - ALPHA * change
    return root(lambda T: T / EA - excess * curvature(T) ** 2 - held, 1.0, 1e6)


@pytest.mark.known_answers(Catenary="temperature")
@pytest.mark.parametrize("change", [-20.0, 20.0, 40.0])
@pytest.mark.parametrize("spans", [[55, 55, 55], [40, 65, 50, 60]])
def test_a_fixed_messenger_keeps_the_equation_of_state(spans, change):
    """That of the ideal span, L² = sum L³ / sum L. The droppers' wire of 1e-6 kg/m and 1 N takes 1e-5 of the tension."""
    line, form = at(table(spans), change)
    ideal = sum(L**3 for L in spans) / sum(spans)
    expected = state(change, WEIGHT**2 * ideal / 24.0 / TENSION**2, lambda T: TENSION / T)
    assert line.sections[0].messenger.tension == pytest.approx(expected, rel=2e-5)
    if spans[0] == 55:  # printed by an independent script, to 10 N and 1 mm
        printed, sag = {-20.0: (18.94e3, 0.496), 20.0: (13.49e3, 0.696), 40.0: (11.45e3, 0.820)}[change]
        assert expected == pytest.approx(printed, abs=10.0)
        middle = np.interp(82.5, form.position, form.height[:, 1])
        assert 3.0 - middle == pytest.approx(sag, abs=1.5e-3)


def test_a_contact_wire_that_keeps_its_tension_holds_the_messenger_up():
    """Many droppers: both sink alike, z'' ~ (T0 + Tc) / (T + Tc). The error goes with the droppers' distance."""
    Tc, weight, change = 22e3, 9.81 * (1.35 + 1.08), 20.0
    tensions = [
        at(table([55, 55, 55], f"tension = {Tc}, mass = 1.35", 1.08, gap), change)[0].sections[0].messenger.tension
        for gap in (2.0, 1.0)
    ]
    expected = state(change, (weight * 55.0 / TENSION) ** 2 / 24.0, lambda T: (TENSION + Tc) / (T + Tc))
    alone = state(change, (weight * 55.0 / TENSION) ** 2 / 24.0, lambda T: TENSION / T)
    assert expected < 0.96 * alone
    errors = [T / expected - 1.0 for T in tensions]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15)
    assert 2.0 * tensions[1] - tensions[0] == pytest.approx(expected, rel=1e-3)


def test_a_fixed_contact_wire_loses_its_expansion_and_keeps_its_droppers():
    """306 N/K for 150 mm² of 120 GPa; it hardly sags. Cut lengths stay; a wire with pre-sag sinks."""
    section = f"tension = 22e3, mass = 1.35, expansion = {ALPHA}"
    text = table([55, 55, 55], section, 1.08, 5.75, "contact_wire").replace(str(EA), "18e6") + "span.sag = 0.03"
    line, form = at(text, 10.0)
    _, rest = at(text, 0.0)
    assert line.sections[0].contact_wire.tension == pytest.approx(22e3 - 3060.0, abs=25.0)
    assert form.cut_length == pytest.approx(rest.cut_length, abs=1e-9)
    assert line.sections[0].messenger.tension == TENSION
    assert (form.layout.droppers.height - rest.layout.droppers.height).min() < -1e-3


@pytest.mark.known_answers(Catenary="wear")
def test_a_worn_wire_rises_by_its_missing_weight_over_both_tensions():
    """Many droppers: w' L² / 8 (T + Tc) in the middle of a span. The error goes with the droppers' distance."""
    Tc, share = 22e3, 0.2
    expected = 9.81 * share * 1.35 * 55.0**2 / 8.0 / (TENSION + Tc)
    rises = []
    for gap in (2.5, 1.25):
        text = table([55, 55, 55], f"tension = {Tc}, mass = 1.35", 1.08, gap).replace(", fixed = true", "")
        (_, new), (line, worn) = at(text), at(text, worn=share)
        rises.append(float(np.interp(82.5, worn.position, worn.height[:, 0]) - np.interp(82.5, new.position, new.height[:, 0])))
        assert worn.cut_length == pytest.approx(new.cut_length, abs=1e-9)
        assert line.sections[0].messenger.tension == TENSION
        assert worn.preload.mean() < new.preload.mean()
    errors = [rise / expected - 1.0 for rise in rises]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15)
    assert 2.0 * rises[1] - rises[0] == pytest.approx(expected, rel=2e-3)


def test_a_worn_contact_wire_between_anchors_keeps_its_strain():
    """T / EA stays where a wire hardly sags: its tension falls with its section, by wear and by warmth."""
    text = table([55, 55, 55], "tension = 22e3, mass = 1.35", 1.08, 5.75, "contact_wire").replace(str(EA), "18e6")
    line, _ = at(text, worn=0.2)
    assert line.sections[0].contact_wire.tension == pytest.approx(0.8 * 22e3, abs=25.0)
    line, _ = at(text, 10.0, 0.2)
    assert line.sections[0].contact_wire.tension == pytest.approx(0.8 * (22e3 - 3060.0), abs=25.0)


def test_wear_of_the_model_is_that_of_the_form():
    """Mass and heights of the mesh; no wear changes nothing; a line whose wires keep their tension wears, too."""
    text = table([50, 60, 50], "tension = 22e3, mass = 1.35", 1.08, 6.0).replace(", fixed = true", "")
    values = {"line_table.table": text, "method": "implicit", "contact_position": 80.0}

    def model(*effects, **more):
        return initialized(
            Catenary(["line_table", *effects], {k: v for k, v in (values | more).items() if k != "contact_position"}),
            {"contact_position": 80.0},
        )

    plain, none, worn = model(), model("wear", **{"wear.share": 0.0}), model("wear", **{"wear.share": 0.2})
    _, form = at(text, worn=0.2)
    heights = np.interp(form.layout.droppers.position, worn.mesh.position, worn.mesh.height[: worn.mesh.position.size])
    assert heights == pytest.approx(form.layout.droppers.height, abs=1e-6)
    assert none["wire_height"] == pytest.approx(plain["wire_height"], abs=1e-10)
    assert "wear.share" not in plain.parameters
    lighter = [model.mesh.mass[np.isfinite(model.mesh.mass)].sum() for model in (plain, worn)]
    assert lighter[0] - lighter[1] == pytest.approx(0.2 * 1.35 * 160.0, rel=0.01)  # but for the halves at the anchors


def test_no_change_changes_nothing():
    text = table([50, 60, 45], "tension = 22e3, mass = 1.35", 1.08, 6.0)
    line, form = at(text, 0.0)
    assert line.sections[0].messenger.tension == pytest.approx(TENSION, rel=1e-12)
    plain = Catenary(["line_table"], {"line_table.table": text}).form()
    assert form.layout.droppers.height == pytest.approx(plain.layout.droppers.height, abs=1e-10)


def test_the_effect_moves_the_wire_of_the_model():
    """Heights at rest are those of the form; a line whose wires all keep their tension is refused."""
    text = table([50, 60, 50], "tension = 22e3, mass = 1.35", 1.08, 6.0)
    values = {"line_table.table": text, "method": "implicit", "temperature.change": 30.0}
    warm = Catenary(["line_table", "temperature"], values)
    _, form = at(text, 30.0)
    warm.set("contact_position", 80.0)
    warm.initialize(0.0)
    heights = np.interp(form.layout.droppers.position, warm.mesh.position, warm.mesh.height[: warm.mesh.position.size])
    assert heights == pytest.approx(form.layout.droppers.height, abs=1e-6)
    assert warm["wire_height"] < -0.02
    with pytest.raises(BadInput, match="nothing changes"):
        Catenary(["line_table", "temperature"], values | {"line_table.table": text.replace(", fixed = true", "")}).form()
    without = text.replace(f", axial_stiffness = {EA}", "")
    with pytest.raises(BadInput, match=r"messenger.*without axial_stiffness"):
        Catenary(["line_table", "temperature"], values | {"line_table.table": without}).form()


def test_the_command_gives_the_droppers_of_a_warm_line(tmp_path):
    file, text = tmp_path / "mine.toml", table([50, 60, 50], "tension = 22e3, mass = 1.35", 1.08, 6.0)
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(app, ["railway", "line", str(file), "--temperature", "30", "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader((tmp_path / "droppers.csv").open(encoding="utf-8")))
    _, form = at(text, 30.0)
    assert [float(row["height [m]"]) for row in rows] == pytest.approx(form.layout.droppers.height)
    rest = Catenary(["line_table"], {"line_table.table": text}).form()
    assert [float(row["cut length [m]"]) for row in rows] == pytest.approx(rest.cut_length, abs=1e-8)  # cut once for all
    both = CliRunner().invoke(app, ["railway", "line", str(file), "--temperature", "30", "--wear", "20%"])
    assert both.exit_code == 0
    assert "mine, +30 K, 20 % worn since" in both.output
    file.write_text(text.replace(", fixed = true", ""), encoding="utf-8")
    done = CliRunner().invoke(app, ["railway", "line", str(file), "--temperature", "30"])
    assert isinstance(done.exception, BadInput)
    assert "automatic tensioning" in str(done.exception)


class Held(complex):
    """A complex number that others are compared with by their real parts."""

    def __lt__(self, other):
        return other.real > self.real


@pytest.mark.parametrize(("by_held", "by_excess"), [(1e-30, 0.0), (0.0, 1e-30)])
def test_a_tension_has_the_derivative_of_its_equation(by_held, by_excess):
    """T / EA - e T0² / T² = held, by a complex step; halving between bounds has only the number, as of a wire that hardly sags."""
    EA, T0, held, e = 18e6, 14.7e3, 7e-4, 3e-5
    T = in_python(tension_of)(EA, Held(held, by_held), complex(e, by_excess), T0)
    slope = 1.0 / (1.0 / EA + 2.0 * e * T0**2 / T.real**3)
    assert T.real / EA - e * T0**2 / T.real**2 == pytest.approx(held, rel=1e-12)
    assert T.imag / 1e-30 == pytest.approx(slope if by_held else slope * T0**2 / T.real**2, rel=1e-9)
