"""Derivatives of coupled runs."""
