"""What the master knows of a unit: the order of its calls, what it may offer, and its capabilities as data."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np

from ...components.core.errors import StepFailed
from ...components.core.measure import Unit as Measure
from .fmu_messages import Messages
from .terminals import Terminals

if TYPE_CHECKING:
    from ...components.core.component import Component
    from ...components.core.contract import KernelComponent

PortValues = Any  # list[float], or an ndarray of more than ARRAY_THRESHOLD numbers
Kind = Literal["real", "integer", "boolean", "enumeration", "string", "binary"]
ARRAY_THRESHOLD = 24  # numbers: more of them are handed over as arrays, fewer as lists


def port_values(values: np.ndarray) -> PortValues:
    """Numbers of a table, (n,), as units get them."""
    return values.copy() if values.size > ARRAY_THRESHOLD else values.tolist()


class Span(NamedTuple):
    """Of a run, as FMUs are told of it before they are initialized, s; stop None: not told.

    parts: whether a unit makes a step that its FMU discards in shorter ones; False: step control repeats it for all units.
    """

    start: float = 0.0
    stop: float | None = None
    parts: bool = True


WITHOUT_END = Span()


@dataclass(frozen=True)
class Signal:
    """One scalar input or output. `feedthrough` of an output: the inputs it depends on within an instant; None: not declared.

    Numbers of every kind travel as floats: integers and members of an enumeration as their value, booleans as 0 and 1.
    Texts take their own way, see `Simulator.set_texts` and `Simulator.text_reader`.
    """

    name: str
    unit: str  # "": not declared, so that it can neither be converted nor refused
    start: float | str = 0.0
    nominal: float = 1.0
    feedthrough: tuple[str, ...] | None = ()
    kind: Kind = "real"
    discrete: bool = False  # changes at instants only: held over a step, never extrapolated; all kinds but real are
    moving: bool = False  # of an input: a place that moves on, extrapolated linearly at least
    relative: bool = False  # a difference: of two temperatures, say; an offset between units of measure is none of it
    members: Mapping[str, int] = field(default_factory=dict)  # of an enumeration, by name
    measure: Measure | None = None  # what `unit` means where the model defines it; None: what it means to everybody

    @property
    def is_text(self) -> bool:
        """Whether its values are texts; binary ones are, as FMI writes them: two hexadecimal digits for each octet."""
        return self.kind in ("string", "binary")


@dataclass(frozen=True)
class Interface:
    """Names, units of measure and capabilities of one unit."""

    title: str
    inputs: Mapping[str, Signal]
    outputs: Mapping[str, Signal]
    effects: Mapping[str, str]  # every effect the unit has -> why it is on, or "" where it is off
    set_inputs: frozenset[str] = frozenset()  # inputs the scene gives a value
    input_degree: int = 2  # highest degree of an input's polynomial over a step; above it the unit holds the mean
    variable_step: bool = True
    saves_state: bool = True  # `save` and `restore` are exact
    packs_state: bool = True  # and a saved state can be written to a file: `pack`, `unpack`
    gives_jacobian: bool = False  # `jacobian` is offered
    fixed_step: float = 0.0  # s, that every communication step must be a multiple of; 0: free
    is_discontinuous: bool = (
        False  # outputs jump where the unit says, and an update behind a step gives the values behind the jump
    )
    may_return_early: bool = False  # events inside a step are reported by `event`
    recordable: Mapping[str, Signal] = field(default_factory=dict)  # what is no output and may be recorded by its name
    arrays: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # elements of what is an array of FMI 3
    ports: Mapping[str, Any] = field(default_factory=dict)  # ports of a component, and what variables are called in them, as
    port_members: Mapping[str, str] = field(default_factory=dict)  # the attributes of its class have them
    sums: Mapping[str, tuple[str, ...]] = field(
        default_factory=dict
    )  # outputs of a component -> their parts, as its class has them
    terminals: Terminals = field(default_factory=Terminals)  # ports of an FMU
    remarks: tuple[str, ...] = ()  # what a user of the unit should know, for the warnings of a run
    foreign: bool = False  # an FMU that a scene names: what it gives may be no number where nothing uses it
    refused: Mapping[str, str] = field(default_factory=dict)  # variables that cannot be connected -> what they are


class SimulationEnded(StepFailed):
    """A unit has ended the simulation, as FMI lets it; no failure, and its outputs may still be read."""

    def __init__(self, unit: str, time: float):
        super().__init__(unit, time, "it has ended the simulation")

    def __str__(self) -> str:
        return f"{self.unit} ended the simulation at t = {self.time:.9g} s"


class SteppedFmu(Protocol):
    """An FMU whose functions compiled code calls. The machine of a master sets the first two, and calls the others."""

    driven: Callable[[], Sequence[PortValues | None]]  # its inputs over the step that compiled code has begun, as of `drive`
    time_of_step: Callable[[], float] | None  # s, where this step began

    def begin_steps(self) -> bool:
        """Compiled steps begin: whether none will be taken back; raises `SimulationEnded` where the FMU has ended it."""

    def count(self, steps: int, warnings: int) -> None:
        """Compiled code has taken so many steps of it, and so many calls have ended with a warning."""


@dataclass(frozen=True)
class CallTable:
    """Addresses by name; where the driven inputs and the read outputs of a component lie; which inputs of an FMU are held.

    stopped: the step from t over h, s, has ended with this status: raises the reason, unless it is done all the same.  stepped: to be
    called with the time, s, to which steps were taken (of an FMU: from which the last one was); None: the unit knows.
    """

    stopped: Callable[[int, float, float], None]
    calls: Mapping[str, int]
    input_mode: int
    alive: tuple[Any, ...]  # the memory that addresses point to
    inputs_at: tuple[int, ...]
    outputs_at: tuple[int, ...]
    set_on_change: tuple[bool, ...]
    in_python: bool = False  # whether a step goes through it
    stepped: Callable[[float], None] | None = None
    fmu: SteppedFmu | None = None


class Simulator(ABC):
    """One simulated part: a component, an FMU, a worker process, a contact. Calls come in this order:

    1. `wire` once: which inputs are driven and which outputs are read in every step; `wire_texts` where texts are driven
    2. `initialize`, repeated while the inputs still change, with `get` after each; then `start` once
    3. for each step `drive`, `step`, `get`; between steps `update`, `get` and the readers of `reader` and `text_reader`;
       `save` and `restore` around a repeated step
    4. `close`, always and once

    `step` may return before the unit has finished; `get` then waits for it. So units in processes of their own work at the
    same time where a master calls `step` of several before it asks for their values. What a step raises, `get` may raise.

    After `SimulationEnded` outputs may still be read; after any other `StepFailed` only `restore` and `close` are allowed.
    `values` and what `get` returns are in the order of the names given to `wire`: plain lists, for the few scalars of a usual
    connection faster than arrays, and arrays where there are more than ARRAY_THRESHOLD of them; what `get` returns may be
    overwritten by the next call.

    What a unit may offer beyond these calls stands below them with the answer of a unit that has none of it, and who asks. Whoever
    has a unit asks these, and never looks for an attribute or a class.
    """

    name: str
    kind: str  # "in process", "FMU", ...

    # -- what every unit does -----------------------------------------------------------------------------------------
    drive: Callable[[PortValues, PortValues | None, PortValues | None, float], None]
    # inputs over the coming step of length h: values + slopes s + quadratic s²; None for no such term
    step: Callable[[float, float], None]  # from t to t + h
    update: Callable[[PortValues], None]  # the inputs have these values now; outputs that depend on them directly follow
    get: Callable[[], PortValues]  # present values of the outputs given to `wire`

    @abstractmethod
    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        """Fix the names of the driven inputs and of the outputs that `get` returns."""

    @abstractmethod
    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        """A function that gives the present values of some outputs."""

    @abstractmethod
    def initialize(self, t: float, values: PortValues) -> None:
        """Find the initial state for these inputs."""

    @abstractmethod
    def save(self, reuse: Any = None) -> Any:
        """Everything a repeated step depends on; `reuse`: an older state that may be overwritten."""

    @abstractmethod
    def restore(self, state: Any) -> None:
        """Take back a state of `save`."""

    @abstractmethod
    def pack(self, state: Any) -> bytes:
        """A state of `save` as bytes for a file."""

    @abstractmethod
    def unpack(self, packed: bytes) -> Any:
        """The state of `pack`, for `restore` of a unit with the same parameters, in this process or another."""

    @abstractmethod
    def parameters(self) -> dict[str, Any]:
        """Values the run was made with, by name."""

    @abstractmethod
    def work(self) -> Mapping[str, float]:
        """Counters of the unit by name."""

    # -- what a unit may do, where its interface says so ----------------------------------------------------------------
    def put(self, name: str, value: float | str) -> None:
        """An input that is not among the driven ones has this value from now on, before `initialize` or between two steps."""
        raise NotImplementedError

    def wire_texts(self, inputs: Sequence[str]) -> None:
        """Fix the names of the texts of `set_texts`; called only where there are some."""
        raise NotImplementedError

    def set_texts(self, values: Sequence[str]) -> None:
        """Texts of the driven inputs from now on."""
        raise NotImplementedError

    def text_reader(self, names: Sequence[str]) -> Callable[[], list[str]]:
        """A function that gives the present texts of some outputs."""
        raise NotImplementedError

    def jacobian(self) -> np.ndarray:
        """Derivatives of the outputs of `get` with respect to the driven inputs at this instant, (outputs, inputs), where
        `Interface.gives_jacobian` says so."""
        raise NotImplementedError

    # -- what a unit may have, and its absence ----------------------------------------------------------------------------
    event: float | None = None  # s, the first event inside the last step, which it has dealt with; the stepping asks after `get`
    component: Component | None = None  # whose arrays lie in this process; for derivatives, sessions, states of a batch
    kernels: KernelComponent | None = None  # the same, where its steps are kernels; for runs in threads and FMUs of scenes
    written: Sequence[np.ndarray] | None = None  # all arrays that compiled steps write, for batches that are taken back
    walls: Sequence[str] = ()  # around its process; for the record of a run

    def call_table(self) -> CallTable | None:
        """How compiled code steps the initialized unit, for the machine of a master; None: through the calls above."""
        return None

    def outputs_at(self, names: Sequence[str]) -> Sequence[int] | None:
        """Addresses of outputs, for recorders of batches; None: its outputs lie elsewhere."""
        return None

    def start(self) -> None:
        """The initial state stands."""

    def restart(self) -> None:
        """An input has jumped, so that its past tells nothing: for what extrapolates by itself."""

    def check_step_repeatable(self, h: float) -> None:
        """Raises `StepFailed` where a step from here is another one when it is repeated; the first step of a run asks."""

    def log_messages(self) -> Messages:
        """What an FMU has said so far, for the warnings of a run."""
        return Messages()

    def release(self, state: Any) -> None:
        """A state of `save` that will not be needed any more."""

    def close(self) -> None:
        """Give back what the unit holds outside this object."""
