"""Independent solution of a pantograph under a catenary: sine series over the whole section, exact in time for each mode.

It shares nothing with the components: no mesh, no time integrator, no coupling between units, no code.

    u(x, t) = sum a_n(t) sin(k_n x),  k_n = n pi / L,   a_n'' + (alpha + beta w_n²) a_n' + w_n² a_n = p_n
    w_n² = (T k_n² + EI k_n⁴) / m,   p_n = 2 / (m L) sum_j f_j sin(k_n x_j)

for either wire. Droppers (tension only), messenger supports and the contact are point forces that vary linearly within a step;
each mode and the pantograph answer them by their matrix exponential. The forces at the end of a step are solved for, each with
the own answer of its point within the step. What the omitted short waves would add to the compliance of a point is an integral
over k beyond the last mode, in the frame of the point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dst
from scipy.linalg import expm

GRAVITY = 9.81  # m/s²


@dataclass(frozen=True)
class Line:
    """A section of the EN 50318:2002 kind; pairs are of the contact wire and the messenger wire."""

    spans: int = 10
    span: float = 60.0  # m
    tension: tuple[float, float] = (20e3, 16e3)  # N
    mass: tuple[float, float] = (1.35, 1.07)  # kg/m
    bending: tuple[float, float] = (0.0, 0.0)  # N m²
    droppers: tuple[float, ...] = (5.0, 10.5, 17.0, 23.5, 30.0, 36.5, 43.0, 49.5, 55.0)  # m within a span
    dropper_stiffness: float = 100e3  # N/m
    support_stiffness: float = 50e3  # N/m
    alpha: float = 0.0  # 1/s
    beta: float = 1e-3  # s


@dataclass(frozen=True)
class Head:
    """Pantograph of two masses, the head first, and the contact spring."""

    mass: tuple[float, float] = (7.2, 15.0)  # kg
    stiffness: tuple[float, float] = (4200.0, 50.0)  # N/m
    damping: tuple[float, float] = (10.0, 90.0)  # N s/m
    static_force: float = 120.0  # N
    contact_stiffness: float = 50e3  # N/m

    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        (k1, k2), (c1, c2) = self.stiffness, self.damping
        return np.diag(self.mass), np.array([[c1, -c1], [-c1, c1 + c2]]), np.array([[k1, -k1], [-k1, k1 + k2]])


def passage(line: Line, head: Head, speed: float, start: float, seconds: float, modes: int, step: float) -> np.ndarray:
    """Rows time (n,) s, contact position m, contact force N and height of the wire at the contact m."""
    L = line.spans * line.span
    k = np.pi * np.arange(1, modes + 1) / L
    x_d = (line.span * np.arange(line.spans)[:, None] + line.droppers).ravel()
    d = x_d.size
    S = np.sin(np.outer(np.concatenate((x_d, line.span * np.arange(1, line.spans))), k))  # (d + s, modes)
    squares = [(T * k**2 + EI * k**4) / m for T, m, EI in zip(line.tension, line.mass, line.bending, strict=True)]
    scale = [2.0 / (m * L) for m in line.mass]
    short = [short_waves(line, w, (modes + 0.5) * np.pi / L, 0.0) for w in (0, 1)]
    dropper = 1.0 / line.dropper_stiffness + sum(short)  # compliances, m/N
    support = 1.0 / line.support_stiffness + short[1]
    contact = 1.0 / head.contact_stiffness + short_waves(line, 0, (modes + 0.5) * np.pi / L, speed)
    preload, *shape = at_rest(line, x_d)

    wave = np.sin(k * start)
    g, r, F = equilibrium(
        [scale[w] * (S / squares[w]) @ S.T for w in (0, 1)],
        scale[0] * (S / squares[0]) @ wave,
        scale[0] * float(wave**2 @ (1.0 / squares[0])),
        (dropper, support, contact),
        preload,
        head,
        float(np.interp(start, shape[0], shape[1])),
    )

    def points(on_droppers, on_supports):
        """Modal forces of both wires, without the contact: droppers pull the contact wire up and the messenger down."""
        return on_droppers @ S[:d], on_supports @ S[d:] - on_droppers @ S[:d]

    own, hung = points(g, r)
    p = [scale[0] * (own + F * wave), scale[1] * hung]
    a = [[p[w] / squares[w], np.zeros(modes)] for w in (0, 1)]
    M, C, K = head.matrices()
    z = np.concatenate((np.linalg.solve(K, [-F, head.static_force]), np.zeros(2)))
    A = np.zeros((7, 7))  # z, z', F, F', 1
    A[:2, 2:4], A[2:4, :2], A[2:4, 2:4] = np.eye(2), -np.linalg.solve(M, K), -np.linalg.solve(M, C)
    A[2, 4], A[3, 6], A[4, 5] = -1.0 / head.mass[0], head.static_force / head.mass[1], 1.0
    X = expm(A * step)
    head_end = X[:4, 5] / step  # answer to a force that grows from 0 to 1 N within the step

    exact = [propagators(squares[w], line.alpha + line.beta * squares[w], step) for w in (0, 1)]
    end = [scale[w] * exact[w][2][0] for w in (0, 1)]  # displacement per force at the end of the step
    within = [(S**2) @ end[w] for w in (0, 1)]
    with_d, with_s = dropper + within[0][:d] + within[1][:d], support + within[1][d:]
    out = np.zeros((4, round(seconds / step) + 1))
    out[:, 0] = 0.0, start, F, np.interp(start, shape[0], shape[1]) + a[0][0] @ wave
    for i in range(1, out.shape[1]):
        for w in (0, 1):  # the forces held ...
            E, P, Q = exact[w]
            q, v = a[w]
            a[w] = [E[0, 0] * q + E[0, 1] * v + (P[0] + Q[0]) * p[w], E[1, 0] * q + E[1, 1] * v + (P[1] + Q[1]) * p[w]]
        z = X[:4, :4] @ z + X[:4, 6] + X[:4, 4] * F
        x, last = start + speed * i * step, wave
        wave, rest = np.sin(k * x), np.interp(x, shape[0], shape[1])
        # ... and what they change to
        u_c, u_m = S[:d] @ a[0][0], S @ a[1][0]
        now, before = (float((end[0] * wave) @ w) - head_end[0] for w in (wave, last))
        F_new = max((z[0] - rest - a[0][0] @ wave + before * F) / (contact + now), 0.0)
        g_new = np.maximum((u_m[:d] - u_c + (with_d - dropper) * g) / with_d, -preload)
        r_new = ((with_s - support) * r - u_m[d:]) / with_s
        own, hung = points(g_new - g, r_new - r)
        for w, more in enumerate((own + F_new * wave - F * last, hung)):
            more = scale[w] * more
            a[w][0] += exact[w][2][0] * more
            a[w][1] += exact[w][2][1] * more
            p[w] = p[w] + more
        z += head_end * (F_new - F)
        g, r, F = g_new, r_new, F_new
        out[:, i] = i * step, x, F, rest + a[0][0] @ wave
    return out


def equilibrium(flex, to_points, own, compliances, preload, head: Head, rest: float):
    """Change of dropper tensions (d,), support forces (s,) and contact force under the pantograph at rest, N.

    flex: compliance between the points for either wire, to_points: from the contact, own: of the contact, m/N.
    """
    dropper, support, contact = compliances
    d, n = preload.size, flex[0].shape[0]
    _, _, K = head.matrices()
    lift = np.linalg.inv(K)
    taut = np.ones(d, dtype=bool)
    for _ in range(100):
        A, b = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
        A[:n, :n] = flex[1]
        A[:d, d:n] *= -1.0
        A[d:n, :d] *= -1.0
        A[:d, :d] += flex[0][:d, :d] + dropper * np.eye(d)
        A[d:n, d:n] += support * np.eye(n - d)
        A[:d, n] = A[n, :d] = to_points[:d]
        A[n, n], b[n] = own + contact + lift[0, 0], lift[0, 1] * head.static_force - rest
        slack = np.flatnonzero(~taut)
        full = A.copy()
        A[slack] = 0.0
        A[slack, slack], b[slack] = 1.0, -preload[slack]
        f = np.linalg.solve(A, b)
        now = preload + f[:d] - (full[:d] @ f) / dropper > 0.0  # the tension that its stretch would give
        if np.array_equal(now, taut):
            return f[:d], f[d:n], float(f[n])
        taut = now
    raise ArithmeticError("the slack droppers of the static equilibrium do not converge")


def propagators(squares: np.ndarray, damping: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """E (2, 2, n), P (2, n), Q (2, n): a and a' after h from a and a', from p at the start, from p at the end of a step."""
    A = np.zeros((squares.size, 4, 4))  # a, a', p, p'
    A[:, 0, 1], A[:, 1, 0], A[:, 1, 1], A[:, 1, 2], A[:, 2, 3] = 1.0, -squares, -damping, 1.0, 1.0
    X = expm(A * h)
    end = np.ascontiguousarray(X[:, :2, 3].T) / h
    return np.ascontiguousarray(X[:, :2, :2].transpose(1, 2, 0)), np.ascontiguousarray(X[:, :2, 2].T) - end, end


def short_waves(line: Line, wire: int, last: float, speed: float) -> float:
    """Compliance of a point that moves with `speed`, of all waves beyond the wave number `last` (1/m), m/N."""
    s = (np.arange(4000) + 0.5) / 4000.0
    k = last / s
    stiffness = line.tension[wire] * k**2 + line.bending[wire] * k**4
    answer = 1.0 / (stiffness * (1.0 - 1j * line.beta * speed * k) - line.mass[wire] * (speed * k) ** 2)
    return float(np.mean(answer.real * last / s**2) / np.pi)


def at_rest(line: Line, x_d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dropper tensions (d,) N with the clamps level; the contact wire's shape: positions and heights (n,) m."""
    L, n = line.spans * line.span, 2**17 - 1
    k = np.pi * np.arange(1, n + 1) / L
    stiffness = 0.5 * L * (line.tension[0] * k**2 + line.bending[0] * k**4)
    load = -line.mass[0] * GRAVITY * (1.0 - np.cos(k * L)) / k
    flex, sag = np.zeros((x_d.size, x_d.size)), np.zeros(x_d.size)
    parts = np.array_split(np.arange(n), 64)
    for part in parts:
        S = np.sin(np.outer(x_d, k[part]))
        flex += (S / stiffness[part]) @ S.T
        sag += S @ (load[part] / stiffness[part])
    tension = np.linalg.solve(flex, -sag)
    for part in parts:
        load[part] += tension @ np.sin(np.outer(x_d, k[part]))
    height = np.concatenate(([0.0], 0.5 * dst(load / stiffness, type=1), [0.0]))
    return tension, L * np.arange(n + 2) / (n + 1), height
