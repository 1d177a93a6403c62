"""Mutated files in large numbers: each is used, or refused with one message, in bounded time and memory.

    python -m cosimo.tests.campaigns.mutated_files scenes --count 100000 --seed 1

Kinds: scenes (.toml), fmus, ssps, ssds (.ssd and .ssv), checkpoints, results (run.json), cases and plans
(.toml), curves and responses (measured, .csv), lines (.toml). FMUs are read as a scene reads them; their binaries are not
executed. Points of a plan are laid out and checked, the form of a line is found. What counts as a finding: an exception other
than `BadInput`, a message of several lines, a crash, more than 10 s for one file, more than 1 GB of resident memory, a file
written outside of the campaign's folder and the cache, and a changed checkpoint that gives other numbers. A case is reproduced
by kind, seed and number.
"""

import argparse
import io
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

SECONDS, MEGABYTES = 10, 1000  # a file may take
BATCH = 500  # files that one process reads
SIGNS = b"[]{}\"'\\=.,</>\n\0\xff*a01"
TOKENS = [
    b"",
    *(bytes([sign]) for sign in SIGNS),
    b"\xef\xbb\xbf",
    b"nan",
    b"inf",
    b"-1",
    b"1e400",
    b"9" * 20,
    b"true",
    b"..",
    b"../../x",
    b"%s",
    b"->",
    b"]]>",
    b"&amp;",
    b"<!DOCTYPE x>",
    b"[[",
    b"1e-320",
    b"[" * 300,
    b"<a>" * 300,
    "ö\u202e".encode(),
]
WRITES = {"os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.truncate", "os.chmod", "shutil.move"}
MODES = re.compile("[wax+]")


class Late(BaseException):
    """A file took too long; no net around loading catches it."""


def mutated(content: bytes, rng: random.Random) -> bytes:
    """The bytes with some of them flipped, cut, doubled, moved, or replaced by what has a meaning somewhere."""
    data = bytearray(content)
    for _ in range(rng.choice([1, 1, 1, 2, 3, 8])):
        at, length = rng.randrange(len(data) + 1), rng.choice([1, 1, 2, 5, 20, 200])
        action = rng.randrange(7)
        if action == 0 and data:
            data[at % len(data)] ^= 1 << rng.randrange(8)
        elif action == 1:
            del data[at : at + length]
        elif action == 2:
            data[at:at] = data[at : at + length] * rng.choice([1, 1, 2, 50])
        elif action == 3:
            data[at : at + rng.choice([0, length])] = rng.choice(TOKENS)
        elif action == 4:
            other = rng.randrange(len(data) + 1)
            data[at : at + length] = data[other : other + length]
        elif action == 5 and rng.random() < 0.3:
            del data[at:]
        else:
            numbers = [m.span() for m in re.finditer(rb"\d+(\.\d+)?(e-?\d+)?", data[:100_000])]
            if numbers:
                first, last = rng.choice(numbers)
                data[first:last] = rng.choice([b"0", b"-1", b"1e308", b"4294967296", b"1e-9", b"nan", b"x", b"7" * 400])
    return bytes(data)


def mutated_archive(content: bytes, rng: random.Random) -> bytes:
    """An archive with damage to its bytes, to one of its files, or to what it holds."""
    if rng.random() < 0.3:
        return mutated(content, rng)
    result = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(result, "w", rng.choice([0, 8])) as new:
        names = old.namelist()
        texts = [n for n in names if n.endswith((".xml", ".ssd", ".ssv", ".npy"))] or names
        chosen, action = rng.choice(texts), rng.random()
        for name in names:
            member = old.read(name)
            if name == chosen and action < 0.1:
                continue
            label = rng.choice(["../x", "/x", "a\\b", name + "x", "x" * 300]) if name == chosen and action < 0.2 else name
            new.writestr(label, mutated(member, rng) if name == chosen else member)
    return result.getvalue()


# -- kinds: originals by name, and what is done with a mutated one ---------------------------------------------------
def small_scene() -> dict[str, Any]:
    from cosimo.tests.support import two_masses

    return {**two_masses("jacobi", 0.05, 1), "stop_time": 1.0}


def scenes(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.scene.scene import scene_files
    from cosimo.orchestrator.systems import load_scene

    return [p.read_bytes() for p in scene_files().values()], "case.toml", lambda path: load_scene(path).coupling


def fmus(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.fmus.build import built
    from cosimo.orchestrator.systems import read_scene

    def use(path: Path) -> None:
        read_scene({"stop_time": 1.0, "units": {"u": {"fmu": str(path)}}, "master": {"step": 0.1}}).coupling  # noqa: B018

    return [built(name).read_bytes() for name in ("Pantograph", "ServoMotor", "DeepGrooveBearing")], "case.fmu", use


def package(folder: Path) -> bytes:
    from cosimo.orchestrator.scene.ssp.write import write
    from cosimo.orchestrator.systems import load_scene

    path = folder / "original.ssp"
    scene = load_scene("mass-on-spring")
    write(scene, path)
    return path.read_bytes()


def ssps(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    return [package(folder)], "case.ssp", scenes(folder)[2]


def ssds(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    with zipfile.ZipFile(io.BytesIO(package(folder))) as archive:
        archive.extractall(folder)
        return [archive.read(n) for n in archive.namelist() if n.endswith((".ssd", ".ssv"))], "case.ssd", scenes(folder)[2]


def checkpoints(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.run.run import run
    from cosimo.orchestrator.systems import read_scene

    scene, path = read_scene(small_scene()), folder / "original"
    whole = run(scene, checkpoint_every=0.5, checkpoint_to=path)

    def use(path: Path) -> None:
        result = run(scene, resume=path)
        same = all(result[n].tobytes() == whole[n].tobytes() for n in whole.columns) and result.outcome == "done"
        assert same, "other numbers from a changed checkpoint"

    return [path.read_bytes()], "case.checkpoint", use


def results(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.run.run import run
    from cosimo.orchestrator.systems import read_result, read_scene

    run(read_scene(small_scene()), output=folder)
    return [(folder / "run.json").read_bytes()], "run.json", lambda path: read_result(path.parent)


CASE = """title = "Mass"\nscene = "mass-on-spring"\n[sources]\nrig = "a test rig"
[[runs]]\ncondition = "soft"\nchanges = { "spring.stiffness" = 50.0 }
[[rows]]\nquantity = "largest"\nmeasure = "mass.base_x, maximum"\nunit = "m"\nlow = 0.0\nhigh = 1e2\nstanding = "verbatim"
source = "rig"
"""
CURVE = """[[curves]]\nsignal = "mass.base_x"\nfile = "case.csv"\ntime = "t"\ncolumn = "x"\nsource = "rig"
tolerances = { mean = 0.01 }
"""
PLANS = (
    """method = "sobol"\npoints = 64\nseed = 3
correlation = [["spring.stiffness", "mass.mass", 0.3]]\n[vary]
"spring.stiffness" = { distribution = "normal", mean = 100.0, deviation = 5.0 }
"mass.mass" = { distribution = "uniform", low = 0.5, high = 2.0 }\n""",
    """[vary]\n"spring.stiffness" = { from = 50.0, to = 200.0, points = 20 }\n"mass.mass" = [1.0, 2.0, 4.0]\n""",
)


def cases(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.harness.validation.own import read_case
    from cosimo.orchestrator.systems import load_scene, summary

    return [CASE.encode()], "case.toml", lambda path: read_case(path, load_scene, summary)


def curves(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.harness.validation.own import read_case
    from cosimo.orchestrator.systems import load_scene, summary

    (folder / "curve.toml").write_text(CASE + CURVE)
    text = "t,x,y\n" + "".join(f"{0.1 * k:.2f},{0.01 * k * k:.4f},1\n" for k in range(60))
    return [text.encode()], "case.csv", lambda path: read_case(folder / "curve.toml", load_scene, summary)


def plans(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.harness.many.plan import plan_of, plan_settings
    from cosimo.orchestrator.systems import load_scene

    scene = load_scene("mass-on-spring")
    return [plan.encode() for plan in PLANS], "case.toml", lambda path: plan_of(scene, plan_settings(path))


def responses(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.systems.railway.frequency_response import read_response

    rows = [(0.5 * k, 1.0 / (100.0 - k), -0.01 * k) for k in range(1, 40)]
    texts = [
        header + "".join(f"{f:g},{a:.5g},{b:.5g}\n" for f, a, b in rows)
        for header in ("frequency [Hz],real [m/N],imaginary [m/N]\n", "frequency [Hz],magnitude [m/s2/N],phase [deg]\n")
    ]
    return [t.encode() for t in texts], "case.csv", read_response


def lines(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    from cosimo.orchestrator.scene.files import shipped
    from cosimo.orchestrator.systems.railway.line import read

    return [p.read_bytes() for p in shipped("lines", ".toml").values()], "case.toml", lambda path: read(path, {})


def faults(folder: Path) -> tuple[list[bytes], str, Callable[[Path], Any]]:
    """No files, but all that counts as a finding, one after the other: the campaign's own test."""
    from cosimo.components.core.errors import BadInput

    def use(path: Path) -> None:
        faults.calls = calls = getattr(faults, "calls", 0) + 1  # type: ignore[attr-defined]
        if calls == 1:
            raise RecursionError("too deep")
        if calls == 2:
            error = BadInput("a", "b", "c")
            error.args = ("two\nlines",)
            raise error
        if calls == 3:
            (Path(__file__).parent / "written-by-the-campaign").write_text("x")
        if calls == 4:
            os._exit(11)

    return [b"x"], "case", use


KINDS = {f.__name__: f for f in (scenes, fmus, ssps, ssds, checkpoints, results, cases, curves, plans, responses, lines, faults)}
ARCHIVES = {"fmus", "ssps"}


def work(kind: str, seed: int, first: int, count: int, folder: Path) -> None:
    """Use `count` files from number `first` on, in this process; one line of JSON each."""
    from cosimo.components.core.errors import BadInput

    warnings.simplefilter("ignore")
    originals, name, use = KINDS[kind](folder)
    allowed = tuple(str(p) for p in (folder, os.environ["COSIMO_CACHE"], os.devnull))
    outside: list[str] = []

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            _, mode, flags = arguments
            writes = MODES.search(mode) if isinstance(mode, str) else (flags or 0) & (os.O_WRONLY | os.O_RDWR)
        else:
            writes = event in WRITES
        place = arguments[0] if writes else None
        if isinstance(place, str | bytes) and not os.path.abspath(os.fsdecode(place)).startswith(allowed):
            outside.append(f"{event} {place!r}")

    def late(*_: object) -> None:
        raise Late(f"more than {SECONDS} s")

    sys.addaudithook(watch)
    signal.signal(signal.SIGALRM, late)
    path = folder / name
    for number in range(first, first + count):
        rng = random.Random(f"{kind} {seed} {number}")
        original = rng.choice(originals)
        path.write_bytes((mutated_archive if kind in ARCHIVES else mutated)(original, rng))
        print(json.dumps({"begins": number}), flush=True)
        verdict, start = "used", time.monotonic()
        signal.alarm(SECONDS)
        try:
            use(path)
        except BadInput as error:
            verdict = "refused" if "\n" not in str(error) else f"a message of several lines: {error}"
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            at = traceback.extract_tb(error.__traceback__)[-1]
            verdict = f"{type(error).__name__}: {str(error)[:200]} ({Path(at.filename).name}:{at.lineno})"
        signal.alarm(0)
        if outside:
            verdict = f"written outside: {outside.pop()}"
            outside.clear()
        took = time.monotonic() - start
        print(json.dumps({"number": number, "verdict": verdict, "seconds": took, "megabytes": peak()}), flush=True)


def peak() -> float:
    """Most resident memory of this process so far, MB.

    Of /proc where there is one: what `getrusage` gives starts with the peak of the process that started this one.
    """
    status = Path("/proc/self/status")
    if status.exists() and (line := re.search(r"VmHWM:\s+(\d+) kB", status.read_text())):
        return int(line[1]) / 1024.0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def campaign(kind: str, count: int, seed: int, batch: int = BATCH) -> dict[str, Any]:
    """Counts of used and refused files, findings by their text with a number that shows them, largest time and memory."""
    counts: Counter[str] = Counter()
    findings: dict[str, int] = {}
    slowest = largest = 0.0
    first = 0
    while first < count:
        with tempfile.TemporaryDirectory(prefix="cosimo-campaign-") as folder:
            environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "TMPDIR": folder, "PYTHONDONTWRITEBYTECODE": "1"}
            environment.setdefault("COSIMO_CACHE", str(Path(folder, "cache")))
            numbers = ("--seed", str(seed), "--first", str(first), "--count", str(min(batch, count - first)))
            done = subprocess.run(
                [sys.executable, "-m", "cosimo.tests.campaigns.mutated_files", kind, *numbers, "--folder", folder],
                capture_output=True,
                text=True,
                env=environment,
            )
        lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        results = [line for line in lines if "verdict" in line]
        for line in results:
            verdict = line["verdict"]
            counts[verdict if verdict in ("used", "refused") else "findings"] += 1
            if verdict not in ("used", "refused"):
                findings.setdefault(verdict, line["number"])
            slowest, largest = max(slowest, line["seconds"]), max(largest, line["megabytes"])
        begun = [line["begins"] for line in lines if "begins" in line]
        if done.returncode:  # a crash, of the file that was begun last
            if not begun:
                raise RuntimeError(done.stderr)
            counts["findings"] += 1
            findings.setdefault(f"the process ended with {done.returncode}: {done.stderr.strip()[-200:]}", begun[-1])
        if largest > MEGABYTES:
            findings.setdefault(f"{largest:.0f} MB", begun[0])
        first = begun[-1] + 1
    return {
        "kind": kind,
        "count": count,
        "seed": seed,
        **{k: counts[k] for k in ("used", "refused", "findings")},
        "slowest": slowest,
        "megabytes": largest,
        "texts": findings,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("kinds", nargs="+", choices=KINDS)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, help="number of the first file, to see one of them again")
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.first is not None:
        folder = options.folder or Path(tempfile.mkdtemp(prefix="cosimo-campaign-"))
        os.environ.setdefault("COSIMO_CACHE", str(folder / "cache"))
        work(options.kinds[0], options.seed, options.first, options.count, folder)
        return
    failed = False
    for kind in options.kinds:
        outcome = campaign(kind, options.count, options.seed)
        print(json.dumps(outcome, indent=1))
        failed = failed or bool(outcome["texts"])
    raise SystemExit(failed)


if __name__ == "__main__":
    main()
