"""Is an FMU fit for use? Works on any co-simulation FMU of FMI 2.0 and 3.0; nothing that goes wrong in it reaches the caller.

The checks run in processes of their own (`check_worker`); one that dies is a finding, too.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

from .check_worker import GROUPS

TIME_LIMIT = 300.0  # s, for one process


@dataclass(frozen=True)
class Finding:
    """The outcome of one check; `detail` says what was seen, or that the FMU does not offer what the check needs."""

    name: str
    ok: bool
    detail: str


def check(path: Path) -> list[Finding]:
    """Run all checks on an FMU file; never raises for a bad one."""
    path = Path(path)
    if not zipfile.is_zipfile(path):
        return [Finding("file", False, f"{path} is " + ("no zip file" if path.exists() else "missing"))]
    findings: list[Finding] = []
    for group in GROUPS:
        todo = list(group)
        while todo:
            findings += _run(path, todo)
            todo = [name for name in todo if name not in {f.name for f in findings}]
    return findings


def _run(path: Path, names: list[str]) -> list[Finding]:
    """Findings of the checks `names` until the worker process ends; at least one."""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        command = [sys.executable, "-m", f"{__package__}.check_worker", str(path.resolve()), *names]
        top = str(Path(__file__).resolve().parent.parent)
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (top, os.environ.get("PYTHONPATH"))))}
        try:
            code = subprocess.run(command, stdout=output, stderr=errors, env=environment, timeout=TIME_LIMIT).returncode
            end = f"the process ended with code {code}" if code >= 0 else f"the process was ended by signal {-code}"
        except subprocess.TimeoutExpired:
            code, end = -1, f"no answer within {TIME_LIMIT:g} s"
        output.seek(0)
        errors.seek(0)
        findings = [Finding(**json.loads(line[len("finding ") :])) for line in output if line.startswith("finding ")]
        if code != 0:
            last = (errors.read().strip().splitlines() or [""])[-1]
            # dying after the last answer is a fault of the last check: it happens when the FMU's library is unloaded
            broken = names[len(findings)] if len(findings) < len(names) else findings.pop().name
            findings.append(Finding(broken, False, f"{end}. {last}".strip()))
    return findings
