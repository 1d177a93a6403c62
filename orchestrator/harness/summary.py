"""The figures of a run in numbers: what a user of its system asks first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from math import ceil, floor, inf, isfinite, isnan, log10, nan
from typing import Any

from ...components.core.errors import BadInput, nearest
from ..run.run_record import MeshRecord, Pace, ParametersRecord, RunRecord, VerificationRecord
from .preferred_units import preferred


@dataclass(frozen=True)
class SummaryRow:
    """One number of a run. name: "unit.quantity", unique in a run.  text: what it is, with how it was made where that matters.

    error: its numerical error, in the same unit; NaN where the run was not verified, or the error is not known.  covers: what makes it.
    parameters: its standard deviation by the tolerances of the scene's parameters; NaN without any, or where it is not known.
    part: of what is judged as a whole only, such as one wire of two: never what a run is judged by.
    """

    name: str
    value: float
    unit: str
    text: str
    error: float = nan
    part: bool = False
    covers: str = "steps"
    parameters: float = nan

    @property
    def shown(self) -> str:
        """The number as it is printed, with its errors where these are known."""
        return with_errors_of(self.value, self.error, self.parameters, self.covers)

    def for_reader(self, size: float = nan) -> SummaryRow:
        """The row in the unit that a person reads. size: the largest number beside which it stands; default: its own."""
        unit, factor = preferred(self.unit, size if isfinite(size) else abs(self.value), self.name)
        return replace(self, value=self.value * factor, error=self.error * factor, parameters=self.parameters * factor, unit=unit)

    def to_json(self) -> dict[str, Any]:
        """The row of summary.json; a number that is not finite is null."""
        return {
            "value": self.value if isfinite(self.value) else None,
            "error": self.error if isfinite(self.error) else None,
            "unit": self.unit,
            "text": self.text,
            **({"part": True} if self.part else {}),
            **({"parameters": self.parameters} if isfinite(self.parameters) else {}),
        }


def with_error(value: float, error: float) -> str:
    """ "116.0 ± 0.3": a number to the digit of its error's leading one, of which two are kept where it is a 1 or a 2.

    Without a known error the number has four digits. With an error below its sixth digit it has five, and ± is rounded up to
    one of the fifth, which covers the rounding of the number. It never has more than six. "–": there is no number.
    """
    if isnan(value):
        return "–"
    if not (isfinite(value) and isfinite(error)):
        return f"{value:.4g}"
    if error == 0.0:
        return f"{value:.6g} ± 0"
    size: float = floor(log10(abs(value))) if value else -inf
    digit = floor(log10(error))
    if error < 10.0 ** (size - 5):
        digit = int(size) - 4
        error = 10.0**digit
    elif error < 3.0 * 10.0**digit and digit > size - 5:
        digit -= 1  # 0.14 rather than 0.2, 21 rather than 30: rounded up to one digit it could be half as large again
    shown = ceil(error / 10.0**digit * (1.0 - 1e-9)) * 10.0**digit  # never less than it is
    if 0 <= digit < 5 and abs(value) < 1e6:
        return f"{round(value, -digit):.0f} ± {shown:.0f}"
    if digit >= 0 or digit < -9 or -inf < size < -5:
        places = max(int(size) - digit, 1) + 1 if value else 1  # down to the digit of the error, as in the other forms
        return f"{value:.{places}g} ± {shown:.2g}"
    return f"{value:.{-digit}f} ± {shown:.{-digit}f}"


def with_errors_of(value: float, error: float, parameters: float, covers: str = "steps") -> str:
    """ "116.0 ± 0.3 (steps) ± 4.2 (parameters)": a number with its numerical error, and where there is one its parameter error."""
    text = with_error(value, error)
    if not isfinite(parameters):
        return text
    digit = floor(log10(parameters)) - 1 if parameters else 0
    shown = f"{round(parameters, -digit):.{max(-digit, 0)}f}" if -9 < digit < 6 else f"{parameters:.2g}"
    return f"{text}{f' ({covers})' if isfinite(error) else ''} ± {shown} (parameters)"


Summary = tuple[SummaryRow, ...]
PACING = {"duration": "duration of a step, without its wait", "lateness": "behind the clock at the end of a step"}


class SummaryTable(Summary):
    """The rows of a run, which a terminal and a notebook show as a table."""

    def value(self, name: str) -> float:
        """The number of that name; raises `BadInput` with the near names."""
        for row in self:
            if row.name == name:
                return row.value
        raise BadInput("summary", repr(name), "a quantity of the run", nearest(name, [row.name for row in self]))

    def __repr__(self) -> str:
        if not self:
            return "no figures: they are those of a system, which [analysis] of the scene names"
        width = max(len(row.name) for row in self)
        return "\n".join(f"{row.name:{width}}  {row.shown} {row.unit}".rstrip() for row in self._for_reader())

    def _for_reader(self) -> list[SummaryRow]:
        return [row.for_reader() for row in self]

    def _repr_html_(self) -> str:
        cells = "".join(
            f"<tr><td>{escape(r.name)}<td>{r.shown}<td>{escape(r.unit)}<td>{escape(r.text)}" for r in self._for_reader()
        )
        return f"<table><tr><th>quantity<th>value<th>unit<th>{cells}</table>"


def with_errors(rows: Iterable[SummaryRow], verification: VerificationRecord) -> Summary:
    """The rows with the errors that verification found."""
    errors = verification.figures
    rows = tuple(row if (error := errors.get(row.name)) is None else replace(row, error=error) for row in rows)
    if not (of_parameters := verification.parameters.figures):
        return rows
    covers = "steps, mesh" if verification.mesh.places else "steps"
    known = {name: one.error for name, one in of_parameters.items() if one.error is not None}
    return tuple(replace(row, parameters=known.get(row.name, nan), covers=covers) for row in rows)


def rows(
    unit: str, values: Mapping[str, float | None], texts: Mapping[str, tuple[str, str]], part: bool = False
) -> Iterable[SummaryRow]:
    """Rows of a unit of a scene for the values that there are. texts: quantity -> (unit of measure, what it is)."""
    given = {name: float(value) for name, value in values.items() if value is not None}
    return (SummaryRow(f"{unit}.{name}", value, *texts[name], part=part) for name, value in given.items())


def pacing_rows(of: Pace | None) -> Summary:
    """How punctual a run at the pace of the clock was; none of another run."""
    if of is None:
        return ()
    counted = (("steps", of.steps, "macro steps at the pace of the clock"), ("late", of.late, "of these ended behind the clock"))
    percentiles = {"duration": of.duration, "lateness": of.lateness}
    ends = (("50 %", "median", "median"), ("99 %", "p99", "99 % are below"), ("100 %", "max", "longest"))
    return (
        *(SummaryRow(f"real_time.{name}", float(count), "1", text) for name, count, text in counted),
        *(
            SummaryRow(f"real_time.{name}_{end}", 1e3 * percentiles[name][p], "ms", f"{text}: {what}")
            for name, text in PACING.items()
            for p, end, what in ends
        ),
    )


def to_json(summary: Summary, info: RunRecord) -> dict[str, Any]:
    """The object of summary.json: rows by their names, which have a dot, and how the run ended."""
    return {row.name: row.to_json() for row in summary} | {"outcome": info.outcome, "warnings": info.warnings}


COLUMNS = ("quantity", "value", "error", "unit", "text")


def to_table(summary: Summary) -> tuple[Sequence[str], list[tuple[str | float, ...]]]:
    """(names of the columns, rows) of summary.csv; an empty cell is a number that is not known."""
    known = lambda number: number if isfinite(number) else ""  # noqa: E731
    table: list[tuple[str | float, ...]] = [(row.name, known(row.value), known(row.error), row.unit, row.text) for row in summary]
    if not any(isfinite(row.parameters) for row in summary):
        return COLUMNS, table
    return (*COLUMNS, "parameter error"), [(*cells, known(row.parameters)) for cells, row in zip(table, summary, strict=True)]


def percent(share: float | None) -> str:
    """A share of a signal's deviation, with two digits."""
    if share is None:
        return "not known"
    if share < 1e-4:
        return "< 0.01 %" if share else "0"
    return f"{100.0 * share:.2g} %" if share < 0.995 else f"{100.0 * share:.0f} %"


def verification_text(verification: VerificationRecord) -> str:
    """How the errors of a run were found, or why there are none."""
    return f"{_numerical_text(verification)}{_parameters_text(verification.parameters)}"


def _parameters_text(parameters: ParametersRecord) -> str:
    """What "(parameters)" is; nothing of a scene without tolerances."""
    if not (deviations := parameters.deviations):
        return ""
    beside = f", beside {parameters.samples} samples" if parameters.samples else ", without samples beside it"
    return (
        f' "± ... (parameters)" is one standard deviation, by first order from the tolerances of {", ".join(deviations)} '
        f"({parameters.how.partition(' (')[0]} derivatives{beside})."
    )


def _numerical_text(verification: VerificationRecord) -> str:
    if not verification.done:
        return f"No error estimate: {verification.why or 'cosimo did not repeat the run'}."
    step, runs = verification.step, "two runs" if verification.runs == 2 else "three runs"
    if windows := verification.windows:
        inner = "half of the" if verification.inside else "the same"
        slower = f"; slower than a window: {', '.join(windows.slower)}" if windows.slower else ""
        slower += f"; taken to grow on as in a window: {', '.join(windows.growing)}" if windows.growing else ""
        return (
            f"Estimated errors of signals (rms, in % of the standard deviation) from {len(windows.begins)} windows of "
            f"{windows.length:.3g} s, repeated with a macro step of {step:g} s and {inner} internal steps{slower}. "
            f"{verification.why[:1].upper()}{verification.why[1:]}. {covered_text(verification.mesh)}"
        )
    shorter = "half of it" if verification.runs == 2 else "half and a quarter of it"
    text = (
        f'± and "error" are estimated discretization errors, from {runs} with a macro step of {2.0 * step:g} s and {shorter}'
        f"{'; internal steps are halved too' if verification.inside else ''}. Errors of signals: rms, in % of "
        "the standard deviation."
    )
    parts = [f"{place}: {100.0 * (part.difference or 0.0):.2g} % of {part.signal}" for place, part in verification.parts.items()]
    text += f" Change by one refinement alone: {'; '.join(parts)}." if parts else ""
    missing = ", ".join(verification.not_refined)
    text += f" The errors exclude the error due to {missing}, which could not be refined." if missing else ""
    return f"{text} {covered_text(verification.mesh)}"


def covered_text(mesh: MeshRecord) -> str:
    """What errors cover beside the steps, and what they leave out."""
    text = ""
    if places := mesh.places:
        name, most = max(((n, rms or 0.0) for n, rms in mesh.signals.items()), key=lambda one: one[1])
        before = ", measured before" if mesh.kept else ""
        text = (
            f"The errors include the mesh ({', '.join(places)}), estimated with half as many elements{before}: "
            f"{100.0 * most:.2g} % of {name}. "
        )
    for reason in dict.fromkeys(mesh.not_covered.values()):
        names = ", ".join(name for name, why in mesh.not_covered.items() if why == reason)
        text += f"The errors exclude the mesh ({names}): {reason}. "
    left_out = mesh.left_out
    kinds = [f"{what} ({', '.join(n for n, w in left_out.items() if w == what)})" for what in dict.fromkeys(left_out.values())]
    return f"{text}{'Also excluded' if 'exclude' in text else 'Excluded'}: {', '.join([*kinds, 'modelling errors'])}."
