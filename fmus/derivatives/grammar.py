"""What of LLVM's language occurs in entries: functions of lines, lines of instructions, instructions of typed operands.

Only what a derivative has to look into is read: instructions whose result or operands are floating-point numbers or memory. All others
stay as the lines they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

NAME = r'[%@](?:"[^"]*"|[-\w$.]+)'
TYPE = r"(?:void|ptr|double|float|half|i\d+|<[^>]*>|\{[^}]*\}|\[[^\]]*\])"
LINE = re.compile(rf"\s+(?:({NAME}) = )?(?:(?:tail|musttail|notail) )?([a-z]+) (.*)")
CALL = re.compile(rf"({TYPE}) ({NAME})\(")
FLAGS = re.compile(r"(?:(?:fast|nnan|ninf|nsz|arcp|contract|afn|reassoc|volatile) )*")
METADATA = re.compile(r"(?:,? ![\w.]+ ![\w]+|,? #\d+)+$")  # aliases and attributes, which derived code does not have
BINARY = ("fadd", "fsub", "fmul", "fdiv", "frem", "fneg")
TYPED = (
    "store",
    "select",
    "freeze",
    "bitcast",
    "insertelement",
    "extractelement",
    "shufflevector",
    "insertvalue",
    "extractvalue",
)


class Unsupported(Exception):
    """An instruction that has no derivative here; the argument names it."""


class Operand(NamedTuple):
    """A value with its type."""

    type: str
    value: str


class Instruction(NamedTuple):
    """One line of a function. type: of the result, of what is stored, of what is compared.

    callee: of a call; labels: of a phi, where each operand comes from; tail: what stands behind the operands, such as alignment.
    """

    line: str
    result: str = ""
    op: str = ""
    type: str = ""
    operands: tuple[Operand, ...] = ()
    callee: str = ""
    labels: tuple[str, ...] = ()
    tail: tuple[str, ...] = ()


class Function(NamedTuple):
    """A function that has a body. arguments: types and names; linkage: "internal" or nothing."""

    linkage: str
    name: str
    type: str
    arguments: tuple[Operand, ...]
    body: tuple[Instruction, ...]


def functions(text: str) -> Iterator[Function]:
    """All functions of a module that have a body."""
    bodies = re.findall(r"^define [^\n]* \{\n(.*?)^\}", text, re.S | re.M)
    for head, body in zip(heads(text), bodies, strict=True):
        yield head._replace(body=tuple(map(_instruction, body.splitlines())))


def heads(text: str) -> Iterator[Function]:
    """The same without their bodies, most of what there is to read."""
    for head in re.findall(r"^define ([^\n]*) \{$", text, re.M):
        match = CALL.search(head)
        assert match
        arguments = tuple(map(typed, _parts(head[match.end() : _closed(head, match.end())])))
        linkage = "internal" if head.startswith("internal ") else ""
        yield Function(linkage, match[2], match[1], arguments, ())


def typed(text: str) -> Operand:
    """A type and a value, between which attributes may stand."""
    words = _parts(text, " ")
    value = next((" ".join(words[k:]) for k, w in enumerate(words) if w in ("getelementptr", "inttoptr", "splat")), words[-1])
    return Operand(words[0], value)


def is_floating(kind: str) -> bool:
    """Whether a type is a number with tangents, or a vector of such."""
    return kind == "double" or kind.endswith(" x double>")


def lanes(kind: str) -> int:
    """Elements of a vector's type; of a scalar's 0."""
    match = re.match(r"<(\d+) x ", kind)
    return int(match[1]) if match else 0


def cells(kind: str) -> int:
    """So many cells of eight bytes are enough for a type."""
    match = re.fullmatch(r"[\[<](\d+) x (.*)[\]>]", kind)
    if match:
        return int(match[1]) * cells(match[2])
    return sum(map(cells, _parts(kind.strip("{} ")))) if kind.startswith("{") else 1


def _instruction(line: str) -> Instruction:
    line = METADATA.sub("", re.sub(r"\s*; preds = .*", "", line))
    match = LINE.fullmatch(line)
    if not match:
        return Instruction(line)
    result, op, rest = match[1] or "", match[2], FLAGS.sub("", match[3], count=1)
    if op == "call":
        called = CALL.search(rest)
        if not called:
            raise Unsupported(line.strip())
        operands = _parts(rest[called.end() : _closed(rest, called.end())])
        return Instruction(line, result, op, called[1], tuple(map(typed, operands)), called[2])
    if op == "phi":
        kind, ends = rest[: _closed(rest, 0, " ")], rest[_closed(rest, 0, " ") :]
        ways = [_parts(way.strip(" []")) for way in _parts(ends)]
        return Instruction(line, result, op, kind, tuple(Operand(kind, v) for v, _ in ways), labels=tuple(at for _, at in ways))
    if op == "fcmp":
        rest = rest.partition(" ")[2]
    if op in BINARY or op == "fcmp":
        first, *others = _parts(rest)
        kind, value = typed(first)
        return Instruction(line, result, op, kind, (Operand(kind, value), *(Operand(kind, other) for other in others)))
    if op == "load":
        kind, pointer, *tail = _parts(rest)
        return Instruction(line, result, op, kind, (typed(pointer),), tail=tuple(tail))
    if op in TYPED:
        rest, _, to = rest.partition(" to ") if op == "bitcast" else (rest, "", "")
        parts = _parts(rest)
        count = next((k for k, p in enumerate(parts) if re.match(r"align |\d", p)), len(parts))
        values = [typed(part) for part in parts[:count]]
        kind = to or values[1 if op == "select" else 0].type
        kind = re.sub(r"<\d+ x (.*)>", r"\1", kind) if op == "extractelement" else kind
        if op == "shufflevector":
            kind = re.sub(r"<\d+", f"<{lanes(values[2].type)}", kind)
        return Instruction(line, result, op, kind, tuple(values), tail=tuple(parts[count:]))
    if op in ("alloca", "inttoptr", "getelementptr"):
        parts = _parts(rest.partition(" to ")[0] if op == "inttoptr" else rest)
        pointers = [typed(part) for part in parts if re.match(r"(?:ptr|i64|<\d+ x ptr>) ", part)]
        kind = parts[0] if op == "alloca" else "ptr"
        return Instruction(line, result, op, kind, tuple(pointers[:1] if op != "alloca" else ()))
    return Instruction(line, result, op)


def _closed(text: str, start: int, mark: str = "") -> int:
    """Where the bracket ends in which `start` lies, or the first mark that is in no bracket."""
    depth, quoted = 0, False
    for at in range(start, len(text)):
        c = text[at]
        quoted ^= c == '"'
        if quoted:
            continue
        if depth == 0 and c == mark:
            return at
        depth += (c in "{[<(") - (c in "}]>)")
        if depth < 0:
            return at
    return len(text)


def _parts(text: str, mark: str = ",") -> list[str]:
    """What stands between marks that are in no bracket."""
    parts, start = [], 0
    while start < len(text):
        end = _closed(text, start, mark)
        if part := text[start:end].strip():
            parts.append(part)
        start = end + 1
    return parts
