"""The command `cosimo`: a module here for each kind of command. Heavy imports stand inside the commands, so that --help and the
completions of a shell are quick.

Exit codes: 0 done, 1 a check or a validation failed, 2 bad input, 3 the simulation failed (its partial result is kept) or the
disk is full, 130 and
143 it was stopped by Ctrl-C or SIGTERM, 129 by SIGHUP (likewise).
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence

from ...components.core.errors import BadInput
from ...components.core.files import refuse_pipe
from ...components.core.garbage import seldom_collected
from ..cache import tidy_daily
from ..output import FULL, NoSpace
from .application import app
from .common import BAD_INPUT, FAILED_RUN, shown_output


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; ends in SystemExit with the exit code."""
    for library in ("OPENBLAS", "OMP", "MKL"):  # threads of BLAS wait by spinning from the moment that NumPy is loaded
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    logging.getLogger("cosimo").addHandler(logging.NullHandler())  # our FMUs log there; a failed step carries the same text
    tidy_daily()
    sys.path.append(os.getcwd())  # module:Class on the command line
    with seldom_collected(), shown_output():
        _run(sys.argv[1:] if arguments is None else arguments)


def _run(arguments: Sequence[str]) -> None:
    try:
        for argument in arguments:
            refuse_pipe(argument)
        app([*arguments])
    except BadInput as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(FAILED_RUN if _disk_is_full(error) else BAD_INPUT) from None
    except MemoryError:  # in a report or a figure: a run ends with what it has
        print("cosimo: out of memory; what was written before stays", file=sys.stderr)
        raise SystemExit(FAILED_RUN) from None
    except OSError as error:  # a full disk, a folder that is a file ...: nothing the code could do better
        if error.errno is None:  # of a library that cannot be loaded, where memory is short
            print(f"cosimo: {error}, expected a library that can be loaded: is there enough memory?", file=sys.stderr)
            raise SystemExit(FAILED_RUN) from None
        place = repr(str(error.filename)) if error.filename is not None else "output"
        print(f"cosimo: {place}: {error.strerror or error}, expected a place that can be read and written", file=sys.stderr)
        raise SystemExit(FAILED_RUN if error.errno in FULL else BAD_INPUT) from None


def _disk_is_full(error: BaseException) -> bool:
    """Whether a full disk is behind a message, such as of an FMU that cannot be unpacked: nothing that the user gave is wrong then."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, NoSpace) or (isinstance(cause, OSError) and cause.errno in FULL):
            return True
        cause = cause.__cause__ or cause.__context__
    return False
