"""Published vehicles: presets of `RovHull`, each with where its numbers were read."""

from __future__ import annotations

from ..core.component import Preset
from .arrangement import EIGHT, eight_places, sf_30k_arrangement

# added mass of the SF 30k beside its diagonal: Berg (2012) p. 28 as copied; 10.774 and 10.775 for heave and yaw, here the mean
SF_30K = {
    "force": (-6.8773, -103.32, 51.29),
    "mixed": (8.5426, -165.54, -7.8033, 409.44, -5.8488, 62.726, 6.1112, -386.42, 10.7745),
    "moment": (-10.027, 21.019, -1.1162),
}
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def coefficients(effect: str, *values: float) -> dict[str, float]:
    """The six numbers of an effect by name."""
    return {f"{effect}.{axis}": value for axis, value in zip(AXES, values, strict=True)}


WATER = ("added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring")

VEHICLES = {
    "Wu 2018, BlueROV2 Heavy": Preset(
        {
            "mass": 11.5,
            "inertia_x": 0.16,
            "inertia_y": 0.16,
            "inertia_z": 0.16,
            "centre_of_gravity_z": 0.02,
            **coefficients("added_mass", 5.5, 12.7, 14.57, 0.12, 0.12, 0.12),
            **coefficients("linear_drag", 4.03, 6.22, 5.18, 0.07, 0.07, 0.07),
            **coefficients("quadratic_drag", 18.18, 21.66, 36.99, 1.55, 1.55, 1.55),
            "restoring.weight": 112.8,
            "restoring.buoyancy": 114.8,
        },
        "Wu (2018), as copied in the repositories OsloMet-OceanLab/BlueROV2 and CentraleNantesROV/bluerov2; thrusters in the "
        "Y-arrangement, which is not that vehicle's",
        "verbatim",
        WATER,
    ),
    "von Benzon 2022, BlueROV2 Heavy": Preset(
        {
            "mass": 13.5,
            "inertia_x": 0.26,
            "inertia_y": 0.23,
            "inertia_z": 0.37,
            "centre_of_gravity_z": 0.0,
            **coefficients("added_mass", 6.36, 7.12, 18.68, 0.189, 0.135, 0.222),
            **coefficients("linear_drag", 13.7, 0.0, 33.0, 0.0, 0.8, 0.0),
            **coefficients("quadratic_drag", 141.0, 217.0, 190.0, 1.19, 0.47, 1.5),
            "restoring.weight": 13.5 * 9.82,
            "restoring.buoyancy": 1000.0 * 0.0134 * 9.82,
            "restoring.centre_of_buoyancy_z": -0.01,
        },
        "von Benzon et al. (2022), as copied in the repository ViktorNfa/bluerov2_dynamics, whose comments note missing "
        "minus signs of added mass and damping, the angle of thruster 3 and one sign of the Coriolis matrix in print; here "
        "the matrix follows from the masses. Another copy has 6.3567, 7.1206, 18.6863, 0.1858, 0.1348, 0.2215 as added mass. "
        "Thrusters in the Y-arrangement, which is not that vehicle's",
        "verbatim",
        WATER,
    ),
    "Li 2020, BlueROV2": Preset(
        {
            **coefficients("linear_drag", 1.31, 9.14, 2.015, 0.0, 0.0, 0.0),
            **coefficients("quadratic_drag", 38.17, 129.6, 243.2, 0.0, 0.0, 4.86),
        },
        "drag of Li et al. (2020), as copied in the repository CentraleNantesROV/bluerov2, which notes that the paper has no "
        "added mass; drag about x and y is missing too and 0 here. Mass and inertia are those of Wu (2018)",
        "verbatim",
        ("coriolis", "linear_drag", "quadratic_drag"),
    ),
    EIGHT: Preset(
        eight_places(),
        "four horizontal thrusters of a public allocation script for this vehicle, four vertical ones of von Benzon et al. "
        "(2022), from memory; masses and drag are the component's own, those of Wu (2018)",
        "unconfirmed",
        (*WATER, "further_thrusters"),
    ),
    "Berg 2012, SF 30k": Preset(
        {
            "mass": 1862.87,
            "inertia_x": 525.39,
            "inertia_y": 794.2,
            "inertia_z": 691.23,
            "centre_of_gravity_z": 0.0,
            **coefficients("added_mass", 779.79, 1222.0, 3659.9, 534.9, 842.69, 224.32),
            **{f"added_mass_coupling.{name}[{i}]": v for name, row in SF_30K.items() for i, v in enumerate(row, 1)},
            **coefficients("linear_drag", 74.82, 69.48, 728.4, 268.8, 309.77, 105.0),
            **coefficients("quadratic_drag", 748.22, 992.53, 1821.01, 672.0, 774.44, 523.27),
            "restoring.weight": 1862.87 * 9.81,
            "restoring.buoyancy": 1028.0 * 1.83826 * 9.81,
            "restoring.centre_of_buoyancy_z": -0.3,
            **eight_places(sf_30k_arrangement()),
        },
        "Berg (2012), a work-class vehicle, as copied in the repository uuvsimulator/uuv_simulator (RexROV), whose comments name the "
        "pages and say that the centre of buoyancy is its own correction, (0, 0, 0.3) m above; density 1028 kg/m3 of that "
        "repository, its products of inertia of at most 33 kg.m2 left out. Thrusters of that copy",
        "verbatim",
        (*WATER, "added_mass_coupling", "further_thrusters"),
    ),
}
