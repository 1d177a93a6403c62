"""The two ways things go wrong: the user's input, and a step that cannot be completed."""

import re

DECIMAL_COMMA = re.compile(r"(?<![\w.,])[-+]?\d+,\d+(?:e[-+]?\d+)?(?![\d,.])", re.IGNORECASE)
UNSEEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


class BadInput(ValueError):
    """Something the user gave cannot be used. The message: PLACE: got ACTUAL, expected EXPECTED. REMEDY.

    Without `expected`, `actual` is a sentence of its own: PLACE: SENTENCE. REMEDY.
    """

    def __init__(self, where: str, actual: str, expected: str, remedy: str = ""):
        self.where, self.actual, self.expected, self.remedy = where, actual, expected, remedy
        super().__init__(visible(f"{where}: {refusal_text(actual, expected, remedy)}"))


def refusal_text(actual: str, expected: str, remedy: str = "") -> str:
    """The words of a refusal, without its place."""
    sentence = f"got {actual}, expected {expected}" if expected else actual
    return f"{sentence}. {remedy}" if remedy else sentence


class StepFailed(RuntimeError):
    """A unit could not complete a step: who, when, why, and what may help."""

    def __init__(self, unit: str, time: float, reason: str, remedy: str = ""):
        self.unit, self.time, self.reason, self.remedy = unit, time, reason, remedy
        super().__init__(visible_lines(f"{unit} failed at t = {time:.9g} s: {reason}" + (f". {remedy}" if remedy else "")))


def visible(text: str) -> str:
    """The text with line ends and control characters escaped: names from files and texts of foreign code may hold any."""
    return text if text.isprintable() else "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def visible_lines(text: str) -> str:
    """The same for a text of several lines, such as a failure and its log."""
    return "\n".join(map(visible, text.split("\n")))


def visible_in_page(page: str) -> str:
    """A page or drawing, in which characters that nobody sees, or that turn the direction of writing, stand as their numbers.

    The numbers mean the same in markup and in the strings of a script.
    """
    return UNSEEN.sub(lambda match: f"\u27e8{ord(match[0]):04X}\u27e9", page)


def counted(count: int, what: str) -> str:
    """A number of things in words: "1 support", "2 supports"."""
    return f"{count} {what}" + ("" if count == 1 else "s")


def nearest(name: str, names) -> str:
    """The part of a message that helps with a misspelt name: the near ones, or all of a short list, or a few of a long one."""
    from difflib import SequenceMatcher, get_close_matches

    names = list(dict.fromkeys(names))
    last = name.rpartition(".")[2]
    same = [other for other in names if "." in name and other.rpartition(".")[2] == last]  # as "total_force" of whichever part
    near = get_close_matches(name, same, n=3, cutoff=0.5) or get_close_matches(name, names, n=3, cutoff=0.5)
    likeness = [SequenceMatcher(None, name, other).ratio() for other in near]
    near = [other for other, ratio in zip(near, likeness, strict=True) if ratio > likeness[0] - 0.1]
    if near:
        return "Did you mean " + " or ".join(repr(n) for n in near) + "?"
    if len(names) > 12:
        return f"The nearest of {len(names)} names are " + ", ".join(get_close_matches(name, names, n=3, cutoff=0.0))
    return "There is " + (", ".join(names) or "none")


def decimal_point(text: object) -> str:
    """The remedy for a number with a decimal comma; "" for a text that has none."""
    match = DECIMAL_COMMA.search(text) if isinstance(text, str) else None
    if match is None:
        return ""
    whole, point = match[0].replace(",", ""), match[0].replace(",", ".")
    if re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}", match[0]):  # a comma of thousands, or of decimals: a factor of 1000
        return f"Write {point}, with a decimal point, or {whole}, without a sign for thousands."
    return f"Write {point}, with a decimal point."


def syntax_remedy(text: str, error: ValueError) -> str:
    """The remedy for an error of syntax of TOML, where its line has a number with a decimal comma; else ""."""
    line = re.search(r"line (\d+)", str(error))
    return decimal_point(text.splitlines()[int(line[1]) - 1].partition("#")[0]) if line else ""


def pick(name, known, where: str, expected: str, what: str = ""):
    """What a mapping has under a name, or the name itself of any other collection; raises `BadInput` with the near names.

    what: the name is of, as in "unit".
    """
    if name in known:
        return known[name] if hasattr(known, "keys") else name
    remedy = nearest(str(name), known)
    if remedy.startswith("There is") and all(str(each) in expected for each in known):
        remedy = ""  # they stand there already
    raise BadInput(where, f"{what} {name!r}".strip(), expected, remedy)
