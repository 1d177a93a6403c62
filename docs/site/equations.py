"""Equations of docstrings, written as text, in LaTeX: `m1 z1'' = k1 (z2 - z1)` with dots, indices and fractions.

Source and terminal show the text, the site the formula. The notation: a prime is a derivative by time, an index stands behind `_` or
as a digit, a product is a space, `a/b` without spaces binds closer than a product, ` / ` divides the product before it by the factor
behind it, two spaces or more separate what stands beside each other, and words are words.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

NAMES_OF_LETTERS = (
    "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi rho sigma tau phi psi omega Delta Omega Phi"
)
GREEK = {name: f"\\{name}" for name in re.findall(r"\w+", NAMES_OF_LETTERS)}
GREEK |= {"eps": "\\varepsilon", "pi": "\\pi", "th": "\\theta", "Om": "\\Omega"}
FUNCTIONS = {n: f"\\{n}" for n in ("sin", "cos", "tan", "exp", "max", "min", "ln", "log")} | {
    "sum": "\\sum",
    "agm": "\\mathrm{agm}",
}
OPERATORS = {
    "<=": "\\le",
    ">=": "\\ge",
    "->": "\\to",
    "~": "\\propto",
    "*": "\\cdot",
    "·": "\\cdot",
    "×": "\\times",
    "±": "\\pm",
    "%": "\\%",
    ".": "\\cdot",
    "...": "\\dots",
    "..": "\\dots",
    "<": "\\lt ",
    ">": "\\gt ",
}
SHORT_WORDS = set(re.findall(r"\w+", "in of as is up to at or it no on by if an be we so do us ms kN Hz mm km nm rpm"))
ARTICLES = {"a", "A", "I"}
OPERATOR = r"[-+=*/<>·×~±]|<=|>="
POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<number>\d+(?:\.\d+)?(?:e-?\d+)?)|(?P<code>`[^`]*`)|(?P<index>_[A-Za-z0-9]+)"
    r"|(?P<name>[A-Za-z]{3,}(?:-[A-Za-z]{3,})+|[A-Za-zα-ωΑ-Ωäöüńąć][A-Za-z0-9äöüńąć]*(?:_[A-Za-z0-9]+(?:\+1)?)*)"
    r"|(?P<primes>'+)|(?P<power>[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)|(?P<operator><=|>=|->|\.\.\.|\.\.|[-+=*/^·×±<>~,;:%.!?])|(?P<bracket>[()\[\]|])"
)


class NotAnEquation(ValueError):
    """What the notation does not have."""


def name_to_latex(name: str) -> str:
    """A symbol or a word: z1, theta_j, T_load, kc, EI, friction."""
    base, _, index = name.partition("_")
    if digits := re.fullmatch(r"([A-Za-z]{1,2}|" + "|".join(GREEK) + r")(\d+)", base):
        base, index = digits[1], digits[2] + ("," + index if index else "")
    if base in FUNCTIONS:
        return FUNCTIONS[base] if base in ("sum", "agm") else f"\\,{FUNCTIONS[base]}\\,"
    if base in GREEK:
        return GREEK[base] + _index(index)
    if len(base) == 1:
        return base + _index(index)
    if len(base) == 2 and base[1].islower() and base not in SHORT_WORDS:
        return base[0] + _index(base[1] + ("," + index if index else ""))
    if len(base) == 2 and base.isupper():
        return base + _index(index)
    if len(index) == 1:
        return f"\\mathrm{{{base}}}_{{{index}}}"
    return "\\text{" + name.replace("_", " ") + "}"


def _index(index: str) -> str:
    if not index:
        return ""
    parts = [
        GREEK.get(p, p if len(p) == 1 or p.isdigit() or "+" in p or set(p) <= {"x", "t"} else f"\\mathrm{{{p}}}")
        for p in re.split("[,_]", index)
    ]
    return "_{" + ",".join(parts) + "}"


def is_symbol(name: str) -> bool:
    """Whether a name is a symbol and no word."""
    return not name_to_latex(name).startswith("\\text")


@dataclass
class _Reader:
    """One line. Factors of the present product are kept in `factors`, so that a slash finds its numerator."""

    tokens: list[tuple[str, str]]
    at: int = 0
    closers: list[str] = field(default_factory=list)

    def peek(self, ahead: int = 0) -> tuple[str, str]:
        return self.tokens[self.at + ahead] if self.at + ahead < len(self.tokens) else ("end", "")

    def take(self) -> tuple[str, str]:
        token = self.peek()
        self.at += 1
        return token

    def sequence(self, closer: str = "") -> str:
        """Products with operators between them, up to a closing bracket, which is taken."""
        written: list[str] = []
        factors: list[str] = []
        while True:
            kind, text = self.peek()
            if kind == "end":
                if closer:
                    raise NotAnEquation(f"no {closer!r}")
                break
            if text == closer and kind == "bracket":
                self.take()
                break
            if kind == "space":
                self.take()
                if len(text) > 1 and self.peek()[1] != "=":
                    written += [*factors, "\\quad"]
                    factors = []
            elif text == "/":
                self._divide(factors)
            elif text == "^":
                self.take()
                factors.append(f"{self._last(factors)}^{{{_bare(self.factor())}}}")
            elif kind == "operator":
                self.take()
                spaced = text != "." or self.peek()[0] == "space"
                written += [*factors, OPERATORS.get(text, text) if spaced else text]
                factors = []
            else:
                factors.append(self.factor())
        return _spaced([*written, *factors])

    def _last(self, factors: list[str]) -> str:
        if not factors:
            raise NotAnEquation("nothing before a sign")
        return factors.pop()

    def _divide(self, factors: list[str]) -> None:
        spaced = self.peek(-1)[0] == "space"
        self.take()
        while self.peek()[0] == "space":
            self.take()
        if spaced:
            begin = max((k + 1 for k, f in enumerate(factors) if f.startswith("\\sum")), default=0)  # a sum is of quotients
            numerator, factors[begin:] = _spaced(factors[begin:]), []
        else:
            numerator = self._last(factors)
        if not numerator:
            raise NotAnEquation("nothing to divide")
        factors.append(f"\\frac{{{_bare(numerator)}}}{{{_bare(self.factor())}}}")

    def factor(self) -> str:
        """A number, a symbol with what hangs on it, or something in brackets."""
        kind, text = self.take()
        if kind == "bracket" and text in "([|":
            closer = {"(": ")", "[": "]", "|": "|"}[text]
            inner = self.sequence(closer)
            index = _index(self.take()[1][1:]) if self.peek()[0] == "index" else ""
            left, right = ("\\vert ", "\\vert ") if text == "|" else (text, closer)
            if self.peek()[0] == "primes":
                self.take()
                return f"\\frac{{d}}{{dt}} \\left{left}{inner}\\right{right}{self._power()}"
            return f"\\left{left}{inner}\\right{right}{index}{self._power()}"
        if kind == "code":
            return f"\\text{{{text[1:-1].replace('_', ' ')}}}"
        if kind == "number":
            return text + self._power()
        if kind != "name":
            raise NotAnEquation(f"{text!r} where a factor is expected")
        if text == "sqrt" and self.peek()[1] == "(":
            self.take()
            return f"\\sqrt{{{self.sequence(')')}}}"
        if text == "sum" and self.peek(1)[1] in ("of", "over"):
            over = self.peek(1)[1] == "over"
            self.at += 2
            if not over:
                return "\\sum"
            self.take()
            return f"\\sum_{{\\text{{{self.take()[1]}}}}}"
        written = self._dotted(name_to_latex(text)) + self._power()
        if self.peek() == ("bracket", "(") and is_symbol(text):  # of a function
            return written + self.factor()
        return written

    def _dotted(self, symbol: str) -> str:
        if self.peek()[0] != "primes":
            return symbol
        dots = len(self.take()[1])
        base, index, rest = symbol.partition("_{")
        return {1: "\\dot", 2: "\\ddot"}.get(dots, "\\dddot") + f"{{{base}}}{index}{rest}"

    def _power(self) -> str:
        if self.peek()[0] != "power":
            return ""
        return f"^{{{self.take()[1].translate(POWERS)}}}"


def _spaced(factors: list[str]) -> str:
    """Side by side, words as one text, with room between words and symbols."""
    parts: list[str] = []
    for k, factor in enumerate(factors):
        words = factor.startswith("\\text{")
        before = parts[-1] if parts else ""
        article = (
            factor in ARTICLES
            and before.startswith("\\text{")
            and factors[k + 1 : k + 2]
            and factors[k + 1].startswith("\\text{")
        )
        if (words or article) and before.startswith("\\text{"):
            parts[-1] = f"{before[:-1]} {factor[6:-1] if words else factor}}}"
        elif (
            words != before.startswith("\\text{")
            and before
            and not re.fullmatch(r"[,;:]|\\quad", before)
            and not re.fullmatch(r"[,;:]", factor)
        ):
            parts += ["\\;", factor]
        else:
            parts.append(factor)
    return " ".join(parts)


def _bare(factor: str) -> str:
    """Without brackets around all of it, which a fraction or a power does not need."""
    if not (factor.startswith("\\left(") and factor.endswith("\\right)")):
        return factor
    depth = 0
    for match in re.finditer(r"\\left|\\right", factor):
        depth += 1 if match[0] == "\\left" else -1
        if depth == 0 and match.end() < len(factor) - 1:
            return factor
    return factor[len("\\left(") : -len("\\right)")]


def tokens_of(text: str) -> list[tuple[str, str]]:
    """(kind, text) of each; raises NotAnEquation where a sign is in none."""
    tokens, at = [], 0
    while at < len(text):
        match = TOKEN.match(text, at)
        if not match:
            raise NotAnEquation(f"{text[at]!r} in {text!r}")
        tokens.append((str(match.lastgroup), match[0]))
        at = match.end()
    return tokens


def latex(line: str) -> str:
    """One line as LaTeX; raises NotAnEquation."""
    if "[[" in line:
        return _with_matrix(line)
    reader = _Reader(tokens_of(line.strip()))
    return reader.sequence()


def _with_matrix(line: str) -> str:
    """A line with matrices written as [[a, b], [c, d]]."""
    parts = re.split(r"(\[\[.*?\]\])", line)
    for k in range(1, len(parts), 2):
        rows = [" & ".join(map(latex, re.split(r", (?![^(]*\))", row))) for row in parts[k][2:-2].split("], [")]
        parts[k] = "\\left[\\begin{matrix}" + " \\\\ ".join(rows) + "\\end{matrix}\\right]"
    return " ".join(latex(part) if k % 2 == 0 else part for k, part in enumerate(parts) if part.strip())


def block(text: str) -> str:
    """Lines below one another as a formula in Markdown; raises NotAnEquation."""
    lines = [line for line in text.splitlines() if line.strip()]
    least = min(len(line) - len(line.lstrip()) for line in lines)
    rows = [("\\quad " if len(line) - len(line.lstrip()) > least else "") + "\\displaystyle " + latex(line) for line in lines]
    if len(rows) == 1:
        return f"$$\n{rows[0]}\n$$"
    return "$$\n\\begin{array}{l}\n" + " \\\\\n".join(rows) + "\n\\end{array}\n$$"


# -- in sentences -----------------------------------------------------------------------------------------------------------------
SYMBOL = re.compile(r"(?:[A-Za-z]|" + "|".join(GREEK) + r")\d?(?:_[A-Za-z0-9]+(?:\+1)?)?")
UNITS = set(re.findall(r"\w+", "N m s W K J kg V A rad Hz Pa mm g h l km kN"))
SIGNS = re.compile(r"[=+/*<>^·×~²³⁴']|(?:^|\s)-(?:\s|$)|sqrt\(")


def symbols_of(text: str) -> set[str]:
    """Names in equations that are symbols."""
    return {m[0] for m in re.finditer(r"[A-Za-z]\w*", text) if is_symbol(m[0]) and m[0] not in FUNCTIONS}


def sentences(text: str, symbols: set[str], write: Callable[[str], str] = str) -> str:
    """Prose with its formulas as $LaTeX$; symbols: those of the equations beside it. write: what becomes of the words."""
    words = re.split(r"(\s+|`[^`]*`)", text)
    mathy = [k % 2 == 0 and _is_mathy(word, symbols) for k, word in enumerate(words)]
    out, k = [], 0
    while k < len(words):
        if not mathy[k]:
            out.append(write(words[k]))
            k += 1
            continue
        end = k
        while end + 2 < len(words) and mathy[end + 2] and (_is_open(words[k : end + 1]) or not re.search(r"[,;:.]$", words[end])):
            end += 2
        preceded = bool(out) and bool(re.search(r"\d\s*$", "".join(out[-2:])))
        out.append(_formula(words[k : end + 1], symbols, preceded, write))
        k = end + 1
    return "".join(out)


def _is_open(words: list[str]) -> bool:
    """Whether a bracket is open behind the words, in which a comma does not end the formula."""
    text = "".join(words)
    return text.count("(") > text.count(")")


def _is_mathy(word: str, symbols: set[str]) -> bool:
    try:
        tokens = tokens_of(word.rstrip(",;:."))
    except NotAnEquation:
        return False
    names = [text for kind, text in tokens if kind == "name"]
    if any(n not in symbols and n not in FUNCTIONS and n != "sqrt" and n not in GREEK and not SYMBOL.fullmatch(n) for n in names):
        return False
    return bool(tokens)


def _formula(words: list[str], symbols: set[str], preceded: bool, write: Callable[[str], str]) -> str:
    """A run of words, all of symbols, numbers and signs: a formula where it has a sign or is one known symbol, else as it is."""
    before, after = "", ""
    while words and (
        words[0].isspace() or re.fullmatch(OPERATOR, words[0]) or (_is_loose(words) and not _joined(words[1:2], words[2:3]))
    ):
        before, words = before + words[0], words[1:]
    while words and (
        words[-1].isspace()
        or re.fullmatch(OPERATOR, words[-1])
        or (words[-1] in ARTICLES and not _joined(words[-2:-1], words[-3:-2]))
    ):
        after, words = words[-1] + after, words[:-1]
    preceded |= bool(re.search(r"\d\s*$", before))
    body = "".join(words)
    tail = re.search(r"[,;:.]*$", body)[0]
    body = body[: len(body) - len(tail)]
    while body.count(")") > body.count("(") and body.endswith(")"):
        body, tail = body[:-1], ")" + tail
    while body.count("(") > body.count(")") and body.startswith("("):
        body, before = body[1:], before + "("
    known = (body in symbols or re.fullmatch(r"[A-Za-z]_\w+", body)) and body not in ARTICLES and not preceded
    names = {text for kind, text in _safe_tokens(body) if kind == "name"}
    measure = names <= UNITS and (preceded or re.match(r"\d", body) or re.fullmatch(r"\(?\w+/\w+\)?|[ms][²³]", body))
    if known or (names and not measure and SIGNS.search(body) and not re.fullmatch(r"[A-Za-z]'?s?|[a-z]/[a-z]", body)):
        try:
            return write(before) + "$" + latex(body) + "$" + write(tail + after)
        except NotAnEquation:
            pass
    return write(before + body + tail + after)


def _is_loose(words: list[str]) -> bool:
    """Whether the first word is an article, or a number that belongs to a unit of measure or to nothing."""
    number = re.fullmatch(r"[\d.,%()-]+", words[0])
    return words[0] in ARTICLES or bool(number and (not words[2:3] or re.sub(r"\W", "", words[2].partition("/")[0]) in UNITS))


def _joined(space: list[str], following: list[str]) -> bool:
    return bool(space and following and re.match(r"[-+=/*<>^·~]", following[0]))


def _safe_tokens(text: str) -> list[tuple[str, str]]:
    try:
        return tokens_of(text)
    except NotAnEquation:
        return []
