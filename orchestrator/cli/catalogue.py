"""Lists of components, FMUs, scenes and cases; the JSON schema of scene files; the user's cache."""

from __future__ import annotations

import json
import textwrap
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from ...components.core.errors import BadInput, counted, nearest, pick
from ...components.core.folders import cache_root
from ...components.core.store import digest_of, read_kept, replaced, write_kept
from .. import cache as kept
from .common import app, output_width, print_table, print_written
from .completion import kinds_and_systems, scene_files
from .options import AsJson, refuse
from .schema import schema_place

PACKAGE = Path(__file__).parents[2]
ACTIONS = ("show", "clear", "prune")
DAYS = 30.0


@app.command("list")
def list_(
    what: Annotated[
        str,
        Argument(
            metavar="[KIND|SYSTEM|WORD]",
            autocompletion=kinds_and_systems,
            help="A kind (components, fmus, scenes, cases, systems), a system, or a word in names and titles. Default: all names.",
        ),
    ] = "",
    as_json: AsJson = False,
) -> None:
    """List components, FMUs, scenes and cases. Example: cosimo list scenes; also cosimo list, cosimo list bearings"""
    everything = _everything()
    what = next((kind for kind in (*everything, "systems") if what.lower() in (kind, kind[:-1])), what)
    if what == "systems":
        listed = {what: _systems(everything)}
    elif what in everything:
        listed = {what: everything[what]}
    else:
        listed = _selected(everything, what) if what else everything
    if as_json:
        print(json.dumps(listed, indent=2))
    elif what:
        for name, entries in listed.items():
            if entries and (name != "fmus" or what == "fmus"):  # which are those of the components
                print_table(name, ("name", "title"), [(e["name"], e["title"]) for e in entries])
    else:
        _print_names(listed)


def _systems(listed: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """The systems, with how many entries of each kind they have."""
    kinds = {kind: [e["system"] for e in listed[kind]] for kind in ("components", "scenes", "cases")}
    return [
        {"name": name, "title": ", ".join(counted(of.count(name), kind[:-1]) for kind, of in kinds.items()), "system": name}
        for name in dict.fromkeys(name for of in kinds.values() for name in of)
    ]


def _selected(listed: dict[str, list[dict[str, Any]]], word: str) -> dict[str, list[dict[str, Any]]]:
    """Entries of a system, or with a word in name or title; raises `BadInput` where there is none."""
    systems = {e["system"] for entries in listed.values() for e in entries}
    low = word.lower()
    chosen = {
        kind: [e for e in entries if e["system"] == word or (word not in systems and low in f"{e['name']} {e['title']}".lower())]
        for kind, entries in listed.items()
    }
    if not any(chosen.values()):
        names = [*listed, *sorted(systems), *(e["name"] for entries in listed.values() for e in entries)]
        raise BadInput("list", repr(word), "a kind, a system, or a word of a name or title", nearest(word, names))
    return chosen


def _print_names(listed: dict[str, list[dict[str, Any]]]) -> None:
    """Names in rows by system, which fit a screen."""
    for kind in ("components", "scenes", "cases"):
        systems: dict[str, list[str]] = {}
        for entry in listed[kind]:
            systems.setdefault(entry["system"], []).append(entry["name"])
        print(f"{kind} ({len(listed[kind])})")
        for system, names in systems.items():
            print(
                textwrap.fill(
                    " ".join(names),
                    min(output_width(), 160),
                    initial_indent=f"  {system:15} ",
                    subsequent_indent=" " * 18,
                    break_on_hyphens=False,
                    break_long_words=False,
                )
            )
    print("With titles: cosimo list KIND | SYSTEM | WORD. Details: cosimo show NAME")


def _everything() -> dict[str, list[dict[str, Any]]]:
    """All entries, kind by kind. They are kept until a file of the package changes: to load all components and cases takes long."""
    folders = [PACKAGE / "components", PACKAGE / "orchestrator" / "systems"]
    files = sorted(file for folder in folders for file in folder.rglob("*.*") if file.suffix != ".pyc")
    state = digest_of(*(f"{file} {s.st_size} {s.st_mtime_ns}" for file in files for s in [file.stat()]))
    path = Path(cache_root()) / "lists" / state[:16]
    if (content := read_kept(path)) is None:
        from .show_parts import everything

        content = json.dumps(everything()).encode()
        with suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_kept(path, content)
    return json.loads(content)


@app.command()
def cache(
    action: Annotated[str, Argument(help="Action: show, clear or prune.")] = "show",
    kinds: Annotated[list[str] | None, Argument(help="Kinds to clear, as `cosimo cache` lists them. Default: all.")] = None,
    days: Annotated[
        float | None, Option(help=f"With prune: remove entries that are unused for this time. Default: {DAYS:g}.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show or clear the cache of FMUs, machine code and measurements. Example: cosimo cache prune --days 7

    All of it is made again when it is needed. The environment variable COSIMO_CACHE moves it.
    """
    pick(action, ACTIONS, "cache", "one of " + ", ".join(ACTIONS))
    without_effect = {"kinds": kinds if action != "clear" else None, "--days": days if action != "prune" else None}
    refuse(without_effect, f"no effect with {action}")
    if action != "show":
        if days is not None and not days >= 0.0:
            raise BadInput("--days", f"{days:g}", "a number of at least 0")
        gone = kept.clear(kinds or ()) if action == "clear" else kept.prune(DAYS if days is None else days)
        print(json.dumps({"removed": gone}) if as_json else f"removed {gone / 1e6:.3g} MB from {kept.root()}")
        return
    entries = kept.entries()
    if as_json:
        print(json.dumps({"cache": str(kept.root()), "entries": [asdict(entry) for entry in entries]}))
        return
    print_table(str(kept.root()), ("kind", "what", "files", "MB"), [(e.kind, e.meaning, e.files, e.size / 1e6) for e in entries])


@app.command()
def schema(
    files: Annotated[
        list[Path] | None,
        Argument(
            metavar="SCENE.toml...",
            autocompletion=scene_files,
            help="Scene files for an editor. The schema goes to the path in their first line. If a file has no such line, cosimo "
            "adds it and writes the schema next to the file.",
        ),
    ] = None,
    output: Annotated[Path | None, Option("-o", "--output", help="File for the schema. Default: standard output.")] = None,
) -> None:
    """Write the JSON schema of scene files for editors. Example: cosimo schema my-scene.toml

    It is that of this version, with all components and their parameters: write it anew after an update.
    """
    from ..systems.scene_schema import scene_schema

    places = dict.fromkeys([*map(schema_place, files or ()), *([output] if output else [])])
    text = json.dumps(scene_schema(), indent=1)
    if not places:
        print(text)
    for place in places:
        with replaced(place) as file:
            file.write(text + "\n")
        print_written([place])
