"""Reference from the declarations: keys of a scene, [analysis], [study], commands, the Python interface."""

from __future__ import annotations

import inspect
import re
from typing import Any, get_args

import click
import python_pages
import typer
from cosimo.orchestrator.cli.application import app
from cosimo.orchestrator.settings import AnalysisKeys, Model, SceneSettings
from cosimo.orchestrator.systems import SYSTEMS
from prose import code, joined, plain, table, verbatim


def pages() -> dict[str, str]:
    """File name -> Markdown."""
    return {
        "scene-keys": _scene_keys(),
        "analysis-keys": _analysis_keys(),
        "command-line": _commands(),
        "python": python_pages.page(),
    }


# -- settings -------------------------------------------------------------------------------------------------------------------
def _scene_keys() -> str:
    tables, waiting, done = [], [("", SceneSettings)], set()
    while waiting:
        name, model = waiting.pop(0)
        done.add(model)
        heading = f"## `[{name}]`" if name else "## Top of the file"
        tables += [heading, plain((inspect.getdoc(model) or "").partition("\n\n")[0]), _fields(model)]
        for key, field in model.model_fields.items():
            for inner in _models(field.annotation):
                if inner not in done and not issubclass(inner, AnalysisKeys) and inner not in [m for _, m in waiting]:
                    waiting.append((f"{name}.{key}" if name else key, inner))
    text = (
        "Every key that a scene file may have. The page [Scenes](../../scenes.md) shows how they are used; `cosimo schema` "
        "prints the same as a JSON schema, with the parameters of all components."
    )
    return joined("# Keys of a scene", text, *tables)


def _analysis_keys() -> str:
    text = (
        "`[analysis]` says what the figures and numbers of a run refer to. Its keys belong to the system that `system` "
        "names; a key that the system does not have is refused."
    )
    parts = ["# Keys of `[analysis]`", text, "## In every system", _fields(AnalysisKeys)]
    for system in SYSTEMS.values():
        own = {k: f for k, f in system.keys.model_fields.items() if k not in AnalysisKeys.model_fields}
        if own:
            parts += [f'## `system = "{system.name}"`', _fields(system.keys, own)]
            for key, field in own.items():
                for inner in _models(field.annotation):
                    parts += [f"### `[analysis.{key}]`", _fields(inner)]
    return joined(*parts)


def _models(annotation: Any) -> list[type[Model]]:
    """Models inside an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, Model):
        return [annotation]
    return [m for inner in get_args(annotation) for m in _models(inner)]


def _fields(model: type[Model], fields: dict[str, Any] | None = None) -> str:
    rows = []
    for name, field in (fields or model.model_fields).items():
        default = "required" if field.is_required() else _default(field.get_default(call_default_factory=True))
        rows.append((code(field.alias or name), code(_type(field.annotation)), default, plain(field.description or "", set())))
    return table(("key", "type", "default", "meaning"), rows)


def _default(value: Any) -> str:
    if value is None or value == () or value == {} or value == "":
        return ""
    if isinstance(value, Model):
        return "its own"
    return code(str(value).lower() if isinstance(value, bool) else str(value))


def _type(annotation: Any) -> str:
    """A type as a scene's author reads it."""
    text = re.sub(r"typing\.|<class '([\w.]+)'>", r"\1", str(annotation))
    words = {"str": "text", "float": "number", "int": "whole number", "bool": "true or false"}
    if "Literal" in text:
        return ", ".join(v.strip(" '") for v in re.findall(r"Literal\[(.*?)\]", text)[0].split(","))
    first = re.search(r"\b(str|float|int|bool)\b", text)
    kind = words[first[1]] if first else "table"
    if text.startswith("dict"):
        return "table"
    return f"list of {kind}s" if text.startswith("tuple") else kind


# -- commands -------------------------------------------------------------------------------------------------------------------
def _commands() -> str:
    group = typer.main.get_command(app)
    context = click.Context(group, info_name="cosimo")
    parts = [
        "# Command line",
        "What `cosimo COMMAND --help` prints, by command. The page [Commands](../../commands.md) shows them in use.",
    ]
    for name in sorted(group.list_commands(context)):
        command = group.get_command(context, name)
        inner = click.Context(command, info_name=f"cosimo {name}", max_content_width=110)
        formatter = click.HelpFormatter(width=110)
        click.Command.format_usage(command, inner, formatter)
        command_text = inspect.cleandoc(command.help or "")
        options = [record for parameter in command.params if (record := _record(parameter, inner))]
        with formatter.section("Options"):
            formatter.write_dl(options or [("--help", "Show this message and exit.")])
        parts += [f"## `cosimo {name}`", plain(command_text), verbatim(formatter.getvalue())]
    return joined(*parts)


def _record(parameter: Any, context: Any) -> tuple[str, str] | None:
    if parameter.param_type_name == "argument":
        return parameter.name.upper(), getattr(parameter, "help", "") or ""
    return ", ".join([*parameter.opts, *parameter.secondary_opts]), parameter.help or ""
