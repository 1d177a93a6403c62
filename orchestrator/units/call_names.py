"""What `CallTable`s hold, by name; in a file of its own, because machine code that reads them depends on it."""

from __future__ import annotations

HELD, COMPANIONS, DERIVATIVES, MEAN = range(4)  # ways to give an FMU inputs that change over a step, see `inputs`
IN_MEMORY = 4  # a component's inputs are written where they lie
FUNCTIONS = {"get": "GetReal", "set": "SetReal", "set_derivatives": "SetRealInputDerivatives", "do_step": "DoStep"}
# what `CallTable.calls` has: of an FMU addresses of functions, the instance, the references of inputs and outputs, and the orders
# 1 ... 1, 2 ... 2 of inputs; the function that hands over inputs which are held, and where these lie; the number of parts that
# outputs of several types are, and where they lie; of a component functions with their arguments, and the distance of two rows of
# inputs, bytes
OF_FMU = (*FUNCTIONS, "instance", "input_references", "output_references", "orders", "hold", "held_values", "parts", "part_cells")
OF_COMPONENT = ("outputs", "outputs_argument", "step", "step_argument", "row")
