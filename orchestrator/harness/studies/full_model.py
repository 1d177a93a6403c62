"""A scene with other effects on: with all that go together, with one of them less, with those that a study has chosen."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ....components.core.component import Component
from ....components.core.errors import BadInput, nearest, pick
from ....components.core.variables import Causality
from ...scene.scene import Scene

Place = tuple[str, str]  # unit, effect


@dataclass(frozen=True)
class Model:
    """A scene with effects. on: of every unit that is a component, in the order of their declaration.

    left: effects that are not in it, and why.
    """

    scene: Scene
    on: Mapping[str, tuple[str, ...]]
    left: Mapping[Place, str]

    @property
    def places(self) -> tuple[Place, ...]:
        """Every effect that is on."""
        return tuple((unit, effect) for unit, effects in self.on.items() for effect in effects)

    def dependents(self, place: Place) -> frozenset[Place]:
        """An effect, and those of its unit that cannot be without it."""
        unit, effect = place
        known, dependents = self.scene.component_classes[unit].effects, {effect}
        while more := {e for e in self.on[unit] if e not in dependents and dependents & set(known[e].requires)}:
            dependents |= more
        return frozenset((unit, e) for e in dependents)

    def without(self, dropped: Iterable[Place]) -> Scene:
        """The scene without some effects; raises `BadInput` where something else in it needs one of them."""
        gone = set(dropped)
        return with_effects(self.scene, {u: tuple(e for e in effects if (u, e) not in gone) for u, effects in self.on.items()})


def effects_on(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Effects of every unit that is a component, by itself or by its preset."""
    effects = {}
    for name, cls in scene.component_classes.items():
        unit = scene.units[name]
        on = {*unit.effects, *(cls.presets[unit.preset].effects if unit.preset else ())}
        effects[name] = tuple(e for e in cls.effects if e in on)
    return effects


def effect_changes(scene: Scene, wanted: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """The changes to exactly these effects; numbers of those that are off, and those that others replace, go with them.

    A preset that has effects which are not wanted is replaced by its numbers.
    """
    changes: dict[str, Any] = {}
    present = effects_on(scene)
    for name, cls in scene.component_classes.items():
        unit, on = scene.units[name], wanted[name]
        if on == present[name]:
            continue
        preset = cls.presets[unit.preset] if unit.preset else None
        parameters = dict(unit.parameters)
        if preset is not None and not set(preset.effects) <= set(on):
            changes[f"units.{name}.preset"] = ""
            parameters = {**preset.parameters, **parameters}
            preset = None
        gone = cls.effects.keys() - set(on) | cls.replaced(on).keys()
        changes[f"units.{name}.parameters"] = {
            k: v for k, v in parameters.items() if k.partition(".")[0].partition("[")[0] not in gone
        }
        changes[f"units.{name}.effects"] = [e for e in on if preset is None or e not in preset.effects]
    return changes


def with_effects(scene: Scene, wanted: Mapping[str, tuple[str, ...]]) -> Scene:
    """The scene with exactly these effects, see `effect_changes`."""
    changes = effect_changes(scene, wanted)
    return scene.with_changes(changes) if changes else scene


def full_model(scene: Scene, more: Iterable[str] = ()) -> Model:
    """The scene with every effect that goes together with its own, the earlier declared ones first.

    Left out are effects that only a scene can ask for and those with inputs, which nothing drives while they are off; `more`,
    "unit.effect", asks for some of them, and raises `BadInput` for what is none.
    """
    asked = _asked(scene, more)
    left: dict[Place, str] = {}
    on = {}
    for unit, cls in scene.component_classes.items():
        have = set(effects_on(scene)[unit])
        for effect in sorted(cls.effects, key=lambda e: (unit, e) not in asked):  # what is asked for comes first; else stable
            if effect in have:
                continue
            group = set(with_required(cls, effect)) - have
            clash = _clash(cls, group, have)
            alone = sorted(e for e in group if (unit, e) not in asked)
            if clash:
                left[unit, effect] = f"excluded by {clash!r}"
            elif any(cls.effects[e].explicit_only for e in alone):
                left[unit, effect] = "only where a scene asks for it"
            elif any(_has_inputs(cls, e) for e in alone):
                left[unit, effect] = "nothing drives its inputs"
            else:
                have |= group
        on[unit] = tuple(e for e in cls.effects if e in have)
    return Model(with_effects(scene, on), on, left)


def _asked(scene: Scene, more: Iterable[str]) -> set[Place]:
    places, known = set(), scene.component_classes
    for text in more:
        unit, effect = scene.split(text)
        pick(unit, known, f"{scene.name}: effects", "a component of the scene", "unit")
        if effect not in known[unit].effects:
            raise BadInput(
                f"{scene.name}: effects",
                repr(text),
                f"unit.effect with an effect of {known[unit].__name__}",
                nearest(effect, known[unit].effects),
            )
        places.add((unit, effect))
    return places


def with_required(cls: type[Component], effect: str) -> tuple[str, ...]:
    """An effect and everything it needs, in the order of declaration."""
    needed: set[str] = set()
    pending = [effect]
    while pending:
        needed.add(name := pending.pop())
        pending += set(cls.effects[name].requires) - needed
    return tuple(n for n in cls.effects if n in needed)


def _clash(cls: type[Component], group: Iterable[str], have: Iterable[str]) -> str:
    """One of `have` that one of the group excludes, or that excludes it; "" where all go together."""
    return next((b for b in sorted(have) for a in group if b in cls.effects[a].excludes or a in cls.effects[b].excludes), "")


def _has_inputs(cls: type[Component], effect: str) -> bool:
    return any(v.causality is Causality.INPUT for v in cls.effects[effect].variables)
