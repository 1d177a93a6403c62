"""What a shell completes: commands, options, and names of components, scenes, units and parameters.

A shell runs the command again at each press of Tab. The answer comes from a file in the cache, without Typer, whose import takes
longer than one waits for a list. That file names every source that it was made from, with its time and size; it is made again
where one of them differs. Imports are few and stand where they are needed.
"""

from __future__ import annotations

import json
import os
import sys
from contextlib import suppress

TYPE_CHECKING = False  # without the import of typing
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from typing import Any

VARIABLE = "_COSIMO_COMPLETE"  # what the scripts of Typer, `cosimo --install-completion`, set to "complete_" and the shell
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SOURCES = ("components", os.path.join("orchestrator", "cli"), os.path.join("orchestrator", "systems"))
SCENE_FILES = (".toml", ".ssd", ".ssp")


_answers: dict[str, Any] = {}  # what they are made from, and the state of its sources


def asking_shell() -> str:
    """The shell that asks; "" where none does."""
    shell = os.environ.get(VARIABLE, "").removeprefix("complete_")
    return shell if shell in ("bash", "zsh", "fish", "powershell", "pwsh") else ""


def answer(shell: str) -> None:
    """Print what a shell asks for, in the format that the scripts of Typer 0.12 to 0.29 take apart."""
    if shell == "bash":
        words, place = _words(os.environ["COMP_WORDS"]), int(os.environ["COMP_CWORD"])
        before, incomplete = words[1:place], (words[place:] or [""])[0]
    else:
        line = os.environ.get("_TYPER_COMPLETE_ARGS", "")
        before, incomplete = _words(line)[1:], os.environ.get("_TYPER_COMPLETE_WORD_TO_COMPLETE", "")
        if incomplete or (before and shell in ("zsh", "fish") and not line.endswith(" ")):
            incomplete = before.pop()
    items = offers(before, incomplete)
    if shell == "bash":
        print("\n".join(items))
    elif shell == "zsh":
        print("_arguments '*: :((" + "\n".join(_zsh(*item) for item in items.items()) + "))'" if items else "_files")
    elif shell != "fish":
        print("\n".join(f"{name}:::{text or ' '}" for name, text in items.items()))
    elif os.environ.get("_TYPER_COMPLETE_FISH_ACTION") == "is-args":  # whether there is anything but files
        raise SystemExit(not items)
    else:
        print("\n".join(f"{name}\t{text}" if text else name for name, text in items.items()))


def _zsh(name: str, text: str) -> str:
    name, text = (t.replace('"', '""').replace("'", "''").replace("$", r"\$").replace("`", r"\`").replace(":", r"\\:")
                  for t in (name, text))
    return f'"{name}":"{text}"' if text else f'"{name}"'


def _words(line: str) -> list[str]:
    """Words of a line in which a quotation may still be open."""
    from shlex import shlex

    lexer = shlex(line, posix=True)
    lexer.whitespace_split, lexer.commenters = True, ""
    words: list[str] = []
    try:
        words += lexer
    except ValueError:
        words.append(lexer.token)
    return words


def offers(before: list[str], incomplete: str) -> dict[str, str]:
    """What may stand for an incomplete word -> its help, "" for names. before: the complete words behind `cosimo`."""
    node, words = _answers["commands"], list(before)
    while words and words[0] in node["commands"]:
        node = node["commands"][words.pop(0)]
    options = {name: option for option in node["options"] for name in option["names"]}
    given, used, wants, ended = [], [], None, False
    for word in words:  # arguments, options, the option whose value comes next
        name, equals, _ = word.partition("=")
        if wants is not None and word == "=":  # bash makes words of its own of "--set", "=" and what follows
            continue
        if wants is not None:
            wants = None
        elif word == "--":
            ended = True
        elif name in options and not ended:
            used.append(options[name])
            wants = options[name] if options[name]["value"] and not equals else None
        elif ended or not word.startswith("-"):
            given.append(word)
    name, equals, value = incomplete.partition("=")
    if wants is None and not ended and equals and name in options:
        wants, incomplete = options[name], value
    elif wants is not None and incomplete == "=":
        incomplete = ""
    if wants is not None:
        return dict.fromkeys(_values(wants["completes"], given, incomplete), "")
    if incomplete.startswith("-") and not ended:
        return {n: o["help"] for n, o in options.items() if n.startswith(incomplete) and (o["multiple"] or o not in used)}
    arguments = node["arguments"][len(given):] or [a for a in node["arguments"][-1:] if a["several"]]
    if arguments:
        return dict.fromkeys(_values(arguments[0]["completes"], given, incomplete), "")
    return {n: c["help"] for n, c in node["commands"].items() if n.startswith(incomplete)}


def _values(function: str, given: list[str], incomplete: str) -> list[str]:
    """Values of an option or argument, from the function here of that name."""
    if not function:
        return []
    complete = globals()[function]
    return complete(given, incomplete) if complete in (parameters, effects, presets) else complete(incomplete)


def is_current() -> bool:
    """Whether what is kept could be read, and is of today's sources."""
    path, state = _file(), _state()
    with suppress(OSError, ValueError), open(path, encoding="utf-8") as file:
        content = json.load(file)
        if isinstance(content, dict) and content.get("state") == state:
            _answers.update(content)
            return True
    return False


def keep(names: dict[str, Any], commands: dict[str, Any]) -> None:
    """Answer from these, now and until a source changes.

    names: components: name -> effects, presets, parameters; scenes: name -> {unit: component}; cases; systems.
    commands: the tree of commands, each with help, options, arguments and commands of its own.
    """
    from ...components.core.store import replaced

    _answers.update(state=_state(), names=names, commands=commands)
    with suppress(OSError):
        os.makedirs(os.path.dirname(_file()), exist_ok=True)
        with replaced(_file()) as file:
            json.dump(_answers, file)


def _file() -> str:
    """One of each installation: several may share a cache."""
    from zlib import crc32

    from ...components.core.folders import cache_root

    return os.path.join(cache_root(), "completion", f"{crc32(ROOT.encode()):08x}.json")


def _state() -> list[str]:
    """Changes with every file that the names come from: ROOT, Python, then path, time of change and size of each file.

    The time is that of the file's entry, too (POSIX), which no copy and no `touch` sets back.
    """
    files = [ROOT, sys.version]
    folders = [os.path.join(ROOT, source) for source in SOURCES]
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in entries:
                if entry.name.endswith((".py", ".toml")):
                    s = entry.stat()
                    files.append(f"{entry.path[len(ROOT):]} {s.st_mtime_ns} {s.st_ctime_ns} {s.st_size}")
                elif "." not in entry.name and entry.name != "__pycache__" and entry.is_dir():
                    folders.append(entry.path)
    return sorted(files)


def units_in(path: str) -> dict[str, str]:
    """Units of a scene file that are components."""
    from tomllib import loads

    try:
        with open(path, encoding="utf-8-sig") as file:
            units = loads(file.read()).get("units", {})
        return {name: str(unit["component"]) for name, unit in units.items() if "component" in unit}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _starting(names: Iterable[str], incomplete: str) -> list[str]:
    return sorted(name for name in names if name.startswith(incomplete))


def _files(incomplete: str) -> Iterator[str]:
    """Folders and scene files in the folder of what is typed, which stands before them as it is."""
    folder = incomplete[: incomplete.rfind("/") + 1]
    with suppress(OSError), os.scandir(folder or ".") as entries:
        for entry in entries:
            if entry.is_dir():
                yield f"{folder}{entry.name}/"
            elif entry.name.endswith(SCENE_FILES):
                yield folder + entry.name


def scene_files(incomplete: str) -> list[str]:
    """Scene files and folders."""
    return sorted(name for name in _starting(_files(incomplete), incomplete) if name.endswith((".toml", "/")))


def kinds_and_systems(incomplete: str) -> list[str]:
    """Of `cosimo list`."""
    return _starting(["components", "fmus", "scenes", "cases", *_answers["names"]["systems"]], incomplete)


def components(incomplete: str) -> list[str]:
    """Of the catalogue."""
    return _starting(_answers["names"]["components"], incomplete)


def scenes(incomplete: str) -> list[str]:
    """Shipped scenes and scene files."""
    return _starting([*_answers["names"]["scenes"], *_files(incomplete)], incomplete)


def cases(incomplete: str) -> list[str]:
    """Validation cases."""
    return _starting(["papers", *_answers["names"]["cases"]], incomplete)


def anything(incomplete: str) -> list[str]:
    """Components, scenes and cases."""
    names = _answers["names"]
    return _starting([*names["components"], *names["scenes"], *names["cases"], *_files(incomplete)], incomplete)


def _in_question(args: list[str]) -> dict[str, str]:
    """Unit -> component, of the scene that is the first argument; of a component alone "" -> its name."""
    if not args:
        return {}
    names = _answers["names"]
    if args[0] in names["components"]:
        return {"": args[0]}
    return names["scenes"].get(args[0]) or units_in(args[0])


def _of_units(args: list[str], key: str) -> Iterator[str]:
    known = _answers["names"]["components"]
    for unit, component in _in_question(args).items():
        for item in known.get(component, {}).get(key, ()):
            yield f"{unit}.{item}" if unit else item


def parameters(args: list[str], incomplete: str) -> list[str]:
    """unit.parameter= of --set. args: the arguments of the command line, here and below."""
    return _starting((f"{name}=" for name in _of_units(args, "parameters")), incomplete)


def effects(args: list[str], incomplete: str) -> list[str]:
    """unit.effect of --effects."""
    return _starting(_of_units(args, "effects"), incomplete)


def presets(args: list[str], incomplete: str) -> list[str]:
    """unit=preset of --preset."""
    known = _answers["names"]["components"]
    return _starting((f"{unit}={preset}" if unit else preset for unit, component in _in_question(args).items()
                      for preset in known.get(component, {}).get("presets", ())), incomplete)
