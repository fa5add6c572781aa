"""Where bodies are and how they move at the start, against homogeneous matrices and differences of them in time."""

import json

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from sigmafmu import _core

from .helpers import BALL, HEAD, complaint, read

EPS = float(np.finfo(float).eps)
X, Y, Z = np.eye(3)
ANGLE, SHIFT = ("coordinate", "rate", "turn", Z), ("coordinate", "rate", "shift", Z)
TYPES = {
    "spherical": [],
    "revolute": [ANGLE],
    "prismatic": [SHIFT],
    "fixed": [],
    "cylindrical": [ANGLE, ("displacement", "displacement_rate", "shift", Z)],
    "universal": [("coordinate1", "rate1", "turn", Y), ("coordinate2", "rate2", "turn", X)],
    "planar": [
        ANGLE,
        ("displacement1", "displacement_rate1", "shift", X),
        ("displacement2", "displacement_rate2", "shift", Y),
    ],
    "point_on_line": [SHIFT],
    "free": [(f"coordinate{i + 1}", f"rate{i + 1}", "shift", axis) for i, axis in enumerate((X, Y, Z))],
}
"""Types of joints that place a body → keys of their coordinates and rates, and what these do along or about which axis
of frame 1; of turns the second one follows the first."""


def moved(kind, x, t):
    """Frame 2 from frame 1 at time t; x has (value, rate) of each coordinate."""
    shift, turn = np.zeros(3), Rotation.identity()
    for (_, _, what, axis), (value, rate) in zip(TYPES[kind], x, strict=True):
        if what == "turn":
            turn = turn * Rotation.from_rotvec((value + rate * t) * axis)
        else:
            shift = shift + (value + rate * t) * axis
    return pose(shift, turn)


def pose(position, rotation):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotation.as_matrix(), position
    return result


def random_frame(rng):
    """As a file has it, and as a matrix."""
    position, vector = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    frame = {"position": position.tolist(), "orientation": {"rotation_vector": vector.tolist()}}
    return frame, pose(position, Rotation.from_rotvec(vector))


def random_tree(seed, count=5):
    """A file whose bodies hang on each other by frames, and a function of time: poses of the bodies' centres of mass.

    The first body moves freely; coordinates grow with their rates.
    """
    rng = np.random.default_rng(seed)
    names = [f"b{i}" for i in range(count)]
    offsets = rng.uniform(-1, 1, (count, 3))
    bodies = {
        name: {"mass": 1, "inertia": [1, 1, 1], "center_of_mass": offset.tolist()}
        for name, offset in zip(names, offsets, strict=True)
    }
    position, rpy = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    velocity, spin = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    bodies["b0"] |= {"position": position.tolist(), "orientation": {"rpy": rpy.tolist()}}
    bodies["b0"] |= {"velocity": velocity.tolist(), "angular_velocity": spin.tolist()}
    joints, links = {}, []
    for i in range(1, count):
        parent, kind = int(rng.integers(i)), list(TYPES)[rng.integers(len(TYPES))]
        (one, first), (two, second) = random_frame(rng), random_frame(rng)
        forward = rng.random() < 0.6
        x = rng.uniform(-1.5, 1.5, (len(TYPES[kind]), 2))
        values = {
            key: float(v)
            for keys, row in zip(TYPES[kind], x, strict=True)
            for key, v in zip(keys[:2], row, strict=True)
        }
        ends = [names[parent], names[i]] if forward else [names[i], names[parent]]
        joints[f"j{i}"] = {"type": kind, "bodies": ends, "frame1": one, "frame2": two, **values}
        links.append((parent, i, forward, first, second, kind, x))
    # joints that hold later bodies may come first in the file
    order = rng.permutation(list(joints))
    file = {"sigmafmu": 1, "name": "Tree", "bodies": bodies, "joints": {name: joints[name] for name in map(str, order)}}

    def poses(t):
        turn = Rotation.from_euler("ZYX", rpy[::-1]) * Rotation.from_rotvec(spin * t)
        start = Rotation.from_euler("ZYX", rpy[::-1])
        centre = position + start.apply(offsets[0]) + velocity * t
        frames = {0: pose(centre - turn.apply(offsets[0]), turn)}
        for parent, child, forward, first, second, kind, x in links:
            between = first @ moved(kind, x, t) @ np.linalg.inv(second)
            frames[child] = frames[parent] @ (between if forward else np.linalg.inv(between))
        return [frames[i] @ pose(offsets[i], Rotation.identity()) for i in range(count)]

    return file, poses


@pytest.mark.parametrize("seed", range(40))
def test_bodies_hang_where_joints_hold_them_and_move_with_them(seed):
    file, poses = random_tree(seed)
    found = read(yaml.safe_dump(file, sort_keys=False))
    h = 1e-3
    # sixth-order differences: h^6 / 140 of the seventh derivative, and rounding eps / h
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    at = {k: poses(k * h) for k in (-3, -2, -1, 1, 2, 3)}
    for i, (body, matrix) in enumerate(zip(found.definition["bodies"], poses(0.0), strict=True)):
        R = Rotation.from_quat(body["orientation"]["quaternion"], scalar_first=True).as_matrix()
        np.testing.assert_allclose(body["position"], matrix[:3, 3], atol=50 * EPS)
        np.testing.assert_allclose(R, matrix[:3, :3], atol=50 * EPS)
        rate = sum(w * (at[k][i] - at[-k][i]) for k, w in weights.items()) / h
        spin = R.T @ rate[:3, :3]
        np.testing.assert_allclose(body["velocity"], rate[:3, 3], atol=1e-10)
        np.testing.assert_allclose(body["angular_velocity"], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-10)
    assert not found.moves
    assert set(found.placed_by) == {f"b{i}" for i in range(1, 5)}


BAR = "{mass: 1, inertia: [1, 1, 1], center_of_mass: [0.5, 0, 0]}"


def test_the_first_joint_in_the_file_places_a_body_that_two_hold():
    text = (
        HEAD + f"bodies:\n  a: {BAR}\njoints:\n"
        "  low: {type: spherical, bodies: [ground, a], frame1: {position: [0, 0, 1]}}\n"
        "  high: {type: spherical, bodies: [ground, a], frame1: {position: [1, 0, 1]}, frame2: {position: [1, 0, 0]}}\n"
    )
    assert read(text).placed_by == {"a": "low"}
    swapped = text.replace("low:", "x:").replace("high:", "low:").replace("x:", "high:")
    assert read(swapped).placed_by == {"a": "high"}


def test_a_body_that_no_joint_places_is_at_the_origin_and_carries_others():
    found = read(
        HEAD + f"bodies:\n  b: {BAR}\n  a: {BAR}\njoints:\n"
        "  j: {type: fixed, bodies: [a, b], frame1: {position: [1, 0, 0]}}\n"
    )
    b, a = (body["position"] for body in found.definition["bodies"])
    assert b == [0.5, 0, 0]  # the first without a place
    assert a == [-0.5, 0, 0]


def test_geometry_in_w_leaves_bodies_at_the_origin_of_w():
    """As drawn: with no position, a body's frame is W, and points in W are points in it."""
    found = read(
        HEAD + f"bodies:\n  a: {BAR}\n  b: {{mass: 1, inertia: [1, 1, 1], center_of_mass: [1.5, 0, 0]}}\njoints:\n"
        "  j: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  k: {type: revolute, bodies: [a, b], point: [1, 0, 0], axis: [0, 1, 0]}\n"
    )
    assert [body["position"] for body in found.definition["bodies"]] == [[0.5, 0, 0], [1.5, 0, 0]]
    k = found.definition["joints"][1]
    assert k["frame1"]["position"] == [0.5, 0, 0]
    assert k["frame2"]["position"] == [-0.5, 0, 0]


def test_what_is_drawn_in_w_comes_before_what_hangs_on_it():
    found = read(
        HEAD + f"bodies:\n  b: {BAR}\n  a: {BAR}\njoints:\n"
        "  j: {type: fixed, bodies: [a, b], frame1: {position: [1, 0, 0]}}\n"
        "  k: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 1, 0]}\n"
    )
    assert found.placed_by == {"b": "j"}
    assert [body["position"] for body in found.definition["bodies"]] == [[1.5, 0, 0], [0.5, 0, 0]]


def start_values(found):
    slave = _core.Slave(found.mechanism)
    slave.start()
    return slave.get


@pytest.mark.parametrize("coordinate", [0.0, 0.7, -3.0])
def test_a_coordinate_given_with_geometry_in_w_is_what_the_joint_has(coordinate):
    get = start_values(
        read(
            HEAD + f"bodies:\n  a: {BAR}\njoints:\n  j: {{type: revolute, bodies: [ground, a], point: [1, 2, 3], "
            f"axis: [1, 1, 1], coordinate: {coordinate}, rate: 2}}"
        )
    )
    assert get("j.angle") == pytest.approx(coordinate, abs=1e-13)
    assert get("j.angularRate") == pytest.approx(2, abs=1e-13)
    assert get("a.position[1]") == pytest.approx(0.5, abs=1e-13)


def test_whole_turns_of_a_coordinate_count():
    found = read(
        HEAD + f"bodies:\n  a: {BAR}\njoints:\n"
        "  i: {type: revolute, bodies: [ground, a], point: [0, 0, 0], axis: [0, 0, 1], coordinate: -1000 deg}"
    )
    assert _core.Simulation(found.mechanism).state.turned[0] == pytest.approx(np.radians(-1000), abs=1e-13)


def test_displacements_count_from_where_frame_1_is():
    found = read(
        HEAD + f"bodies:\n  a: {BAR}\njoints:\n  j: {{type: cylindrical, bodies: [ground, a], point: [1, 0, 0], "
        "axis: [0, 0, 2], coordinate: 1 rad, displacement: 200 mm, displacement_rate: 3}"
    )
    joint = found.definition["joints"][0]
    np.testing.assert_allclose(joint["frame1"]["position"], [1, 0, -0.2], atol=EPS)
    np.testing.assert_allclose(joint["frame2"]["position"], [0.5, 0, 0], atol=EPS)
    get = start_values(found)
    assert get("j.displacement") == pytest.approx(0.2, abs=1e-14)
    assert get("j.rate") == pytest.approx(3, abs=1e-13)


def test_the_axes_of_a_universal_joint_are_those_of_the_cross():
    """y of frame 1 in the first body, x of frame 2 in the second, wherever these are."""
    rng = np.random.default_rng(1)
    turns = [Rotation.random(rng=rng) for _ in range(2)]
    axis1 = rng.uniform(-1, 1, 3)
    axis2 = np.cross(axis1, rng.uniform(-1, 1, 3))
    bodies = {
        name: {
            "mass": 1,
            "inertia": [1, 1, 1],
            "position": rng.uniform(-1, 1, 3).tolist(),
            "orientation": {"quaternion": turn.as_quat(scalar_first=True).tolist()},
        }
        for name, turn in zip("ab", turns, strict=True)
    }
    joint = {"type": "universal", "bodies": ["a", "b"], "point": [1, 2, 3]}
    joint |= {"axis1": axis1.tolist(), "axis2": axis2.tolist()}
    file = {"sigmafmu": 1, "name": "Cross", "bodies": bodies, "joints": {"j": joint}}
    found = read(json.dumps(file)).definition["joints"][0]
    frames = [np.array(found[key]["orientation"]["matrix"]) for key in ("frame1", "frame2")]
    for R, frame, column, axis in zip(turns, frames, (1, 0), (axis1, axis2), strict=True):
        np.testing.assert_allclose(R.apply(frame[:, column]), axis / np.linalg.norm(axis), atol=10 * EPS)
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=10 * EPS)


SLIDER = f"""{HEAD}bodies:
  crank: {{mass: 1, inertia: [1, 1, 1], center_of_mass: [0.5, 0, 0]}}
  rod: {{mass: 1, inertia: [1, 1, 1], center_of_mass: [1, 0, 0]}}
  slider: {{mass: 1, inertia: [1, 1, 1], position: [2.7, 0, 0]}}
joints:
  turn: {{type: revolute, bodies: [ground, crank], frame1: {{}}, coordinate: 0.8, rate: 3}}
  pin: {{type: revolute, bodies: [crank, rod], frame1: {{position: [1, 0, 0]}}}}
  slide:
    type: prismatic
    bodies: [ground, slider]
    frame1: {{orientation: {{rotation_vector: [0, 90 deg, 0]}}}}
    frame2: {{orientation: {{rotation_vector: [0, 90 deg, 0]}}}}
  wrist: {{type: revolute, bodies: [rod, slider], frame1: {{position: [2, 0, 0]}}}}
"""


def test_a_loop_closes_around_the_coordinates_and_rates_of_the_file():
    """Crank 1 m and rod 2 m: s = cos a + sqrt(4 - sin² a) and its derivative, with a = 0.8 and a' = 3."""
    found = read(SLIDER)
    get = start_values(found)
    root = np.sqrt(4 - np.sin(0.8) ** 2)
    assert get("turn.angle") == pytest.approx(0.8, abs=1e-12)
    assert get("turn.angularRate") == pytest.approx(3, abs=1e-12)
    assert get("slide.displacement") == pytest.approx(np.cos(0.8) + root, abs=1e-11)
    assert get("slide.rate") == pytest.approx(-3 * np.sin(0.8) * (1 + np.cos(0.8) / root), abs=1e-11)
    assert {move.body for move in found.moves} == {"rod", "slider"}


def test_a_coordinate_out_of_reach_names_the_joints():
    message = complaint(SLIDER.replace("  slide:\n", "  slide:\n    coordinate: 4 m\n"))
    assert "slide" in message
    assert "turn" in message


def test_inertia_in_other_axes_is_turned():
    turn = Rotation.from_euler("ZYX", [0.3, -0.5, 0.9])
    text = HEAD + "bodies: {a: {mass: 1, inertia: [1, 2, 2.5], inertia_axes: {rpy: [0.9, -0.5, 0.3]}}}"
    body = read(text).definition["bodies"][0]["inertia"]
    J = turn.as_matrix() @ np.diag([1, 2, 2.5]) @ turn.as_matrix().T
    np.testing.assert_allclose([body[k] for k in ("xx", "yy", "zz")], np.diag(J), atol=10 * EPS)
    np.testing.assert_allclose([body[k] for k in ("xy", "xz", "yz")], [J[0, 1], J[0, 2], J[1, 2]], atol=10 * EPS)


def test_a_drive_moves_its_joint_to_where_it_prescribes():
    get = start_values(
        read(
            HEAD + f"bodies:\n  a: {BALL}\njoints:\n  j: {{type: revolute, bodies: [ground, a], frame1: {{}}}}\n"
            "drives: {j: {motion: rate, value: 60 rpm}}"
        )
    )
    assert get("j.angularRate") == pytest.approx(2 * np.pi, rel=1e-14)


@pytest.mark.parametrize(
    "kind", ["revolute", "prismatic", "cylindrical", "universal", "planar", "point_on_line", "free"]
)
def test_coordinates_with_geometry_in_w_are_what_the_joint_has(kind):
    """All of them and their rates; frame 2 is at the point and the axes are where the file says."""
    rng = np.random.default_rng(5)
    values = dict(zip([key for keys in TYPES[kind] for key in keys[:2]], rng.uniform(-1, 1, 6).tolist(), strict=False))
    geometry = {"universal": {"axis1": [0, 3, 4], "axis2": [1, 0, 0]}, "planar": {"normal": [1, 2, 2]}, "free": {}}
    joint = {
        "type": kind,
        "bodies": ["a", "b"],
        "point": [1, 2, 3],
        **geometry.get(kind, {"axis": [2, 1, 2]}),
        **values,
    }
    body = {"mass": 1, "inertia": [1, 1, 1], "orientation": {"rpy": [1, 2, 3]}, "position": [0, 0, 1]}
    other = {"mass": 1, "inertia": [1, 1, 1], "orientation": {"rpy": [3, 2, 1]}, "position": [1, 0, 0]}
    found = read(json.dumps({"sigmafmu": 1, "name": "One", "bodies": {"a": body, "b": other}, "joints": {"j": joint}}))
    q, v = _core.assemble(found.mechanism.multibody)
    x, rates = _core.System(found.mechanism.multibody).coordinates(q, v)
    np.testing.assert_allclose(x, list(values.values())[::2], atol=1e-13)
    np.testing.assert_allclose(rates, list(values.values())[1::2], atol=1e-12)
    at = found.definition["joints"][0]["frame2"]["position"]
    place = np.array([1, 0, 0]) + Rotation.from_euler("ZYX", [1, 2, 3]).apply(at)
    np.testing.assert_allclose(place, [1, 2, 3], atol=20 * EPS)


def test_a_rod_keeps_its_distance_or_has_a_length():
    text = (
        HEAD + f"bodies:\n  a: {BALL}\njoints:\n  j: {{type: distance, bodies: [ground, a], point1: [0, 0, 2], "
        "point2: [0, 0, 0.5]%s}\n"
    )
    get = start_values(read(text % ""))
    assert get("a.position[3]") == pytest.approx(0, abs=1e-14)
    found = read(text % ", length: 2 m")
    assert [move.body for move in found.moves] == ["a"]
    q, _ = _core.assemble(found.mechanism.multibody)
    point = q[:3] + Rotation.from_quat(q[3:], scalar_first=True).apply([0, 0, 0.5])
    assert np.linalg.norm(point - [0, 0, 2]) == pytest.approx(2, abs=1e-12)


def test_friction_stops_armatures_and_motors():
    found = read(
        HEAD + f"bodies:\n  a: {BAR}\n  b: {BAR}\njoints:\n"
        "  j: {type: revolute, bodies: [ground, a], frame1: {}, friction: 3, creep_rate: 1 deg/s, "
        "limits: [-90 deg, 1], stop_stiffness: 10 kN m, armature: 2 g cm^2}\n"
        "  k: {type: planar, bodies: [a, b], point: [0, 0, 0], normal: [0, 0, 1], displacement_limits2: [0, 1 mm], "
        "displacement_stop_stiffness2: 5 kN/m, displacement_friction1: 2}\n"
        "  l: {type: spherical, bodies: [ground, b], point: [0, 0, 0], motor: true}\n"
    ).definition
    assert found["joint_frictions"] == [
        {"joint": "j", "coordinate": 0, "friction": 3.0, "creep_rate": pytest.approx(np.pi / 180, rel=2 * EPS)},
        {"joint": "k", "coordinate": 1, "friction": 2.0},
    ]
    quarter = pytest.approx(-np.pi / 2, rel=2 * EPS)
    assert found["joint_stops"] == [
        {"joint": "j", "coordinate": 0, "lower_stop": quarter, "upper_stop": 1.0, "stop_stiffness": 1e4},
        {"joint": "k", "coordinate": 2, "lower_stop": 0.0, "upper_stop": 0.001, "stop_stiffness": 5000.0},
    ]
    assert found["joint_armatures"] == [{"joint": "j", "coordinate": 0, "armature": pytest.approx(2e-7, rel=2 * EPS)}]
    assert found["rotation_motors"] == [{"joint": "l"}]


def test_springs_on_coordinates_and_forces_in_frames():
    found = read(
        HEAD + f"bodies:\n  a: {BAR}\njoints:\n  j: {{type: cylindrical, bodies: [ground, a], point: [0, 0, 0], "
        "axis: [0, 0, 1], stiffness: 3 N m/deg, displacement_damping: 4, displacement_rest: 5 mm}\n"
        "forces:\n  f: {type: spring_damper, bodies: [ground, a], point1: [1, 1, 1], frame2: {position: [2, 0, 0]}, "
        "stiffness: [1 kN/m, 0, 0]}\n"
    ).definition
    assert found["joint_springs"] == [
        {"joint": "j", "coordinate": 0, "stiffness": pytest.approx(540 / np.pi, rel=4 * EPS)},
        {"joint": "j", "coordinate": 1, "damping": 4.0, "rest": 0.005},
    ]
    force = found["forces"][0]
    assert (force["point1"], force["point2"], force["stiffness"]) == ([1, 1, 1], [1.5, 0, 0], [1000, 0, 0])


@pytest.mark.parametrize(("word", "inputs"), [("auto", None), ("all", ["*"]), ("{inputs: [j.*]}", ["j.*"])])
def test_expose(word, inputs):
    found = read(HEAD + f"bodies: {{a: {BALL}}}\nexpose: {word}").mechanism.expose
    assert (found.inputs if found else None) == inputs


def test_expose_all_is_all():
    text = HEAD + f"bodies: {{a: {BALL}}}\n"
    assert _core.Slave(read(text + "expose: all").mechanism).names == _core.Slave(read(text).mechanism).names
