"""Contacts in the graph of a scene: each is a unit of its own between its two bodies, with connections to both."""

from __future__ import annotations

from collections.abc import Mapping

from ....components.core.errors import BadInput
from ...settings import ConnectionSettings, ContactSettings, SceneSettings
from ...settings.names import split_name
from ...units import Interface
from ...units.interface import Signal

SIDES = ("first", "second")
PARTS = {"position": "m", "velocity": "m/s", "acceleration": "m/s2", "compliance": "m/N"}
DIRECT = ("position", "velocity", "compliance")  # what the law goes by


def sources(contact: ContactSettings) -> dict[str, str]:
    """Inputs of a contact as a unit, with the unit.output each comes from: {"first_position": "head.height", ...}."""
    return {
        f"{label}_{part}": source
        for label in SIDES
        for part in PARTS
        if (source := getattr(getattr(contact, label), part)) is not None
    }


def describe_contact(contact: ContactSettings) -> Interface:
    """The interface of a contact with those inputs that the scene gives it."""
    names = list(sources(contact))
    units = {name: PARTS[name.partition("_")[2]] for name in names}
    direct = tuple(n for n in names if n.partition("_")[2] in DIRECT)
    return Interface(
        title=f"contact, {contact.law}",
        inputs={name: Signal(name, unit) for name, unit in units.items()},
        outputs={name: Signal(name, unit, feedthrough=direct) for name, unit in (("force", "N"), ("indentation", "m"))},
        effects={},
    )


def connections(contact: ContactSettings) -> dict[str, ConnectionSettings]:
    """Every connection of a contact by its place in the scene; the force pushes the bodies apart."""
    place = f"contacts.{contact.name}"
    table = {
        f"{place}.{name.replace('_', '.')}": ConnectionSettings(source=source, target=f"{contact.name}.{name}")
        for name, source in sources(contact).items()
    }
    for label, factor in zip(SIDES, (-1.0, 1.0), strict=True):
        target = getattr(contact, label).force
        table[f"{place}.{label}.force"] = ConnectionSettings(source=f"{contact.name}.force", target=target, factor=factor)
    return table


def check_contacts(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> None:
    """Names, and what the algorithm can do; raises `BadInput`."""
    names = [contact.name for contact in scene.contacts]
    for k, name in enumerate(names):
        if name in scene.units or name in names[:k]:
            raise BadInput("contacts", f"two of the name {name!r}", "a name that no unit and no other contact has")
    master = scene.master
    if not master.abilities.reduces_contacts:
        return
    if not names:
        raise BadInput(
            "master.algorithm",
            f"{master.algorithm!r} without contacts",
            "at least one [[contacts]]",
            "Or take another algorithm.",
        )
    if master.feedthrough == "delayed":
        raise BadInput(
            "master.feedthrough", f"'delayed' with {master.algorithm}", "'immediate'; a contact's force follows its bodies"
        )
    if master.control is not None and master.control.method != "doubling":
        raise BadInput(
            "master.control.method",
            f"{master.control.method!r} with {master.algorithm}",
            "'doubling'; the force of a contact is not extrapolated, so the others have nothing to measure it by",
        )
    for text in master.bonds:
        if any(end.strip().rpartition(".")[0] in names for end in text.split("*")):
            raise BadInput(
                f"master.bonds: {text!r}",
                f"a contact with {master.algorithm}",
                "other connections; a contact gives both bodies the same force, and its positions are not handed over",
            )
    leaders: dict[str, str] = {}
    followers: dict[str, str] = {}
    for contact in scene.contacts:
        if contact.leader is not None:
            sides = (contact.first, contact.second) if contact.leader == "first" else (contact.second, contact.first)
            for by_unit, side in zip((leaders, followers), sides, strict=True):
                by_unit[_unit(side.force, interfaces)] = contact.name
    if both := leaders.keys() & followers.keys():
        unit = min(both)
        raise BadInput(
            f"contacts.{leaders[unit]}.leader",
            f"{unit}, which follows in {followers[unit]!r}",
            "units that lead in all of their contacts or in none",
        )


def _unit(end: str, interfaces: Mapping[str, Interface]) -> str:
    """The unit of "unit.variable"."""
    return split_name(end, interfaces)[0]
