"""What the FMU of a scene shows: variables by the names of the scene, terminals, texts and the drawing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from ...components.core.variables import port_of
from ...fmus.interface import interface
from ...fmus.native.instance import Places
from ...fmus.native.variables import NativeVariable, component_variable
from ..scene.scene import Scene
from .layout import Layout


def described(scene: Scene) -> SimpleNamespace:
    """What texts and attributes of the FMU come from, with the names that classes of components have."""
    units = "\n".join(f"    {', '.join((f'{name}: {kind.label}', *kind.settings.effects))}" for name, kind in scene.kinds.items())
    arrows = "\n".join(f"    {arrow}" for arrow in scene.arrows)
    master = f"    {scene.master.algorithm}, macro step {scene.master.step:g} s"
    text = f"{scene.title}\n\nUnits:\n{units}\n\nConnections:\n{arrows}\n\nMaster algorithm:\n{master}"
    return SimpleNamespace(
        title=scene.title,
        __doc__=text,
        default_start=scene.start_time,
        default_stop=scene.stop_time,
        default_step=scene.master.step,
        variables={},
        ports=open_ports(scene),
        port_members={},
        start_inputs=None,
        needs_scipy=False,
        drawing=str(scene.show()),
    )


def names_of(scene: Scene) -> dict[tuple[str, str, str], list[str]]:
    """(causality, unit, variable) -> the names that the scene gives it."""
    names: dict[tuple[str, str, str], list[str]] = {}
    for name, shown in scene.coupling.shown.items():
        if not shown.kind:
            names.setdefault((shown.causality, *shown.end), []).append(name)
    return names


def open_ports(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Ports that components declare and no connection touches, as `unit.port`, with what their members are called."""
    linked = {end for link in scene.coupling.links for end in (link.source, link.target)}
    names, ports = names_of(scene), dict[str, tuple[str, ...]]()
    for unit, of in scene.coupling.interfaces.items():
        for port in of.ports:
            members = [
                (c, n) for c, all_ in (("input", of.inputs), ("output", of.outputs)) for n in all_ if port_of(n, of.ports) == port
            ]
            if not linked & {(unit, n) for _, n in members}:
                ports[f"{unit}.{port}"] = tuple(s for c, n in members for s in names.get((c, unit, n), [f"{unit}.{n}"]))
    return ports


def variables_of(scene: Scene, layout: Layout) -> Iterator[NativeVariable]:
    """Parameters, inputs that nothing drives, and outputs that are recorded or named, as `unit.variable` or by the scene's names.

    Behind them figures.
    """
    driven = {link.target for link in scene.coupling.links}
    recorded, names = set(scene.coupling.signals), names_of(scene)
    outputs: dict[tuple[str, str], NativeVariable] = {}
    for unit in sorted(layout.units, key=lambda unit: list(scene.units).index(unit.name)):
        component: Any = type(unit.component)
        places = Places(unit.component)
        for scalar in interface(component):
            variable = component_variable(scalar, unit.component, places)
            end = unit.name, scalar.name
            given = names.get((scalar.causality, *end), [])
            if variable.role in ("ABSENT", "DERIVATIVE") or end in driven:
                continue
            placed = replace(variable, scalar=replace(variable.scalar, feedthrough=()), cell=variable.cell + unit.first)
            if variable.role == "OUTPUT":
                outputs[end] = placed
                if end not in recorded and not given:
                    continue
            for name in given or [".".join(end)]:
                yield replace(placed, scalar=replace(placed.scalar, name=name))
    behind = f", from {scene.analysis.transient:g} s on" if scene.analysis.transient else ""
    for name, shown in scene.coupling.shown.items():
        if shown.kind:
            of = outputs[shown.end]
            text = f"{shown.kind} of {'.'.join(shown.end)} over the macro steps{behind}"
            scalar = replace(
                of.scalar, type="Real", discrete=False, name=name, text=text, relative=shown.kind == "standard deviation"
            )
            yield replace(of, scalar=scalar, cell=layout.figure(shown.end, shown.kind))
