"""Is an FMU fit for use? Works on any co-simulation FMU of FMI 2.0 and 3.0; nothing that goes wrong in it reaches the caller.

The checks run in processes of their own (`check_worker`); one that dies is a finding, too. All but that of the model description
execute the FMU.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from .check_worker import GROUPS, READING

TIME_LIMIT = 300.0  # s, for one process


@dataclass(frozen=True)
class Finding:
    """The outcome of one check; `detail` says what was seen, or that the FMU does not offer what the check needs."""

    name: str
    ok: bool
    detail: str


def check(
    path: Path, *, execute: bool = True, command: Sequence[str] = (), environment: Mapping[str, str] | None = None
) -> list[Finding]:
    """Run all checks on an FMU file; never raises for a bad one.

    execute: False leaves out the checks that execute the FMU.  command, environment: of the processes that check; the path and the
    names of checks follow the command.
    """
    path = Path(path)
    if not zipfile.is_zipfile(path):
        return [Finding("file", False, f"{path} is " + ("no zip file" if path.exists() else "missing"))]
    findings: list[Finding] = []
    for group in GROUPS:
        todo = [name for name in group if execute or name in READING]
        while todo:
            findings += _run(path, todo, command, environment)
            todo = [name for name in todo if name not in {f.name for f in findings}]
    return findings


def _run(path: Path, names: list[str], start: Sequence[str], surroundings: Mapping[str, str] | None) -> list[Finding]:
    """Findings of the checks `names` until the worker process ends; at least one."""
    # what an FMU prints may be no text
    with tempfile.TemporaryFile("w+", errors="replace") as output, tempfile.TemporaryFile("w+", errors="replace") as errors:
        command = [*(start or (sys.executable, "-m", f"{__package__}.check_worker")), str(path.resolve()), *names]
        top = str(Path(__file__).resolve().parent.parent)
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (top, os.environ.get("PYTHONPATH"))))}
        worker = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=errors,
            env=surroundings or environment,
            start_new_session=os.name != "nt",
        )
        try:
            code = worker.wait(TIME_LIMIT)
            end = f"the process ended with code {code}" if code >= 0 else f"the process was ended by signal {-code}"
        except subprocess.TimeoutExpired:
            code, end = -1, f"no answer within {TIME_LIMIT:g} s"
        finally:
            with suppress(OSError):  # what the FMU has started goes with it
                worker.kill() if os.name == "nt" else os.killpg(worker.pid, signal.SIGKILL)
            worker.wait()
        output.seek(0)
        errors.seek(0)
        findings = _read(output, names)
        if code != 0:
            last = (errors.read().strip().splitlines() or [""])[-1]
            # dying after the last answer is a fault of the last check: it happens when the FMU's library is unloaded
            broken = names[len(findings)] if len(findings) < len(names) else findings.pop().name
            findings.append(Finding(broken, False, f"{end}. {last}".strip()))
    return findings


def _read(lines: Iterable[str], names: Sequence[str]) -> list[Finding]:
    """The findings that a worker has written, one for each check in its turn: an FMU may write lines like them."""
    findings: list[Finding] = []
    for line in lines:
        if line.startswith("finding ") and len(findings) < len(names):
            with suppress(ValueError, TypeError, RecursionError):
                finding = Finding(**json.loads(line[len("finding ") :]))
                if finding.name == names[len(findings)] and isinstance(finding.ok, bool) and isinstance(finding.detail, str):
                    findings.append(finding)
    return findings
