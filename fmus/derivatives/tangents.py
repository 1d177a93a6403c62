"""Forward-mode derivatives of entries: text in LLVM's language to text in LLVM's language.

Each floating-point number gets its tangents in `width` directions, side by side. All memory of an entry lies in one arena, its stack
too, and the tangents of the cell at an address a stand at width * a + offset. So copies, calls by address and loops need no rule of
their own: the derivative of a function is the function, with the tangents of each instruction computed behind it. Instructions that
compute numbers are the same ones in the same order, so these are bit-identical.

    d.f(double t, <width x double> dt, ..., i64 address, i64 offset, i64 stack, i64 ties)

An integer that is copied takes the tangents of its cell along, for a number may be copied as one; and in the first of the tangents of
an address of a function stands the address of its derivative, by which a call of an address finds it.

A derivative is that of the branch which the run takes. Where a decision stands at its very boundary and a direction moves it, as at
a kink, a tangent tells one side at most: of each direction for which that has happened, a bit is set in a number at `ties`. Kinks of
numbers that only decisions read are not told, see `reading`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from .grammar import Function, Instruction, Operand, Unsupported, cells, functions, is_floating, lanes, typed
from .numbers import Number, constant, intrinsic
from .reading import MOVES, name_of, read
from .rules import FLAT, KINKED, NO_NUMBERS, PARTIALS, SAME, SINGULAR

PREFIX = "d."
ELSEWHERE = "_kernel."  # in the name of a function whose derivative is in another module
REST = "i64 %offset, i64 %stack, i64 %ties"  # behind the arguments of a derivative
ZERO = "zeroinitializer"


def derived(text: str, width: int, ties: bool = True) -> str:
    """The module of the derivatives of all functions of a module, in `width` directions; raises `Unsupported`.

    ties: whether decisions at their very boundary are told.
    """
    text = re.sub(r" initializes\(\([^)]*\)(?:, \([^)]*\))*\)", "", text)
    here = list(functions(text))
    elsewhere = list(declared_elsewhere(text))
    known = {f.name for f in (*here, *elsewhere)}
    bodies = "\n".join(
        [
            *(_Derivative(f, known, width, ties).text() for f in here),
            *(_entry(f, width) for f in here if not f.linkage),
            *(_declared(f, width) for f in elsewhere),
        ]
    )
    kept = [re.sub(r" #\d+$|, !.*$", "", line) for line in text.splitlines() if re.match(r"declare |@", line)]
    declared = {match[1] for line in kept if (match := re.match(r"declare .*?(@[^( ]+)\(", line))}
    new = dict.fromkeys(re.findall(r"call (<[^>]*>|double|void) (@llvm\.[\w.]+)\(([^\n]*)\)", bodies))
    for kind, name, given in new:
        if name not in declared:
            declared.add(name)
            types = re.findall(r"(?:^|, )(<[^>]*>|double|ptr|i\d+)", given)
            kept.append(f"declare {kind} {name}({', '.join(types)})")
    return "\n".join(kept) + "\n" + bodies


def declared_elsewhere(text: str) -> Iterable[Function]:
    """Functions without a body here whose derivatives are in another module."""
    for kind, name, arguments in re.findall(r"^declare (\S+) (@[^( ]+)\(([^\n]*)\)", text, re.M):
        if ELSEWHERE in name:
            yield Function("", name, kind, tuple(map(typed, arguments.split(", "))), ())


def derivative_of(name: str) -> str:
    """The name of a function's derivative."""
    return f'@"{PREFIX}{name[1:].strip(chr(34))}"'


def entry_of(name: str) -> str:
    """The name of what calls it with the arguments of the function, whose tangents are zero."""
    return derivative_of(name).replace(PREFIX, f"call.{PREFIX}", 1)


def _entry(function: Function, width: int) -> str:
    given = ", ".join(f"{a.type} {a.value}" for a in function.arguments)
    derivative = _Derivative(function, set(), width, False)
    handed = ", ".join(derivative._arguments(function.arguments, lambda a: ZERO))
    called = f"%status = call {function.type} {derivative_of(function.name)}({handed}, {REST})"
    return (
        f"define {function.type} {entry_of(function.name)}({given}, {REST}) {{\n  {called}\n  ret {function.type} %status\n}}\n"
    )


def _declared(function: Function, width: int) -> str:
    derivative = _Derivative(function, set(), width, False)
    kinds = [kind for a in function.arguments for kind in (a.type, *[derivative.wide(a.type)] * is_floating(a.type))]
    return f"declare {function.type} {derivative_of(function.name)}({', '.join(kinds)}, i64, i64, i64)"


class _Derivative:
    """The derivative of one function. known: names of functions that have a derivative, here or elsewhere."""

    def __init__(self, function: Function, known: set[str], width: int, ties: bool):
        self.function, self.known, self.width, self.ties = function, known, width, ties
        self.lines: list[str] = []
        self.names = self.stack = 0
        self.sources = {i.result: i for i in function.body if i.result}
        self.copied = self._copied()
        self.moving = {a.value for a in function.arguments if is_floating(a.type)}
        before = -1
        while len(self.moving) > before:
            before = len(self.moving)
            self.moving |= {i.result for i in function.body if i.result and self._moves(i)}
        self.read, self.unread = read(function, self.sources) if ties else (set(), set())

    def text(self) -> str:
        """Of the derivative."""
        if is_floating(self.function.type) or "double" in self.function.type:
            raise Unsupported(f"a function that returns {self.function.type}")
        given = ", ".join(self._arguments(self.function.arguments, lambda a: self.tangent_name(a.value)))
        for i in self.function.body:
            if i.op == "alloca":
                place = self.emit(f"add i64 %stack, {8 * self.stack}")
                self.lines.append(f"  {i.result} = inttoptr i64 {place} to ptr")
                self.stack += cells(i.type)
            elif not (i.op == "call" and self._replaced(i)):
                self.lines.append(i.line)
                if i.op != "call" or not i.callee.startswith("%"):
                    self._derive(i)
        lines = "\n".join(self.lines)
        name = derivative_of(self.function.name)
        return f"define {self.function.linkage} {self.function.type} {name}({given}, {REST}) {{\n{lines}\n}}\n"

    def _arguments(self, operands: Iterable[Operand], tangent: Callable[[Operand], str]) -> list[str]:
        given = []
        for a in operands:
            given += [f"{a.type} {a.value}"] + [f"{self.wide(a.type)} {tangent(a)}"] * is_floating(a.type)
        return given

    # -- which numbers have tangents ---------------------------------------------------------------------------------
    def _copied(self) -> set[str]:
        """Integers that may be copies of numbers, or addresses of functions."""
        wanted: set[str] = set()
        for i in self.function.body:
            if (i.op == "store" and "i64" in i.type) or (i.op == "bitcast" and is_floating(i.type)):
                wanted.add(i.operands[0].value)
            elif i.op == "call" and i.callee.startswith("%") and (source := self.sources.get(i.callee)):
                wanted |= {source.operands[0].value} if source.op == "inttoptr" else {i.callee}
        before = -1
        while len(wanted) > before:
            before = len(wanted)
            for i in self.function.body:
                if i.result in wanted and i.op in MOVES:
                    wanted |= {o.value for o in i.operands}
        return wanted

    def _moves(self, i: Instruction) -> bool:
        """Whether the result of an instruction has tangents."""
        if i.op == "load":
            return (is_floating(i.type) or i.result in self.copied) and not self._is_constant(i.operands[0].value)
        if i.op in MOVES:
            counted = is_floating(i.type) or ("i64" in i.type and i.result in self.copied)
            return counted and any(o.value in self.moving for o in i.operands)
        if i.op == "call":
            name = name_of(i.callee)
            if name.startswith("masked.") and is_floating(i.type):
                return True
            return is_floating(i.type) and name not in FLAT and any(o.value in self.moving for o in i.operands)
        return i.op in PARTIALS and any(o.value in self.moving for o in i.operands)

    def _is_constant(self, pointer: str) -> bool:
        """Whether an address is in a table of constants, where nothing has tangents."""
        while (source := self.sources.get(pointer)) and source.op == "getelementptr":
            pointer = source.operands[0].value
        if (
            (source := self.sources.get(pointer))
            and source.op in ("phi", "select")
            and any("@" in o.value for o in source.operands)
        ):
            raise Unsupported("an address that is or is not one of a constant")
        return "@" in pointer

    # -- writing -----------------------------------------------------------------------------------------------------
    def emit(self, text: str, name: str = "") -> str:
        """One more instruction; returns the name of its result."""
        self.names += 1
        name = name or f'%"t.{self.names}"'
        self.lines.append(f"  {name} = {text}")
        return name

    def tangent_name(self, value: str) -> str:
        """The name of a value's tangents."""
        return f'%"{PREFIX}{value[1:].strip(chr(34))}"'

    def wide(self, kind: str) -> str:
        """The type of the tangents of a type."""
        if self.width == 1:
            return kind
        element = re.sub(r"<\d+ x (.*)>", r"\1", kind)
        return f"<{max(lanes(kind), 1) * self.width} x {element}>"

    def tangent(self, o: Operand) -> str:
        """The tangents of an operand."""
        return self.tangent_name(o.value) if o.value in self.moving else ZERO

    def spread(self, kind: str, value: str) -> str:
        """A value once for each direction."""
        if self.width == 1:
            return value
        n, wide = lanes(kind), self.wide(kind)
        if value.startswith("splat"):
            return value
        if n == 0:
            kind, n = f"<1 x {kind}>", 1
            value = self.emit(f"insertelement {kind} poison, {wide.split(' x ')[1][:-1]} {value}, i64 0")
        order = ", ".join(f"i32 {k // self.width}" for k in range(n * self.width))
        return self.emit(f"shufflevector {kind} {value}, {kind} poison, <{n * self.width} x i32> <{order}>")

    def shadow(self, pointer: str) -> str:
        """Where the tangents of the cell at an address stand."""
        if self.width == 1:
            return self.emit(f"getelementptr i8, ptr {pointer}, i64 %offset")
        address = self.emit(f"ptrtoint ptr {pointer} to i64")
        address = self.emit(f"mul i64 {address}, {self.width}")
        address = self.emit(f"add i64 {address}, %offset")
        return self.emit(f"inttoptr i64 {address} to ptr")

    # -- the derivative of each kind of instruction ------------------------------------------------------------------
    def _derive(self, i: Instruction) -> None:
        if i.op == "store":
            if (is_floating(i.type) or "i64" in i.type) and not self._is_constant(i.operands[1].value):
                place = self.shadow(i.operands[1].value)
                self.lines.append(f"  store {self.wide(i.type)} {self.tangent(i.operands[0])}, ptr {place}, align 8")
        elif i.op == "call":
            self._call(i)
        elif i.op == "fcmp" and not re.search(r" fcmp (?:uno|ord) ", i.line):  # whether it is a number at all
            self._note_kink(i, [o.value for o in i.operands], [self.tangent(o) for o in i.operands])
        elif i.op == "bitcast" and is_floating(i.type) and i.operands[0].value not in self.moving:
            if i.operands[0].value.startswith("%"):
                raise Unsupported(f"a number that is made of bits: {i.line.strip()}")
        elif i.result in self.moving:
            if i.op in PARTIALS:
                self._chain(i, i.op)
            else:
                self._move(i, self.tangent_name(i.result))

    def _move(self, i: Instruction, name: str) -> None:
        wide, width = self.wide(i.type), self.width
        values = [self.tangent(o) for o in i.operands]
        kinds = [self.wide(o.type) for o in i.operands]
        if i.op == "load":
            self.emit(f"load {wide}, ptr {self.shadow(i.operands[0].value)}, align 8", name)
        elif i.op == "phi":
            self.emit(f"phi {wide} {', '.join(f'[ {v}, {at} ]' for v, at in zip(values, i.labels, strict=True))}", name)
        elif i.op == "select":
            kind, condition = i.operands[0]
            if lanes(kind) and width > 1:
                kind, condition = self.wide(kind), self.spread(kind, condition)
            self.emit(f"select {kind} {condition}, {wide} {values[1]}, {wide} {values[2]}", name)
        elif i.op == "freeze":
            self.emit(f"freeze {wide} {values[0]}", name)
        elif i.op == "bitcast":
            self.emit(f"bitcast {kinds[0]} {values[0]} to {wide}", name)
        elif i.op == "shufflevector":
            mask = _mask(i.operands[2], lanes(i.type))
            order = ", ".join("i32 poison" if m < 0 else f"i32 {width * m + k}" for m in mask for k in range(width))
            size = width * len(mask)
            self.emit(f"shufflevector {kinds[0]} {values[0]}, {kinds[1]} {values[1]}, <{size} x i32> <{order}>", name)
        elif width == 1:
            index = i.operands[-1]
            inner = f", {kinds[1]} {values[1]}" if i.op == "insertelement" else ""
            self.emit(f"{i.op} {kinds[0]} {values[0]}{inner}, {index.type} {index.value}", name)
        else:
            self._element(i, values, kinds, name)

    def _element(self, i: Instruction, values: list[str], kinds: list[str], name: str) -> None:
        """The tangents of an element that is put into a vector, or taken from it."""
        width, index = self.width, i.operands[-1].value
        if not index.isdigit():
            raise Unsupported(f"an element of a vector by a variable: {i.line.strip()}")
        first, n = width * int(index), width * lanes(i.operands[0].type)
        if i.op == "extractelement":
            order = ", ".join(f"i32 {first + k}" for k in range(width))
            self.emit(f"shufflevector {kinds[0]} {values[0]}, {kinds[0]} poison, <{width} x i32> <{order}>", name)
            return
        order = ", ".join(f"i32 {k if k < width else 0}" for k in range(n))
        whole = self.emit(f"shufflevector {kinds[1]} {values[1]}, {kinds[1]} poison, <{n} x i32> <{order}>")
        order = ", ".join(f"i32 {n + k - first if first <= k < first + width else k}" for k in range(n))
        self.emit(f"shufflevector {kinds[0]} {values[0]}, {kinds[0]} {whole}, <{n} x i32> <{order}>", name)

    def _chain(self, i: Instruction, rule: str) -> None:
        """The sum of partial derivatives times tangents."""
        numbers = [Number(self.emit, i.type, o.value) for o in (*i.operands, Operand(i.type, i.result))]
        partials, terms = PARTIALS[rule](*numbers), []
        wide, zero = self.wide(i.type), constant(self.wide(i.type), 0.0)
        for partial, o in zip(partials, i.operands, strict=True):
            if o.value not in self.moving:
                continue
            tangent = self.tangent(o)
            if partial == -1.0:
                term = self.emit(f"fneg {wide} {tangent}")
            elif partial == 1.0:
                term = tangent
            else:
                term = self.emit(f"fmul {wide} {self.spread(i.type, partial.value)}, {tangent}")
            if rule in SINGULAR:
                still = self.emit(f"fcmp oeq {wide} {tangent}, {zero}")
                term = self.emit(f"select {_truth(wide)} {still}, {wide} {zero}, {wide} {term}")
            terms.append(term)
        total = terms[0]
        for term in terms[1:]:
            total = self.emit(f"fadd {wide} {total}, {term}")
        if rule == "hypot":  # at the origin the length of the tangents: one-sided
            squares = [self.emit(f"fmul {wide} {self.tangent(o)}, {self.tangent(o)}") for o in i.operands]
            length = self.emit(intrinsic("sqrt", wide, self.emit(f"fadd {wide} {squares[0]}, {squares[1]}")))
            self._note_kink(i, [i.result, constant(i.type, 0.0)], [length])
            origin = self.emit(f"fcmp oeq {i.type} {i.result}, {constant(i.type, 0.0)}")
            origin = self.spread(_truth(i.type), origin)
            total = self.emit(f"select {_truth(wide)} {origin}, {wide} {length}, {wide} {total}")
        self.emit(f"freeze {wide} {total}", self.tangent_name(i.result))

    def _call(self, i: Instruction) -> None:
        name, result = name_of(i.callee), self.tangent_name(i.result) if i.result else ""
        if name.startswith(("memcpy", "memmove", "memset")):
            self._copy(i, name)
        elif name.startswith("masked."):
            self._masked(i, name, result)
        elif name in ("floor", "ceil", "trunc"):  # at a whole number they jump
            self._note_tie(i.type, [i.operands[0].value, i.result], [self.tangent(i.operands[0])])
        elif i.result in self.moving:
            rule = SAME.get(name, name)
            if rule in PARTIALS:
                self._chain(i, rule)
            elif name in KINKED:
                self._kink(i, name, result)
            else:
                raise Unsupported(f"the function {name}")
        elif any(o.value in self.moving and is_floating(o.type) for o in i.operands) and name not in FLAT:
            raise Unsupported(f"the function {name}")

    def _note_kink(self, i: Instruction, values: list[str], tangents: list[str]) -> None:
        """The same where the result counts."""
        if i.result in self.read:
            self._note_tie(i.type, values, tangents)

    def _note_tie(self, kind: str, values: list[str], tangents: list[str]) -> None:
        """Set the bits of directions that move two numbers apart which are equal, and compared.

        A number that only decisions read may have kinks behind it: it is taken to move.
        """
        tangents = [t for t in tangents if t != ZERO]
        if not tangents or not self.ties:
            return
        wide, n = self.wide(kind), max(lanes(kind), 1)
        apart = self.emit(f"fsub {wide} {', '.join(tangents)}") if len(tangents) == 2 else tangents[0]
        order = "true" if self.unread.intersection(values) else "une"
        apart = self.emit(f"fcmp {order} {wide} {apart}, {constant(wide, 0.0)}")
        equal = self.emit(f"fcmp oeq {kind} {', '.join(values)}")
        none = "false" if wide == "double" else ZERO
        bits = self.emit(f"select {self._spread_truth(kind, equal)}, {_truth(wide)} {apart}, {_truth(wide)} {none}")
        if wide != "double":
            bits = self.emit(f"bitcast {_truth(wide)} {bits} to i{n * self.width}")
        wanted = self.emit("inttoptr i64 %ties to ptr")
        bits = bits if n * self.width == 64 else self.emit(f"zext i{n * self.width} {bits} to i64")
        known = self.emit(f"load i64, ptr {wanted}, align 8")
        self.lines.append(f"  store i64 {self.emit(f'or i64 {known}, {bits}')}, ptr {wanted}, align 8")

    def _copy(self, i: Instruction, name: str) -> None:
        to, what, size, *_ = i.operands
        if size.value.isdigit() and int(size.value) % 8:
            return  # truth values: numbers have whole cells
        place, size_of = self.shadow(to.value), self.emit(f"mul i64 {size.value}, {self.width}")
        if name.startswith("memset") or self._is_constant(what.value):
            self.lines.append(f"  call void @llvm.memset.p0.i64(ptr {place}, i8 0, i64 {size_of}, i1 false)")
        else:
            begin = self.shadow(what.value)
            self.lines.append(f"  call void {i.callee}(ptr {place}, ptr {begin}, i64 {size_of}, i1 false)")

    def _masked(self, i: Instruction, name: str, result: str) -> None:
        """Loads and stores of those elements of a vector that a mask has."""
        if not any(is_floating(o.type) for o in (*i.operands, Operand(i.type, ""))):
            return
        operands = list(i.operands)
        at = 1 if name.startswith(("masked.store", "masked.scatter")) else 0
        pointer = operands[at]
        if lanes(pointer.type):
            place = self._shadows(pointer)
        else:
            place = f"ptr align 8 {self.shadow(pointer.value)}"
        given = []
        for k, o in enumerate(operands):
            if k == at:
                given.append(f"{place}")
            elif is_floating(o.type):
                given.append(f"{self.wide(o.type)} {self.tangent(o)}")
            elif o.type.endswith("x i1>"):
                given.append(f"{self.wide(o.type)} {self.spread(o.type, o.value)}")
            else:
                given.append(f"{o.type} {o.value}")
        n = lanes(self.wide(i.type if i.result else operands[0].type))
        kind = name.partition(".v")[0]
        pointers = f"v{n}p0" if lanes(pointer.type) else "p0"
        suffix = f"v{n}f64.{pointers}"
        call = f"call {self.wide(i.type) if i.result else 'void'} @llvm.{kind}.{suffix}({', '.join(given)})"
        if i.result:
            self.emit(call, result)
        else:
            self.lines.append(f"  {call}")

    def _shadows(self, pointers: Operand) -> str:
        """Where the tangents of the cells at addresses in a vector stand, with their type."""
        n, width = lanes(pointers.type), self.width
        kind, wide = f"<{n} x i64>", f"<{n * width} x i64>"
        address = self.emit(f"ptrtoint {pointers.type} {pointers.value} to {kind}")
        address = self.emit(f"mul {kind} {address}, splat (i64 {width})")
        base = self.spread("i64", "%offset") if width > 1 else "%offset"
        if n * width > 1:
            one = self.emit("insertelement <1 x i64> poison, i64 %offset, i64 0")
            base = self.emit(f"shufflevector <1 x i64> {one}, <1 x i64> poison, <{n * width} x i32> zeroinitializer")
        address = self.emit(f"add {wide} {self.spread(kind, address)}, {base}")
        steps = ", ".join(f"i64 {8 * (k % width)}" for k in range(n * width))
        address = self.emit(f"add {wide} {address}, <{steps}>")
        return f"<{n * width} x ptr> align 8 " + self.emit(f"inttoptr {wide} {address} to <{n * width} x ptr>")

    def _kink(self, i: Instruction, name: str, result: str) -> None:
        """Of what is smooth but for one point: there the derivative along the direction."""
        kind, wide = i.type, self.wide(i.type)
        one = i.operands[0]
        a = self.tangent(one)
        if name == "fabs":
            self._note_kink(i, [one.value, constant(kind, 0.0)], [a])
        if name in ("fabs", "copysign"):
            other = constant(kind, 0.0) if name == "fabs" else i.result
            same = self.emit(f"fcmp {'ogt' if name == 'fabs' else 'oeq'} {kind} {one.value}, {other}")
            back = self.emit(f"fneg {wide} {a}")
            total = self.emit(f"select {self._spread_truth(kind, same)}, {wide} {a}, {wide} {back}")
            if name == "fabs":
                zero = self.emit(f"fcmp oeq {kind} {one.value}, {constant(kind, 0.0)}")
                size = self.emit(intrinsic("fabs", wide, a))
                total = self.emit(f"select {self._spread_truth(kind, zero)}, {wide} {size}, {wide} {total}")
            self.emit(f"freeze {wide} {total}", result)
            return
        two = i.operands[1]
        b, largest = self.tangent(two), "max" in name
        self._note_kink(i, [one.value, two.value], [a, b])
        first = self.emit(f"fcmp {'ogt' if largest else 'olt'} {kind} {one.value}, {two.value}")
        total = self.emit(f"select {self._spread_truth(kind, first)}, {wide} {a}, {wide} {b}")
        tie = self.emit(f"fcmp oeq {kind} {one.value}, {two.value}")
        side = self.emit(intrinsic("maxnum" if largest else "minnum", wide, a, b))
        self.emit(f"select {self._spread_truth(kind, tie)}, {wide} {side}, {wide} {total}", result)

    def _spread_truth(self, kind: str, value: str) -> str:
        truth = _truth(kind)
        return f"{self.wide(truth)} {self.spread(truth, value)}" if lanes(kind) else f"i1 {value}"

    def _replaced(self, i: Instruction) -> bool:
        """Whether a call was replaced by one of the derivative, which computes the numbers, too."""
        if name_of(i.callee).startswith(NO_NUMBERS):
            return True
        indirect = i.callee.startswith("%")
        if not indirect and i.callee not in self.known:
            return False
        if any(o.type == "ptr" and self._is_constant(o.value) for o in i.operands):
            raise Unsupported(f"a function that is given the address of a constant: {i.callee}")
        called = self._called(i) if indirect else derivative_of(i.callee)
        given = self._arguments(i.operands, self.tangent)
        stack = self.emit(f"add i64 %stack, {8 * self._room}")
        name = f"{i.result} = " if i.result else ""
        self.lines.append(f"  {name}call {i.type} {called}({', '.join([*given, 'i64 %offset', f'i64 {stack}', 'i64 %ties'])})")
        return True

    @property
    def _room(self) -> int:
        """Cells of the stack that this function uses."""
        return sum(cells(i.type) for i in self.function.body if i.op == "alloca")

    def _called(self, i: Instruction) -> str:
        """The derivative of a function that is called by address."""
        source = self.sources.get(i.callee)
        value = source.operands[0].value if source and source.op == "inttoptr" else i.callee
        if value not in self.moving:
            raise Unsupported(f"a call of an address: {i.line.strip()}")
        address, kind = self.tangent_name(value), self.sources[value].type
        if self.width > 1:
            address = self.emit(f"extractelement {self.wide(kind)} {address}, i64 0")
        return address if kind == "ptr" else self.emit(f"inttoptr i64 {address} to ptr")


def _truth(kind: str) -> str:
    """The type of a comparison."""
    return kind.replace("double", "i1")


def _mask(operand: Operand, size: int) -> list[int]:
    """The order of a `shufflevector`; -1 where anything will do."""
    if operand.value == ZERO:
        return [0] * size
    if operand.value.startswith("splat"):
        return [int(re.search(r"i32 (\d+)", operand.value)[1])] * size  # type: ignore[index]
    return [int(m) if m.isdigit() else -1 for m in re.findall(r"i32 (\w+)", operand.value)]
