"""MJCF: features one by one against MuJoCo's own accelerations, and what has no counterpart."""

import numpy as np
import pytest

from research.robots import with_mujoco

from .helpers import converted, degrees, refusal, told

mujoco = pytest.importorskip("mujoco")

GEOM = '<geom type="box" size="0.1 0.07 0.05" pos="0.1 0.02 0.03" density="500"/>'


def model(body: str, more: str = "") -> str:
    return f'<mujoco model="some"><compiler angle="radian"/><worldbody>{body}</worldbody>{more}</mujoco>'


def body(name: str, inside: str, place: str = 'pos="0.2 0.1 0" quat="1 0.2 0.3 0.1"') -> str:
    return f'<body name="{name}" {place}>{GEOM}{inside}</body>'


def hinge(name: str, axis: str = "0 1 0", more: str = "") -> str:
    return f'<joint name="{name}" axis="{axis}" {more}/>'


def slide(name: str, axis: str, more: str = "") -> str:
    return f'<joint name="{name}" type="slide" axis="{axis}" {more}/>'


LOADED = 'stiffness="3" damping="0.4" armature="0.02" springref="0.3" ref="0.2" pos="0.05 0.02 -0.1"'
MODELS = {
    "springs, dampers, armatures, references": body(
        "a", hinge("one", "0 1 1", LOADED) + body("b", slide("two", "1 0 1", LOADED))
    ),
    "a free body that carries one": body("a", "<freejoint/>" + body("b", hinge("one"))),
    "a ball": body(
        "a", hinge("one") + body("b", '<joint name="ball" type="ball" stiffness="5"/>' + body("c", hinge("two")))
    ),
    "two hinges": body("a", hinge("one") + body("b", hinge("two", "1 0 0") + hinge("three", "0 1 0"))),
    "three hinges": body(
        "a", hinge("one", "1 0 0", LOADED) + hinge("two", "0 1 0") + hinge("three", "0 0 1") + body("b", hinge("four"))
    ),
    "three hinges on a body": body(
        "a", "<freejoint/>" + body("b", hinge("one", "1 0 0") + hinge("two", "0 1 0") + hinge("three", "0 1 1"))
    ),
    "a plane": body(
        "a",
        slide("x", "1 0 0", LOADED) + slide("z", "0 0 1") + hinge("turn", "0 1 0", LOADED) + body("b", hinge("one")),
    ),
    "a plane, the other way": body("a", slide("x", "1 0 0") + slide("z", "0 0 1") + hinge("turn", "0 -1 0")),
    "two slides": body("a", slide("x", "1 0 0", LOADED) + slide("y", "0 1 0") + body("b", hinge("one"))),
    "two slides and a hinge aslant": body("a", slide("x", "1 0 0") + slide("y", "0 1 0") + hinge("turn", "1 0 1")),
    "a slide and a hinge": body("a", slide("x", "1 0 0") + hinge("turn", "1 0 1", LOADED)),
    "a hinge and a slide": body("a", hinge("turn", "0 0 1", LOADED) + slide("x", "1 0 0")),
    "a hinge and a slide on a body": body("a", hinge("one") + body("b", hinge("turn", "0 0 1") + slide("x", "1 0 0"))),
    "fixed bodies": body("a", hinge("one") + body("b", "" + body("c", "") + body("d", hinge("two")))),
}


@pytest.mark.parametrize("name", MODELS)
def test_accelerations(tmp_path, name):
    path = tmp_path / "some.xml"
    path.write_text(model(MODELS[name]), encoding="utf-8")
    found = with_mujoco.compare(path, "", states=3)
    assert found.error < 1e-10
    m = mujoco.MjModel.from_xml_path(str(path))
    assert found.degrees == m.nv
    assert not any("no mass" in text for text in found.told)


@pytest.mark.parametrize(
    "actuators",
    [
        '<position joint="one" kp="5" kv="0.3" gear="2"/>',
        '<velocity joint="one" kv="0.7"/>',
        '<general joint="one" gaintype="fixed" biastype="affine" gainprm="2" biasprm="3 -4 -0.5" gear="-1.5"/>',
        '<motor joint="one" gear="7"/>',
    ],
)
def test_servos_are_springs_and_dampers(tmp_path, actuators):
    path = tmp_path / "some.xml"
    text = model(body("a", hinge("one", "0 1 0", LOADED)), f"<actuator>{actuators}</actuator>")
    path.write_text(text, encoding="utf-8")
    assert with_mujoco.compare(path, "", states=3).error < 1e-10


def test_damping_of_a_ball_joint_is_told(tmp_path):
    text = model(body("a", '<joint name="ball" type="ball" damping="0.3" armature="0.1"/>'))
    content, made, _ = converted(tmp_path, text)
    assert content["forces"]["ball_bushing"]["torsional_damping"] == [0.3, 0.3, 0.3]
    assert [text.partition(":")[0] for text in made.told] == ["ball", "ball", "contacts"]


def test_tendons_between_two_sites_are_line_springs(tmp_path):
    inside = '<site name="s" pos="0.1 0 0.2"/>'
    text = model(
        '<site name="w" pos="0 0 1"/>' + body("a", hinge("one") + inside),
        '<tendon><spatial name="rope" stiffness="40" damping="2" springlength="0.3">'
        '<site site="w"/><site site="s"/></spatial></tendon>',
    )
    path = tmp_path / "some.xml"
    path.write_text(text, encoding="utf-8")
    assert with_mujoco.compare(path, "", states=3).error < 1e-10
    content, _, _ = converted(tmp_path, text)
    assert content["forces"]["rope"]["free_length"] == 0.3


FIXED = (
    '<tendon><fixed name="cable" stiffness="40" damping="2" {more}>'
    '<joint joint="one" coef="0.3"/><joint joint="{two}" coef="-0.5"/></fixed></tendon>'
)


@pytest.mark.parametrize(
    ("inside", "two"),
    [
        (body("b", hinge("two", "1 0 0")), "two"),
        (body("b", slide("x", "1 0 0") + slide("z", "0 0 1") + hinge("turn", "0 1 0")), "z"),  # one planar joint
    ],
    ids=["hinges", "a plane"],
)
@pytest.mark.parametrize("more", ['springlength="0.2"', ""])
def test_springs_over_coordinates_are_tendons(tmp_path, inside, two, more):
    """Without a length of its own the spring has no force where its joints are at their references."""
    text = model(
        body("a", hinge("one", "0 1 0", 'ref="0.2" springref="0.4"') + inside), FIXED.format(more=more, two=two)
    )
    path = tmp_path / "some.xml"
    path.write_text(text, encoding="utf-8")
    assert with_mujoco.compare(path, "", states=3).error < 1e-10
    content, made, _ = converted(tmp_path, text)
    assert content["tendons"]["cable"]["coefficients"] == [0.3, -0.5]
    assert content["tendons"]["cable"]["free_length"] == pytest.approx(0.2 if more else 0.3 * 0.4)
    assert not any(text.startswith("cable") for text in made.told)


def test_a_tendon_that_is_slack_between_two_lengths_is_told(tmp_path):
    text = model(
        body("a", hinge("one") + body("b", hinge("two"))), FIXED.format(more='springlength="0 0.2"', two="two")
    )
    content, made, _ = converted(tmp_path, text)
    assert "tendons" not in content
    assert told(made, "cable") == "cable: stiffness and damping of a tendon"


BARS = (
    '<body name="a"><joint name="one" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.4"/>'
    '<body name="b" pos="0 0 0.4"><joint name="two" axis="0 1 0"/>'
    '<geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0"/>'
    '<body name="c" pos="0.5 0 0"><joint name="three" axis="0 1 0"/>'
    '<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.4"/>'
    "</body></body></body>"
)
LOOP = model(
    BARS, '<option gravity="2 0 -9.81"/><equality><connect name="four" body1="c" anchor="0 0 -0.4"/></equality>'
)


def test_a_loop_is_closed_by_a_joint(tmp_path):
    """From rest M a = -bias + J' f and J a = 0, with matrices of MuJoCo."""
    content, made, file = converted(tmp_path, LOOP)
    assert content["joints"]["four"]["type"] == "spherical"
    assert content["joints"]["four"]["bodies"] == ["c", "ground"]
    assert told(made, "equalities").startswith("equalities: they hold exactly")
    assert degrees(file) == 1

    from sigmafmu import _core

    slave = _core.Slave(file.mechanism)
    slave.start()
    found = [slave.get(f"{name}.angularAcceleration") for name in ("one", "two", "three")]
    m = mujoco.MjModel.from_xml_string(LOOP)
    data = mujoco.MjData(m)
    mujoco.mj_forward(m, data)
    M, J = np.zeros((3, 3)), np.zeros((3, 3))
    for i, unit in enumerate(np.eye(3)):
        mujoco.mj_mulM(m, data, M[i], unit)
    mujoco.mj_jac(m, data, J, None, np.array([0.5, 0, 0.0]), m.body("c").id)
    J = J[[0, 2]]  # along y nothing moves
    matrix = np.block([[M, J.T], [J, np.zeros((2, 2))]])
    expected = np.linalg.solve(matrix, [*(-data.qfrc_bias), 0, 0])[:3]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_a_weld_is_a_fixed_joint_and_sites_can_be_its_ends(tmp_path):
    text = model(
        body("a", hinge("one") + '<site name="s" pos="1 0 0"/>') + body("b", "<freejoint/>", 'pos="2 0 0"'),
        '<equality><weld name="hold" body1="a" body2="b" relpose="1 0 0 1 0 0 0"/></equality>',
    )
    content, _, file = converted(tmp_path, text)
    assert content["joints"]["hold"]["type"] == "fixed"
    assert degrees(file) == 1


def test_equations_between_coordinates(tmp_path):
    text = model(
        body("a", hinge("one", "0 1 0", 'ref="0.5"')) + body("b", hinge("two")) + body("c", hinge("three")),
        '<equality><joint name="gear" joint1="one" joint2="two" polycoef="0.1 2 3 0 0"/>'
        '<joint name="held" joint1="three" polycoef="0.2 0 0 0 0"/></equality>',
    )
    content, _, file = converted(tmp_path, text)
    gear = content["couplings"]["gear"]
    assert (gear["type"], gear["joints"]) == ("mimic", ["one", "two"])
    assert gear["polynomial"] == pytest.approx([0.6, 2, 3])
    assert content["couplings"]["held"] == {"type": "sum", "joints": ["three"], "polynomials": [[0, 1]], "offset": 0.2}
    assert degrees(file) == 1


def test_coupled_tendons(tmp_path):
    text = model(
        body("a", hinge("one")) + body("b", hinge("two")),
        '<tendon><fixed name="t"><joint joint="one" coef="2"/><joint joint="two" coef="-3"/></fixed></tendon>'
        '<equality><tendon name="even" tendon1="t" polycoef="0.5 0 0 0 0"/></equality>',
    )
    content, _, _ = converted(tmp_path, text)
    even = content["couplings"]["even"]
    assert (even["joints"], even["polynomials"], even["offset"]) == (["one", "two"], [[0, 2], [0, -3]], 0.5)


def test_what_is_not_in_the_file_is_told(tmp_path):
    text = model(
        body("a", hinge("one", "0 1 0", 'limited="true" range="-1 1" frictionloss="0.2"'))
        + '<body name="m" mocap="true"><geom size="0.1"/></body>',
        "<actuator>"
        '<motor name="m1" joint="one" gear="3"/><position name="p1" joint="one" kp="2"/>'
        '<general name="g1" joint="one" dyntype="none" gaintype="affine" gainprm="1 1 1"/>'
        '<intvelocity name="g2" joint="one" kp="3" actrange="-1 1"/></actuator>'
        '<sensor><jointpos joint="one"/></sensor><keyframe><key qpos="0.1"/></keyframe>'
        '<option density="1.2"/>',
    )
    content, made, _ = converted(tmp_path, text)
    assert content["joints"]["one"]["limits"] == [-1, 1]
    assert content["joints"]["one"]["friction"] == 0.2
    assert content["joints"]["one"]["stiffness"] == 2
    assert made.told == [
        "m: moved from outside in MuJoCo, is fixed",
        "motors, whose forces are inputs of joints: m1 (3 x its command at one)",
        "servos, which are springs and dampers with their command in `rest`: p1 at one",
        "other actuators: g1, g2",
        "contacts",
        "forces of a fluid",
        "sensors",
        "keyframes",
        "part of the ground, not drawn: m",
    ]


def test_shapes(tmp_path):
    text = model(
        '<body name="a"><joint/><geom type="capsule" size="0.1 0.2" rgba="1 0 0 1"/>'
        '<geom type="ellipsoid" size="1 2 3" contype="0" conaffinity="0" rgba="0 0 1 1"/></body>'
        '<body name="b"><joint/><geom type="capsule" size="0.1 0.2" rgba="1 0 0 1"/></body>'
    )
    content, made, _ = converted(tmp_path, text)
    assert content["bodies"]["a"]["shapes"] == [{"box": [2, 4, 6], "color": "#0000ff"}]
    red = {"color": "#ff0000"}
    assert content["bodies"]["b"]["shapes"] == [
        {"sphere": 0.1, **red, "position": [0, 0, -0.2]},
        {"sphere": 0.1, **red, "position": [0, 0, 0.2]},
        {"cylinder": {"radius": 0.1, "length": 0.4}, **red},
    ]
    assert "ellipsoids: drawn as boxes" in made.told


def test_meshes_are_where_they_were(tmp_path):
    """MuJoCo moves a mesh into its principal axes; the file's mesh is where the description has it."""
    points = np.array([[3, 1, 2], [5, 1, 2], [3, 2, 2], [3, 1, 2.5]])
    faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "wedge.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in points) + faces, encoding="utf-8")
    text = model('<body name="a"><joint/><geom type="mesh" mesh="w" pos="0.1 0 0" quat="1 0 0 1"/></body>').replace(
        "<worldbody>", '<asset><mesh name="w" file="wedge.obj" scale="2 2 2"/></asset><worldbody>'
    )
    shape = converted(tmp_path, text)[0]["bodies"]["a"]["shapes"][0]
    assert (shape["mesh"], shape["scale"]) == ("wedge.obj", 2)
    assert shape["position"] == pytest.approx([0.1, 0, 0], abs=1e-6)  # a mesh has single precision
    from sigmafmu.mechanism_file import rotations

    turned = shape["orientation"]
    if "rotation_vector" in turned and isinstance(turned["rotation_vector"][2], str):
        assert turned == {"rotation_vector": [0, 0, "90 deg"]}
    else:
        R = rotations.matrix(rotations.of_orientation(turned))
        np.testing.assert_allclose(R, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-6)


def test_what_mujoco_warns_of_is_told_and_not_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = model(body("a", hinge("one"))).replace("<compiler ", '<compiler settotalmass="3" ')
    content, made, _ = converted(tmp_path, text)
    assert "settotalmass" in told(made, "MuJoCo warns")
    assert content["bodies"]["a"]["mass"] == pytest.approx(3)
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]


def test_what_mujoco_refuses(tmp_path):
    assert "MuJoCo refuses it" in refusal(tmp_path, "<mujoco><worldbody><body/><bodi/></worldbody></mujoco>")
