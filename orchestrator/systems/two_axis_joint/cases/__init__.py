"""Validation cases of the system, each beside its table."""
