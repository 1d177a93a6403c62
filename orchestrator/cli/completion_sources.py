"""What the kept answers of `completion` are made of: names of the catalogue and the systems, commands of the application."""

from __future__ import annotations

from inspect import unwrap
from typing import Any, get_type_hints

from typer import Context
from typer.main import get_command

from .completion import units_in


def names() -> dict[str, Any]:
    """Those that `completion.keep` takes."""
    from ...components.catalogue import CATALOGUE, component_class
    from ...components.core.variables import Causality
    from ..scene.scene import scene_files
    from ..systems import NAMES, cases

    classes = {name: component_class(name) for name in CATALOGUE}
    return {
        "components": {name: {
            "effects": list(cls.effects), "presets": list(cls.presets),
            "parameters": [n for n, v in cls.variables.items() if v.causality is not Causality.OUTPUT]}
            for name, cls in classes.items()},
        "scenes": {name: units_in(str(path)) for name, path in scene_files().items()},
        "cases": list(cases()), "systems": list(NAMES)}


def commands() -> dict[str, Any]:
    """The tree that `completion.keep` takes."""
    from .application import app

    return _node(get_command(app))


def _node(command: Any) -> dict[str, Any]:
    """options: names, help, whether it takes a value, whether several times, what completes it; arguments likewise."""
    hints = get_type_hints(unwrap(command.callback), include_extras=True) if command.callback else {}
    options, arguments = [], []
    for param in command.get_params(Context(command)):
        info = getattr(hints.get(param.name), "__metadata__", (None,))[0]
        function = getattr(info, "autocompletion", None)
        completes = function.__name__ if function else ""
        if param.param_type_name == "argument":
            arguments.append({"completes": completes, "several": param.nargs == -1})
        elif not param.hidden:
            options.append({"names": [*param.opts, *param.secondary_opts], "help": " ".join((param.help or "").split()),
                            "value": not (param.is_flag or param.count), "multiple": param.multiple, "completes": completes})
    children = {name: child for name, child in getattr(command, "commands", {}).items() if not child.hidden}
    return {"help": " ".join(command.get_short_help_str().split()), "options": options, "arguments": arguments,
            "commands": {name: _node(child) for name, child in children.items()}}
