"""What a run will need, before it is started: `cosimo run --dry-run`."""

from .probing import Advice, PairLimit, advise

__all__ = ["Advice", "PairLimit", "advise"]
