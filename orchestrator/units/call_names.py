"""What `CallTable`s hold, by name; in a file of its own, because machine code that reads them depends on it."""

from __future__ import annotations

HELD, COMPANIONS, DERIVATIVES, MEAN = range(4)  # ways to give an FMU inputs that change over a step, see `inputs`
IN_MEMORY, IN_PYTHON = 4, 5  # a component's inputs are written where they lie; a callback takes them from the links
NOTED = 6  # inputs that a unit with a rate of its own gets when it steps
OF_STEP = 8  # added to the status of an FMU's step that was not made: larger than any of them
FAILED = 16  # times the status of an entry: larger than any of an FMU
FUNCTIONS = {"get": "GetReal", "set": "SetReal", "set_derivatives": "SetRealInputDerivatives", "do_step": "DoStep"}
# What `CallTable.calls` has. Of an FMU: addresses of functions, the instance, the references of inputs and outputs, and the
# orders 1 ... 1, 2 ... 2 of inputs; the function that hands over inputs which are held, and where these lie; the number of parts
# that outputs of several types are, and where they lie; the function that saves a state and its place, where each step needs it; the
# cells of `environment`. Of all others: entries and their argument, `read` where outputs have to
# be asked for, and the distance of two rows of inputs, bytes.
OF_FMU = (
    *FUNCTIONS,
    "instance",
    "input_references",
    "output_references",
    "orders",
    "hold",
    "held_values",
    "parts",
    "part_cells",
    "save",
    "state",
    "environment",
)
OF_ENTRIES = ("step", "outputs", "read", "argument", "row")
