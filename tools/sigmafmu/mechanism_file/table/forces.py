"""Types of forces, and loads."""

from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_ends
from sigmafmu.mechanism_file.kinds import Number, Text, Word
from sigmafmu.mechanism_file.structures import ByType, Key, List, Struct, vector
from sigmafmu.mechanism_file.table.ends import BODY, PAIR, POINTS, End, both, keys_of
from sigmafmu.mechanism_file.table.quantities import least, positive


@dataclass(frozen=True)
class ForceType:
    """A type of force: what it is, where it attaches, and its numbers."""

    meaning: str
    ends: tuple[End, ...]
    keys: tuple[Key, ...]
    bodies: Key = PAIR


SURFACE = (
    Key("modulus", least("modulus"), "contact modulus: 1/E* = (1 - ν₁²)/E₁ + (1 - ν₂²)/E₂", default="1e7"),
    Key(
        "dissipation", least("slowness"), "Hunt and Crossley's: small impacts at v lose the part c v of it", default="0"
    ),
    Key("friction", least("number"), "coefficient", default="0"),
    Key("slip_velocity", positive("velocity"), "where friction has 0.7 of its full force", default="0.01"),
)
"""Of contacts."""

MATRIX = List(List(Number(), 6), 6)

FORCE_TYPES = {
    "line_spring": ForceType(
        "spring and damper along the line between two points",
        POINTS,
        (
            Key("stiffness", least("stiffness"), "along the line", default="0"),
            Key("damping", least("damping"), "along the line", default="0"),
            Key("free_length", least("length"), "where the spring has no force", default="0"),
        ),
    ),
    "table_spring": ForceType(
        "tension by tables over length and rate, between two points",
        POINTS,
        (
            Key("length", List(least("length"), least=2), "lengths that increase", default="none"),
            Key("force", List(Number("force"), least=2), "tension at these", default="none"),
            Key("rate", List(Number("velocity"), least=2), "rates of the length that increase", default="none"),
            Key("rate_force", List(Number("force"), least=2), "tension at these, which is added", default="none"),
        ),
    ),
    "torsion_spring": ForceType(
        "spring and damper about an axis",
        both("point", "axis"),
        (
            Key("stiffness", least("torsional stiffness"), "about the axis", default="0"),
            Key("damping", least("torsional damping"), "about the axis", default="0"),
            Key("rest", Number("angle"), "where the spring has no torque", default="0"),
        ),
    ),
    "bushing": ForceType(
        "springs and dampers in all six directions between two frames",
        both("point", "orientation"),
        (
            Key("stiffness", List(least("stiffness"), 3), "along the axes of the first frame", default="0"),
            Key("damping", List(least("damping"), 3), "along the axes of the first frame", default="0"),
            Key("torsional_stiffness", List(least("torsional stiffness"), 3), "about them", default="0"),
            Key("torsional_damping", List(least("torsional damping"), 3), "about them", default="0"),
            Key("stiffness_coupling", MATRIX, "6 × 6 in SI units, symmetric, zeros on the diagonal", default="0"),
            Key("damping_coupling", MATRIX, "the same of the damping", default="0"),
        ),
    ),
    "bearing": ForceType(
        "springs and dampers along three axes that cross-couple, as journal bearings and seals",
        both("point", "orientation"),
        (
            Key("stiffness", List(Number("stiffness"), 3), "along the axes of the first frame", default="0"),
            Key("damping", List(Number("damping"), 3), "along the axes of the first frame", default="0"),
            Key("cross_stiffness", List(Number("stiffness"), 2), "force along x by y, along y by x", default="0"),
            Key("cross_damping", List(Number("damping"), 2), "the same of the damping", default="0"),
        ),
    ),
    "drag": ForceType(
        "quadratic drag in a medium",
        (End(("point",), "frame", 0, is_frame=False),),
        (
            Key("coefficient", List(least("drag"), 3), "along the body's axes: density c_d area / 2", default="0"),
            Key("rotational", List(least("rotational drag"), 3), "about the body's axes", default="0"),
            Key("flow", vector("velocity"), "of the medium, in W", default="0"),
        ),
        Key("body", BODY, "on which it acts", required=True),
    ),
    "follower_force": ForceType(
        "a force and a torque that turn with a body",
        (End(("point",), "frame", 0, is_frame=False),),
        (
            Key("force", vector("force"), "in the body's axes", default="0"),
            Key("torque", vector("torque"), "in the body's axes", default="0"),
        ),
        Key("body", BODY, "on which it acts", required=True),
    ),
    "plane_contact": ForceType(
        "a sphere of the second body on a plane of the first",
        (End(("point", "normal"), "frame1", 0), POINTS[1]),
        (Key("radius", positive("length"), "of the sphere about point2", required=True), *SURFACE),
    ),
    "cloud_contact": ForceType(
        "many points of the second body on a plane of the first",
        (End(("point", "normal"), "frame1", 0), End(("points2",), "", 1, is_frame=False, many=True)),
        (Key("radius", positive("length"), "of the spheres about the points", required=True), *SURFACE),
    ),
    "sphere_contact": ForceType(
        "spheres of two bodies",
        POINTS,
        (
            Key("radius1", positive("length"), "of the sphere about point1", required=True),
            Key("radius2", positive("length"), "of the sphere about point2", required=True),
            *SURFACE,
        ),
    ),
    "spring_damper": ForceType(
        "springs and dampers along each axis of W",
        POINTS,
        (
            Key("stiffness", List(least("stiffness"), 3), "along the axes of W", default="0"),
            Key("damping", List(least("damping"), 3), "along the axes of W", default="0"),
        ),
    ),
}


def _force(name: str, force: ForceType) -> Struct:
    kind = Key("type", Word((name,)), force.meaning, required=True)
    return Struct((kind, force.bodies, *keys_of(force.ends), *force.keys), check_ends(force.ends), name)


LOAD = Struct(
    (
        Key("description", Text(), "for the FMU"),
        Key("body", BODY, "on which it acts", required=True),
        Key("force", vector("force"), "constant, in W, at the centre of mass", default="0"),
        Key("torque", vector("torque"), "constant, in W", default="0"),
    ),
    name="load",
)


FORCES = ByType({name: _force(name, force) for name, force in FORCE_TYPES.items()})
