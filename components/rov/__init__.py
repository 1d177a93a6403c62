"""Remotely operated underwater vehicle."""
