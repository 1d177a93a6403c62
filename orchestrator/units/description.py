"""What an FMU's model description says, with scalars by name.

FMPy reads the file. Arrays of FMI 3 become their elements, "name[1]" or "name[1,2]", in the order of their values.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import product
from math import isfinite, prod
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...components.core.errors import BadInput, nearest
from ...components.core.measure import is_quantity, number_in
from ..loading import MOST_ELEMENTS, MOST_REFERENCE, MOST_VARIABLES, MOST_XML, check_archive
from .interface import Kind
from .solvers import METHODS
from .terminals import Terminals, read_terminals

if TYPE_CHECKING:  # a run without FMUs loads no FMPy
    from fmpy.model_description import CoSimulation, ModelDescription, ModelExchange, ModelVariable

    from ..settings import UnitSettings

DESCRIPTION = "modelDescription.xml"
OWN_TOOL = "cosimo "  # what FMUs of our making say of their tool, before the version
FAULTY = "The FMU's model description is faulty."
SIGNAL_KINDS: dict[str, Kind] = {
    "Real": "real",
    "Boolean": "boolean",
    "String": "string",
    "Enumeration": "enumeration",
    "Binary": "binary",
}
TEXTS = ("String", "Binary")  # octets as FMI writes them, two hexadecimal digits each
NEITHER = ("Clock",)  # types that are neither numbers nor texts


@dataclass(frozen=True)
class Scalar:
    """A scalar variable, or one element of an array."""

    name: str
    variable: ModelVariable
    position: int  # among the values of the array, 0 for a scalar
    size: int  # values of the variable
    start: Any  # of the type's Python kind; None: not given

    @property
    def kind(self) -> Kind:
        """Kind of its values."""
        type_ = self.variable.type
        return SIGNAL_KINDS.get(type_) or ("real" if type_.startswith("Float") else "integer")

    @property
    def nominal(self) -> float:
        """Typical size of its values, positive: its own, of its declared type, or 1."""
        declared = self.variable.declaredType
        return abs(float(self.variable.nominal or (declared.nominal if declared else None) or 1.0)) or 1.0

    @property
    def unit(self) -> str:
        """Its unit of measure, its own or of its declared type; "": none is given."""
        declared = self.variable.declaredType
        return self.variable.unit or (declared.unit if declared else None) or ""

    @property
    def relative(self) -> bool:
        """Whether it is a difference, by its own attribute or by its declared type."""
        declared, own = self.variable.declaredType, self.variable.relativeQuantity
        return bool(own if own is not None else declared and declared.relativeQuantity)

    @property
    def discrete(self) -> bool:
        """Whether it changes at instants only."""
        return self.kind != "real" or self.variable.variability != "continuous"


@dataclass(frozen=True)
class Description:
    """FMPy's model description, and its scalars by name."""

    path: str
    model: ModelDescription
    scalars: Mapping[str, Scalar]
    derives: Set[str]  # interfaces that give directional derivatives: "CoSimulation", "ModelExchange"
    texts: Mapping[str | None, Sequence[str]]  # start values of texts, which FMPy does not read of arrays
    requested: Set[str] = frozenset()  # inputs that the FMU asks for inside a step, by the intermediate update of FMI 3
    terminals: Terminals = field(default_factory=Terminals)
    exchange: bool = False  # the interface for model exchange is used, not the one for co-simulation

    @property
    def interface(self) -> CoSimulation | ModelExchange:
        """What the file says of the interface that is used."""
        return self.model.modelExchange if self.exchange else self.model.coSimulation

    @property
    def directional(self) -> bool:
        """Whether it gives directional derivatives."""
        return ("ModelExchange" if self.exchange else "CoSimulation") in self.derives

    @property
    def interpolates(self) -> bool:
        """Whether it takes derivatives of inputs with the functions of FMI 2."""
        return not (self.exchange or self.fmi3) and self.model.coSimulation.canInterpolateInputs

    @property
    def fmi3(self) -> bool:
        """Whether it is of FMI 3."""
        return self.model.fmiMajorVersion == 3

    @property
    def holds_component(self) -> bool:
        """Whether this project has made it: a component discards the steps it cannot make, and never ends a simulation."""
        return (self.model.generationTool or "").startswith(OWN_TOOL)

    def time(self, name: str) -> float | None:
        """An attribute of the default experiment, s, or the tolerance; None where it is not given, or no number."""
        try:
            value = float(getattr(self.model.defaultExperiment, name, None) or "nan")
        except ValueError:
            return None
        return value if isfinite(value) else None

    @property
    def tolerance(self) -> float | None:
        """Relative tolerance of the default experiment."""
        return value if (value := self.time("tolerance")) is not None and value > 0.0 else None

    @property
    def default_step(self) -> float | None:
        """Step of the default experiment, s, or the fixed internal step where it gives none."""
        fixed = self.interface.fixedInternalStepSize if self.fmi3 and self.model.coSimulation and not self.exchange else None
        return next((step for step in (self.time("stepSize"), float(fixed or 0.0)) if step and step > 0.0), None)

    def chosen(self, settings: UnitSettings, where: str) -> Description:
        """With the interface that a scene's entry asks for; `BadInput` where the file has none such, or for needless options."""
        wanted, model = settings.interface, self.model
        exchange = model.coSimulation is None if wanted is None else wanted == "model-exchange"
        if (model.modelExchange if exchange else model.coSimulation) is None:
            only = "co-simulation" if exchange else "model exchange"
            raise BadInput(f"{where}.interface", repr(wanted), "an interface of the FMU", f"It is for {only} only.")
        if settings.solver is not None and not exchange:
            raise BadInput(
                f"{where}.solver",
                "no effect on an FMU for co-simulation, which has its own solver",
                "",
                'Remove it, or write interface = "model-exchange".',
            )
        if settings.solver is not None and settings.solver not in METHODS:
            raise BadInput(f"{where}.solver", repr(settings.solver), "a method of integration", nearest(settings.solver, METHODS))
        return replace(self, exchange=exchange)

    def sized(self, values: Mapping[str, Any], where: str) -> Description:
        """With the sizes of arrays that these values of structural parameters give."""
        sizes = {n: values[n] for n, s in self.scalars.items() if n in values and s.variable.causality == "structuralParameter"}
        if not sizes:
            return self
        for name, size in sizes.items():
            if not isinstance(size, int) or isinstance(size, bool) or size < 0:
                raise BadInput(f"{where}.parameters", f"{name} = {size!r}", "a whole number of elements")
        return replace(self, scalars=_scalars(self.model, sizes, self.texts))


def read(path: str, where: str) -> Description:
    """The description of an FMU; `BadInput` for what is none."""
    try:
        if isfile(path):  # which takes a name that no file can have for one of no file
            return _read(path, Path(path).stat().st_mtime_ns, where)
    except FileNotFoundError:  # it has just gone
        pass
    raise BadInput(where, repr(path), "an FMU file")


@lru_cache(maxsize=64)
def _read(path: str, _changed: int, where: str) -> Description:
    from fmpy import read_model_description
    from lxml import etree

    try:
        with zipfile.ZipFile(path) as file:
            root = etree.fromstring(_checked(file, path))
            if root.tag != "fmiModelDescription":
                raise BadInput(
                    where, f"{path}, whose {DESCRIPTION} is <{root.tag}>", "<fmiModelDescription>", "Ask its maker for the FMU."
                )
            terminals = read_terminals(file, (root.get("generationTool") or "").startswith(OWN_TOOL))
        model = read_model_description(path, validate=False)
    except BadInput:
        raise
    except Exception as error:  # FMPy raises bare exceptions and those of zipfile and lxml
        raise BadInput(where, repr(path), "an FMU", f"{error or type(error).__name__}.") from None
    if not model.fmiVersion.startswith(("2.0", "3.0")):
        raise BadInput(where, f"{path} (FMI {model.fmiVersion})", "an FMU of FMI 2.0 or 3.0")
    if model.coSimulation is None and model.modelExchange is None:
        raise BadInput(where, f"{path}, for scheduled execution only", "an FMU for co-simulation or model exchange")
    for v in model.modelVariables:
        if v.type == "Clock" and v.causality == "input" and v.intervalVariability != "triggered":
            raise BadInput(
                where,
                f"{path} with the clock {v.name!r}, which its importer has to tick",
                "an FMU without such clocks; it would stand still",
            )
    _complete(model, root)
    _check_numbers(model, where)
    _check_names(model, where)
    derives = {
        i.tag
        for i in root
        if i.tag in ("CoSimulation", "ModelExchange")  # FMPy knows that of FMI 2
        and any(is_true(i.get("providesDirectionalDerivative" + plural)) for plural in ("", "s"))
    }
    texts = {v.get("name"): [s.get("value") for s in v.findall("Start")] for v in root.iterfind("ModelVariables/*")}
    return Description(path, model, _scalars(model, {}, texts), derives, texts, _requested(model, root), terminals)


def default_experiment(path: Path, given: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Start time, stop time and step, s, as in a scene, of an FMU's default experiment; remarks about what it does not say.

    given: settings of a scene by their places, which count instead. Where nothing else is said, a run begins at 0, lasts 1 s, and
    has a step of the FMU's fixed internal step, or of a thousandth of the run.
    """
    if not path.is_file():
        raise BadInput("scene", repr(str(path)), "an FMU that can be read", "There is no such file.")
    description = read(str(path), "scene")
    remarks = []

    def of_time(place: str) -> float | None:
        value = given.get(place)
        return number_in(str(value), "s", place) if is_quantity(value) else value

    start, stop, step = (of_time(place) for place in ("start_time", "stop_time", "master.step"))
    if start is None:
        start = description.time("startTime") or 0.0
    if stop is None and ((stop := description.time("stopTime")) is None or stop <= start):
        stop = start + 1.0
        remarks.append(f"{path.name} gives no stop time{f' after {start:g} s' if start else ''}; {stop:g} s is taken")
    length = float(stop) - float(start) if stop > start else 1.0  # which is refused, with the scene
    if step is None and (step := description.default_step) is None:
        step = 1e-3 * length
        remarks.append(f"{path.name} gives no step; {step:g} s is taken")
    times = {"start_time": float(start)} if start else {}
    return {**times, "stop_time": float(stop), "master": {"step": min(step, length)}}, tuple(remarks)


def _checked(file: zipfile.ZipFile, path: str) -> bytes:
    """The text of the model description, of a size that can be read; `BadInput` with the limit for another one."""
    check_archive(file, path)
    size = file.getinfo(DESCRIPTION).file_size
    if size > MOST_XML:
        raise BadInput(path, f"a model description of {size} bytes", f"at most {MOST_XML} bytes")
    content = file.read(DESCRIPTION)
    if (variables := content.count(b"valueReference")) > MOST_VARIABLES:
        raise BadInput(path, f"an FMU of about {variables} variables", f"at most {MOST_VARIABLES}")
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise BadInput(path, "a model description with a document type and entities of its own", "plain XML")
    return content


def _check_sizes(scalars: int, where: str) -> None:
    if scalars > MOST_ELEMENTS:
        raise BadInput(where, f"arrays of {scalars} elements", f"at most {MOST_ELEMENTS} in an FMU")


def _check_numbers(model: ModelDescription, where: str) -> None:
    """FMPy leaves the attributes of variables as texts; `BadInput` for those that are not what their type says."""
    for v in model.modelVariables:
        if not 0 <= int(v.valueReference) <= MOST_REFERENCE:
            raise BadInput(
                where, f"valueReference {v.valueReference} of {v.name!r}", f"a whole number from 0 to {MOST_REFERENCE}", FAULTY
            )
    for owner in (*model.modelVariables, *model.typeDefinitions):
        read_one = READERS.get(owner.type, int)
        for attribute in ("start", "nominal", "min", "max") if owner.type not in (*TEXTS, *NEITHER) else ():
            words = str(getattr(owner, attribute, None) or "").split()
            try:
                for word in words:
                    (float if attribute == "nominal" else read_one)(word)
            except ValueError:
                raise BadInput(
                    where, f"{attribute} = {' '.join(words)[:40]!r} of {owner.name!r}", f"a value of type {owner.type}", FAULTY
                ) from None


def _complete(model: ModelDescription, root: Any) -> None:
    """Attributes of variables that FMPy passes by: `relativeQuantity`, and the range of whole numbers without sign."""
    rows = [row for row in root.find("ModelVariables") if row.get("name") is not None]
    for variable, row in zip(model.modelVariables, rows, strict=False):
        value = row if model.fmiMajorVersion == 3 else next((i for i in row if i.tag == variable.type), row)
        given = value.get("relativeQuantity")
        variable.relativeQuantity = None if given is None else is_true(given)
        variable.min, variable.max = value.get("min"), value.get("max")
    for alias in model.modelVariables[len(rows) :]:
        alias.relativeQuantity, alias.min, alias.max = alias.alias.relativeQuantity, alias.alias.min, alias.alias.max


def _check_names(model: ModelDescription, where: str) -> None:
    """Every name stands for one variable or element: `BadInput` with both where it stands for two."""
    known: dict[str, ModelVariable] = {}
    for variable in model.modelVariables:
        first = known.setdefault(variable.name, variable)
        if first is not variable:
            lines = f"lines {first.sourceline} and {variable.sourceline}"
            what = f"({first.causality} {first.valueReference} and {variable.causality} {variable.valueReference}; {lines})"
            raise BadInput(where, f"two variables {variable.name!r} {what}", "names that are unique", FAULTY)


def _requested(model: ModelDescription, root: Any) -> frozenset[str]:
    """Continuous inputs of 64 bits, no arrays, that may be given inside a step; FMPy does not read the attribute."""
    if model.coSimulation is None or not model.coSimulation.providesIntermediateUpdate:
        return frozenset()
    return frozenset(
        v.get("name")
        for v in root.iterfind("ModelVariables/Float64")
        if is_true(v.get("intermediateUpdate"))
        and v.get("causality") == "input"
        and v.get("variability") in (None, "continuous")
        and v.find("Dimension") is None
    )


def _scalars(model: ModelDescription, sizes: Mapping[str, int], texts: Mapping[str | None, Sequence[str]]) -> dict[str, Scalar]:
    """Scalars by name; `sizes`: changed structural parameters; `texts`: start values of arrays of texts."""
    scalars: dict[str, Scalar] = {}
    total = 0
    for v in model.modelVariables:
        if v.type in NEITHER:
            continue
        shape = tuple(d.start if d.variable is None else sizes.get(d.variable.name, int(d.variable.start)) for d in v.dimensions)
        size = prod(shape)
        _check_sizes(total := total + size, f"variable {v.name!r}")
        starts = _starts(v, size, texts.get(v.name) or [])
        names = [f"{v.name}[{','.join(map(str, i))}]" for i in product(*(range(1, n + 1) for n in shape))] if shape else [v.name]
        for k, n in enumerate(names):
            if n in scalars:  # an element of an array and a scalar of the same name
                first = scalars[n].variable
                raise BadInput(
                    f"variable {v.name!r}", f"{n!r}, which {first.name!r} is or has, too", "names that are unique", FAULTY
                )
            scalars[n] = Scalar(n, v, k, size, starts[k])
    return scalars


def _starts(v: ModelVariable, size: int, texts: Sequence[str]) -> Sequence[Any]:
    """Start values of all elements; one value stands for all, and where their number does not fit, none is known."""
    if v.type in TEXTS:
        values: list[Any] = list(texts) or ([] if v.start is None else [v.start])
    else:
        values = [READERS.get(v.type, int)(word) for word in (v.start or "").split()]
    return values * size if len(values) == 1 else values if len(values) == size else [None] * size


def is_true(text: Any) -> bool:
    """A truth value as XML writes it."""
    return str(text).lower() in ("true", "1")


# how values are read that are no whole numbers
READERS: dict[str, Callable[[str], Any]] = {"Boolean": is_true, "Real": float, "Float32": float, "Float64": float}


def is_companion(name: str, scalars: Mapping[str, Scalar]) -> bool:
    """Whether a variable is one of the inputs "der(x)" and "der(x,2)" that carry the derivatives of an input x.

    A lone "der(x)" is a variable as any other: Modelica calls them so.
    """
    base = name[4:-1].removesuffix(",2") if name.startswith("der(") else ""
    return all(n in scalars and scalars[n].variable.causality == "input" for n in (base, f"der({base})", f"der({base},2)"))


def has_companions(scalars: Mapping[str, Scalar], inputs: Sequence[str]) -> bool:
    """Whether all inputs have companions "der(x)" and "der(x,2)" that carry their derivatives."""
    return bool(inputs) and all(is_companion(f"der({n})", scalars) for n in inputs)
