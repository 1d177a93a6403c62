"""The user's cache: what is in it, and what can go."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated

import typer

from ...components.core.errors import BadInput, nearest
from .common import AsJson, app, print_table

ACTIONS = ("show", "clear", "prune")
DAYS = 30.0


@app.command()
def cache(
    action: Annotated[str, typer.Argument(help="show, clear or prune")] = "show",
    kinds: Annotated[list[str] | None, typer.Argument(help="with clear: kinds that `cosimo cache` names; default: all")] = None,
    days: Annotated[float | None, typer.Option("--days", help=f"With prune: unused for so long; default {DAYS:g}.")] = None,
    as_json: AsJson = False,
) -> None:
    """What is kept from run to run: FMUs, machine code, measurements. Example: cosimo cache prune --days 7

    All of it is made again when it is needed. The environment variable COSIMO_CACHE moves it.
    """
    from .. import cache as kept

    if action not in ACTIONS:
        raise BadInput("cache", repr(action), "one of " + ", ".join(ACTIONS), nearest(action, ACTIONS))
    for option, given, wanted in (("kinds", kinds, "clear"), ("--days", days, "prune")):
        if given is not None and given != [] and action != wanted:
            raise BadInput(option, repr(given), f"none with {action}; it would have no effect", "Leave it out.")
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
