"""A scene as one FMU without Python: compiled, linked with the runtime, described and packed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ...components.core.errors import BadInput
from ...fmus.evidence import Evidence
from ...fmus.native.build import Library, assembled, check_versions, compiler, pack
from ...fmus.native.instance import Model
from ...fmus.native.machine_code import compile_entries
from ...fmus.native.variables import with_sizes
from ..engine.stepping.faults import Faults
from ..opened.open_scene import OpenScene
from ..scene.scene import Scene
from .layout import Layout, in_python, stepped_in_python
from .tables import fault_changes, model_of
from .variables import described, variables_of

HOST = (
    "This FMU needs no Python. It holds a scene: the components above, and the master algorithm that couples them. "
    "Effects and structural parameters are constants, fixed when it was built; the other parameters can be set before the run, "
    "tunable ones during it. "
    "A communication step is a whole multiple of the macro step, which the default experiment names; inputs are held over it."
)


def refuse_what_needs_python(scene: Scene) -> None:
    """`BadInput` for a scene of which something is no kernel, with the names of all that is not."""
    if reasons := in_python(scene):
        raise _refusal(scene, ", ".join(reasons))


def _refusal(scene: Scene, actual: str) -> BadInput:
    return BadInput(
        f"build {scene.name} --native",
        actual,
        "a scene of components whose macro step is kernels alone (Jacobi or Gauss-Seidel, no algebraic loop)",
        "Build its units one by one with --scene, or write the scene with cosimo ssp.",
    )


@contextmanager
def laid_out(scene: Scene) -> Iterator[tuple[Layout, Model]]:
    """Where everything of a scene lies, and its block before initialization; `BadInput` where something of it is no kernel."""
    refuse_what_needs_python(scene)
    shown = scene.coupling.shown.values()
    with ExitStack() as stack:
        watched = (*scene.coupling.signals, *(each.end for each in shown if each.causality == "output"))
        open_scene = OpenScene(scene, stack, in_process=True, watched=watched)
        master = open_scene.master
        if reasons := stepped_in_python(scene, master):
            raise _refusal(scene, ", ".join(reasons))
        changes = fault_changes(scene)
        Faults(scene.faults, scene.coupling, master, open_scene.clock).before_start()
        layout = Layout.of(scene, master, bool(changes))
        yield layout, model_of(scene, layout, changes)


def scene_block(scene: Scene) -> Model:
    """The block of a scene before initialization, with the tables that say what lies in it."""
    with laid_out(scene) as (_, model):
        return model


def scene_library(scene: Scene, targets: Iterable[str], sources: Sequence[str] = ()) -> Library:
    """Compile a scene for all targets; `BadInput` where something of it is no kernel, or no compiler is found.

    sources: further ones of the runtime.
    """
    compilers = {target: compiler(target) for target in targets}
    with laid_out(scene) as (layout, model):
        variables = with_sizes(list(variables_of(scene, layout)))
        same = {"canHandleVariableCommunicationStepSize": "false"}  # whole multiples of the macro step alone
        return assembled(
            re.sub(r"\W", "_", scene.name),
            described(scene),
            variables,
            model,
            [compile_entries(source) for source in layout.sources],
            compilers,
            abilities={2: same | {"canInterpolateInputs": "false"}, 3: same | {"fixedInternalStepSize": repr(scene.master.step)}},
            host=HOST,
            sources=("scene.c", "begin.c", *sources),
        )


def build_scene_fmu(
    scene: Scene, directory: Path, targets: Iterable[str], standards: Iterable[int] = (2,), evidence: Evidence | None = None
) -> list[Path]:
    """Write directory/<scene>.fmu (FMI 2) and directory/<scene>.fmi3.fmu (FMI 3), as asked for, and return their paths."""
    targets, standards = list(targets), list(standards)
    check_versions(targets, standards)
    library = scene_library(scene, targets)
    return [pack(library, directory, fmi, False, scene.name, evidence) for fmi in standards]
