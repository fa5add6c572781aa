"""Types of joints."""

from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_ends
from sigmafmu.mechanism_file.kinds import Flag, Word
from sigmafmu.mechanism_file.structures import ByType, Key, Struct
from sigmafmu.mechanism_file.table import coordinates, ends
from sigmafmu.mechanism_file.table.coordinates import ANGLE, BOTH, CROSS, DISPLACEMENT, PLANE, SPACE, Coordinate
from sigmafmu.mechanism_file.table.ends import PAIR, End, both
from sigmafmu.mechanism_file.table.quantities import positive


@dataclass(frozen=True)
class JointType:
    """A type of joint: what it does, where it attaches, and what it leaves free."""

    meaning: str
    ends: tuple[End, ...]
    coordinates: tuple[Coordinate, ...] = ()
    keys: tuple[Key, ...] = ()
    places: bool = True
    """Whether it says where one body is to the other."""


MOTOR = (Key("motor", Flag(), "whether it has inputs for a torque between its bodies", default="false"),)

JOINT_TYPES = {
    "spherical": JointType("holds a point", both("point"), keys=MOTOR),
    "revolute": JointType("turns about an axis", both("point", "axis"), (ANGLE,)),
    "universal": JointType("holds a point; the two axes stay perpendicular", both("point", "axis1", "axis2"), CROSS),
    "prismatic": JointType("slides along an axis", both("point", "axis"), (DISPLACEMENT,)),
    "fixed": JointType("holds everything", both("point")),
    "cylindrical": JointType("turns about an axis and slides along it", both("point", "axis"), BOTH),
    "planar": JointType("turns about a normal and slides across it", both("point", "normal"), PLANE),
    "point_on_line": JointType("keeps a point on an axis", both("point", "axis"), (DISPLACEMENT,), MOTOR),
    "distance": JointType(
        "keeps two points apart, as a rod",
        (End(("point1",), "frame1", 0), End(("point2",), "frame2", 1)),
        keys=(Key("length", positive("length"), "of the rod", default="the distance at the start"), *MOTOR),
        places=False,
    ),
    "free": JointType("holds nothing", both("point", "orientation"), SPACE, MOTOR),
}


def _joint(name: str, joint: JointType) -> Struct:
    keys = (
        Key("type", Word((name,)), joint.meaning, required=True),
        PAIR,
        *ends.keys_of(joint.ends),
        *joint.keys,
        *(key for c in joint.coordinates for key in coordinates.keys_of(c)),
    )
    return Struct(keys, check_ends(joint.ends), name)


JOINTS = ByType({name: _joint(name, joint) for name, joint in JOINT_TYPES.items()})
