"""Forces and sensors: where they attach, mapped back into W by the poses of the definition."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sigmafmu import _core

from .helpers import HEAD, complaint, complaints, read

EPS = float(np.finfo(float).eps)
BODIES = """bodies:
  a: {mass: 1, inertia: [1, 1, 1], center_of_mass: [0.1, 0.2, 0.3], position: [1, 2, 3], orientation: {rpy: [3, 2, 1]}}
  b: {mass: 1, inertia: [1, 1, 1], center_of_mass: [-0.1, 0, 0], position: [3, 2, 1], orientation: {rpy: [1, 2, 3]}}
"""


def element(text, sort="forces"):
    """The only element, and functions from its bodies to W."""
    content = read(f"{HEAD}{BODIES}{sort}:\n  e: {text}\n").definition
    poses = {
        body["name"]: (
            np.array(body["position"]),
            Rotation.from_quat(body["orientation"]["quaternion"], scalar_first=True),
        )
        for body in content["bodies"]
    } | {"ground": (np.zeros(3), Rotation.identity())}
    found = content[sort][0]

    def to_w(point, body):
        position, turn = poses[body]
        return position + turn.apply(point)

    def turned(frame, body):
        return poses[body][1].as_matrix() @ np.array(frame["orientation"]["matrix"])

    return found, to_w, turned


@pytest.mark.parametrize(
    "kind",
    [
        "spring_damper",
        "line_spring, stiffness: 4 kN/m, damping: 2, free_length: 100 mm",
        "table_spring, length: [0, 1 mm], force: [0, 2 N]",
        "sphere_contact, radius1: 0.1, radius2: 0.2",
    ],
)
def test_points_in_w_are_points_of_bodies(kind):
    found, to_w, _ = element(f"{{type: {kind}, bodies: [a, b], point1: [1, 2, 4], point2: [-1, 0, 5]}}")
    np.testing.assert_allclose(to_w(found["point1"], "a"), [1, 2, 4], atol=10 * EPS)
    np.testing.assert_allclose(to_w(found["point2"], "b"), [-1, 0, 5], atol=10 * EPS)


def test_numbers_have_their_units():
    found, _, _ = element(
        "{type: line_spring, bodies: [a, b], frame1: {}, frame2: {}, "
        "stiffness: 4 kN/m, damping: 2 N s/mm, free_length: 5 cm}"
    )
    assert (found["stiffness"], found["damping"], found["free_length"]) == (4000, 2000, 0.05)
    found, _, _ = element(
        "{type: table_spring, bodies: [a, b], frame1: {}, frame2: {}, rate: [0, 1 mm/s], rate_force: [0, 2 kN]}"
    )
    assert (found["rate"], found["rate_force"]) == ([0, 0.001], [0, 2000])


def test_frames_of_bodies_count_from_their_centres_of_mass():
    found, _, _ = element("{type: line_spring, bodies: [a, b], frame1: {}, frame2: {position: [1, 1, 1]}}")
    np.testing.assert_allclose(found["point1"], [-0.1, -0.2, -0.3], atol=EPS)
    np.testing.assert_allclose(found["point2"], [1.1, 1, 1], atol=EPS)


def test_a_torsion_spring_has_its_axis_in_both_bodies():
    found, to_w, turned = element(
        "{type: torsion_spring, bodies: [a, b], point: [1, 1, 1], axis: [1, 2, 2], rest: 90 deg}"
    )
    for key, body in (("frame1", "a"), ("frame2", "b")):
        np.testing.assert_allclose(to_w(found[key]["position"], body), [1, 1, 1], atol=10 * EPS)
        np.testing.assert_allclose(turned(found[key], body)[:, 2], [1 / 3, 2 / 3, 2 / 3], atol=10 * EPS)
    assert found["rest"] == pytest.approx(np.pi / 2, rel=2 * EPS)


def test_a_bushing_has_axes_of_w_or_others_there():
    text = (
        "{type: bushing, bodies: [a, b], point: [1, 1, 1]%s, stiffness: [1, 2, 3 kN/m], torsional_damping: [1, 2, 3]}"
    )
    for more, expected in (
        ("", np.eye(3)),
        (", orientation: {rpy: [0.3, 0.2, 0.1]}", Rotation.from_euler("ZYX", [0.1, 0.2, 0.3]).as_matrix()),
    ):
        found, _, turned = element(text % more)
        for key, body in (("frame1", "a"), ("frame2", "b")):
            np.testing.assert_allclose(turned(found[key], body), expected, atol=10 * EPS)
        assert found["stiffness"] == [1, 2, 3000]


def test_a_bearing_has_axes_of_w():
    found, to_w, turned = element(
        "{type: bearing, bodies: [a, b], point: [1, 1, 1], stiffness: [1, 1, 0], cross_stiffness: [2 kN/m, -2000]}"
    )
    for key, body in (("frame1", "a"), ("frame2", "b")):
        np.testing.assert_allclose(to_w(found[key]["position"], body), [1, 1, 1], atol=10 * EPS)
        np.testing.assert_allclose(turned(found[key], body), np.eye(3), atol=10 * EPS)
    assert found["cross_stiffness"] == [2000, -2000]


def test_drag_is_at_a_point_of_a_body():
    found, to_w, _ = element("{type: drag, body: b, point: [1, 2, 4], coefficient: [1, 2, 3], flow: [36 km/h, 0, 0]}")
    np.testing.assert_allclose(to_w(found["point"], "b"), [1, 2, 4], atol=10 * EPS)
    assert (found["coefficient"], found["flow"]) == ([1, 2, 3], [10, 0, 0])


def test_a_cloud_has_its_points_in_the_second_body():
    found, to_w, _ = element(
        "{type: cloud_contact, bodies: [ground, b], point: [0, 0, 0], normal: [0, 0, 1], "
        "points2: [[1, 2, 3], [3, 2, 1]], radius: 1 mm}"
    )
    np.testing.assert_allclose(to_w(found["points2"], "b"), [[1, 2, 3], [3, 2, 1]], atol=10 * EPS)


def test_a_follower_force_is_in_the_bodys_axes():
    found, to_w, _ = element("{type: follower_force, body: a, point: [1, 2, 4], force: [1, 0, 0]}")
    np.testing.assert_allclose(to_w(found["point"], "a"), [1, 2, 4], atol=10 * EPS)
    assert found["body"] == "a"
    assert found["force"] == [1, 0, 0]


def test_a_plane_is_in_the_first_body_and_a_sphere_in_the_second():
    found, to_w, turned = element(
        "{type: plane_contact, bodies: [a, b], point: [0, 0, 1], normal: [0, 3, 4], point2: [2, 2, 2], "
        "radius: 5 cm, modulus: 2 MPa}"
    )
    np.testing.assert_allclose(to_w(found["frame1"]["position"], "a"), [0, 0, 1], atol=10 * EPS)
    np.testing.assert_allclose(turned(found["frame1"], "a")[:, 2], [0, 0.6, 0.8], atol=10 * EPS)
    np.testing.assert_allclose(to_w(found["point2"], "b"), [2, 2, 2], atol=10 * EPS)
    assert (found["radius"], found["modulus"]) == (0.05, 2e6)


HINGES = """bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1]}
joints:
  j: {type: revolute, bodies: [ground, a], frame1: {}, coordinate: 0.5}
  k: {type: cylindrical, bodies: [ground, b], frame1: {}}
"""


@pytest.mark.parametrize(
    ("text", "terms", "offset"),
    [
        ("gear, joints: [j, k], ratio: -2", [("j", 0, [0, -2]), ("k", 0, [0, -1])], None),
        ("rack_and_pinion, joints: [j, k.displacement], radius: 3 cm", [("j", 0, [0, 0.03]), ("k", 1, [0, -1])], None),
        ("mimic, joints: [k, j], polynomial: [1, 2, 3]", [("k", 0, [0, -1]), ("j", 0, [1, 2, 3])], 0),
        (
            "differential, joints: [j, k, k.displacement]",
            [("j", 0, [0, 1]), ("k", 0, [0, -0.5]), ("k", 1, [0, -0.5])],
            None,
        ),
        (
            "sum, joints: [j, k], polynomials: [[0, 1], [0, 0, 3]], offset: 0.8",
            [("j", 0, [0, 1]), ("k", 0, [0, 0, 3])],
            0.8,
        ),
    ],
)
def test_couplings(text, terms, offset):
    found = read(f"{HEAD}{HINGES}couplings:\n  c: {{type: {text}}}\n").definition["couplings"][0]
    assert [(t["joint"], t["coordinate"], t["polynomial"]) for t in found["terms"]] == terms
    assert found.get("offset") == offset


def test_numbers_of_couplings_are_parameters_of_the_fmu():
    found = read(f"{HEAD}{HINGES}couplings:\n  c: {{type: gear, joints: [j, k], ratio: -2}}\n")
    assert found.definition["couplings"][0]["type"] == "gear"
    slave = _core.Slave(found.mechanism)
    assert slave.get("c.ratio") == -2.0


def test_tendons():
    found = read(
        f"{HEAD}{HINGES}tendons:\n  t: {{joints: [j, k.displacement], coefficients: [20 mm, 1], stiffness: 3 N/mm, "
        "free_length: -1 cm}\n"
    )
    assert found.definition["tendons"] == [
        {
            "name": "t",
            "terms": [
                {"joint": "j", "coordinate": 0, "coefficient": 0.02},
                {"joint": "k", "coordinate": 1, "coefficient": 1},
            ],
            "stiffness": 3000,
            "free_length": -0.01,
        }
    ]
    slave = _core.Slave(found.mechanism)
    slave.start()
    assert slave.get("t.force") == pytest.approx(3000 * (0.02 * 0.5 + 0.01), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "angle", "displacement"),
    [
        ("coordinate: 90 deg", np.pi / 2, 0.005),
        ("displacement: 5 mm", np.pi / 2, 0.005),
        ("displacement: 45 mm", np.pi / 2, 0.045),
        ("coordinate: 90 deg, displacement: 25 mm", np.pi / 2, 0.025),
    ],
)
def test_a_screw_is_placed_by_its_angle_or_its_displacement(text, angle, displacement):
    joint = f"{{type: screw, bodies: [ground, a], frame1: {{}}, pitch: 2 cm, rate: 3, {text}}}"
    found = read(f"{HEAD}bodies:\n  a: {{mass: 1, inertia: [1, 1, 1]}}\njoints:\n  j: {joint}\n")
    assert not found.moves
    slave = _core.Slave(found.mechanism)
    slave.start()
    assert slave.get("j.displacement") == pytest.approx(displacement, abs=1e-14)
    assert np.remainder(slave.get("j.angle"), 2 * np.pi) == pytest.approx(angle, abs=1e-12)
    assert slave.get("j.rate") == pytest.approx(3 * 0.02 / (2 * np.pi), rel=1e-12)


def test_a_reaction_is_told_where_it_is_wanted():
    found = read(
        f"{HEAD}bodies:\n  a: {{mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}\njoints:\n"
        "  j: {type: fixed, bodies: [ground, a], frame1: {position: [1, 0, 0]}, frame2: {orientation: "
        "{rpy: [0, 0, 0]}}, reaction: {at: frame1, point: [-1, 0, 0], axes: frame1}}\n"
    )
    slave = _core.Slave(found.mechanism)
    slave.start()
    assert slave.get("j.reactionForce[3]") == pytest.approx(9.81, rel=1e-12)
    assert slave.get("j.reactionTorque[2]") == pytest.approx(-9.81, rel=1e-12)  # 1 m from the ground's origin


def test_a_mimic_moves_its_follower_to_where_it_belongs():
    found = read(f"{HEAD}{HINGES}couplings:\n  c: {{type: mimic, joints: [k, j], polynomial: [1, 2]}}\n")
    slave = _core.Slave(found.mechanism)
    slave.start()
    assert slave.get("j.angle") == pytest.approx(0.5, abs=1e-12)
    assert slave.get("k.angle") == pytest.approx(2.0, abs=1e-12)


def test_drives():
    found = read(
        f"{HEAD}{HINGES}drives:\n  j: {{motion: rate, table: [[0, 0], [500 ms, 60 rpm]]}}\n"
        "  k.displacement: {motion: acceleration, value: input}\n"
    ).definition["drives"]
    turn = pytest.approx(2 * np.pi, rel=2 * EPS)
    assert found == [
        {"joint": "j", "coordinate": 0, "motion": "rate", "table": {"times": [0, 0.5], "values": [0, turn]}},
        {"joint": "k", "coordinate": 1, "motion": "acceleration", "value": 0.0, "input": True},
    ]


def with_table(folder, lines):
    (folder / "speed.csv").write_text(lines, encoding="utf-8")
    return f"{HEAD}{HINGES}drives:\n  j: {{motion: rate, table: speed.csv}}\n"


@pytest.mark.parametrize("header", ["", "time,rate\n", "\ufefftime [s],rate [rad/s]\n\n"])
def test_a_table_may_be_a_csv_file(tmp_path, header):
    found = read(with_table(tmp_path, f"{header}0,0,what\n0.5,2\n1,-1e-3\n"), tmp_path / "some.yaml")
    assert found.definition["drives"][0]["table"] == {"times": [0, 0.5, 1], "values": [0, 2, -1e-3]}


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        ("0,0\n1,one\n", '"speed.csv" has no two numbers in line 2; every line must begin with time and value'),
        ("0\n1\n", "has no two numbers in line 2"),
        ("0,0\n", '"speed.csv" has 1 points; it must have two'),
        ("0,0\n2,1\n1,1\n", "line 3 of speed.csv: comes at 1 after 2; points must ascend"),
        ("0,0\n1,nan\n", "line 2 of speed.csv[2]: is nan; it must be finite"),
    ],
)
def test_mistakes_in_a_csv_file(tmp_path, lines, what):
    assert what in complaints(with_table(tmp_path, lines), tmp_path / "some.yaml")[0]


def test_a_csv_file_must_be_there():
    message = complaint(f"{HEAD}{HINGES}drives:\n  j: {{motion: rate, table: none.csv}}\n")
    assert 'drives.j.table: "none.csv" cannot be read: No such file or directory; it must be a CSV file' in message


def test_what_is_driven_by_an_input_follows_it():
    slave = _core.Slave(read(f"{HEAD}{HINGES}drives: {{j: {{motion: rate, value: input}}}}\n").mechanism)
    slave.set("j.drivenRate", 3.0)
    slave.start()
    slave.do_step(0, 0.1)
    assert slave.get("j.angle") == pytest.approx(0.8, abs=1e-12)


def test_joints_hold_to_moving_frames_of_the_ground():
    """A body hung on a deck at (0, 0, 1) that is turned by 90 degrees about z and rises by 2 m/s."""
    found = read(
        f"{HEAD}bodies:\n  a: {{mass: 1, inertia: [1, 1, 1], center_of_mass: [0.5, 0, 0]}}\njoints:\n"
        "  j: {type: revolute, bodies: [ground, a], frame1: {motion: deck, position: [1, 0, 0]}}\n"
        "motions:\n  deck: {position: [0, 0, 1], orientation: {rpy: [0, 0, 90 deg]}, z: [[0, 0], [1, 2]]}\n"
    )
    assert found.definition["joints"][0]["frame1"]["node"] == 0
    np.testing.assert_allclose(found.definition["bodies"][0]["position"], [0, 1.5, 1], atol=10 * EPS)
    slave = _core.Slave(found.mechanism)
    slave.start()
    assert [slave.get(f"a.velocity[{i}]") for i in (1, 2, 3)] == pytest.approx([0, 0, 2], abs=1e-12)


def test_sensors():
    found, to_w, turned = element("{type: imu, body: a, point: [1, 2, 4]}", "sensors")
    np.testing.assert_allclose(to_w(found["frame"]["position"], "a"), [1, 2, 4], atol=10 * EPS)
    np.testing.assert_allclose(turned(found["frame"], "a"), np.eye(3), atol=10 * EPS)
    found, _, _ = element(
        "{type: motion, body: a, frame: {}, reference: b, reference_frame: {position: [1, 0, 0]}, axes: sensor}",
        "sensors",
    )
    np.testing.assert_allclose(found["reference_frame"]["position"], [1.1, 0, 0], atol=EPS)
    assert (found["reference"], found["axes"]) == ("b", "sensor")


def test_a_sensor_tells_what_happens_at_its_point():
    """A body that turns about z at 2 rad/s with its sensor 0.5 m from its centre: w² r towards the axis."""
    mechanism = read(
        HEAD + "gravity: [0, 0, 0]\nbodies:\n  a: {mass: 1, inertia: [1, 1, 1], angular_velocity: [0, 0, 2]}\n"
        "sensors:\n  i: {type: imu, body: a, point: [0.5, 0, 0]}\n"
    ).mechanism
    slave = _core.Slave(mechanism)
    slave.start()
    assert [slave.get(f"i.specificForce[{k}]") for k in (1, 2, 3)] == pytest.approx([-2, 0, 0], abs=1e-14)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{type: line_spring, bodies: [a, b], point1: [0, 0, 0]}", "point2 is missing; give point2, or frame2"),
        (
            "{type: line_spring, bodies: [a, b], point1: [0, 0, 0], frame1: {}, frame2: {}}",
            "give it or frame1, not both",
        ),
        ("{type: table_spring, bodies: [a, b], frame1: {}, frame2: {}, length: [1, 0], force: [0, 0]}", "e.length"),
        ("{type: plane_contact, bodies: [a, b], point: [0, 0, 0], point2: [0, 0, 0], radius: 1}", "normal is missing"),
        ("{type: plane_contact, bodies: [a, b], frame1: {}, point2: [0, 0, 0]}", "radius is missing"),
        ("{type: cloud_contact, bodies: [a, b], frame1: {}, radius: 1}", "points2 is missing; give points2"),
        ("{type: follower_force, body: ground, point: [0, 0, 0]}", 'there is no body "ground"'),
        ("{type: line_sprint, bodies: [a, b]}", "did you mean line_spring?"),
    ],
)
def test_mistakes(text, what):
    message = complaint(f"{HEAD}{BODIES}forces:\n  e: {text}\n")
    assert message.startswith("some.yaml:7: forces.e")
    assert what in message
