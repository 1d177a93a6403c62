"""Exact forward derivatives of compiled entries."""
