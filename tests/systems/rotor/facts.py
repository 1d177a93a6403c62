"""Rotors."""

from cosimo.tests.contract.facts import Facts

NO_SUPPORT = {f"linear_supports.{n}[{k}]": 0.0 for n in ("stiffness_x", "stiffness_y", "damping_x", "damping_y") for k in (1, 2)}
NO_DISK = {f"disks.{n}[{k}]": 0.0 for n in ("mass", "polar_inertia", "diametral_inertia") for k in (1, 2)}
NO_UNBALANCE = {"unbalance.moment[1]": 0.0}

FACTS: dict[str, Facts] = {
    "JeffcottRotor": Facts(
        moving=frozenset({"angle"}),
        plain=(("unbalance", "internal_damping", "gravity", "orthotropy", "run_up"), {}, 20),
        disturbance={"force_x": 10.0, "force_y": 5.0},
        strengths={
            "unbalance.eccentricity": ({}, 1e-6),
            "internal_damping.coefficient": ({}, 1e-3),
            "gravity.acceleration": ({}, 1e-3),
            "run_up.acceleration": ({}, 1e-3),
        },
        structural=frozenset({"high_order", "orthotropy"}),
        form=frozenset({"unbalance.phase", "run_up.end_speed", "run_up.start_time"}),
    ),
    "BeamRotor": Facts(
        small={"element": 0.75},
        moving=frozenset({"angle"}),
        plain=(
            (
                "gyroscopic",
                "disks",
                "unbalance",
                "internal_damping",
                "gravity",
                "run_up",
                "linear_supports",
                "bearing_a",
                "frame_rotation",
            ),
            {"element": 0.75, "substep": 5e-4},
            3,
        ),
        disturbance={"force_x": 10.0, "force_y": 5.0},
        step=2e-4,
        strengths={
            "disks.mass[1]": (NO_DISK, 1e-5),
            "disks.diametral_inertia[1]": (NO_DISK, 1e-7),
            "unbalance.moment[1]": (NO_UNBALANCE, 1e-4),
            "internal_damping.time_constant": ({}, 1e-9),
            "gravity.acceleration": ({}, 1e-3),
            "run_up.acceleration": ({}, 1e-3),
            **{
                f"linear_supports.{n}_{axis}[1]": (NO_SUPPORT, value)
                for axis in "xy"
                for n, value in (("stiffness", 1.0), ("damping", 1e-3))
            },
            "frame_rotation.rate_x": ({}, 1e-3),
            "frame_rotation.rate_y": ({}, 1e-3),
        },
        structural=frozenset({"shaft_table", "disk_table", "support_table", "gyroscopic", "bearing_a", "bearing_b"}),
        form=frozenset(
            {
                "disks.position",
                "disks.polar_inertia",
                "unbalance.phase",
                "run_up.end_speed",
                "run_up.start_time",
                "linear_supports.position",
                "frame_rotation.position",
            }
        ),
    ),
}
