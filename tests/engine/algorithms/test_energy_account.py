"""Energy at power bonds: the account against the energy of the whole, the correction, and steps controlled by it."""

from contextlib import ExitStack

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.opened.open_scene import Course, OpenScene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.engine.algorithms.bonded import BOND, HERE, bonded, oscillation
from cosimo.tests.slopes import orders
from cosimo.tests.support import Linear
from scipy.linalg import expm

STEPS = (0.05, 0.025, 0.0125)


class InMillimetres(Linear):
    """As `bonded.Link` without damping, in millimetres, giving the force that its end exerts on it instead of the reaction."""

    k = parameter(1.0, "N/m", "stiffness")
    velocity = input_(0.0, "mm/s", "velocity of the end")
    force = output("kN", "force of the end")

    def matrices(self):
        return np.zeros((1, 1)), np.ones((1, 1)), np.array([[self.parameters["k"] * 1e-6]]), np.zeros((1, 1)), [0.0]


def misses(algorithm: str, degree: int, **master) -> np.ndarray:
    """An undamped mass on a spring by step: energy gained, what the account says beyond it, error of the state at the end."""
    rows = []
    for step in STEPS:
        result = run(read_scene(bonded("Link", algorithm, step, degree, **master)))
        energy = 0.5 * (result["a.v_out"] ** 2 + result["b.x_out"] ** 2)
        gained, made = energy[-1] - energy[0], result.info.energy[BOND].created
        error = np.abs(np.array([result["b.x_out"][-1], result["a.v_out"][-1]]) - oscillation(10.0)).max()
        rows.append((gained, made - gained, error))
    return np.abs(rows).T


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_the_account_of_held_inputs_is_the_energy_that_the_whole_has_gained(algorithm):
    """The units are exact, so what the whole gains comes from the coupling alone, and each unit's own work is a rectangle."""
    gained, beyond, _ = misses(algorithm, 0)
    assert gained.min() > 2e-3
    assert beyond.max() < 1e-12  # rounding of 800 steps with energies of 1 J


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [1, 2])
def test_the_account_is_right_in_its_leading_term(algorithm, degree):
    """Outputs are interpolated one degree above the inputs: what the account misses falls faster by one order and more."""
    gained, beyond, _ = misses(algorithm, degree)
    assert abs(orders(gained)[-1] - 2.0) < 0.2  # of degree 2 too: its first step is held
    assert orders(beyond)[-1] > degree + 1.85
    assert beyond[-1] < 0.02 * gained[-1]


@pytest.mark.parametrize(
    ("algorithm", "degree", "order"), [("jacobi", 0, 2), ("jacobi", 1, 3), ("gauss-seidel", 0, 2), ("gauss-seidel", 1, 3)]
)
def test_correction_raises_the_order_by_one(algorithm, degree, order):
    gained, _, error = misses(algorithm, degree, energy_correction=True)
    assert abs(orders(error)[-1] - order) < 0.15
    assert abs(orders(gained)[-1] - order) < 0.15
    assert error[-1] < 0.25 * misses(algorithm, degree)[2][-1]


def test_corrected_held_inputs_give_the_impulses_of_linear_ones():
    """What a held input has missed is half a step of its slope: added to the next one it makes that the mean of the line."""
    np.testing.assert_allclose(misses("jacobi", 0, energy_correction=True)[2], misses("jacobi", 1)[2], rtol=1e-6)


def test_account_in_other_units_and_with_the_opposite_sign_of_the_force():
    plain = run(read_scene(bonded("Link", "jacobi", 0.05, 1)))
    scene = bonded("Link", "jacobi", 0.05, 1)
    scene["units"]["b"] = {"component": f"{__name__}:InMillimetres"}
    scene["connections"][0] = {"source": "b.force", "target": "a.force", "factor": -1.0}
    other = run(read_scene(scene))
    for entry in ("created", "exchanged"):
        assert getattr(other.info.energy[BOND], entry) == pytest.approx(getattr(plain.info.energy[BOND], entry), rel=1e-9)


def test_energy_is_exchanged_both_ways_and_created_for_the_unit_named_first():
    """The mass gives the spring all its energy, 0.5 J, in the first quarter of its period, and gets it back in the next."""
    scene = bonded("Link", "jacobi", 1e-3, 1, stop=np.pi)
    assert run(read_scene(scene)).info.energy[BOND].exchanged == pytest.approx(1.0, rel=1e-3)
    turned = "b.force * a.v_out"
    one, other = (run(read_scene(bonded("Link", "jacobi", 0.1, 0, bonds=[name]))).info.energy[name] for name in (BOND, turned))
    assert one.created > 0.0
    assert other.created == pytest.approx(-one.created, rel=1e-12)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_energy_that_a_fault_puts_in_is_accounted_where_signals_jump(degree):
    """A body of 1e6 kg stands still; its damper is told 10 m/s for 0.1 s: 10 N s/m * 10 m/s * 10 m/s * 0.1 s, all of it made."""
    scene = bonded("Link", "jacobi", 0.1, degree, stop=1.0, a={"m": 1e6, "v0": 0.0}, b={"k": 0.0, "c": 10.0})
    scene["faults"] = [{"kind": "offset", "signal": "b.velocity", "begin": 0.5, "end": 0.6, "value": 10.0}]
    assert abs(run(read_scene(scene)).info.energy[BOND].created) == pytest.approx(100.0, rel=1e-3)


def test_a_coupling_that_makes_much_energy_is_warned_of():
    warnings = run(read_scene(bonded("Link", "jacobi", 0.1, 0))).info.warnings
    assert "the coupling made 0.852 J at the bond a.v_out * b.force" in warnings[0]
    assert not run(read_scene(bonded("Link", "jacobi", 0.01, 1))).info.warnings


# Chassis and wheel of a quarter car (numbers of the FMITest suite), the wheel kicked to 1 m/s
MS, MU, KS, CS, KT, CT = 290.0, 15.0, 16200.0, 1000.0, 191000.0, 2500.0


def quarter_car(step: float, degree: int, **master) -> tuple[float, dict]:
    """Relative rms error of the chassis' velocity over 2 s, and the run's counters."""
    scene = bonded(
        "Tethered",
        "jacobi",
        step,
        degree,
        stop=2.0,
        a={"m": MS, "v0": 0.0},
        b={"m": MU, "k": KS, "c": CS, "kg": KT, "cg": CT, "v0": 1.0},
        **master,
    )
    result = run(read_scene(scene))
    A = np.array(
        [[0, 1, 0, 0], [-KS / MS, -CS / MS, KS / MS, CS / MS], [0, 0, 0, 1], [KS / MU, CS / MU, -(KS + KT) / MU, -(CS + CT) / MU]]
    )
    exact = np.array([(expm(A * t) @ [0.0, 0.0, 0.0, 1.0])[1] for t in result.time])
    weights = np.gradient(result.time)
    error = np.sqrt(weights @ (result["a.v_out"] - exact) ** 2 / (weights @ exact**2))
    return error, result.info.counters.master | {"time": result.time}


def test_correction_of_the_quarter_car():
    """Held inputs: published is that the correction takes away up to 98 % of the error, with steps controlled."""
    assert quarter_car(1e-3, 0, energy_correction=True)[0] < 0.06 * quarter_car(1e-3, 0)[0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bonds": ["a.v_out"]}, r'master.bonds: got \'a.v_out\', expected "unit.output \* unit.output"'),
        ({"bonds": ["a.v_out * b.x_out"]}, "b.x_out, which feeds no inputs of a, expected one connection each way"),
        ({"bonds": ["a.v * b.force"]}, "a.v, expected an output of a. There is x_out, v_out"),
        ({"energy_correction": True, "bonds": []}, "true without bonds"),
    ],
)
def test_bonds_that_are_none_are_refused(changes, message):
    scene = bonded("Link", "jacobi", 0.1, 1)
    scene["master"] |= changes
    with pytest.raises(BadInput, match=message):
        read_scene(scene)


def test_a_product_that_is_no_power_is_refused():
    scene = {
        "stop_time": 1.0,
        "connections": ["b.force -> a.force", "a.x_out -> b.velocity"],
        "units": {"a": {"component": f"{HERE}:Body"}, "b": {"component": f"{HERE}:Link"}},
        "master": {"step": 0.1, "bonds": ["a.x_out * b.force"]},
    }
    scene["connections"][1] = {"source": "a.x_out", "target": "b.velocity", "convert_units": False}
    with pytest.raises(BadInput, match=r"a product in m times N, expected a power"):
        read_scene(scene)


def test_connections_with_other_gains_forth_and_back_are_refused():
    scene = bonded("Link", "jacobi", 0.1, 1)
    scene["connections"][0] = {"source": "b.force", "target": "a.force", "factor": 2.0}
    with pytest.raises(BadInput, match="connections with factors 1 and 2, expected the same gain both ways"):
        read_scene(scene)
    scene["connections"][0] = {"source": "b.force", "target": "a.force", "offset": 2.0}
    with pytest.raises(BadInput, match=r"factor 1 and offset 2 on the way from b\.force"):
        read_scene(scene)


def test_the_bond_knows_its_power():
    bond = resolve_coupling(read_scene(bonded("Link", "jacobi", 0.1, 1))).bonds[0]
    assert bond.watts == 1.0
    assert [link.target for link in bond.links] == [("b", "velocity"), ("a", "force")]


def test_the_account_does_not_depend_on_how_many_steps_are_entered_together():
    """Torques of a sampled controller jump; what is entered together follows the clock of a run, which must change no bit."""
    scene = load_scene("two-link-manipulator", {"stop_time": 0.1, "analysis.transient": 0.0})
    reports = []
    for pieces in ([1] * 40, [40], [7, 1, 19, 13]):
        with ExitStack() as stack:
            course = Course(OpenScene(scene, stack, in_process=True))
            course.start()
            for n in pieces:
                course.stepping.run((), n)
            reports.append(course.account.report())
    assert reports[0] == reports[1] == reports[2]
    assert any(one.created for one in reports[0].values())
