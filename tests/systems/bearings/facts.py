"""Bearings and their heat."""

from cosimo.tests.contract.facts import Facts

# Every ball moves: nothing of a turning bearing is at rest.
MOVING = frozenset({"*"})
TWO_DOF_FORM = frozenset(
    {
        "unbalance.phase",
        "inner_waviness.order",
        "inner_waviness.phase",
        "outer_waviness.order",
        "outer_waviness.phase",
        "inner_defect.width",
        "inner_defect.position",
        "outer_defect.width",
        "outer_defect.position",
        "ball_defect.width",
        "ball_defect.position",
        "ball_defect.ball",
        "cage_fault.ball",
        "load_variation.frequency",
        "load_variation.phase",
        "speed_ramp.duration",
    }
)


def two_dof(length: float, force: float, acceleration: float, damping: float) -> dict[str, tuple[dict[str, float], float]]:
    """Strengths of the bearing's effects; `length`, `force` ... are small in the form's own units."""
    passing = {"position": 0.05, "width": 0.2}
    return {
        "clearance.radial_clearance": ({}, length),
        "contact_damping.coefficient": ({}, damping),
        "unbalance.eccentricity": ({}, length),
        "inner_waviness.amplitude[1]": ({}, length),
        "outer_waviness.amplitude[1]": ({}, length),
        **{
            f"{ring}_defect.depth": ({f"{ring}_defect.{n}": v for n, v in passing.items()}, length)
            for ring in ("inner", "outer", "ball")
        },
        "cage_fault.offset": ({}, 1e-5),
        "load_variation.amplitude": ({}, force),
        "speed_ramp.acceleration": ({}, acceleration),
    }


EVERYTHING = ("clearance", "contact_damping", "unbalance", "inner_waviness", "outer_defect", "ball_defect", "speed_ramp")
FACTS: dict[str, Facts] = {
    "BallBearing": Facts(
        moving=MOVING,
        plain=(EVERYTHING, {}, 20),
        disturbance={"load": 250.0, "speed": 100.0},  # at the default speed a step ends just where the angle is wrapped
        strengths=two_dof(1e-10, 1e-3, 1e-3, 1e-4),
        structural=frozenset({"given_start"}),
        form=TWO_DOF_FORM,
    ),
    "DimensionlessBallBearing": Facts(
        moving=MOVING,
        plain=(EVERYTHING, {}, 200),
        disturbance={"load": 1.3, "speed": 0.08},
        step=1.0,
        strengths=two_dof(1e-5, 1e-5, 1e-8, 1e-6),
        structural=frozenset({"given_start"}),
        form=TWO_DOF_FORM,
    ),
    "AngularContactConductance": Facts(
        plain=(("ball_bulk", "film", "gas_path", "radiation"), {"axial_force": 500.0}, 20),
        disturbance={"axial_force": 500.0, "radial_force": 300.0},
        strengths={
            "film.thickness": ({}, 1e-10),
            "lubricant_path.conductivity": ({}, 1e-6),
            "gas_path.conductivity": ({}, 1e-6),
            "convection.coefficient": ({}, 1e-2),
            "radiation.emissivity": ({}, 1e-3),
        },
        structural=frozenset({"ball_bulk", "ring_walls"}),
        form=frozenset(
            {
                "film.conductivity",
                "lubricant_path.meniscus_height",
                "gas_path.widest_gap",
                "gas_path.ring_gap",
                "radiation.inner_temperature",
                "radiation.outer_temperature",
            }
        ),
    ),
    "BearingTemperatures": Facts(
        slopes=0.01,  # temperatures above zero kelvin
        plain=(("housing", "oil_flow", "radiation", "shaft_heat"), {"friction_power": 20.0}, 20),
        disturbance={"friction_power": 20.0, "ambient": 300.0},
        step=10.0,
        strengths={
            "oil_flow.capacity_rate": ({}, 1e-4),
            "radiation.emissivity": ({}, 1e-4),
            "radiation.area": ({}, 1e-6),
            "shaft_heat.power": ({}, 1e-3),
        },
        structural=frozenset({"housing"}),
        form=frozenset({"oil_flow.inlet_temperature"}),
    ),
    "DeepGrooveBearing": Facts(
        plain=(
            (
                *(
                    "film",
                    "damping",
                    "inner_waviness",
                    "outer_defect",
                    "ball_defect",
                    "linearisation",
                    "friction",
                    "thermal_growth",
                ),
                *("rating_life", "life_factor", "ball_inertia", "oil_friction", "skf_friction", "cage_slip"),
            ),
            {"diametral_clearance": 5e-6},
            20,
        ),
        disturbance={
            "displacement_x": 2e-5,
            "displacement_y": -1e-5,
            "tilt_x": 1e-4,
            "velocity_x": 1e-3,
            "tilt_rate_y": 1e-2,
            "speed": 30.0,
        },
        strengths={
            "damping.factor": ({}, 1e-8),
            **{f"{ring}_waviness.amplitude[1]": ({}, 1e-10) for ring in ("inner", "outer")},
            **{
                f"{ring}_defect.depth": ({f"{ring}_defect.position": 0.05, f"{ring}_defect.width": 0.2}, 1e-10)
                for ring in ("inner", "outer", "ball")
            },
            "thermal_growth.clearance_change": ({}, 1e-10),
        },
        # A film vanishes with the power 0.67 of its viscosity; linearisation, friction and life change no output of the bearing's own.
        # Balls without inertia are those without the effect to rounding, not to the bit: see test_ball_inertia. A cage slips with any
        # values, see test_cage_slip.
        structural=frozenset(
            {
                "film",
                "published_levers",
                "linearisation",
                "friction",
                "oil_friction",
                "skf_friction",
                "rating_life",
                "life_factor",
                "ball_inertia",
                "cage_slip",
            }
        ),
        form=frozenset(
            {
                "inner_waviness.order",
                "inner_waviness.phase",
                "outer_waviness.order",
                "outer_waviness.phase",
                "inner_defect.width",
                "inner_defect.position",
                "outer_defect.width",
                "outer_defect.position",
                "ball_defect.width",
                "ball_defect.position",
                "ball_defect.ball",
            }
        ),
    ),
}
