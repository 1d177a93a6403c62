"""The checks of an FMU in the sandbox: who checks an FMU of others may not trust it yet.

python -m cosimo.orchestrator.units.checked FILE CHECK ... is the process in it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from ...fmus.check import Finding, check
from ...fmus.check_worker import main
from .sandbox import environment, limit_resources, sandboxed


def walled_check(path: Path) -> list[Finding]:
    """`check` in the sandbox. Raises `BadInput` where there is none."""
    start = [*sandboxed("--isolate", str(path.resolve())), sys.executable, "-P", "-m", __spec__.name]
    return check(
        path, command=start, environment=environment() | {"PYTHONPATH": ":".join(filter(None, sys.path)), "TMPDIR": "/tmp"}
    )


if __name__ == "__main__":
    limit_resources(restricted=True)
    main(*sys.argv[1:])
