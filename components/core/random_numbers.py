"""Random numbers by count instead of by history: number k of a seed is the same whenever it is asked for."""

from __future__ import annotations

import math

from .kernels import kernel

MASK = (1 << 31) - 1


@kernel
def mixed(a):
    """A whole number below 2^31 from another: Lehmer's multiplier and two folds, all within 62 bits."""
    for _ in range(3):
        a = (a ^ (a >> 15)) & MASK
        a = (a * 0x2C1B3C6D) & MASK
        a = a ^ (a >> 12)
        a = (a * 0x297A2D39) & MASK
    return a ^ (a >> 15)


@kernel
def key_of(seed, k):
    """What both kinds of number are made of; k: whole, also as a float."""
    place = int(k)
    return mixed(mixed((seed + 0x1B873593) & MASK) ^ (place & MASK)) ^ (place >> 31)


@kernel
def uniform_number(seed, k):
    """Number k of the uniform distribution over [0, 1) for a seed."""
    return mixed((2 * key_of(seed, k)) & MASK) / (MASK + 1.0)


@kernel
def normal_number(seed, k):
    """Number k of the standard normal distribution for a seed, by Box and Muller."""
    key = key_of(seed, k)
    first, second = mixed((2 * key) & MASK), mixed((2 * key + 1) & MASK)
    radius = math.sqrt(-2.0 * math.log((first + 1.0) / (MASK + 1.0)))
    return radius * math.cos(2.0 * math.pi * second / (MASK + 1.0))
