"""Steps of the energy account, in machine code; in a file of its own, whose imports are what that depends on."""

from __future__ import annotations

import numpy as np

from ....components.core.kernels import kernel

# points and weights of Gauss's rule on [0, 1], exact for the product of an input of degree 2 and an output of degree 3
POINTS = 0.5 + np.array([-0.5, 0.0, 0.5]) * np.sqrt(0.6)
WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0


@kernel
def enter_steps(h, basis, outputs, jumped, given, degrees, factors, watts, work, integrals, course):
    """Equal steps of an account, for I inputs and I / 2 bonds, of which the k-th has the inputs 2 k and 2 k + 1.

    basis: (3, k), of the last k outputs, the newest first, at `POINTS`; outputs: (k - 1 + n, I), the oldest first; jumped: likewise,
    of each output where its step ends: those before it move with it; given: (n, I, 5), value, slope, half of the second derivative
    and degree; work: (2, I, 3), what the inputs stand for and what they were given, at `POINTS`; integrals: (I,), added to;
    course: (n + 1, 1 + I), the sums behind each step, of which the first are given.
    """
    kept, bonds = basis.shape[1], watts.size
    for i in range(len(given)):
        for k in range(degrees.size):
            value, slope, quadratic = given[i, k, 0], given[i, k, 1], given[i, k, 2]
            if given[i, k, 3] > degrees[k]:  # the unit holds the mean
                value, slope, quadratic = value + h * (slope / 2.0 + h * quadratic / 3.0), 0.0, 0.0
            missed = 0.0
            for p in range(3):
                at, now, moved = h * POINTS[p], kept - 1 + i, 0.0
                true = basis[p, 0] * (outputs[now, k] - jumped[now, k])
                for j in range(1, kept):
                    true += basis[p, j] * (outputs[now - j, k] + moved)
                    moved += jumped[now - j, k]
                work[0, k, p], work[1, k, p] = true, (value + at * (slope + at * quadratic)) / factors[k]
                missed += WEIGHTS[p] * (work[1, k, p] - true)
            integrals[k] += h * missed
        course[i + 1, 0] = course[i, 0] + h
        for b in range(bonds):
            created = exchanged = 0.0
            for p in range(3):
                into = watts[b] * work[0, 2 * b, p] * work[1, 2 * b + 1, p]
                out_of = watts[b] * work[1, 2 * b, p] * work[0, 2 * b + 1, p]
                created += WEIGHTS[p] * (into - out_of)
                exchanged += WEIGHTS[p] * abs(into + out_of)
            course[i + 1, 1 + b] = course[i, 1 + b] + h * created
            course[i + 1, 1 + bonds + b] = course[i, 1 + bonds + b] + h * exchanged / 2.0
