"""Scenes: files, includes, checks, SSP."""
