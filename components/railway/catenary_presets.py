"""Presets of the catenary."""

from __future__ import annotations

from ..core.component import Preset

PRESETS = {
    "EN 50318:2002": Preset(
        {"support_stiffness": 50e3, "dropper_stiffness": 100e3},
        "the defaults: repository ChandraguptSharma07/faraway; script after Liu et al., Appl. Sci. 13 (2023) 6819",
        "verbatim",
        ("dropper_slackening", "gravity_sag"),
    ),
    "EN 50318:2018 AC simple": Preset(
        {
            "substep": 2.5e-4,
            "span_length": 55.0,
            "contact_wire_tension": 22e3,
            "contact_wire_mass": 1.35,
            "messenger_tension": 16e3,
            "messenger_mass": 1.08,
            "droppers": 9,
            **{f"dropper_position[{i + 1}]": 4.5 + 5.75 * i for i in range(9)},
            "dropper_stiffness": 200e3,
            "dropper_mass": 0.117,
            "contact_clamp_mass": 0.165,
            "messenger_clamp_mass": 0.195,
            "support_stiffness": 500e3,
            "support_damping": 1000.0,
            "pre_sag.depth": 0.055,
            "bending_stiffness.contact_wire": 195.0,
            "bending_stiffness.messenger": 131.7,
            "damping.alpha": 0.0125,
            "damping.beta": 1e-4,
        },
        "repository vivek-nexus/pantograph-catenary-model-ui and a public MATLAB program; dropper stiffness and support "
        "damping from memory, steady arm left out",
        "unconfirmed",
        ("dropper_slackening", "gravity_sag", "pre_sag", "bending_stiffness", "damping"),
    ),
}
