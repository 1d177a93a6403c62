"""Stiffness of the wires as bands: kernels that fill them, multiply with them and find their highest frequency."""

from __future__ import annotations

import math

import numpy as np

from ..core.kernels import kernel


@kernel
def kink(side, i, length):
    """Share of the node to the left (0), of the node itself (1) and of that to the right (2) in the kink at node i, 1/m."""
    left, right = 1.0 / length[i - 1], 1.0 / length[i]
    if side == 0:
        return left
    return right if side == 2 else -left - right


@kernel
def add_wire(tension, curvature, gradient, length, band):
    """Add one wire's stiffness to an upper band, band[i, k] = K[i, i + k], (n, 3 or more) N/m.

    tension, length: of the element to the right of the node, N, m, (n,) or more; curvature: (n,) N m.

    K = T times that of linear elements + the sum of c[i] kink[i]² + gradient (kink[i + 1] - kink[i])² over the inner nodes, where
    kink[i] = u[i-1]/l - u[i] (1/l + 1/r) + u[i+1]/r; the end nodes have none.
    """
    n, width = band.shape
    for k in range(n - 1):
        pull = tension[k] * (1.0 / length[k])
        band[k, 0] += pull
        band[k + 1, 0] += pull
        band[k, 1] -= pull
    for i in range(3):
        for j in range(3):
            if j >= i:
                for k in range(1, n - 1):
                    c = curvature[k] + 2.0 * gradient
                    band[k - 1 + i, j - i] += c * kink(i, k, length) * kink(j, k, length)
            shift, first = abs(j + 1 - i), min(i, j + 1)  # with the kink of the next node
            share = 2.0 * gradient if shift == 0 else gradient
            if shift < width and gradient != 0.0:
                for k in range(1, n - 2):
                    band[k - 1 + first, shift] -= share * kink(i, k, length) * kink(j, k + 1, length)


@kernel
def fill_stiffness(tension, curvature, bending_gradient, length, band):
    """Upper band of the stiffness of all wires, interleaved, without droppers, clamps, supports and arms, (N, 3 W + 1) N/m.

    Arguments before: as of `Mesh`.
    """
    W = bending_gradient.size
    band[:] = 0.0
    for lane in range(W):
        add_wire(tension[lane + W :: W], curvature[lane::W], bending_gradient[lane], length[::1], band[lane::W, ::W])


@kernel
def add_spring(one, other, stiffness, band):
    """Add a spring between two degrees of freedom to an upper band, N/m."""
    band[one, 0] += stiffness
    band[other, 0] += stiffness
    band[min(one, other), abs(one - other)] -= stiffness


@kernel
def product_at(i, band, x):
    """Element i of the product of a symmetric matrix, as its upper band, with x."""
    value = band[i, 0] * x[i]
    for k in range(1, band.shape[1]):
        if i + k < x.size:
            value += band[i, k] * x[i + k]
        if i >= k:
            value += band[i - k, k] * x[i - k]
    return value


@kernel
def highest_eigenvalue(stiffness, inverse_mass, clamped, clamp, x, y):
    """Largest omega², 1/s², by power iteration; 2 % are added for the terms that are left out.

    stiffness: upper band, (N, 3 W + 1); inverse_mass, clamped, clamp: as of `Mesh`; x, y: (N,) workspace.
    """
    N, W = stiffness.shape[0], (stiffness.shape[1] - 1) // 3
    for j in range(N):
        x[j] = (1.0 - 2.0 * (j // W % 2)) * (1.0 + 0.1 * math.sin(j))
        if j % W == 1:  # the wires swing against each other: droppers take part
            x[j] *= -1.0
    value = 0.0
    for _ in range(60):
        for k in range(clamped.size):
            x[clamped[k]] = x[clamp[k]]
        for j in range(N):
            y[j] = product_at(j, stiffness, x)
        for k in range(clamped.size):
            y[clamp[k]] += y[clamped[k]]
        square = 0.0
        for j in range(N):
            y[j] *= inverse_mass[j]
            square += y[j] * y[j]
        value = math.sqrt(square)
        for j in range(N):
            x[j] = y[j] / value
    return 1.02 * value


def stiffness_of_wires(mesh, reach: int) -> np.ndarray:
    """`fill_stiffness` up to 2 nodes beside each, or 3 with bending stiffness, (N, reach W + 1) N/m."""
    W = mesh.bending_gradient.size
    band = np.zeros((mesh.mass.size, 3 * W + 1))
    fill_stiffness(mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.length, band)
    return band[:, : reach * W + 1].copy()
