"""What a run will need, before it is started: `cosimo run --dry-run`."""

from .probing import Advice, Contact, advise

__all__ = ["Advice", "Contact", "advise"]
