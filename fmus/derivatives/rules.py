"""The derivative of each operation beside it: its partial derivatives at the arguments, and what has none.

A partial derivative is written with numbers of the undisturbed run, `x`, `y`, `z` the arguments and `r` the result, and is computed
once for all directions. 1.0 and -1.0 cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from math import log, pi, sqrt
from typing import Any

Partials = Callable[..., tuple[Any, ...]]

SMOOTH: dict[str, Partials] = {
    "fadd": lambda x, y, r: (1.0, 1.0),
    "fsub": lambda x, y, r: (1.0, -1.0),
    "fmul": lambda x, y, r: (y, x),
    "fdiv": lambda x, y, r: (1.0 / y, -(r / y)),
    "fneg": lambda x, r: (-1.0,),
    "fma": lambda x, y, z, r: (y, x, 1.0),
    "frem": lambda x, y, r: (1.0, -(x / y).call("trunc")),
    "sin": lambda x, r: (x.call("cos"),),
    "cos": lambda x, r: (-x.call("sin"),),
    "tan": lambda x, r: (1.0 + r * r,),
    "atan": lambda x, r: (1.0 / (1.0 + x * x),),
    "sinh": lambda x, r: (x.call("cosh"),),
    "cosh": lambda x, r: (x.call("sinh"),),
    "tanh": lambda x, r: (1.0 - r * r,),
    "asinh": lambda x, r: (1.0 / (1.0 + x * x).call("sqrt"),),
    "exp": lambda x, r: (r,),
    "exp2": lambda x, r: (log(2.0) * r,),
    "expm1": lambda x, r: (1.0 + r,),
    "erf": lambda x, r: (2.0 / sqrt(pi) * (-(x * x)).call("exp"),),
    "erfc": lambda x, r: (-2.0 / sqrt(pi) * (-(x * x)).call("exp"),),
}
# Infinite or undefined somewhere: there a tangent that is zero stays zero
SINGULAR: dict[str, Partials] = {
    "sqrt": lambda x, r: (0.5 / r,),
    "cbrt": lambda x, r: (r / (3.0 * x),),
    "log": lambda x, r: (1.0 / x,),
    "log2": lambda x, r: (1.0 / (log(2.0) * x),),
    "log10": lambda x, r: (1.0 / (log(10.0) * x),),
    "log1p": lambda x, r: (1.0 / (1.0 + x),),
    "asin": lambda x, r: (1.0 / (1.0 - x * x).call("sqrt"),),
    "acos": lambda x, r: (-1.0 / (1.0 - x * x).call("sqrt"),),
    "acosh": lambda x, r: (1.0 / (x * x - 1.0).call("sqrt"),),
    "atanh": lambda x, r: (1.0 / (1.0 - x * x),),
    "pow": lambda x, y, r: (y * x.call("pow", y - 1.0), r * x.call("log")),
    "atan2": lambda y, x, r: (x / (x * x + y * y), -(y / (x * x + y * y))),
    "hypot": lambda x, y, r: (x / r, y / r),
}
PARTIALS = SMOOTH | SINGULAR
SAME = {"fmuladd": "fma", "fmod": "frem"}  # other names of a rule
FLAT = {"floor", "ceil", "trunc", "rint", "nearbyint", "round", "roundeven", "is.fpclass"}  # constant but for jumps
KINKED = {"fabs", "maxnum", "minnum", "maximum", "minimum", "copysign"}  # one-sided, along the direction, at their kinks
NO_NUMBERS = ("lifetime.", "assume", "experimental.noalias.scope.decl", "dbg.")  # calls that compute nothing
