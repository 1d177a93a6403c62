"""Numbers without bounds in the place of parameters that have some: a filter can move them as far as it wants."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, isfinite, log


@dataclass(frozen=True)
class Bounds:
    """Of a parameter p; the number q in its place is p itself, a logarithm of the distance to one bound, or a logit between two."""

    low: float = -inf
    high: float = inf

    def inner(self, p: float) -> float:
        """The number q without bounds of a parameter within them."""
        if isfinite(self.low) and isfinite(self.high):
            return log((p - self.low) / (self.high - p))
        if isfinite(self.low):
            return log(p - self.low)
        return -log(self.high - p) if isfinite(self.high) else p

    def outer(self, q: float) -> float:
        """The parameter p of a number q."""
        if isfinite(self.low) and isfinite(self.high):
            share = 1.0 / (1.0 + exp(-q)) if q > -700.0 else 0.0
            return self.low + (self.high - self.low) * share
        if isfinite(self.low):
            return self.low + exp(min(q, 700.0))
        return self.high - exp(min(-q, 700.0)) if isfinite(self.high) else q

    def slope(self, q: float) -> float:
        """dp/dq."""
        p = self.outer(q)
        if isfinite(self.low) and isfinite(self.high):
            return (p - self.low) * (self.high - p) / (self.high - self.low)
        return p - self.low if isfinite(self.low) else self.high - p if isfinite(self.high) else 1.0
