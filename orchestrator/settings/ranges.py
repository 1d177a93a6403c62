"""What every range has: two ends of which one may be open, and whether a number lies between them."""

from __future__ import annotations

import math

from ...components.core.errors import BadInput

OLD_STANDINGS = {"recalled": "unconfirmed"}  # files of 0.7 say so


class Range:
    """Of a class with `low` and `high`, None for an open end."""

    low: float | None
    high: float | None

    def check_ends(self, where: str = "") -> None:
        """Raises `BadInput` for a range that is open at both ends, and for ends in the wrong order."""
        if self.low is None and self.high is None:
            raise BadInput(where, "no low and no high", "at least one end of a range")
        if self.low is not None and self.high is not None and not self.low <= self.high:
            raise BadInput(where, f"low {self.low:g} above high {self.high:g}", "low <= high")

    @property
    def size(self) -> float:
        """What its numbers are scaled by: the larger one, 1 where both are zero."""
        return max(abs(e) for e in (self.low, self.high) if e is not None) or 1.0

    def keeps(self, value: float, slack: float = 0.0) -> bool:
        """Whether a number lies in the range, its ends and `slack` included; NaN does not."""
        return (self.low is None or value >= self.low - slack) and (self.high is None or value <= self.high + slack)

    def margin(self, value: float) -> float:
        """Distance of a number to the nearer end, negative outside; NaN for one that is not finite."""
        low, high = -math.inf if self.low is None else self.low, math.inf if self.high is None else self.high
        return min(value - low, high - value) if math.isfinite(value) else math.nan
