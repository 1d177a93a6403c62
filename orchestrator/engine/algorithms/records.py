"""The memory of a master: units, links, samples and signals as records of one block, on which the kernels of the loop work.

All fields are numbers of eight bytes. A macro step changes nothing but the records, so a copy of the block is enough to return to an
instant. Addresses and places in the block do not change as long as the master lives.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ....components.core.kernels import kernel_tuple
from ...units.call_names import OF_ENTRIES, OF_FMU

# where inputs end: not known; at values that were known; where extrapolation has taken them
UNKNOWN, INTERPOLATED, EXTRAPOLATED = range(3)
CHANGES, JUMPS, CONSTANT = range(3)  # inputs follow the polynomial; jump between steps; are held beside a place that moves on
UNALTERED, OVERRIDDEN, SHIFTED = range(3)  # by faults
OVERRIDE, OFFSET, FROZEN, DROPPED, LOST = range(5)  # kinds of faults
BEGINS, ENDS = 1, 2  # what becomes of a fault at an instant
START, READ, UPDATE, FOLLOW, PUSH, LOOK, FORESEE, LEFT, RIGHT, SHIFT = range(10)  # what a row of the program does, see `kernels`
GIVEN = "value", "slope", "quadratic", "degree", "jump"  # of a link, over a step and behind it
BEYOND = -2  # in the place of a unit: signals have left the limit
NOT_CONVERGED = -3  # in the place of a unit: the initial values of a group
SECANTS = 30  # quasi-Newton steps of an initialization
CONVERGED = 1e-12  # residual relative to the size, or change of an output from one sweep to the next
STALLED = 1e-9  # and where it no longer falls: gains above 1, or stiff units, amplify the rounding
ABOUT_ZERO = 1e-3  # of the nominal value: an output below it is compared with it instead of with itself


def _record(fields: str) -> tuple[np.dtype, tuple[str, ...]]:
    """The type of a record, and the names of the fields that change from step to step, which * marks.

    A line of `fields` has a name, i for int64 or f for float64, and the meaning.
    """
    lines = [line.split(maxsplit=2) for line in fields.strip().splitlines()]
    kinds = {"i": np.int64, "f": np.float64}
    return np.dtype([(name, kinds[kind[0]]) for name, kind, _ in lines]), tuple(name for name, kind, _ in lines if "*" in kind)


UNIT, UNIT_STATE = _record(
    "\n".join(f"{name} i address, see `call_names`" for name in (*OF_FMU, *OF_ENTRIES, "initialize"))
    + """
    input_mode       i  how the unit gets inputs, see `call_names`
    first_link       i  its links
    links            i  their number
    n_extrapolated   i  so many of them have their values extrapolated; these come first
    all_interpolated i  whether all end at values that are known
    first_signal     i  its outputs in the table of signals
    signals          i  their number
    first_past       i  its samples
    pasts            i  their number
    n_set_on_change  i  links that an FMU is handed only when they change
    pressed          i  whether some are the force of a contact
    corrected        i  whether something may be owed to some
    every            i  macro steps to one of the unit
    slow             i  of a unit with a rate of its own, the first of its other two records
    stop             f  s, end of the run
    no_return        i  no state before a step will be taken back
    warned           i  steps that an FMU has ended with a warning since the unit was told
    degree           i  of what an FMU is handed
    ends             i* of its inputs: `UNKNOWN`, ...
    taken            i* steps since the unit was told
    lost             i* it takes no more steps
    count            i* macro steps since it stepped
    start            f* s, where they began
    length           f* s, of all of them
    time             f* s, reached; of an FMU the start of its last step
"""
)
LINK, LINK_STATE = _record("""
    at               i  address of a component's input
    set_on_change    i  whether an FMU is handed it only when it changes
    source           i  in the table of signals
    past             i  its samples
    converted        i  whether it has another factor than 1, an offset, or a map
    factor           f  of the connection
    offset           f  of the connection
    first_pair       i  of its map of values, in the table of signals: a value, and what becomes of it
    pairs            i  how many; 0: no map
    direct           i  whether an output follows it within an instant
    change           f  unless it has moved by no more than this part
    held             i  `CHANGES`, ...
    fault            i* `UNALTERED`, ...
    alteration       f* by the fault
    pressed          i* whether a contact gives a line in place of its source
    force            f* value of that line
    rate             f* and slope
    now              f* value behind the last step
    looked           f  value at the last `LOOK`
    seen             f  value before faults began or ended
    foreseen         f  value at the last `FORESEE`
    present          f* newest sample
    before           f* the one before
    earlier          f* and before that
    known            f* value at which its polynomial ends
    value            f* given over the last step
    slope            f* given
    quadratic        f* given, half of the second derivative
    degree           f* of what was given
    jump             f  of the input, behind the last step
    reached          f* where that ends
    owed             f* its integral over time that is still to be given
""")
PAST, PAST_STATE = _record("""
    degree           i  of the polynomial
    every            i  macro steps from one sample to the next
    samples          i* that are kept, up to degree + 1
    left             i* macro steps to come before the one that ends at a sample
    h1               f* s, between the newest samples
    h2               f* s, between those before
    elapsed          f* s, since the newest one
""")
REQUEST, _ = _record("""
    first            i  rows of the program, from this one
    last             i  to before this one
    steps            i  macro steps
    times            i  address of the times at which they begin; 0: the one that is handed over
    whole            i  whether the rows are a macro step
    updated          i  whether outputs have moved
    rows             i  address for the signals behind each, (steps, S); 0: none of what follows is wanted
    given            i  address for what bonded links were given in each, (steps, B, 5)
    watched          i  address of addresses of further numbers
    watches          i  how many
    outputs          i  address for them, (steps, watches)
    sampled          i  address of steps behind which inputs are wanted
    sampled_count    i  how many
    sampled_done     i  steps so far that inputs were wanted of
    driven           i  inputs
    inputs           i  address for them and the ends of their polynomials, (sampled_count, 2, driven)
    halt             i  end behind the present step
    done             i  answer: macro steps that were completed
    unit             i  answer: the unit whose call failed, -1, or `BEYOND`
    status           i  answer: of the call
    row              i  answer: row of the program in which it failed
""")

GROUP, _ = _record("""
    first      i  its units in `initial_order`
    last       i  to before this one
    first_answer i  its outputs in `answers`
    answers      i  their number
    sweeps     i  answer: how often its units have been initialized one after the other
    secants    i  answer: quasi-Newton steps behind them
    residual   f  answer: relative change of an output in the last sweep
    worst      i  answer: the cell of that output
    parallel   i  answer: whether answers differed although their misses did not
""")

ANSWER, _ = _record("""
    cell    i  of an output of a group in the table of signals
    unknown i  whether a sweep depends on it
    least   f  value that a change is compared with at least
""")

FAULT, FAULT_STATE = _record("""
    kind    i  `OVERRIDE`, ...
    value   f  of an override, an offset
    unit    i  that is lost
    first   i  its inputs in `fault_ends`
    last    i  to before this one
    active  i* whether it acts
    change  i  what becomes of it at this instant: `BEGINS`, ...; 0: nothing
""")
FAULT_END, FAULT_END_STATE = _record("""
    link    i  the input
    start   f  its start value
    held    f* what takes the place of the input, or is added to it
""")

# program: rows of (act, unit); outputs_at: addresses of components' outputs; inverse: 1 / nominal of every output, or 0; bonded:
# links that are noted; buffer: what FMUs are handed; initial_order: units of the groups; space, pivots: workspace of the
# initialization
FIELDS = (
    "request units links pasts program outputs_at inverse bonded signals buffer groups initial_order answers space pivots "
    "faults fault_ends"
)
Memory = kernel_tuple(namedtuple("Memory", FIELDS))  # type: ignore[misc]
