"""LLVM text of 64-bit machines for one whose pointers have 32 bits: in memory a pointer keeps its eight bytes.

Numba optimizes for the machine that it runs on, so offsets into structures, their sizes and lengths of copies stand in its text as
numbers. On a machine with shorter pointers LLVM would lay the structures out shorter, and memory would be overwritten without a
word. Here each type of something in memory has i64 in the place of a pointer: what is allocated, what an offset is counted in,
what is loaded and stored. No such type contains a pointer then, so every structure has the layout of the 64-bit machine. Text in
which a pointer could lie in memory in any other way is refused.
"""

from __future__ import annotations

import re

POINTER = re.compile(r"\bptr\b")
OFFSET = re.compile(r"getelementptr(?: inbounds| nusw| nuw| inrange\([^)]*\))* \(?")
MEMORY = re.compile(r"( *)(?:(%\S+) = )?(alloca|load|store) (?:volatile )?")
# what hands on a structure in memory, or moves pointers, by instructions that are not looked into
UNKNOWN = re.compile(
    r"\b(?:byval|byref|sret|inalloca|preallocated)\(|\b(?:atomicrmw|cmpxchg|va_arg)\b|\b(?:load|store) atomic\b"
    r"|@llvm\.(?:masked\.(?:load|store|gather|scatter|expandload|compressstore))\.v\d+p0"
    r"|^%\S+ = type .*\bptr\b"
)


class PointerInMemory(ValueError):
    """Text in which a pointer may lie in memory in a way that is not known here; the argument is its line."""


def widened(text: str) -> str:
    """The text with pointers of eight bytes in memory. Raises `PointerInMemory`."""
    constants = _constants_with_pointers(text)
    return "\n".join(_line(line, k, constants) for k, line in enumerate(text.splitlines())) + "\n"


def _line(line: str, k: int, constants: re.Pattern[str] | None) -> str:
    if UNKNOWN.search(line):
        raise PointerInMemory(line.strip())
    if "getelementptr" in line:
        line = _offsets(line)
    used = MEMORY.match(line)
    if constants and not line.startswith("@") and constants.search(line):
        _check_use(line, used.group(3) if used else "", constants)
    if not used:
        return line
    space, result, instruction = used.groups()
    end = _end(line, used.end())
    kind, rest = line[used.end() : end], line[end:].partition(", !")[0]
    if not POINTER.search(kind):
        return line
    wide = _wide(kind)
    if instruction == "alloca":
        return line[: used.end()] + wide + line[end:]
    if kind.startswith(("{", "[")):
        raise PointerInMemory(line.strip())
    name, begin = f'%"wide {k}"', line[used.start(3) : used.end()]
    if instruction == "load":
        return f"{space}{name} = {begin}{wide}{rest}\n{space}{result} = inttoptr {wide} {name} to {kind}"
    comma = _end(line, end + 1, ",")
    return f"{space}{name} = ptrtoint {kind}{line[end:comma]} to {wide}\n{space}{begin}{wide} {name}{line[comma:]}"


def _wide(kind: str) -> str:
    return POINTER.sub("i64", kind)


def _offsets(line: str) -> str:
    """With the types that offsets are counted in widened."""
    parts, last = [], 0
    for match in OFFSET.finditer(line):
        end = _end(line, match.end())
        parts += [line[last : match.end()], _wide(line[match.end() : end])]
        last = end
    return "".join(parts) + line[last:]


def _end(line: str, start: int, marks: str = ", ") -> int:
    """Where the type or value that begins here ends: at a mark that is in no bracket."""
    depth = 0
    for at in range(start, len(line)):
        c = line[at]
        if depth == 0 and c in marks:
            return at
        depth += (c in "{[<(") - (c in "}]>)")
        if depth < 0:
            return at
    return len(line)


def _constants_with_pointers(text: str) -> re.Pattern[str] | None:
    """What finds the names of variables outside of functions that hold pointers: they have the layout of the other machine."""
    names = []
    for name, kind in re.findall(r"^(@\S+) = [^\n]*?(?:global|constant) ([^\n]*)", text, re.M):
        if POINTER.search(kind[: _end(kind, 0)]):
            names.append(re.escape(name))
    return re.compile(rf"(?:{'|'.join(names)})(?![\w.$-])") if names else None


def _check_use(line: str, instruction: str, constants: re.Pattern[str]) -> None:
    """Only the address of such a variable may be used, as that of an exception that a kernel hands back and nothing reads."""
    handed_on = re.match(r" *(?:%\S+ = )?(?:phi|select|ret)\b", line) is not None
    stored = instruction == "store" and not constants.search(line[line.rindex(", ptr ") :])
    if not (handed_on or stored):
        raise PointerInMemory(line.strip())
