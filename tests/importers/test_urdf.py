"""URDF: features one by one, against MuJoCo's reading of the same file where motion matters, and its mistakes."""

import numpy as np
import pytest

from research.robots import State

from .helpers import accelerations_at, converted, degrees, refusal, told

EPS = np.finfo(float).eps


def link(name, mass=1.0, more="", xyz="0.1 0.2 0.05", rpy="0.3 -0.2 0.5", J="0.02 0.03 0.04"):
    xx, yy, zz = J.split()
    return (
        f'<link name="{name}"><inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0.001" ixz="-0.002" iyz="0.003"/></inertial>{more}</link>'
    )


def joint(name, kind, parent, child, more="", xyz="0.3 0.1 0.2", rpy="0.1 0.2 0.3", axis="0 1 0"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def robot(*parts):
    return f'<robot name="Some">\n{chr(10).join(parts)}\n</robot>'


LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'
ARM = robot(
    '<link name="world"/>',
    link("a"),
    link("b", 2),
    link("tool", 0.5, xyz="0 0 0.3", J="0.01 0.01 0.005"),
    link("c", 1.5),
    joint("one", "continuous", "world", "a", '<dynamics damping="0.7" friction="0.1"/>'),
    joint("two", "prismatic", "a", "b", LIMIT + '<dynamics damping="0.4"/>', axis="0.6 0 0.8"),
    joint("hold", "fixed", "b", "tool"),
    joint("three", "revolute", "b", "c", LIMIT, axis="1 2 -1"),
)


def with_mujoco(text: str, state: dict[str, tuple[float, float]]) -> np.ndarray:
    """Accelerations of MuJoCo's reading of a URDF file, whose root is the ground, without friction and limits."""
    mujoco = pytest.importorskip("mujoco")
    m = mujoco.MjModel.from_xml_string(text)
    m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(m)
    for name, (x, rate) in state.items():
        data.joint(name).qpos[0], data.joint(name).qvel[0] = x, rate
    mujoco.mj_forward(m, data)
    return np.array([data.qacc_smooth[m.joint(name).dofadr[0]] for name in state])


def test_joints_inertial_frames_and_fixed_links(tmp_path):
    state = {"one": (0.7, -1.1), "two": (0.2, 0.5), "three": (-0.4, 2.0)}
    expected = with_mujoco(ARM, state)
    found = accelerations_at(tmp_path, ARM, State(state))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_what_the_file_says(tmp_path):
    content, made, file = converted(tmp_path, ARM)
    assert list(content["bodies"]) == ["a", "b", "c"]
    assert content["joints"]["one"]["damping"] == 0.7
    assert content["joints"]["one"]["friction"] == 0.1
    assert "limits" not in content["joints"]["one"]  # continuous
    assert content["joints"]["two"]["limits"] == [-1, 2]
    assert content["bodies"]["b"]["mass"] == 2.5  # with the tool
    assert made.told == ["largest efforts and velocities of joints", "part of the ground, not drawn: world"]
    assert degrees(file) == 3


def test_a_link_is_read_as_it_is_written(tmp_path):
    content, _, _ = converted(
        tmp_path, robot('<link name="world"/>', link("a"), joint("one", "continuous", "world", "a"))
    )
    body = content["bodies"]["a"]
    inertia = {"xx": 0.02, "yy": 0.03, "zz": 0.04, "xy": 0.001, "xz": -0.002, "yz": 0.003}
    assert {key: pytest.approx(value, rel=1e-13) for key, value in inertia.items()} == body["inertia"]
    assert body["inertia_axes"] == {"rpy": [0.3, -0.2, 0.5]}
    assert body["center_of_mass"] == [0.1, 0.2, 0.05]


def test_mimic_joints_follow(tmp_path):
    text = ARM.replace('name="c">', 'name="c">').replace(
        "</robot>",
        link("d")
        + joint("four", "continuous", "c", "d", '<mimic joint="one" multiplier="-2" offset="0.5"/>')
        + "</robot>",
    )
    content, _, file = converted(tmp_path, text)
    assert content["couplings"] == {"four_mimic": {"type": "mimic", "joints": ["four", "one"], "polynomial": [0.5, -2]}}
    assert degrees(file) == 3


@pytest.mark.parametrize(("base", "moves"), [(None, 7), ("free", 7), ("fixed", 1)])
def test_the_root(tmp_path, base, moves):
    text = robot(link("a"), link("b"), joint("one", "continuous", "a", "b"))
    _, made, file = converted(tmp_path, text, base)
    assert degrees(file) == moves
    assert any("--base" in sentence for sentence in made.told) == (base is None)


def test_a_root_without_mass_is_the_ground_unless_it_is_free(tmp_path):
    text = robot(
        '<link name="base"/>',
        link("a"),
        joint("hold", "fixed", "base", "a"),
        link("b"),
        joint("j", "continuous", "a", "b"),
    )
    assert degrees(converted(tmp_path, text)[2]) == 1
    content, _, file = converted(tmp_path, text, "free")
    assert degrees(file) == 7
    assert list(content["bodies"]) == ["base", "b"]


def test_floating_and_planar_joints(tmp_path):
    text = robot(
        '<link name="world"/>',
        link("a"),
        link("b"),
        joint("f", "floating", "world", "a"),
        joint("p", "planar", "a", "b"),
    )
    content, _, file = converted(tmp_path, text)
    assert content["bodies"]["a"]["position"] == [0.3, 0.1, 0.2]
    assert content["joints"]["p"]["type"] == "planar"
    assert degrees(file) == 9


def test_links_without_mass_at_the_end_go(tmp_path):
    text = robot(
        '<link name="world"/>', link("a"), '<link name="tip"/>', '<link name="tip_of_tip"/>',
        joint("one", "continuous", "world", "a"), joint("two", "continuous", "a", "tip"),
        joint("three", "continuous", "tip", "tip_of_tip", '<mimic joint="two"/>'),
    )  # fmt: skip
    content, made, _ = converted(tmp_path, text)
    assert list(content["joints"]) == ["one"]
    assert told(made, "joints that move nothing") == (
        "joints that move nothing with mass: three with tip_of_tip, two with tip"
    )
    assert told(made, "couplings of these") == "couplings of these: three_mimic"


def test_a_link_without_mass_between_joints_changes_nothing(tmp_path):
    """Against MuJoCo, where a body may have two hinges."""
    mujoco = pytest.importorskip("mujoco")
    text = robot(
        '<link name="world"/>', link("a", rpy="0 0 0"), '<link name="cross"/>', link("b", 0.7, rpy="0 0 0"),
        joint("one", "continuous", "world", "a"),
        joint("two", "continuous", "a", "cross", axis="1 0 0"),
        joint("three", "continuous", "cross", "b", xyz="0 0 0", rpy="0 0 0", axis="0 1 0"),
    )  # fmt: skip
    inertial = '<inertial pos="0.1 0.2 0.05" mass="{}" fullinertia="0.02 0.03 0.04 0.001 -0.002 0.003"/>'
    place = 'pos="0.3 0.1 0.2" euler="0.1 0.2 0.3"'
    m = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody><body {place}>{inertial.format(1)}'
        f'<joint name="one" axis="0 1 0"/><body {place}>{inertial.format(0.7)}<joint name="two" axis="1 0 0"/>'
        '<joint name="three" axis="0 1 0"/></body></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(m)
    state = {"one": (0.3, 1.0), "two": (-0.5, 0.4), "three": (0.9, -2.0)}
    for name, (x, rate) in state.items():
        data.joint(name).qpos[0], data.joint(name).qvel[0] = x, rate
    mujoco.mj_forward(m, data)
    expected = np.array([data.qacc_smooth[m.joint(name).dofadr[0]] for name in state])
    found = accelerations_at(tmp_path, text, State(state))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def test_shapes(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "hull.stl").write_text("", encoding="utf-8")
    visual = (
        '<visual><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><geometry><box size="1 2 3"/></geometry>'
        '<material name="blue"/></visual>'
        f'<visual><geometry><mesh filename="package://{tmp_path.name}/meshes/hull.stl" scale="0.001 0.001 0.001"/>'
        "</geometry>"
        '<material name="own"><color rgba="1 0.5 0 1"/></material></visual>'
        '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
        '<collision><geometry><sphere radius="1"/></geometry></collision>'
    )
    text = robot(
        '<material name="blue"><color rgba="0 0 1 1"/></material>', link("a", more=visual),
        link("b", more='<collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision>'),
        joint("one", "continuous", "a", "b"),
    )  # fmt: skip
    content, made, _ = converted(tmp_path, text)
    assert content["bodies"]["a"]["shapes"] == [
        {
            "box": [1, 2, 3],
            "color": "#0000ff",
            "position": [1, 0, 0],
            "orientation": {"rotation_vector": [0, 0, "90 deg"]},
        },
        {"mesh": "meshes/hull.stl", "scale": 0.001, "color": "#ff8000"},
    ]
    assert content["bodies"]["b"]["shapes"] == [{"cylinder": {"radius": 0.1, "length": 2}}]
    assert "shapes for collision" in made.told
    assert told(made, "meshes that") == "meshes that were not found, not drawn: 1, gone.dae"


def test_an_inertia_that_none_can_have_is_changed_and_told(tmp_path):
    text = robot(
        '<link name="world"/>', link("a", J="0.1 0.1 0.5", rpy="0 0 0"), joint("one", "continuous", "world", "a")
    )
    _, made, _ = converted(tmp_path, text)
    assert "no body has the principal moments" in told(made, "a: ")
    assert made.changed == ["a"]


def test_a_joint_starts_within_its_limits(tmp_path):
    text = robot(
        '<link name="world"/>', link("a"), joint("one", "revolute", "world", "a", '<limit lower="0.5" upper="1"/>')
    )
    content, made, _ = converted(tmp_path, text)
    assert content["joints"]["one"]["coordinate"] == 0.5
    assert told(made, "one: ") == "one: starts at 0.5, since 0 is beyond its limits"


def test_names_become_names_of_a_mechanism_file(tmp_path):
    text = robot('<link name="world"/>', link("1 arm"), joint("1 arm", "continuous", "world", "1 arm"))
    content, made, _ = converted(tmp_path, text)
    assert list(content["bodies"]) == ["_1_arm"]
    assert list(content["joints"]) == ["_1_arm_joint"]
    assert told(made, "other names") == "other names: 1 arm is _1_arm, 1 arm is _1_arm_joint"


def test_names_do_not_break_comments_and_texts(tmp_path):
    name = 'a\u2028b: "x" \u0085 #\\'
    quoted = name.replace('"', "&quot;")
    visual = f'<visual><geometry><mesh filename="{quoted}.stl"/></geometry></visual>'
    (tmp_path / f"{name}.stl").touch()
    text = robot(
        '<link name="world"/>', link(quoted, more=visual), link("tip"),
        joint("one", "continuous", "world", quoted), joint("hold", "fixed", quoted, "tip"),
    )  # fmt: skip
    content, _, file = converted(tmp_path, text)
    (body,) = content["bodies"].values()
    assert body["shapes"] == [{"mesh": f"{name}.stl"}]
    assert degrees(file) == 1


BAD = {
    "no XML": ("<robot", ":1: is no XML"),
    "another root": ("<house/>", ":1: the root is <house>; it must be <robot> (URDF), <mujoco> (MJCF) or <sdf>"),
    "no link": ('<robot name="a"/>', ":1: there is no link; a robot has at least one"),
    "xacro": (
        '<robot name="a" xmlns:xacro="http://x"><xacro:macro/></robot>',
        ":1: this is a xacro file; make URDF of it with xacro first",
    ),
    "two links of a name": (robot(link("a"), link("a")), ":3: the link a is there twice; names must differ"),
    "two roots": (robot(link("a"), link("b")), ":1: the links a, b have no parent; exactly one must be the root"),
    "two parents": (
        robot(link("a"), link("b"), joint("i", "fixed", "a", "b"), joint("j", "fixed", "a", "b")),
        ":1: the link b is the child of i and of j; one may carry it",
    ),
    "a ring": (
        robot(link("a"), link("b"), joint("i", "fixed", "a", "b"), joint("j", "fixed", "b", "a")),
        ":1: every link has a parent; exactly one must be the root",
    ),
    "a ring beside": (
        robot(link("r"), link("a"), link("b"), joint("i", "fixed", "a", "b"), joint("j", "fixed", "b", "a")),
        ":1: the joints i, j carry each other in a ring; one link must be the root",
    ),
    "unknown type": (
        robot(link("a"), link("b"), joint("i", "revolut", "a", "b")),
        ":4: the type of joint i is revolut; did you mean revolute? allowed are revolute, continuous, prismatic, "
        "fixed, floating, planar",
    ),
    "unknown link": (
        robot(link("arm"), link("b"), joint("i", "fixed", "am", "b")),
        ":4: joint i: there is no link am; did you mean arm? allowed are arm, b",
    ),
    "no child": (
        robot(link("a"), '<joint name="i" type="fixed"><parent link="a"/></joint>'),
        ":3: joint i has no <child>; it must have one",
    ),
    "no limit": (
        robot(link("a"), link("b"), joint("i", "revolute", "a", "b")),
        ":4: joint i is revolute and has no <limit>; it must have one, or be continuous",
    ),
    "no axis": (
        robot(link("a"), link("b"), joint("i", "continuous", "a", "b", axis="0 0 0")),
        ":4: the axis of joint i is (0, 0, 0); it must have a length above 0",
    ),
    "no number": (
        robot(link("a"), link("b"), joint("i", "continuous", "a", "b", xyz="0 0 x")),
        ':4: xyz of <origin> is "0 0 x"; it must be 3 finite numbers with spaces between',
    ),
    "negative mass": (robot(link("a", -1)), ":2: mass is -1 kg; it must be at least 0"),
    "no value": (
        robot('<link name="a"><inertial><mass/></inertial></link>'),
        ":2: <mass> has no value; it must have one",
    ),
    "negative damping": (
        robot(link("a"), link("b"), joint("i", "continuous", "a", "b", '<dynamics damping="-1"/>')),
        ":4: damping of joint i is -1; it must be at least 0",
    ),
    "two joints of a name": (
        robot(link("a"), link("b"), link("c"), joint("i", "fixed", "a", "b"), joint("i", "fixed", "b", "c")),
        ":6: the joint i is there twice; names must differ",
    ),
    "nothing moves": (
        robot('<link name="world"/>', link("a"), joint("i", "fixed", "world", "a")),
        ": nothing moves; a mechanism needs a body with mass and a joint or a free base",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_mistakes(tmp_path, case):
    text, message = BAD[case]
    found = refusal(tmp_path, text)
    assert found.startswith(message) if case == "no XML" else found == message


def test_external_entities_are_not_read(tmp_path):
    (tmp_path / "secret.txt").write_text("secret", encoding="utf-8")
    text = f'<!DOCTYPE robot [<!ENTITY x SYSTEM "{tmp_path}/secret.txt">]><robot name="a"><link name="&x;"/></robot>'
    assert "secret" not in refusal(tmp_path, text).replace("secret.txt", "")
