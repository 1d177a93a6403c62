"""A vehicle from a reader's file: matrices arrive whole, in any axes and signs; what is no vehicle is one message."""

import json

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rov.hull import RovHull
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.systems.rov.own_vehicle import FLIPS, read_vehicle, vehicle_scene
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import initialized

ADDED = np.diag([6.0, 7.0, 18.0, 0.2, 0.15, 0.22]) + 0.02 * (1.0 - np.eye(6))
DRAG = np.diag([10.0, 12.0, 30.0, 0.5, 0.6, 0.4]) + 0.01 * np.arange(36.0).reshape(6, 6) * (1.0 - np.eye(6))
THRUSTERS = [
    {"position": [x, y, 0.05], "direction": d}
    for x, y, d in (
        (0.16, 0.11, [1, -1, 0]), (0.16, -0.11, [1, 1, 0]), (-0.16, 0.11, [-1, -1, 0]), (-0.16, -0.11, [-1, 1, 0]),
        (0.1, 0.22, [0, 0, 1]), (0.1, -0.22, [0, 0, 1]), (-0.2, 0.0, [0, 0, 1]),
    )
]  # fmt: skip
DATA = {
    "mass": 13.5, "inertia": [0.26, 0.23, 0.37], "centre_of_gravity": [0.01, 0.0, 0.02], "centre_of_buoyancy": [0.01, 0.0, -0.01],
    "added_mass": ADDED.tolist(), "linear_damping": DRAG.tolist(), "quadratic_damping": [60.0, 70.0, 80.0, 1.0, 1.1, 0.9],
    "thrusters": THRUSTERS,
}  # fmt: skip


def written(folder, **changes):
    path = folder / "vehicle.toml"
    data = {k: v for k, v in {**DATA, **changes}.items() if v is not None}
    path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in data.items()))
    return path


def toml(value) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return f"{{ {', '.join(f'{k} = {toml(v)}' for k, v in value.items())} }}" if isinstance(value, dict) else json.dumps(value)


def hull(path) -> RovHull:
    unit = read_scene(vehicle_scene(path), "own").units["hull"]
    return initialized(RovHull(unit.effects, unit.parameters))


def test_the_matrices_of_a_file_are_those_of_the_hull(tmp_path):
    own = hull(written(tmp_path))
    np.testing.assert_allclose(own.masses()[1], ADDED, rtol=1e-14)
    water = own.arguments[0].water
    np.testing.assert_allclose(water[0], ADDED - np.diag(ADDED.diagonal()), rtol=1e-14)
    np.testing.assert_allclose(water[1], DRAG - np.diag(DRAG.diagonal()), rtol=1e-14)
    assert own["linear_drag.heave"] == 30.0
    assert "quadratic_drag_coupling" not in own.on


def test_other_axes_and_signs_are_the_same_vehicle(tmp_path):
    """Forward, port, up: every second axis turns; derivatives are the negative matrices."""
    flip = FLIPS["forward-port-up"]
    turned = {k: (np.array(DATA[k]) * flip[:3]).tolist() for k in ("centre_of_gravity", "centre_of_buoyancy")}
    for key in ("added_mass", "linear_damping"):
        turned[key] = (-np.array(DATA[key]) * np.outer(flip, flip)).tolist()
    turned["quadratic_damping"] = [-v for v in DATA["quadratic_damping"]]
    turned["thrusters"] = [{k: (np.array(v) * flip[:3]).tolist() for k, v in t.items()} for t in THRUSTERS]
    plain = vehicle_scene(written(tmp_path))
    other = vehicle_scene(written(tmp_path, axes="forward-port-up", signs="derivatives", **turned))
    np.testing.assert_equal(other["units"]["hull"], plain["units"]["hull"])


def test_added_mass_of_a_panel_program(tmp_path):
    """A sphere beside the origin, m = 2/3 pi rho a^3 by its energy, in the program's axes; the infinite period (below 0) does not count."""
    density, length, radius, place = 1025.0, 2.0, 0.3, np.array([0.1, 0.05, 0.2])
    x, y, z = place

    def sphere(x, y, z):
        velocity = np.hstack([np.eye(3), [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]])  # of its centre, v + omega x r
        return 2.0 / 3.0 * np.pi * density * radius**3 * velocity.T @ velocity + 0.01 * np.diag([0, 0, 0, 1, 1, 1])

    scale = density * length ** (3.0 + (np.arange(6) > 2)[:, None] + (np.arange(6) > 2)[None, :])
    rows = [(-1.0, 9.0)] + [(period, factor) for period, factor in ((4.0, 2.0), (0.0, 1.0))]
    written_up = sphere(x, y, z) / scale
    lines = [
        f"{period:.4E} {i + 1} {j + 1} {factor * written_up[i, j]:.12E}"
        for period, factor in rows
        for i in range(6)
        for j in range(6)
        if written_up[i, j]
    ]
    (tmp_path / "hull.1").write_text(" title\n" + "\n".join(lines))
    for axes in FLIPS:  # those of the rest of the file
        own = read_vehicle(written(tmp_path, added_mass="hull.1", density=density, length=length, axes=axes))
        np.testing.assert_allclose(own["added_mass"], sphere(x, -y, -z), rtol=1e-10)
    for line, words in (
        ("0.0 7 1 0.3", f"line {len(lines) + 1}"),
        ("0.0 1 1 0.3", "a second row 1 1 of the period 0"),
        ("-1.0 1 1 0.3", "no row 4 4 of the period 0"),
    ):
        kept = [text for text in lines if words[:2] != "no" or not text.startswith(f"{0:.4E} 4 4")]
        (tmp_path / "hull.1").write_text("\n".join([*kept, line]))
        with pytest.raises(BadInput, match=words):
            read_vehicle(written(tmp_path, added_mass="hull.1"))


@pytest.mark.parametrize("sensors", [False, True])
def test_the_scene_keeps_the_vehicle_in_its_place(tmp_path, sensors):
    result = finished(read_scene(vehicle_scene(written(tmp_path), sensors) | {"stop_time": 30.0}, "own"))
    assert {row.name for row in result.summary} >= {"hull.position_error_rms", "hull.thrust_max"}
    assert abs(result["hull.depth"][-1] - 5.0) < (0.15 if sensors else 0.01)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"added_mass": (ADDED + np.eye(6)[[1]].T @ np.eye(6)[[3]]).tolist()}, "sway by roll and 0.02 for roll by sway"),
        ({"linear_damping": [-10.0, -12.0, -30.0, -0.5, -0.6, -0.4]}, "derivatives"),
        ({"linear_damping": [10.0, 12.0]}, "6 finite numbers"),
        ({"mass": "heavy"}, "a finite number"),
        ({"mass": None}, "no mass"),
        ({"axes": "east-north-up"}, "forward-port-up"),
        ({"thrusters": []}, "one to eight"),
        ({"thrusters": [{"position": [0.0, 0.0, 0.0]}]}, r"thrusters\[1\].direction"),
        ({"volume": 0.013}, "a key of a vehicle"),
        ({"inertia": [0.26, 0.23, 2.6]}, "none above the sum of both others"),
        ({"weight": 13.5}, "weight: got 13.5 N, expected 132.39 N"),
        ({"buoyancy": 13.6}, "buoyancy: got 0.103 of the weight"),
        ({"centre_of_buoyancy": [0.0, 0.0, -10.0]}, "centre_of_buoyancy: got a place 10 m from the origin"),  # mm
        ({"thrusters": [{"position": [0.1, 0.0, 0.0], "direction": [1, 0, 0], "thrust": 40}]}, "key 'thrust'"),
        ({"density": 1.025}, "density: got 1.025, expected 500 to 2000"),
        ({"depth": -5.0}, "depth is downwards"),
        ({"added_mass": [1e5, 1e5, 1e5, 1.0, 1.0, 1.0]}, "added_mass: got .* times the mass, expected at most 20"),
    ],
)
def test_what_is_no_vehicle_is_one_message(tmp_path, changes, words):
    with pytest.raises(BadInput, match=words):
        vehicle_scene(written(tmp_path, **changes))
