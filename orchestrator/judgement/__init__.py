"""What a run will need, before it is started: `cosimo run --dry-run`."""

from .advice import Advice, advise

__all__ = ["Advice", "advise"]
