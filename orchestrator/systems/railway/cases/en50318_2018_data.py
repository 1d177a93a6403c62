"""The numbers of the three models of EN 50318:2018 in the scenes, each with its standing: none was read in the standard."""

from __future__ import annotations

from typing import Any

from .....components.railway.line.dropper_table import line_of

REPOSITORIES = "two public programs of the benchmark's catenary"
DRAWING = "a public program's drawing of the model, measured to 0.3 m"
RE_330 = "the class Re 330; that the model is of this class is weak"
ITALIAN = "the Italian 540 mm² line for 3 kV; that the model is of this class is weak"
# what, name of a parameter or key of the line's first section, unit, standing, source
Datum = tuple[str, str, str, str, str]
COMMON: tuple[Datum, ...] = (
    ("damping of the wires, α", "damping.alpha", "1/s", "unconfirmed", "the benchmark, as a public script uses it"),
    ("damping of the wires, β", "damping.beta", "s", "unconfirmed", "the benchmark, as a public script uses it"),
)
DATA: dict[str, tuple[Datum, ...]] = {
    "en50318-2018-ac-simple": (
        ("span", "span_length", "m", "read", REPOSITORIES),
        ("contact wire, tension", "contact_wire_tension", "N", "read", REPOSITORIES),
        ("contact wire, mass", "contact_wire_mass", "kg/m", "read", REPOSITORIES),
        ("contact wire, EI", "bending_stiffness.contact_wire", "N m²", "read", "one public program; another has 179"),
        ("messenger, tension", "messenger_tension", "N", "read", REPOSITORIES),
        ("messenger, mass", "messenger_mass", "kg/m", "read", REPOSITORIES),
        ("messenger, EI", "bending_stiffness.messenger", "N m²", "read", "one public program; another has 111"),
        ("first dropper", "dropper_position[1]", "m", "read", REPOSITORIES),
        ("droppers in a span", "droppers", "1", "read", REPOSITORIES),
        ("pre-sag", "pre_sag.depth", "m", "read", REPOSITORIES),
        ("dropper, stiffness", "dropper_stiffness", "N/m", "unconfirmed", "public programs use 200 kN as EA"),
        ("dropper, mass", "dropper_mass", "kg", "inferred", "0.117 kg/m read, taken as that of 1 m"),
        ("clamp on the contact wire", "contact_clamp_mass", "kg", "read", REPOSITORIES),
        ("clamp on the messenger", "messenger_clamp_mass", "kg", "read", REPOSITORIES),
        ("messenger support, stiffness", "support_stiffness", "N/m", "read", REPOSITORIES),
        ("messenger support, damping", "support_damping", "N s/m", "unconfirmed", "that there is one was read"),
        *COMMON,
    ),
    "en50318-2018-ac-stitched": (
        ("span", "spans[0].length", "m", "inferred", DRAWING),
        ("contact wire, tension", "contact_wire.tension", "N", "unconfirmed", RE_330),
        ("contact wire, mass", "contact_wire.mass", "kg/m", "unconfirmed", RE_330),
        ("contact wire, EI", "contact_wire.bending", "N m²", "inferred", "195 N m² of 150 mm² by the squared section"),
        ("messenger, tension", "messenger.tension", "N", "unconfirmed", RE_330),
        ("messenger, mass", "messenger.mass", "kg/m", "unconfirmed", RE_330),
        ("messenger, EI", "messenger.bending", "N m²", "inferred", "as AC simple"),
        ("stitch wire, half of its length", "stitch.half_length", "m", "inferred", DRAWING),
        ("stitch wire, tension", "stitch.tension", "N", "unconfirmed", RE_330),
        ("stitch wire, mass", "stitch.mass", "kg/m", "unconfirmed", RE_330),
        ("first dropper, on the stitch", "span.positions[0]", "m", "inferred", DRAWING),
        ("second dropper", "span.positions[1]", "m", "inferred", DRAWING),
        ("dropper, stiffness", "droppers.stiffness", "N/m", "inferred", "as AC simple"),
        ("clamp on the contact wire", "droppers.contact_clamp", "kg", "inferred", "as AC simple"),
        ("clamp on the messenger", "droppers.messenger_clamp", "kg", "inferred", "as AC simple"),
        ("system height", "support.system_height", "m", "unconfirmed", RE_330),
        ("messenger support, stiffness", "support.stiffness", "N/m", "inferred", "as AC simple"),
        ("messenger support, damping", "support.damping", "N s/m", "inferred", "as AC simple"),
        *COMMON,
    ),
    "en50318-2018-dc-simple": (
        ("span", "spans[0].length", "m", "inferred", DRAWING),
        ("each contact wire, tension", "contact_wire.tension", "N", "unconfirmed", ITALIAN),
        ("each contact wire, mass", "contact_wire.mass", "kg/m", "unconfirmed", ITALIAN),
        ("messenger, both ropes as one, tension", "messenger.tension", "N", "unconfirmed", ITALIAN),
        ("messenger, both ropes as one, mass", "messenger.mass", "kg/m", "unconfirmed", ITALIAN),
        ("first dropper of the first wire", "span.positions[0]", "m", "inferred", DRAWING),
        ("first dropper of the second wire", "span.second_positions[0]", "m", "inferred", DRAWING),
        ("dropper, stiffness", "droppers.stiffness", "N/m", "inferred", "as the model of 2002"),
        ("clamp on the contact wire", "droppers.contact_clamp", "kg", "inferred", "as AC simple"),
        ("system height", "support.system_height", "m", "unconfirmed", ITALIAN),
        ("messenger support, stiffness", "support.stiffness", "N/m", "inferred", "as AC simple"),
        *COMMON,
    ),
}


def model_data(name: str, catenary: Any) -> list[tuple[str, ...]]:
    """What the catenary of a model is made of, from the catenary itself, and how each number is known."""
    return [(what, f"{_value(catenary, key):g}", unit, standing, source) for what, key, unit, standing, source in DATA[name]]


def _value(catenary: Any, key: str) -> float:
    if key in catenary.parameters:
        return float(catenary.parameters[key])
    value: Any = line_of(catenary.parameters).sections[0]
    for part in key.split("."):
        name, _, index = part.partition("[")
        value = getattr(value, name)
        value = value[int(index[:-1])] if index else value
    return float(value)
