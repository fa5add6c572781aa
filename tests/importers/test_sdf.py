"""SDF: frames, joints and loops, against the same mechanism written otherwise, and its mistakes."""

import numpy as np
import pytest

from research.robots import State
from sigmafmu import _core
from sigmafmu.importers.robot import DescriptionError

from .helpers import accelerations_at, converted, degrees, refusal, told

INERTIAL = (
    "<inertial><pose>0.1 0.2 0.05 0.3 -0.2 0.5</pose><mass>{}</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy>"
    "<izz>0.04</izz><ixy>0.001</ixy><ixz>-0.002</ixz><iyz>0.003</iyz></inertia></inertial>"
)


def link(name, pose="0 0 0 0 0 0", mass=1.0, attributes="", more=""):
    return f'<link name="{name}"><pose {attributes}>{pose}</pose>{INERTIAL.format(mass)}{more}</link>'


def joint(name, kind, parent, child, axis="0 1 0", more="", axis_more="", pose=""):
    axes = f"<axis><xyz>{axis}</xyz>{axis_more}</axis>" if axis else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{pose}{axes}{more}</joint>'
    )


def sdf(*parts, world=""):
    model = f'<model name="some">\n{chr(10).join(parts)}\n</model>'
    return f'<sdf version="1.9">{f"<world>{world}{model}</world>" if world else model}</sdf>'


def test_the_same_as_urdf(tmp_path):
    from .test_urdf import joint as urdf_joint
    from .test_urdf import link as urdf_link
    from .test_urdf import robot

    state = State({"one": (0.7, -1.1), "two": (0.2, 0.5)})
    urdf = robot(
        '<link name="world"/>', urdf_link("a"), urdf_link("b", 2),
        urdf_joint("one", "continuous", "world", "a", '<dynamics damping="0.7"/>'),
        urdf_joint("two", "prismatic", "a", "b", '<limit lower="-1" upper="1"/>', axis="1 2 2"),
    )  # fmt: skip
    text = sdf(
        link("a", "0.3 0.1 0.2 0.1 0.2 0.3"),
        link("b", "0.3 0.1 0.2 0.1 0.2 0.3", 2, 'relative_to="a"'),
        joint("one", "revolute", "world", "a", axis_more="<dynamics><damping>0.7</damping></dynamics>"),
        joint("two", "prismatic", "a", "b", "1 2 2", axis_more="<limit><lower>-1</lower><upper>1</upper></limit>"),
    )
    expected = accelerations_at(tmp_path, urdf, state)
    np.testing.assert_allclose(accelerations_at(tmp_path, text, state), expected, rtol=1e-12)


def test_axes_in_other_frames_and_poses_of_joints(tmp_path):
    """A frame that is turned by 90 degrees: its y is the model's -x."""
    plain = sdf(
        link("a", "0 0 1 0 0 0"), joint("one", "continuous", "world", "a", "1 0 0", pose="<pose>0 0.2 0 0 0 0</pose>")
    )
    turned = sdf(
        '<frame name="f"><pose degrees="true">0 0.2 1 0 0 90</pose></frame>',
        link("a", "0 0 1 0 0 0"),
        joint("one", "continuous", "world", "a", "", pose='<pose relative_to="f"/>')
        .replace("</joint>", '<axis><xyz expressed_in="f">0 -1 0</xyz></axis></joint>'),
    )  # fmt: skip
    state = State({"one": (0.4, 1.0)})
    np.testing.assert_allclose(
        accelerations_at(tmp_path, turned, state), accelerations_at(tmp_path, plain, state), rtol=1e-12
    )


BARS = (
    link("crank", "0 0 0 0 0 0"), link("coupler", "0 0 0.4 0 0 0"), link("rocker", "0.5 0 0.4 0 0 0"),
    joint("one", "revolute", "world", "crank"), joint("two", "revolute", "crank", "coupler"),
    joint("three", "revolute", "coupler", "rocker"),
    joint("four", "revolute", "world", "rocker", pose="<pose>0 0 -0.4 0 0 0</pose>"),
)  # fmt: skip


def test_a_loop_stays_one(tmp_path):
    content, _, file = converted(tmp_path, sdf(*BARS))
    assert content["joints"]["four"]["bodies"] == ["ground", "rocker"]
    assert degrees(file) == 1
    assert list(content["joints"])[-1] in ("three", "four")
    assert not file.moves


def test_a_loop_moves_as_its_drawing(tmp_path):
    """The same four bars, written as a mechanism file with geometry in W."""
    from .helpers import load_text

    _, _, file = converted(tmp_path, sdf(*BARS))
    inertia = (
        "inertia: {xx: 0.02, yy: 0.03, zz: 0.04, xy: 0.001, xz: -0.002, yz: 0.003}, "
        "inertia_axes: {rpy: [0.3, -0.2, 0.5]}, center_of_mass: [0.1, 0.2, 0.05], mass: 1"
    )
    drawn = load_text(
        f"sigmafmu: 1\nname: Drawn\nbodies:\n  crank: {{{inertia}, position: [0, 0, 0]}}\n"
        f"  coupler: {{{inertia}, position: [0, 0, 0.4]}}\n  rocker: {{{inertia}, position: [0.5, 0, 0.4]}}\njoints:\n"
        "  one: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 1, 0]}\n"
        "  two: {type: revolute, bodies: [crank, coupler], point: [0, 0, 0.4], axis: [0, 1, 0]}\n"
        "  three: {type: revolute, bodies: [coupler, rocker], point: [0.5, 0, 0.4], axis: [0, 1, 0]}\n"
        "  four: {type: revolute, bodies: [ground, rocker], point: [0.5, 0, 0], axis: [0, 1, 0]}\n",
        "drawn.yaml",
    )
    slaves = [_core.Slave(mechanism) for mechanism in (file.mechanism, drawn.mechanism)]
    for slave in slaves:
        slave.start()
        for i in range(100):
            slave.do_step(1e-3 * i, 1e-3)
    angles = [slave.get("one.angle") for slave in slaves]
    assert abs(angles[0]) > 1e-3
    assert angles[0] == pytest.approx(angles[1], rel=1e-9)


def test_worlds(tmp_path):
    world = "<gravity>0 0 -1.6</gravity><physics><max_step_size>0.0005</max_step_size></physics>"
    static = '<model name="floor"><static>true</static><link name="l"/></model>'
    text = sdf(
        "<pose>1 2 3 0 0 0</pose>", link("a"), link("b"), joint("one", "ball", "a", "b", ""), world=world + static
    )
    content, made, file = converted(tmp_path, text)
    assert content["gravity"] == [0, 0, -1.6]
    assert content["integrator"]["stepSize"] == 0.0005
    assert content["bodies"]["a"]["position"] == [1, 2, 3]
    assert degrees(file) == 9
    assert told(made, "static models") == "static models: floor"


def test_universal_joints_and_screws(tmp_path):
    pitch = "<screw_thread_pitch>0.01</screw_thread_pitch>"
    axis2 = "<axis2><xyz>0 1 0</xyz><dynamics><damping>3</damping></dynamics></axis2>"
    text = sdf(
        link("a"), link("b"), joint("s", "screw", "world", "a", "0 0 1", pitch),
        joint("u", "universal", "a", "b", "1 0 0", axis2),
    )  # fmt: skip
    content, _, file = converted(tmp_path, text)
    assert content["joints"]["u"]["damping2"] == 3
    thread = content["couplings"]["s_thread"]
    assert thread["joints"] == ["s.angle", "s.displacement"]
    assert thread["radius"] == pytest.approx(0.01 / (2 * np.pi))
    assert degrees(file) == 3


def test_shapes_and_springs(tmp_path):
    visual = (
        '<visual name="v"><pose>1 0 0 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry>'
        "<material><diffuse>0 1 0 1</diffuse></material></visual>"
    )
    dynamics = "<dynamics><spring_stiffness>5</spring_stiffness><spring_reference>0.2</spring_reference></dynamics>"
    text = sdf(link("a", more=visual), joint("j", "revolute", "world", "a", axis_more=dynamics))
    content, _, _ = converted(tmp_path, text)
    assert content["bodies"]["a"]["shapes"] == [{"box": [1, 2, 3], "color": "#00ff00", "position": [1, 0, 0]}]
    assert (content["joints"]["j"]["stiffness"], content["joints"]["j"]["rest"]) == (5, 0.2)


@pytest.mark.parametrize(
    ("limits", "expected", "sentence"),
    [
        ("<lower>-1</lower><upper>2</upper>", [-1, 2], None),
        ("<lower>-1e16</lower><upper>1e16</upper>", None, None),
        ("<lower>-inf</lower><upper>inf</upper>", None, None),
        ("<lower>-1</lower>", None, "limits of one side"),
        ("<lower>1</lower><upper>1</upper>", None, "j: limits from 1 to 1 leave it no room"),
    ],
)
def test_limits(tmp_path, limits, expected, sentence):
    text = sdf(link("a"), joint("j", "revolute", "world", "a", axis_more=f"<limit>{limits}</limit>"))
    content, made, _ = converted(tmp_path, text)
    assert content["joints"]["j"].get("limits") == expected
    assert made.told == ([sentence] if sentence else [])


BAD = {
    "no model": ("<sdf/>", ":1: there are 0 models that may move; it must be one"),
    "no link": (sdf(), ":1: there is no link; a model has at least one"),
    "unknown frame": (
        sdf(link("a", attributes='relative_to="b"')),
        ":2: there is no frame b; allowed is a",
    ),
    "a ring of frames": (
        sdf(link("a", attributes='relative_to="b"'), link("b", attributes='relative_to="a"')),
        ":3: the frame a is relative to itself; frames must end at the model",
    ),
    "unknown type": (
        sdf(link("a"), joint("j", "hinge", "world", "a")),
        ":3: the type of joint j is hinge; allowed are revolute, continuous, prismatic, fixed, ball, universal, screw",
    ),
    "unknown link": (
        sdf(link("a"), joint("j", "revolute", "b", "a")),
        ":3: there is no link b; allowed is a",
    ),
    "the same link": (
        sdf(link("a"), joint("j", "revolute", "a", "a")),
        ":3: joint j has a on both sides; they must differ",
    ),
    "no axis": (
        sdf(link("a"), joint("j", "revolute", "world", "a", "")),
        ":3: joint j has no <axis>; it must have one",
    ),
    "zero axis": (
        sdf(link("a"), joint("j", "revolute", "world", "a", "0 0 0")),
        ":3: the axis of joint j is (0, 0, 0); it must have a length above 0",
    ),
    "axes that are not perpendicular": (
        sdf(link("a"), joint("j", "universal", "world", "a", "1 0 0", "<axis2><xyz>1 1 0</xyz></axis2>")),
        ":3: the axes of joint j are not perpendicular; they must be",
    ),
    "no child": (
        sdf(link("a"), '<joint name="j" type="fixed"><parent>a</parent></joint>'),
        ":3: joint j has no <child>; it must have one",
    ),
    "no pose": (
        sdf(link("a", "1 2 3")),
        ':2: <pose> is "1 2 3"; it must be 6 finite numbers with spaces between',
    ),
    "equal names": (sdf(link("a"), link("a")), ":3: the name a is there twice; names must differ"),
}  # fmt: skip


def test_the_base_is_only_asked_of_urdf(tmp_path):
    with pytest.raises(DescriptionError, match="only asked of URDF"):
        converted(tmp_path, sdf(link("a")), "free")


@pytest.mark.parametrize("case", BAD)
def test_mistakes(tmp_path, case):
    text, message = BAD[case]
    assert refusal(tmp_path, text) == message
