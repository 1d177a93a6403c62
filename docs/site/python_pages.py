"""The page of the Python interface: signature, parameters with types and meanings, what is returned and raised, an example."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import fields, is_dataclass
from typing import Any, get_args

import cosimo
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.settings import Model
from prose import code, docstring, joined, plain, table

GROUPS = {
    "Scenes and runs": (
        "load_scene",
        "build_scene",
        "unit",
        "read_scene",
        "write_scene",
        "Scene",
        "run",
        "compare",
        "Result",
        "read_result",
        "summary",
        "write_report",
        "delivered",
    ),
    "Many runs": ("sweep", "run_many", "sensitivity", "uncertainty", "fit", "design"),
    "Judging": ("validate", "accuracy", "stability", "effects"),
    "FMUs": ("build", "check"),
    "Errors": ("BadInput", "StepFailed"),
}
OTHERS = "Components of your own"
ALIASES = {
    "Wish": " | ".join(map(repr, get_args(verification.Wish))),
    "PlanLike": "PlanSettings | Mapping[str, Any] | str | Path",
}
COMMON = {  # what a name means wherever the docstring does not say it
    "scene": "a scene, its name, or the path of its file",
    "in_process": "run components in this process, not as FMUs: the same bits, several times faster",
    "native": "run components as native FMUs, which are built where the cache has none",
    "progress": "show a bar with the time left",
    "output": "where results are written; what is there is read, not run again",
    "jobs": "workers; 1: this process alone, None: one for each core",
    "cluster": "address of a Dask scheduler, whose workers run the scene",
    "verify": "find the numerical error of each number, as in `run`",
    "plan": "a plan, the file of one, or the same as plain data",
    "settings": "the file of a study, or the same as plain data",
}
HIDDEN = ("summarize", "observe", "on_message")  # what programs hand to one another
EXAMPLES = {
    "load_scene": """
        scene = cosimo.load_scene("mass-on-spring")
        print(scene.units["spring"].parameters)""",
    "open": """
        with cosimo.open("mass-on-spring") as sim:
            sim["spring.stiffness"] = "60 N/m"
            sim.initialize()
            sim.step(100)
            print(sim.time, sim["mass.base_x"])""",
    "function": """
        with cosimo.function("mass-on-spring", ["spring.stiffness"], ["mass.base_x, maximum"]) as f:
            print(f(f.start), f([[80.0], [120.0]]))""",
    "gym": """
        env = cosimo.gym(
            "double-pendulum",
            actions={"chain.first_torque": (-20.0, 20.0)},
            observations=["chain.first_angle [deg]", "chain.first_rate"],
            reward=lambda observation, action: -abs(observation[0] - 180.0),
        )
        env.reset(seed=1)
        print(env.step([5.0]))
        env.close()""",
    "build_scene": """
        scene = cosimo.build_scene(
            {"mass": cosimo.unit("PlanarLink", mass=2.0), "spring": cosimo.unit("CompliantJoint", stiffness=5e3)},
            {"mass.base_x": "spring.second_x", "spring.second_force_x": "mass.base_force_x"},
            stop_time=0.5,
            step=1e-3,
        )""",
    "unit": """
        cosimo.unit("Pantograph", effects=["contact_loss"], speed="250 km/h")""",
    "write_scene": """
        cosimo.write_scene(cosimo.load_scene("mass-on-spring"), "copy.toml")""",
    "run": """
        result = cosimo.run("mass-on-spring", in_process=True)
        print(result.outcome, result["mass.base_x"].min())""",
    "compare": """
        scene = cosimo.load_scene("mass-on-spring")
        softer = scene.with_changes({"spring.stiffness": 50.0})
        print(cosimo.compare(scene, softer))""",
    "summary": """
        result = cosimo.run("double-pendulum", in_process=True)
        for row in cosimo.summary(result):
            print(row.name, row.value, row.error, row.unit)""",
    "write_report": """
        cosimo.write_report(cosimo.run("mass-on-spring", in_process=True), "out")""",
    "read_result": """
        cosimo.run("mass-on-spring", in_process=True, output="kept")
        print(cosimo.read_result("kept").time[-1])""",
    "sweep": """
        done = cosimo.sweep("mass-on-spring", {"vary": {"spring.stiffness": [50.0, 100.0, 200.0]}})
        print(done)""",
    "run_many": """
        print(cosimo.run_many("mass-on-spring", {"spring.stiffness": [50.0, 100.0], "mass.mass": [1.0, 2.0]}))""",
    "validate": """
        results = cosimo.validate(["four-bar"], "judged", in_process=True)
        print(results[0].outcome)""",
    "check": """
        from pathlib import Path

        print(cosimo.check(cosimo.build("Pantograph", Path("fmus"))))""",
    "BadInput": """
        try:
            cosimo.load_scene("mass-on-sprung")
        except cosimo.BadInput as error:
            print(error)  # where, what came, what was expected, and the near name""",
}
RAISES = re.compile(r"\s*Raises `\w+`.*?\.(?=\s|$)(?! [a-z])", re.DOTALL)


class Described(str):
    """The description of a field, in the place of its default."""


def page() -> str:
    """Its Markdown."""
    listed = {name for names in GROUPS.values() for name in names}
    groups = GROUPS | {OTHERS: tuple(n for n in cosimo.__all__ if n not in listed)}
    text = (
        "`import cosimo` gives the names of this page; what they need is imported when they are used first. Everything "
        "else in the package may change from version to version. Times are in s, all other numbers in SI units."
    )
    parts = ["# Python interface", text]
    for title, names in groups.items():
        parts.append(f"## {title}")
        parts += [_object(name, getattr(cosimo, name)) for name in names if name in cosimo.__all__]
    return joined(*parts)


def example(name: str) -> str:
    """The example of a name, a program; nothing where there is none."""
    return "import cosimo\n\n" + inspect.cleandoc(EXAMPLES[name]) + "\n" if name in EXAMPLES else ""


def _object(name: str, value: Any) -> str:
    if isinstance(value, int):
        return f"````{{py:data}} cosimo.{name}\n:value: {value}\n\nA status of a kernel: {_STATUS[name]}.\n````"
    kind = "class" if inspect.isclass(value) else "function"
    body = _body(value, _parameters(value, name))
    if kind == "class":
        methods = (_method(k, v) for k, v in vars(value).items() if not k.startswith(("_", "model_")) and _is_public(v))
        body = joined(body, *methods)
    if name in EXAMPLES:
        body = joined(body, f"```python\n{example(name)}```")
    return f"`````{{py:{kind}}} cosimo.{name}{_signature(value, name)}\n\n{body.rstrip()}\n`````"


_STATUS = {"DONE": "it has done what it was asked for", "OWN": "the first number of a component's own refusals"}


def _is_public(value: Any) -> bool:
    inner = value.fget if isinstance(value, property) else getattr(value, "__func__", value)
    return inspect.isfunction(inner) and bool(inspect.getdoc(inner))


def _method(name: str, value: Any) -> str:
    if isinstance(value, property):
        kind = _type(value.fget.__annotations__.get("return", ""))
        return f"````{{py:property}} {name}\n:type: {kind}\n\n{docstring(inspect.getdoc(value) or '')}\n````"
    function = getattr(value, "__func__", value)
    kind = {staticmethod: "staticmethod", classmethod: "classmethod"}.get(type(value), "method")
    body = _body(function, _parameters(function)[kind != "staticmethod" :])
    return f"````{{py:{kind}}} {name}{_signature(function, bound=kind != 'staticmethod')}\n\n{body}\n````"


def _parameters(value: Any, name: str = "") -> list[inspect.Parameter]:
    """Those of a function, the fields of a class of data; of other classes those of its constructor."""
    if inspect.isclass(value) and (issubclass(value, Model) or is_dataclass(value)):
        if not issubclass(value, Model):
            return [inspect.Parameter(f.name, inspect.Parameter.KEYWORD_ONLY, annotation=f.type) for f in fields(value)]
        written = {k: t for cls in reversed(value.__mro__) for k, t in vars(cls).get("__annotations__", {}).items()}
        return [
            inspect.Parameter(k, inspect.Parameter.KEYWORD_ONLY, annotation=written[k], default=Described(f.description or ""))
            for k, f in value.model_fields.items()
        ]
    try:
        own = list(inspect.signature(value).parameters.values())
    except (ValueError, TypeError):
        return []
    return [p for p in own if p.name not in HIDDEN]


def _body(value: Any, parameters: list[inspect.Parameter]) -> str:
    """The docstring in parts: what it does, a table of parameters, what it raises."""
    text = inspect.getdoc(value) or ""
    head, _, rest = text.partition("\n\n")
    names = {p.name for p in parameters}
    raised = [m[0].strip() for m in RAISES.finditer(rest)]
    rest, meanings = _meanings(RAISES.sub("", rest), names)
    data = inspect.isclass(value) and (issubclass(value, Model) or is_dataclass(value))
    meanings = ({} if data else COMMON) | {p.name: p.default for p in parameters if isinstance(p.default, Described)} | meanings
    rows = [
        (code(p.name), code(_type(p.annotation)).replace("|", "\\|"), _default(p), plain(meanings.get(p.name, "")))
        for p in parameters
    ]
    header = ("attribute" if data else "parameter", "type", "default", "meaning")
    columns = [k for k in range(4) if k < 2 or any(row[k] for row in rows)]
    listed = table([header[k] for k in columns], [[row[k] for k in columns] for row in rows])
    returned = "" if inspect.isclass(value) else _type(getattr(value, "__annotations__", {}).get("return", ""))
    returns = f"Returns {code(returned)}." if returned not in ("", "None") else ""
    return joined(plain(head), docstring(rest), listed, returns, *map(plain, raised)).rstrip()


def _meanings(text: str, names: Iterable[str]) -> tuple[str, dict[str, str]]:
    """(the text without them, name -> meaning) of "name: meaning" and "name, name: meaning" in a text."""
    if not names:
        return text, {}
    name = f"`?(?:{'|'.join(map(re.escape, sorted(names, key=len, reverse=True)))})`?"
    pieces = re.split(rf"(?:(?<=^)|(?<=[.;)\s]\s)|(?<=\n))({name}(?:, {name})*): ", text)
    meanings: dict[str, str] = {}
    for which, meaning in zip(pieces[1::2], pieces[2::2], strict=True):
        for one in which.replace("`", "").split(", "):
            meanings[one] = joined(meanings.get(one, ""), meaning).replace("\n\n", " ").strip().rstrip(";")
    return pieces[0].strip(), meanings


def _signature(value: Callable[..., Any], name: str = "", bound: bool = False) -> str:
    """Names, types and defaults; of a class of data nothing: its attributes stand in a table."""
    if inspect.isclass(value) and (issubclass(value, Model) or is_dataclass(value)):
        return ""
    parameters = _parameters(value, name)[1 if bound else 0 :]
    shown, starred = [], False
    for p in parameters:
        if p.kind is p.KEYWORD_ONLY and not starred and not any(q.kind is q.VAR_POSITIONAL for q in parameters):
            shown.append("*")
            starred = True
        kind, default = _type(p.annotation), _default(p).strip("`")
        text = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "") + p.name + (f": {kind}" if kind else "")
        shown.append(text + (f" = {default}" if default else ""))
    returned = "" if inspect.isclass(value) else _type(getattr(value, "__annotations__", {}).get("return", ""))
    return f"({', '.join(shown)})" + (f" -> {returned}" if returned else "")


def _default(parameter: inspect.Parameter) -> str:
    value = parameter.default
    if value is parameter.empty or isinstance(value, Described):
        return ""
    return code(repr(value)) if isinstance(value, str | int | float | bool | tuple | None.__class__) else code("...")


def _type(annotation: Any) -> str:
    """An annotation as it is written in a program."""
    if annotation is inspect.Parameter.empty:
        return ""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    text = re.sub(r"\b(" + "|".join(ALIASES) + r")\b", lambda m: ALIASES[m[1]], text)
    text = re.sub(r"Annotated\[(\w+(?:\[\w+\])?), [^\]]*?(?:\([^)]*\))?\]", r"\1", text)  # rules of pydantic
    text = re.sub(r"SerializeAsAny\[(\w+)\]", r"\1", text)
    return re.sub(r"ForwardRef\('([^']*)'\)", r"\1", text).replace("cosimo.orchestrator.settings.", "").replace("typing.", "")
