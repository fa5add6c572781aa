"""Types of joints."""

from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_ends
from sigmafmu.mechanism_file.kinds import Flag, Number, Word
from sigmafmu.mechanism_file.structures import ByType, Key, Struct, vector
from sigmafmu.mechanism_file.table import coordinates, ends
from sigmafmu.mechanism_file.table.coordinates import ACROSS, ANGLE, BOTH, CROSS, DISPLACEMENT, PLANE, SPACE, Coordinate
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

PITCH = Key("pitch", Number("length"), "displacement of a turn; negative: a left-handed thread", required=True)
RADIUS = Key("radius", positive("length"), "of the disk", required=True)
REACTION = Struct(
    (
        Key("at", Word(("frame1", "frame2")), "frame about whose origin the torque is", default="frame2"),
        Key("point", vector("length"), "another point of that frame, in its axes", default="its origin"),
        Key("axes", Word(("ground", "frame1", "frame2")), "of both vectors", default="ground"),
    ),
    name="reaction",
    shared=True,
)

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
    "screw": JointType("turns about an axis and moves along it by its pitch", both("point", "axis"), BOTH, (PITCH,)),
    "constant_velocity": JointType(
        "holds a point and transmits the rotation about z however it is bent", both("point", "axis"), keys=MOTOR
    ),
    "point_in_plane": JointType("keeps a point in a plane", both("point", "normal"), ACROSS, MOTOR),
    "rolling_disk": JointType(
        "the second body has a disk that rolls without slip on a plane of the first",
        (End(("point1", "normal"), "frame1", 0), End(("point2", "axis"), "frame2", 1)),
        keys=(RADIUS,),
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
        Key("reaction", REACTION, "point and axes of its reaction", default="origin of frame 2, in W"),
        *(key for c in joint.coordinates for key in coordinates.keys_of(c)),
    )
    return Struct(keys, check_ends(joint.ends), name)


JOINTS = ByType({name: _joint(name, joint) for name, joint in JOINT_TYPES.items()})
