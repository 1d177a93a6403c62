"""Friction-wheel drive: two wheels that move a sleeve along and about its axis by friction."""
