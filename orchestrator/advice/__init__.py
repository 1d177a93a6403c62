"""What a run will need, told before it is made: `cosimo run --dry-run`."""

from .probing import Advice, Contact, advise

__all__ = ["Advice", "Contact", "advise"]
