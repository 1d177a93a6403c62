"""What is done to the program very often, or for very long: rows, life cycles, kills, builds at once, ill-behaved FMUs.

    python -m cosimo.tests.campaigns.endurance kills --count 100

rows: steps of one run, each of them a row; memory, clock and checkpoint are looked at. cycles: runs of one scene in one process,
of each packaging. kills: `kill -9` of one run that goes on each time, its rows at the end compared with those of a run that was
never killed. builds: three processes at once with an empty cache. foreign: C FMUs that crash, hang, end or fill the process, in
it and in a sandbox, `count` times each. Prints what it has seen as JSON; exit code 1 where there are findings.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
from cosimo.tests.c_compiler import shared_library
from cosimo.tests.campaigns.mutated_files import peak

STEP = 2.0**-8  # s: its multiples are exact
PATIENCE = 300.0  # s for something to happen on a busy machine
PLAIN = {"NUMBA_DISABLE_JIT": "1"}
TROUBLES = {
    1: "segmentation fault",
    2: "abort",
    3: "exit(0)",
    4: "_exit(7)",
    5: "hangs",
    6: "error",
    7: "fatal",
    8: "unknown status",
    9: "NaN",
    10: "infinite",
    11: "takes all memory",
    12: "endless recursion",
    13: "prints 20 MB",
    14: "logs null pointers",
    15: "closes all files",
    16: "ignores all signals, changes the directory",
    17: "floating point signal",
    18: "segmentation fault in the initialization",
    19: "hangs in the initialization",
    20: "hangs in the termination",
    21: "segmentation fault when it is freed",
    22: "writes into all files",
    23: "spoils the heap",
    24: "forks",
}
PACKAGINGS = (("in process", {"in_process": True}, 100), ("pythonfmu", {}, 8_000), ("native", {"native": True}, 200))  # bytes
WARM = 100  # runs before those that count
UNGUARDED = {4, 15}  # which take the process, or all it could say, with them and leave an exit code of their own
LIMIT, LONGEST, MEMORY = 5.0, 90.0, 3 << 30  # s for an answer in a sandbox; s for a run; bytes without a sandbox


def mass() -> Any:
    from cosimo.orchestrator.systems import load_scene

    return load_scene("mass-on-spring").with_changes({"master.step": STEP, "record.signals": ["mass.base_x"]})


def rows(count: int, folder: Path) -> dict[str, Any]:
    """One run of `count` steps in this process."""
    from cosimo.orchestrator.run.rows import Rows
    from cosimo.orchestrator.run.run import run

    run(mass().with_changes({"stop_time": 1.0}), in_process=True, output=folder)
    before = peak()
    result = run(
        mass().with_changes({"stop_time": count * STEP}),
        in_process=True,
        output=folder,
        checkpoint_every=0.4 * count * STEP,
        checkpoint_to=folder / "checkpoint",
    )
    findings, first = [], 0
    for time, *_ in Rows.read(folder / "result.parquet").chunks():
        if not np.array_equal(time, np.arange(first, first + time.size) * STEP):
            findings.append(f"a wrong time at row {first} to {first + time.size}")
        first += time.size
    if (result.outcome, first) != ("done", count + 1):
        findings.append(f"{result.outcome} with {first} rows: {result.message}")
    return {
        "megabytes": peak(),
        "megabytes before": before,
        "rows": first,
        "checkpoint bytes": (folder / "checkpoint").stat().st_size,
        "result bytes": (folder / "result.parquet").stat().st_size,
        "seconds": result.info.timing.run,
        "findings": findings,
    }


def cycles(count: int, folder: Path) -> dict[str, Any]:
    """Some `count` runs of three steps of each packaging, in this process: memory, files and folders that one leaves."""
    from cosimo.tests.units.test_many_runs import growth

    tempfile.tempdir = str(folder)  # those of other processes do not count
    scene, seen, findings = mass().with_changes({"stop_time": 3 * STEP}), {}, []
    for packaging, how, most in PACKAGINGS:
        try:
            left = growth(scene, count, WARM, **how)
        except AssertionError as error:
            findings.append(f"{packaging}: a run failed or left files, threads, folders or paths: {str(error)[:300]}")
            continue
        seen[packaging] = {"runs": count, "bytes a run": round(left)}
        findings += [f"{packaging}: {left:.0f} bytes a run, more than {most}"] if left > most else []
    return {"packagings": seen, "findings": findings}


def kills(count: int, folder: Path, seed: int) -> dict[str, Any]:
    """One run that is killed `count` times, at random moments, also before it has gone on."""
    from cosimo.orchestrator.output import UNFINISHED
    from cosimo.orchestrator.run.results import Result
    from cosimo.orchestrator.run.run import run
    from cosimo.orchestrator.systems import load_scene

    rng, checkpoint, findings, ends, fresh = random.Random(seed), folder / "checkpoint", [], [0.0], 0  # ends: s, behind each kill
    for k in range(count):
        old = checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
        more = ["--resume", str(checkpoint)] if old else []
        process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "cosimo.orchestrator.cli",
                "run",
                "mass-on-spring",
                "--in-process",
                "-o",
                str(folder),
                "--stop",
                "1e6",
                "--checkpoint-every",
                "5",
                *more,
            ],
            env=os.environ | PLAIN,
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )
        end, wait = monotonic() + PATIENCE, rng.random() < 0.7 or not old  # for a new checkpoint
        while wait and process.poll() is None and monotonic() < end:
            if checkpoint.exists() and checkpoint.stat().st_mtime_ns > old:
                fresh += 1
                break
            sleep(0.01)
        sleep(rng.uniform(0.0, 1.0 if wait else 4.0))
        process.kill()
        errors = process.communicate()[1].decode()
        if process.returncode != -9:
            findings.append(f"kill {k}: it had ended with {process.returncode}: {errors[-300:]}")
        if (folder / UNFINISHED / "run.json").exists():
            try:
                left = Result.read(folder)
                ends.append(left.end if left.rows else 0.0)
            except ValueError as error:
                findings.append(f"kill {k}: {error}")
    left = Result.read(folder)
    again = run(load_scene("mass-on-spring").with_changes({"stop_time": left.end}), in_process=True)
    rows_ = left.rows - 2  # the last step of `again` is a shorter one
    different = [n for n in left.columns if left[n][:rows_].tobytes() != again[n][:rows_].tobytes()]
    findings += [f"other numbers: {', '.join(different)}"] if different else []
    return {"kills": count, "behind a new checkpoint": fresh, "reached": max(ends), "rows": left.rows, "findings": findings}


BUILD = (
    "import hashlib; from cosimo.fmus.build import built; from cosimo.orchestrator.run.run import run; "
    "from cosimo.orchestrator.systems import load_scene; "
    "r = run(load_scene('mass-on-spring').with_changes({'stop_time': 0.05})); "
    "print(hashlib.sha256(built('PlanarLink').read_bytes() + r['mass.base_x'].tobytes()).hexdigest(), r.outcome)"
)


def builds(count: int, folder: Path, compiled: bool) -> dict[str, Any]:
    """Three processes that build two FMUs, and where `compiled` their kernels, at once in an empty cache; `count` times."""
    answers, findings = Counter[str](), []
    for k in range(count):
        cache = folder / f"cache-{k}"
        environment = os.environ | {"COSIMO_CACHE": str(cache)} | ({} if compiled else PLAIN)
        several = [
            subprocess.Popen(
                [sys.executable, "-c", BUILD], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            for _ in range(3)
        ]
        for process in several:
            output, errors = process.communicate()
            answers[output.strip()] += 1
            if process.returncode or not output.strip().endswith(" done") or "Traceback" in errors:
                findings.append(f"round {k}: {process.returncode} {errors[-300:]}")
        if parts := [str(p) for p in cache.rglob("*") if ".part" in p.name or ".tmp." in p.name]:
            findings.append(f"round {k}: left behind {parts}")
        shutil.rmtree(cache)
    if len(answers) > 1:
        findings.append(f"different answers: {dict(answers)}")
    return {"rounds": count, "processes": 3 * count, "compiled": compiled, "findings": findings}


def unruly(trouble: int, folder: Path) -> Path:
    """The FMU with a trouble; needs a C compiler."""
    import zipfile

    from cosimo.tests.units import foreign_fmu

    source, path = Path(foreign_fmu.__file__).with_name("unruly.c"), folder / f"unruly-{trouble}.fmu"
    library = path.with_suffix(".so")
    shared_library(library, f"-DTROUBLE={trouble}", source)
    with zipfile.ZipFile(path, "w") as file:
        flags = 'canHandleVariableCommunicationStepSize="true"'
        file.writestr("modelDescription.xml", foreign_fmu.DESCRIPTION.format(flags=flags))
        file.write(library, "binaries/linux64/foreign.so")
    return path


def foreign(count: int, folder: Path, troubles: tuple[int, ...] = tuple(TROUBLES)) -> dict[str, Any]:
    """Runs of the command line with each trouble, without and with --isolate.

    In a sandbox every run must end as documented, with its rows. Without it the FMU may take the process with it, which
    the documentation says; what was written must be readable then, and an exit code of 0 stands for a whole result only.
    """
    outcomes: dict[str, dict[str, str]] = {}
    findings = []
    for trouble in troubles:
        fmu = unruly(trouble, folder)
        for isolated in (True, False) * count:
            out = folder / f"out-{trouble}-{isolated}"
            scene = folder / "scene.toml"
            limit = f'isolation = "restricted"\ntime_limit = {LIMIT}\n' if isolated else ""
            scene.write_text(f'stop_time = 1.0\nmaster.step = 0.1\n[units.u]\nfmu = "{fmu}"\n{limit}')
            shutil.rmtree(out, ignore_errors=True)
            verdict, wrong = _unruly_run(trouble, scene, out, isolated)
            outcomes.setdefault(TROUBLES[trouble], {})["in a sandbox" if isolated else "in the process"] = verdict
            findings += [f"{TROUBLES[trouble]}, {'in a sandbox' if isolated else 'in the process'}: {wrong}"] if wrong else []
    return {"troubles": len(troubles), "runs": 2 * count * len(troubles), "outcomes": outcomes, "findings": findings}


def _unruly_run(trouble: int, scene: Path, out: Path, isolated: bool) -> tuple[str, str]:
    """What a run did, and what was wrong with that."""
    from cosimo.orchestrator.run.results import Result

    def limit() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    with open(out.with_suffix(".log"), "w+b") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "cosimo.orchestrator.cli", "run", str(scene), "-o", str(out)],
            stdout=log,
            stderr=log,
            env=os.environ | PLAIN | {"OPENBLAS_NUM_THREADS": "1"},
            preexec_fn=None if isolated else limit,
            start_new_session=True,
        )
        try:
            code = process.wait(LONGEST if isolated else LONGEST / 3.0)
            late = False
        except subprocess.TimeoutExpired:
            process.kill()
            code, late = process.wait(), True
        with suppress(ProcessLookupError):  # what the FMU has forked in the process itself
            os.killpg(process.pid, signal.SIGKILL)
        log.seek(0)
        text = log.read(200_000).decode(errors="replace")
    try:
        result = Result.read(out)
        kept = f"{result.outcome}, {result.rows} rows"
    except ValueError as error:
        result, kept = None, f"no result ({error})"
    verdict = f"{'killed after waiting' if late else f'exit code {code}'}; {kept}"
    if "Traceback" in text:
        return verdict, "a traceback"
    if code == 0 and (result is None or result.outcome != "done" or result.rows != 11):
        return verdict, f"exit code 0 with {kept}"
    if isolated and (late or code not in (0, 3)):
        return verdict, f"ended with {code}{' after waiting' if late else ''}: {text[-300:]}"
    if isolated and (result is None or (trouble < 18 and result.rows < 5)):
        return verdict, f"lost rows: {kept}"
    if not isolated and code not in (0, 3) and code > 0 and trouble not in UNGUARDED:
        return verdict, f"ended with {code}: {text[-300:]}"
    return verdict, ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("kind", choices=("rows", "cycles", "kills", "builds", "foreign"))
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--compiled", action="store_true", help="builds: machine code, too")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="cosimo-endurance-") as name:
        folder = Path(name)
        seen = {
            "rows": lambda: rows(options.count, folder),
            "cycles": lambda: cycles(options.count, folder),
            "kills": lambda: kills(options.count, folder, options.seed),
            "builds": lambda: builds(options.count, folder, options.compiled),
            "foreign": lambda: foreign(options.count, folder),
        }[options.kind]()
    print(json.dumps({"kind": options.kind, "count": options.count, "seed": options.seed, **seen}, indent=1))
    raise SystemExit(bool(seen["findings"]))


if __name__ == "__main__":
    main()
