"""Machine code of a component that is kernels, and the block that an instance begins with.

The entries are those of the process (`components.core.block`), with the kernels linked in. An instance computes its initial state
itself, from parameters that can be set; structural ones have the values of the build.
"""

from __future__ import annotations

from numba import types
from numba.core.typing.typeof import typeof

from ...components.core.block import ENTRIES, check_result, kinds_of
from ...components.core.contract import KernelComponent, filled
from ...components.core.variables import Causality
from .kept_code import digest_of, load, save
from .machine_code import Code, Image, _Compiler, _linked, called_kernels

SYMBOLS = {"initialize": ("start", "double %t"), "step": ("step", "double %t, double %h"), "outputs": ("outputs", "double %t")}


class KernelBlock:
    """Where what an FMU knows of lies in the block, cells."""

    def __init__(self, component: KernelComponent):
        block = component.block
        assert block is not None
        self.u, self.y, self.x = (block.cell("s", name) for name in ("u", "y", "x"))
        self.cells, self.saved, self.first_parameter = block.cells, block.saved, block.parameters_at
        self.parameters = {}
        for name in component.parameters:
            if (at := _cell_of(component, name)) is not None:
                self.parameters[name] = at


def _cell_of(component: KernelComponent, name: str) -> int | None:
    """The cell of a parameter; None for a text, which kernels do not get."""
    block, cls = component.block, type(component)
    assert block is not None
    whole, bracket, index = name.partition("[")
    effect, dot, field = whole.partition(".")
    variable = cls.variables[name]
    if variable.kind.value == "text":
        return None
    at = block.cell("e", effect, field) if dot else block.cell("p", whole)
    return at + (int(index.rstrip("]")) - 1 if bracket else 0)


def kernel_code(component: KernelComponent) -> Code:
    """The entries of a component in LLVM's language; raises what Numba raises, and `BadInput`."""
    try:
        return _code(component, counted=False)
    except Exception:
        # code that is never reached may mention allocation; what remains of it is seen among the symbols
        return _code(component, counted=True)


def _code(component: KernelComponent, counted: bool) -> Code:
    block, cls, compiler = component.block, type(component), _Compiler(counted)
    assert block is not None
    kernels = {name: compiler.clone(getattr(cls.kernels, name)) for name in ENTRIES}
    reached = [function for _, function in compiler.kernels.values()]
    of_arguments = tuple(map(typeof, component.arguments))
    layout = "\n".join(map(repr, block.in_order()))
    identity = (layout, *map(str, of_arguments), *(getattr(cls.kernels, n) for n in ENTRIES))
    digest = digest_of(identity, called_kernels, reached, cls)
    text = load(digest) if digest else None
    if text is None:
        texts = {}
        for name, kernel in kernels.items():
            symbol, times = SYMBOLS[name]
            signature = (types.float64,) * len(ENTRIES[name]) + of_arguments
            kernel.compile(signature)
            overload = kernel.overloads[signature]
            check_result(kernel, overload)
            body = block.body(name, kinds_of(overload, len(ENTRIES[name])), overload.fndesc.llvm_func_name)
            texts[symbol] = overload.library.get_llvm_str() + f"""
define i32 @model_{symbol}({times}, i64 %address) {{
%block = inttoptr i64 %address to ptr
{body}
}}
"""
        text = _linked(component, texts, [k.__name__ for k in reached])
        if digest:
            save(digest, text)
    return Code(text, (), KernelBlock(component), "initialize")  # type: ignore[arg-type]


def kernel_image(component: KernelComponent, code: Code) -> Image:
    """The block before initialization: inputs at their start values, parameters, and tables that the layout gives."""
    block = component.block
    assert block is not None
    component._prepare()
    cells = block.memory.copy()
    cells[block.addresses_at : block.addresses_at + len(ENTRIES)] = 0.0
    cells[block.cell("s", "y") : block.cell("s", "x")] = 0.0
    settable = {name: () for name in code.block.parameters if not type(component).variables[name].structural}
    return Image(cells, frozenset(), False, settable)


def refusals_of(component: KernelComponent) -> list[tuple[int, str, list[int]]]:
    """(status, format of a message, cells of the numbers in it) of what `initialize` refuses."""
    block = component.block
    assert block is not None
    rows = []
    for status, refusal in type(component).refusals.items():
        cells: list[int] = []

        def value(name: str, cells: list[int] = cells) -> str:
            variable = type(component).variables.get(name)
            if isinstance(said := getattr(component, name, None), str):
                return said.replace("%", "%%")
            if variable is not None and variable.structural:
                return str(component.parameters[name]).replace("%", "%%")
            if variable is None:
                array, _, index = name.partition("[")
                cells.append(block.cell("s", array) + int(index.rstrip("]") or 0))
            elif variable.causality is Causality.INPUT:
                cells.append(block.cell("s", "u") + component.inputs.index(name))
            elif name in component.parameters:
                at = _cell_of(component, name)
                assert at is not None
                cells.append(at)
            return "%.6g"

        actual, expected, remedy = (text.replace("%", "%%") for text in refusal)
        try:
            text = filled(f"{actual}; expected {expected}" + (f". {remedy}" if remedy else ""), value)
        except (KeyError, AssertionError):  # it names what belongs to an effect that is off
            continue
        rows.append((status, text, cells))
    return rows
