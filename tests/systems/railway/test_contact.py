"""The contact between pantograph and wire against solutions that share no code: Fourier integrals, sine series, dispersion."""

import math

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.contact import WireOnMesh, node_compliance
from cosimo.orchestrator.harness.analysis.signals import ButterworthFilter
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway.modal import Head, Line, passage
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from numpy.polynomial import Polynomial
from scipy.integrate import quad

T, M = 20e3, 1.35  # N, kg/m, of the contact wire
C = np.sqrt(T / M)


def moving_compliance(speed: float, omega: float, beta: float, EI: float) -> complex:
    """Deflection per force at a force F e^(i omega t) that moves along an infinite wire: 1/2 pi ∫ dk / D(k, omega - k v).

    By residues at the poles of the upper half plane; undamped, a trace of damping tells which of the real poles radiate there.
    """
    Omega = Polynomial([omega, -speed])
    D = Polynomial([0.0, 0.0, T, 0.0, EI]).trim() * (1.0 + 1j * max(beta, 1e-9) * Omega) - M * Omega**2
    poles = D.roots()
    return complex(1j * np.sum(1.0 / D.deriv()(poles[poles.imag > 0.0])))


def long_wire(beta: float, EI: float, element: float, substep: float, method: str = "explicit") -> Catenary:
    """A contact wire of 300 m whose one dropper takes no part; two forces of opposite sign would cancel its ends' influence."""
    effects, values = ["damping"], {"damping.alpha": 0.0, "damping.beta": beta}
    if EI:
        effects, values = [*effects, "bending_stiffness"], values | {"bending_stiffness.contact_wire": EI}
    values |= {
        "spans": 1,
        "span_length": 300.0,
        "droppers": 1,
        "dropper_position[1]": 1.0,
        "dropper_stiffness": 1.0,
        "element": element,
        "substep": substep,
        "method": method,
        "first_watched_support": 0,
    }
    return initialized(Catenary(effects, values), {"contact_position": 120.0, "contact_force": 0.0})


def answer(catenary: Catenary, speed: float, omega: float, h: float = 1e-3) -> complex:
    """Complex deflection per force under an oscillating force that moves, its contact compliance included; over 8 periods."""
    # A force sin(omega t), faded in; waves from the ends of the wire come back too late.
    period = 2.0 * np.pi / omega
    n = round(12.0 * period / h)
    values = []
    for i in range(n):
        t = (i + np.array([0.0, 0.5, 1.0])) * h
        start, middle, end = np.sin(omega * t) * np.minimum(t / (3.0 * period), 1.0)
        catenary.u[:, 0] = 120.0 + speed * t[0], speed, 0.0
        catenary.u[:, 1] = start, (4.0 * middle - 3.0 * start - end) / h, 2.0 * (start - 2.0 * middle + end) / h**2
        catenary.step(t[0], h)
        values.append(catenary["wire_height"] + catenary["contact_compliance"] * end)
    last = n // 2
    t = (np.arange(n - last, n) + 1) * h
    basis = np.stack((np.sin(omega * t), np.cos(omega * t), np.ones(last), t), axis=1)
    a, b, _, _ = np.linalg.lstsq(basis, np.array(values[-last:]), rcond=None)[0]
    return complex(a, b)


@pytest.mark.first
@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize(("speed", "beta", "EI"), [(69.4, 1e-3, 0.0), (83.3, 3e-3, 0.0), (83.3, 1e-3, 195.0)])
def test_answer_to_a_moving_load_is_that_of_the_infinite_wire(method, speed, beta, EI):
    """12 Hz, the frequency of passing droppers. Amplitude and phase; hat functions on two nodes leave 3 to 5 % here."""
    exact = moving_compliance(speed, 2.0 * np.pi * 12.0, beta, EI)
    measured = answer(long_wire(beta, EI, 0.4, 5e-4, method), speed, 2.0 * np.pi * 12.0)
    assert abs(measured / exact - 1.0) < 0.012


@pytest.mark.full
@pytest.mark.parametrize(("speed", "beta", "EI"), [(83.3, 1e-3, 195.0), (69.4, 0.0, 195.0), (83.3, 3e-3, 0.0), (69.4, 1e-3, 0.0)])
def test_answer_converges_at_second_order_or_better(speed, beta, EI):
    """Element and step together (explicit), then the step of either method on one mesh; at 250 and 300 km/h."""
    omega = 2.0 * np.pi * 15.0

    elements = np.array([0.7, 0.5, 0.35])
    substeps = 1e-3 / np.ceil(2.0 / elements**2)  # whole parts of the macro step
    answers = [answer(long_wire(beta, EI, e, h), speed, omega) for e, h in zip(elements, substeps, strict=True)]
    errors = np.abs(np.array(answers) - moving_compliance(speed, omega, beta, EI))
    assert slope(elements, errors) > 2.5

    for method, longest in (("explicit", 5e-4), ("implicit", 2e-3)):
        steps = longest * 0.5 ** np.arange(3.0 if method == "explicit" else 5.0)
        *answers, exact = [answer(long_wire(beta, EI, 0.5, h, method), speed, omega, 2e-3) for h in (*steps, 2e-3 / 64.0)]
        errors = np.abs(np.array(answers) - exact)
        assert np.all(errors <= 2.0 * errors[0] * (steps / longest) ** 2)  # no slope: at one of these steps it is almost zero


@pytest.mark.full
def test_compliance_of_the_mesh_is_what_a_moving_constant_load_needs():
    """What a coarse mesh lacks against one of a quarter of its element is the difference of their compliances."""
    heights, compliances = [], []
    for element, substep in ((0.5, 5e-4), (0.125, 1e-4)):
        catenary, depth = long_wire(1e-3, 0.0, element, substep), []
        for i in range(2000):
            catenary.u[:, 0] = 120.0 + 0.0833 * i, 83.3, 0.0
            catenary.u[:, 1] = (0.5 * i, 500.0, 0.0) if i < 200 else (100.0, 0.0, 0.0)  # a jump would be late by half a substep
            catenary.step(i * 1e-3, 1e-3)
            depth.append(catenary["wire_height"])
        heights.append(np.mean(depth[1000:]) / 100.0)
        compliances.append(catenary["contact_compliance"])
    assert heights[1] - heights[0] == pytest.approx(compliances[0] - compliances[1], rel=0.05)


@pytest.mark.first
@pytest.mark.parametrize("beta", [0.0, 1e-3])
def test_waves_ahead_and_behind_have_the_numbers_of_doppler(beta):
    """A moving oscillating load sends waves with k = omega / (c - v) ahead and omega / (c + v) behind (undamped string)."""
    speed, omega = 69.4, 2.0 * np.pi * 8.0
    catenary = long_wire(beta, 0.0, 0.4, 5e-4)
    for i in range(1600):
        t = np.array([i * 1e-3, (i + 1) * 1e-3])
        f = np.sin(omega * t) * np.minimum(t / 0.1, 1.0)
        catenary.u[:, 0] = 120.0 + speed * t[0], speed, 0.0
        catenary.u[:, 1] = f[0], (f[1] - f[0]) / 1e-3, 0.0
        catenary.step(t[0], 1e-3)
    x, u = catenary.mesh.position, catenary.x[: 2 * catenary.mesh.position.size : 2]
    at = 120.0 + speed * 1.6
    for side, low, high in (("ahead", at + 1.0, at + 40.0), ("behind", at - 90.0, at - 1.0)):
        # complex root of (T k²)(1 + i beta Omega) = M Omega², Omega = omega - k v, for waves that decay away from the load
        direction = 1.0 if side == "ahead" else -1.0
        roots = np.roots(
            [-1j * beta * speed * T, T * (1.0 + 1j * beta * omega) - M * speed**2, 2.0 * M * omega * speed, -M * omega**2]
            if beta
            else [T - M * speed**2, 2.0 * M * omega * speed, -M * omega**2]
        )
        expected = min(roots, key=lambda k: abs(k + direction * omega / (C - direction * speed)))
        inside = (x > low) & (x < high)
        s = x[inside] - at

        def misfit(k, s=s, v=u[inside]):
            wave = np.exp(1j * k * s)
            basis = np.stack((wave.real, wave.imag, np.ones(s.size), s), axis=1)
            return np.linalg.norm(v - basis @ np.linalg.lstsq(basis, v, rcond=None)[0])

        real = expected.real * np.linspace(0.95, 1.05, 401)
        best = real[np.argmin([misfit(k + 1j * expected.imag) for k in real])]
        assert best == pytest.approx(expected.real, rel=4e-3)


LINES = {
    "strings": (Line(spans=6), (), {}),
    "beams": (Line(spans=6, bending=(195.0, 131.7)), ("bending_stiffness",), {}),
    "another line": (
        Line(
            spans=6,
            span=55.0,
            droppers=tuple(4.5 + 5.75 * i for i in range(9)),
            tension=(22e3, 16e3),
            mass=(1.35, 1.08),
            support_stiffness=500e3,
            beta=3e-3,
        ),
        (),
        {
            "span_length": 55.0,
            "contact_wire_tension": 22e3,
            "messenger_mass": 1.08,
            "support_stiffness": 500e3,
            "substep": 5e-4,
            "damping.beta": 3e-3,
            **{f"dropper_position[{i + 1}]": 4.5 + 5.75 * i for i in range(9)},
        },
    ),
}


@pytest.mark.full
@pytest.mark.parametrize("speed", [250.0, 300.0])
@pytest.mark.parametrize("name", LINES)
def test_filtered_force_is_within_a_percent_of_the_sine_series(name, speed):
    """20 Hz-filtered force over spans 3 and 4 of 6, with the numerics that the scene ships, rms over sigma."""
    line, effects, parameters = LINES[name]
    v = speed / 3.6
    scene = load_scene("en50318-2002")
    given = scene.units["catenary"]
    seconds = round(5.0 * line.span / v, 3)
    changes = {
        "stop_time": seconds,
        "pantograph.speed": v,
        "record.snapshots": [],
        "record.snapshot_interval": None,
        "units.catenary.effects": [e for e in given.effects if e != "wire_profile"] + list(effects),
        "units.catenary.parameters": dict(given.parameters) | {"spans": 6, "first_watched_support": 1} | parameters,
    }
    result = finished(scene.with_changes(changes))
    reference = passage(line, Head(), v, 30.0, seconds, 3600, 5e-4)
    grid = np.linspace(2.0 * line.span, 4.0 * line.span, 2401)
    histories = [
        np.interp(grid, x, ButterworthFilter().apply(force, rate))
        for x, force, rate in (
            (result["pantograph.contact_position"], result["pantograph.contact_force"], 1.0 / scene.master.step),
            (reference[1], reference[2], 2000.0),
        )
    ]
    error = np.sqrt(np.mean((histories[0] - histories[1]) ** 2)) / histories[1].std()
    assert error < 0.01


@pytest.mark.full
def test_sine_series_converges():
    """Halving step and doubling modes moves its filtered force by less than the error that it is to judge."""

    def history(modes, step):
        force = passage(Line(spans=4), Head(), 69.4, 30.0, 2.5, modes, step)[2]
        return ButterworthFilter().apply(force, 1.0 / step)[:: round(1e-3 / step)][500:]

    coarse, middle, fine = history(1200, 1e-3), history(2400, 5e-4), history(4800, 5e-4)
    assert np.std(middle - fine) < 0.002 * fine.std()
    assert np.std(coarse - fine) < 0.008 * fine.std()


def test_a_node_lacks_what_its_mesh_lacks_of_the_bent_wire():
    """1 / (T q² + ...) over the waves of the mesh by another quadrature, less the wire's own sqrt(EI / T) / 2 T."""
    wire = WireOnMesh(20e3, 1.35, 200.0, 0.5, 15.0, 200.0 * 0.25 / 6.0, 0.0, 0.0, 0.0, 0.0)

    def lost(z):
        q = 2.0 * math.sin(z) / wire.element
        string = wire.tension * q**2
        return 1.0 / string - 1.0 / (string + (wire.bending + wire.curvature) * q**4 + wire.gradient * q**6)

    on_mesh = quad(lost, 0.0, 0.5 * math.pi)[0] / (0.5 * math.pi * wire.element)
    bent = 0.5 * math.sqrt(wire.bending / wire.tension) / wire.tension
    assert abs(on_mesh - bent) > 1e-3 * bent  # there is something to say
    assert node_compliance(wire) == pytest.approx(on_mesh - bent, abs=1e-6 * bent)
