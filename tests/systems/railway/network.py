"""A line at rest by a formulation of its own: strings between points, droppers of given cut length, absolute heights.

Nothing is linearized about a state of rest, there is no mesh, and no code is shared with the component: an element of a string is
its tension over its length with half of its weight at either end, which is exact at the points.
"""

from dataclasses import dataclass, field

import numpy as np

G = 9.81


@dataclass
class Network:
    """Points are (wire, x). A stitch wire that ends at a messenger's point is given that point's name."""

    segments: list = field(default_factory=list)  # (point, point, tension N, weight N/m, length m)
    springs: list = field(default_factory=list)  # (point, stiffness N/m, rest height m)
    droppers: list = field(default_factory=list)  # (lower, upper, stiffness N/m, cut length m, weight at either end N)
    fixed: dict = field(default_factory=dict)  # point -> height m
    loads: dict = field(default_factory=dict)  # point -> N upwards

    def wire(self, name, xs, tension, weight, inside=lambda x: 0.0, ends=None):
        """A wire through points at xs. inside: added to the tension at x.  ends: other names of both end points."""
        xs = sorted({round(float(x), 6) for x in xs})
        points = [(name, x) for x in xs]
        if ends:
            points[0], points[-1] = ends
        for a, b, x, y in zip(points, points[1:], xs, xs[1:], strict=False):
            self.segments.append((a, b, tension + inside(0.5 * (x + y)), weight, y - x))

    def solve(self, extra=None):
        """Heights by point and tension of each dropper, slack ones at 0; extra: more loads by point, N."""
        points = sorted({p for a, b, *_ in self.segments for p in (a, b)})
        at = {p: i for i, p in enumerate(points)}
        n = len(points)
        K, f = np.zeros((n, n)), np.zeros(n)
        for a, b, T, w, L in self.segments:
            i, j = at[a], at[b]
            K[[i, j], [i, j]] += T / L
            K[[i, j], [j, i]] -= T / L
            f[[i, j]] -= 0.5 * w * L
        for p, k, rest in self.springs:
            K[at[p], at[p]] += k
            f[at[p]] += k * rest
        for a, b, _, _, weight in self.droppers:
            f[at[a]] -= weight[0]
            f[at[b]] -= weight[1]
        for p, load in (*self.loads.items(), *(extra or {}).items()):
            f[at[p]] += load
        held = np.array([at[p] for p in self.fixed])
        free = np.setdiff1d(np.arange(n), held)
        z = np.zeros(n)
        z[held] = list(self.fixed.values())
        low, up = (np.array([at[d[k]] for d in self.droppers]) for k in (0, 1))
        k, L0 = (np.array([d[j] for d in self.droppers]) for j in (2, 3))
        taut = np.ones(k.size, dtype=bool)
        for _ in range(50):
            A, b = K.copy(), f.copy()
            for i, j, s, length in zip(low[taut], up[taut], k[taut], L0[taut], strict=True):
                A[[i, j], [i, j]] += s
                A[[i, j], [j, i]] -= s
                b[i] -= s * length
                b[j] += s * length
            z[free] = np.linalg.solve(A[np.ix_(free, free)], b[free] - A[np.ix_(free, held)] @ z[held])
            N = k * (z[up] - z[low] - L0)
            if np.array_equal(N > 0.0, taut):
                return {p: z[i] for p, i in at.items()}, np.where(taut, N, 0.0)
            taut = N > 0.0
        raise AssertionError("no set of taut droppers")
