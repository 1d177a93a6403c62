"""The memory of a master: units, links, samples and signals as records of one block, on which the kernels of the loop work.

All fields are numbers of eight bytes. What a macro step changes is in the records and nowhere else, so that the block is all that
has to be copied to come back to an instant; addresses and places in it stay as they are as long as the master lives.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from ....components.core.kernels import kernel_tuple
from ...units.call_names import OF_ENTRIES, OF_FMU

NOWHERE, LED, GUESSED = range(3)  # where inputs end: not known; at values that were known; where extrapolation has taken them
CHANGES, JUMPS, CONSTANT = range(3)  # inputs follow the polynomial; jump between steps; are held beside a place that moves on
UNALTERED, OVERRIDDEN, SHIFTED = range(3)  # by faults
START, READ, UPDATE, FOLLOW, PUSH, LOOK, FORESEE = range(7)  # what a row of the program does, see `kernels.perform`


def _records(integers: str, numbers: str = "") -> np.dtype:
    return np.dtype([(name, np.int64) for name in integers.split()] + [(name, np.float64) for name in numbers.split()])


# A unit. Addresses as in `CallTable`; way: in which it gets inputs; first_link, links, late: its links, of which the first `late` are
# extrapolated; led: all of them are led to values that are known; first_signal, signals: in the table of signals; first_past, pasts:
# histories of its links; apart: links an FMU is handed only when they change; smooth: inputs begin where they ended; pressed: some
# are the force of a contact; corrected: some are owed something; every, slow: macro steps to one of the unit, and the first of its
# other two records, see `kernels`. What changes: ends: of its inputs; taken: steps; kept: states to come back to are kept; lost: takes
# no more steps; count: macro steps since `start`, s, over `length`, s; time: s, reached, of an FMU the start of its last step.
UNIT = _records(" ".join((*OF_FMU, *OF_ENTRIES)) + " way first_link links late led first_signal signals first_past pasts apart smooth "
                "pressed corrected every slow ends taken no_return lost count", "stop start length time")
UNIT_STATE = ("ends", "taken", "lost", "count", "start", "length", "time")
# A link; those of a unit stand together. at: address of a component's input; apart: see `UNIT`; source: in the table of signals;
# past: its history; converted, factor, offset: of the connection; direct, change: an output follows it within an instant, unless it
# has moved by no more than this part; held: `CHANGES`, ... What changes: fault, alteration: by a fault; pressed, force, rate: the
# line that a contact gives in place of its source; now: its value behind the last step; looked: at the last `LOOK`; foreseen: at the
# last `FORESEE`; present, before, earlier: samples; known: what it is led to; value, slope, half of the second derivative, degree:
# given in the last step; reached: where that ends; owed: its integral over time that is still to be given.
LINK = _records("at apart source past converted direct held fault pressed", "factor offset change alteration force rate now looked "
                "foreseen present before earlier known value slope half degree reached owed")
LINK_STATE = ("fault", "alteration", "pressed", "force", "rate", "now", "present", "before", "earlier", "known", "value", "slope",
              "half", "degree", "reached", "owed")
# Samples of links whose sources step together: degree of the polynomial; samples kept, up to degree + 1; every: macro steps from one to
# the next, `left` of which are to come before the step that ends at one; h1, h2: s, between them, the newest first; elapsed: s, since.
PAST = _records("degree samples every left", "h1 h2 elapsed")
PAST_STATE = ("samples", "left", "h1", "h2", "elapsed")
# What is asked of the kernels: rows of the program from `first` to `last`, in `steps` macro steps from `times` (an address; 0: from t
# on); begin: units of the first row that are done; updated: outputs have moved already; whole: these are macro steps, whose
# signals go to `rows`, what bonded links were given to `given`, what `watched` (`watches` addresses) has to `outputs`, and behind the
# steps `looks` (`look_count`) all inputs, `driven` in number, to `inputs`: addresses, 0 where none is wanted; halt: ends the march
# behind the present step.
# What they answer: done: steps; row, place, unit, status: where a call failed, unit is -1 where none has, `BEYOND` where signals
# have left the limit.
REQUEST = _records("first last steps times begin updated whole rows given inputs outputs looks look_count driven watched watches halt done row "
                   "place unit status")
BEYOND = -2

FIELDS = "request units links pasts program order outputs_at inverse bonded signals buffer"
Memory = kernel_tuple(namedtuple("Memory", FIELDS))  # type: ignore[misc]
