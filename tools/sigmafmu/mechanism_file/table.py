"""The one table of the keys of a mechanism file.

The loader reads by it; the JSON Schema and the tables of the documentation are made of it. A new element is an entry
here: its keys, with dimension, meaning and default, and the geometry that says how it attaches to bodies
(definition.py). Keys that are not geometry go into the definition under their own names.
"""

from collections.abc import Callable
from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import (
    check_body,
    check_coupling,
    check_ends,
    check_motion,
    check_orientation,
    check_shape,
)
from sigmafmu.mechanism_file.kinds import (
    ByType,
    Direction,
    Either,
    Flag,
    Key,
    Kind,
    Later,
    List,
    Named,
    Number,
    Points,
    Record,
    Reference,
    Struct,
    Text,
    Version,
    Whole,
    Word,
    WordOr,
    vector,
)

VERSION = 1
GROUND = "ground"

NAME = Text(
    r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*",
    "allowed are letters, digits and _, no digit first, and dots between such words",
)
IDENTIFIER = Text(r"[A-Za-z_][A-Za-z0-9_]*", "allowed are letters, digits and _, no digit first")

BODY, ANY_BODY, COORDINATE = Reference("body"), Reference("body or ground"), Reference("coordinate")


def least(dimension: str) -> Number:
    """A number that must not be negative."""
    return Number(dimension, 0.0)


def positive(dimension: str) -> Number:
    """A number above zero."""
    return Number(dimension, 0.0, above=True)


def limits(dimension: str) -> List:
    """The least and the largest of what is allowed."""
    return List(Number(dimension), 2)


ORIENTATION = Struct(
    (
        Key("rotation_vector", vector("angle"), "axis times angle"),
        Key("quaternion", List(Number(), 4), "(w, x, y, z), of any length above 0"),
        Key("rpy", vector("angle"), "roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll)"),
    ),
    check_orientation,
    "orientation",
    one_of=("rotation_vector", "quaternion", "rpy"),
    shared=True,
)

FRAME = Struct(
    (
        Key("position", vector("length"), "of the origin, in the body's frame", default="its origin"),
        Key("orientation", ORIENTATION, "of the axes, in the body's frame", default="its axes"),
        Key("node", Whole(), "of a flexible body: the frame moves with it and is given from it"),
        Key("motion", Reference("motion"), "of the ground: the frame moves with it and is given from it"),
    ),
    name="frame",
    shared=True,
)

INERTIA = Struct(
    (
        *(Key(name, least("inertia"), "moment", required=True) for name in ("xx", "yy", "zz")),
        *(Key(name, Number("inertia"), "element of the matrix", default="0") for name in ("xy", "xz", "yz")),
    ),
    name="matrix elements",
)

FLEXIBLE = Struct(
    (
        Key("file", Text(), "modal data, beside the mechanism file", required=True),
        Key("mass_damping", least("rate"), "times the modal mass: damping", default="0"),
        Key("stiffness_damping", least("time"), "times the modal stiffness: damping", default="0"),
        Key("initial_coordinates", List(Number()), "modal coordinates at the start", default="0"),
        Key("initial_rates", List(Number()), "their rates at the start", default="0"),
    ),
    name="modal data with more",
)

SHAPE = Struct(
    (
        Key("box", List(positive("length"), 3), "edges"),
        Key(
            "cylinder",
            Struct(
                (
                    Key("radius", positive("length"), "radius", required=True),
                    Key("length", positive("length"), "along z", required=True),
                ),
                name="cylinder",
            ),
            "about its middle, along z",
        ),
        Key("sphere", positive("length"), "radius"),
        Key("mesh", Text(), "a file beside the mechanism file"),
        Key("scale", positive("number"), "of a mesh", default="1"),
        Key("position", vector("length"), "in the body's frame", default="its origin"),
        Key("orientation", ORIENTATION, "in the body's frame", default="its axes"),
        Key("color", Text(r"#[0-9A-Fa-f]{6}", 'it must be like "#4477aa"'), "of the surface", default="by the viewer"),
    ),
    check_shape,
    "shape",
    one_of=("box", "cylinder", "sphere", "mesh"),
)

BODY_KEYS = Struct(
    (
        Key("description", Text(), "for the FMU"),
        Key("mass", positive("mass"), "required of rigid bodies"),
        Key(
            "inertia",
            Either(List(least("inertia"), 3), INERTIA),
            "about the centre of mass, in the body's axes; a list has xx, yy, zz; required of rigid bodies",
        ),
        Key("center_of_mass", vector("length"), "in the body's frame", default="its origin"),
        Key("inertia_axes", ORIENTATION, "axes in which `inertia` is given, in the body's frame", default="its axes"),
        Key("flexible", Either(Text(), FLEXIBLE), "file of modal data in place of mass and inertia"),
        Key("position", vector("length"), "of the body's frame, in W, at the start", default="by a joint"),
        Key("orientation", ORIENTATION, "of the body's frame, in W, at the start", default="by a joint"),
        Key("velocity", vector("velocity"), "of the centre of mass, in W", default="by a joint"),
        Key("angular_velocity", vector("angular velocity"), "in the body's axes", default="by a joint"),
        Key("shapes", List(SHAPE), "what is drawn"),
    ),
    check_body,
    "body",
)


@dataclass(frozen=True)
class Coordinate:
    """What a joint leaves free, and how keys and variables of it are called."""

    turns: bool
    number: str = ""
    """1, 2, ... where a joint has several of its kind."""
    beside_angle: bool = False
    """Whether it is a displacement of a joint that turns as well."""
    axis: int = 2
    """Of x, y, z: about or along it; what turns before it turns it."""

    @property
    def word(self) -> str:
        """What the FMU calls it: `angle`, `displacement`, with the number."""
        return ("angle" if self.turns else "displacement") + self.number

    def key(self, word: str) -> str:
        """The key for what acts on it: `stiffness`, `displacement_stiffness`; `displacement` for the value itself."""
        if not self.beside_angle:
            return word + self.number
        return ("displacement" if word == "coordinate" else f"displacement_{word}") + self.number

    def initial(self, word: str) -> str:
        """The FMU's parameter for its `coordinate` or `rate` at the start."""
        names = {"coordinate": ("initialAngle", "initialDisplacement"), "rate": ("initialAngularRate", "initialRate")}
        return names[word][0 if self.turns else 1] + self.number

    def dimension(self, of_angle: str, of_displacement: str) -> str:
        """The one or the other."""
        return of_angle if self.turns else of_displacement


ANGLE, DISPLACEMENT = Coordinate(turns=True), Coordinate(turns=False)
BOTH = (ANGLE, Coordinate(turns=False, beside_angle=True))
CROSS = (Coordinate(turns=True, number="1", axis=1), Coordinate(turns=True, number="2", axis=0))
PLANE = (
    ANGLE,
    Coordinate(turns=False, number="1", beside_angle=True, axis=0),
    Coordinate(turns=False, number="2", beside_angle=True, axis=1),
)
SPACE = tuple(Coordinate(turns=False, number=str(i + 1), axis=i) for i in range(3))


@dataclass(frozen=True)
class ActingKey:
    """A key for what acts on a coordinate."""

    word: str
    dimensions: tuple[str, str]
    """For an angle, for a displacement."""
    meaning: str
    default: str = "0"
    kind: Callable[[str], Kind] = least
    """Of a dimension."""
    into: tuple[str, ...] = ()
    """Keys in the definition, where these are others."""


ACTING = {
    "joint_springs": (
        ActingKey("stiffness", ("torsional stiffness", "stiffness"), "of a spring"),
        ActingKey("damping", ("torsional damping", "damping"), "of a damper"),
        ActingKey("rest", ("angle", "length"), "where the spring has no force", kind=Number),
    ),
    "joint_frictions": (
        ActingKey("friction", ("torque", "force"), "Coulomb's"),
        ActingKey("stribeck_friction", ("torque", "force"), "what is added to it at rest"),
        ActingKey("stribeck_rate", ("angular velocity", "velocity"), "at which 1/e of that is left", "0.1", positive),
        ActingKey("viscous_friction", ("torsional damping", "damping"), "by the rate"),
        ActingKey(
            "creep_rate", ("angular velocity", "velocity"), "at which friction has 76 % of it", "0.001", positive
        ),
    ),
    "joint_stops": (
        ActingKey(
            "limits", ("angle", "length"), "where its stops are", "none", limits, into=("lower_stop", "upper_stop")
        ),
        ActingKey("stop_stiffness", ("torsional stiffness", "stiffness"), "of the stops", "1e4, 1e6"),
        ActingKey("stop_damping", ("torsional slowness", "slowness"), "of the stops"),
        ActingKey("stop_depth", ("angle", "length"), "from which the stops are stiff", "0.001", positive),
    ),
    "joint_armatures": (ActingKey("armature", ("inertia", "mass"), "inertia that moves with it, as a motor's rotor"),),
}
"""What acts on coordinates: the list in the definition → its keys."""

STOP_STIFFNESS = (1e4, 1e6)
"""Of limits that do not say theirs: of an angle [N m/rad], of a displacement [N/m]."""


def _coordinate_keys(c: Coordinate) -> tuple[Key, ...]:
    what = "its angle" if c.turns else "its displacement"
    start = c.dimension("angle", "length"), c.dimension("angular velocity", "velocity")
    return (
        Key(c.key("coordinate"), Number(start[0]), f"{what} at the start", default="0, or as placed"),
        Key(c.key("rate"), Number(start[1]), f"rate of {what} at the start", default="0, or by the bodies"),
        *(
            Key(c.key(key.word), key.kind(c.dimension(*key.dimensions)), key.meaning, default=key.default)
            for keys in ACTING.values()
            for key in keys
        ),
    )


@dataclass(frozen=True)
class End:
    """Where an element attaches to one of its bodies: by keys in W, or by a frame of the body.

    Ends with the same keys in W share them: all of these are given by them, or all by frames.
    """

    in_w: tuple[str, ...]
    frame: str
    body: int = 0
    """Which of the element's bodies."""
    is_frame: bool = True
    """Whether the element attaches to a frame there; else to its origin, by the key that is the first in W."""


def both(*in_w: str) -> tuple[End, End]:
    """Frames of two bodies that have the same keys in W."""
    return End(in_w, "frame1", 0), End(in_w, "frame2", 1)


POINTS = (End(("point1",), "frame1", 0, is_frame=False), End(("point2",), "frame2", 1, is_frame=False))

IN_W = {
    key.name: key
    for key in (
        Key("point", vector("length"), "where it is at the start, in W"),
        Key("point1", vector("length"), "on the first body, in W, at the start"),
        Key("point2", vector("length"), "on the second body, in W, at the start"),
        Key("axis", Direction(), "in W, at the start"),
        Key("normal", Direction(), "in W, at the start"),
        Key("orientation", ORIENTATION, "of the axes, in W, at the start", default="those of W"),
        Key("axis1", Direction(), "fixed in the first body; in W, at the start"),
        Key("axis2", Direction(), "fixed in the second body, perpendicular; in W, at the start"),
    )
}
"""Geometry in W of elements, by its keys."""


def _ends(ends: tuple[End, ...]) -> tuple[Key, ...]:
    """Keys of ends."""
    names = dict.fromkeys(name for end in ends for name in end.in_w)
    which = {0: "the first body", 1: "the second body"} if len(ends) > 1 else {0: "the body"}
    frames = (Key(end.frame, FRAME, f"in {which[end.body]}, in place of geometry in W; z is the axis") for end in ends)
    return (*(IN_W[name] for name in names), *frames)


PAIR = Key("bodies", List(ANY_BODY, 2), "first and second body, or ground", required=True)


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
        *_ends(joint.ends),
        *joint.keys,
        *(key for c in joint.coordinates for key in _coordinate_keys(c)),
    )
    return Struct(keys, check_ends(joint.ends), name)


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
    return Struct((kind, force.bodies, *_ends(force.ends), *force.keys), check_ends(force.ends), name)


LOAD = Struct(
    (
        Key("description", Text(), "for the FMU"),
        Key("body", BODY, "on which it acts", required=True),
        Key("force", vector("force"), "constant, in W, at the centre of mass", default="0"),
        Key("torque", vector("torque"), "constant, in W", default="0"),
    ),
    name="load",
)

MOTIONS = {
    "position": ("angle", "length"),
    "rate": ("angular velocity", "velocity"),
    "acceleration": ("angular acceleration", "acceleration"),
}
"""What a drive prescribes → dimension of its value for angles and displacements."""

INPUT = "input"


def prescribed(dimension: str) -> dict[str, Kind]:
    """Kinds of what a drive prescribes, by its keys."""
    return {
        "value": WordOr(INPUT, Number(dimension)),
        "table": Points(Number("time"), Number(dimension)),
    }


def _later(key: str, text: str) -> Later:
    return Later(text, tuple(prescribed(d)[key] for pair in MOTIONS.values() for d in pair))


DRIVE = Struct(
    (
        Key("motion", Word(tuple(MOTIONS)), "what is prescribed; the others go on from the start", required=True),
        Key("value", _later("value", "number of the motion, or `input`"), "constant, or an input of the FMU"),
        Key("table", _later("table", "list of [time, number of the motion]"), "a natural cubic spline through points"),
    ),
    name="drive",
    one_of=("value", "table"),
)

MOTION = Struct(
    (
        Key("position", vector("length"), "of the frame in W, where its motion is zero", default="the origin"),
        Key("orientation", ORIENTATION, "of the frame in W, where its motion is zero", default="that of W"),
        Key("input", Flag(), "whether its displacement and rotation are inputs of the FMU", default="false"),
        *(Key(axis, Points(Number("time"), Number("length")), "displacement in W", default="0") for axis in "xyz"),
        *(
            Key(f"r{axis}", Points(Number("time"), Number("angle")), "rotation vector in the frame's axes", default="0")
            for axis in "xyz"
        ),
    ),
    check_motion,
    "motion",
)
MOVING = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class CouplingType:
    """A type of coupling: p_1(x_1) + p_2(x_2) + ... is constant, with polynomials of its coordinates."""

    meaning: str
    joints: tuple[str, ...]
    """What its coordinates are; empty: any number."""
    keys: tuple[Key, ...]
    polynomials: Callable[[Record], list[list[float]]]
    """Coefficients from the constant on, in the order of the coordinates."""
    offset: Callable[[Record], float | None] = lambda _: None
    """The constant; None: what it is at the start."""


COUPLING_TYPES = {
    "gear": CouplingType(
        "rate of the second = ratio × rate of the first",
        ("first", "second"),
        (Key("ratio", Number(), "negative where they turn the other way", required=True),),
        lambda c: [[0.0, -c["ratio"]], [0.0, 1.0]],
    ),
    "rack_and_pinion": CouplingType(
        "the rack moves by the radius for each rad",
        ("pinion", "rack"),
        (Key("radius", Number("length"), "of the pinion", required=True),),
        lambda c: [[0.0, -c["radius"]], [0.0, 1.0]],
    ),
    "differential": CouplingType(
        "rate of the carrier = mean of both sides",
        ("carrier", "left", "right"),
        (),
        lambda _: [[0.0, 1.0], [0.0, -0.5], [0.0, -0.5]],
    ),
    "mimic": CouplingType(
        "the follower is a polynomial of the leader",
        ("follower", "leader"),
        (Key("polynomial", List(Number(), least=2), "coefficients in SI units, from the constant on", required=True),),
        lambda c: [[0.0, 1.0], [-x for x in c["polynomial"]]],
        lambda _: 0.0,
    ),
    "sum": CouplingType(
        "a sum of polynomials stays constant",
        (),
        (
            Key("polynomials", List(List(Number(), least=2), least=1), "one for each coordinate", required=True),
            Key("offset", Number(), "what the sum is", default="as at the start"),
        ),
        lambda c: c["polynomials"],
        lambda c: c.get("offset"),
    ),
}


def _coupling(name: str, coupling: CouplingType) -> Struct:
    roles = ", ".join(coupling.joints) or "any"
    joints = List(COORDINATE, len(coupling.joints) or None, 1)
    keys = (
        Key("type", Word((name,)), coupling.meaning, required=True),
        Key("joints", joints, f"{roles}: joints, or `joint.angle2` and so on", required=True),
        *coupling.keys,
    )
    return Struct(keys, check_coupling, name)


STATION = Struct(
    (
        Key("description", Text(), "for the FMU"),
        Key("body", BODY, "a flexible one", required=True),
        Key("nodes", List(Whole(), least=1), "its place is their mean", required=True),
        Key("deflection_axes", List(Direction()), "of displacements by deformation, in the body's axes"),
    ),
    name="station",
)


@dataclass(frozen=True)
class SensorType:
    """A type of sensor: what it measures, and its keys beside body and frame."""

    meaning: str
    keys: tuple[Key, ...] = ()


SENSOR_ENDS = (End(("point", "orientation"), "frame"),)

SENSOR_TYPES = {
    "motion": SensorType(
        "how a frame moves, seen from another one",
        (
            Key("reference", ANY_BODY, "from where it is seen", default="ground"),
            Key("reference_frame", FRAME, "in the reference", default="its frame"),
            Key("axes", Word(("ground", "reference", "sensor")), "in which vectors are", default="reference"),
        ),
    ),
    "imu": SensorType("specific force and angular velocity of a frame, in its axes"),
}


def _sensor(name: str, sensor: SensorType) -> Struct:
    keys = (
        Key("type", Word((name,)), sensor.meaning, required=True),
        Key("description", Text(), "for the FMU"),
        Key("body", ANY_BODY, "whose frame it is", required=True),
        *_ends(SENSOR_ENDS),
        *sensor.keys,
    )
    return Struct(keys, check_ends(SENSOR_ENDS), name)


EXPOSE = Struct(
    tuple(
        Key(name, List(Text()), f"patterns of names of {name}", default="none")
        for name in ("inputs", "outputs", "parameters")
    ),
    name="patterns",
)

EXPERIMENT = Struct(
    (
        Key("stop_time", positive("time"), "of a run", default="1"),
        Key("step_size", positive("time"), "communication step", default="0.001"),
    ),
    name="experiment",
)


def _integrator() -> Struct:
    """The integrator's settings, as the core has them: its values are numbers, words where it has enumerations."""
    import json

    from sigmafmu import _core

    settings = json.loads(_core.to_json(_core.Mechanism()))["integrator"]

    def kind(name: str, value: object) -> Number | Whole | Text:
        if isinstance(value, str):
            return Text()
        return Number("time") if name == "stepSize" else Whole() if isinstance(value, int) else Number()

    return Struct(
        tuple(
            Key(name, kind(name, value), f"integrator.{name} of the FMU", default=str(value))
            for name, value in settings.items()
        ),
        name="settings",
    )


JOINTS = ByType({name: _joint(name, joint) for name, joint in JOINT_TYPES.items()})
FORCES = ByType({name: _force(name, force) for name, force in FORCE_TYPES.items()})
COUPLINGS = ByType({name: _coupling(name, coupling) for name, coupling in COUPLING_TYPES.items()})
SENSORS = ByType({name: _sensor(name, sensor) for name, sensor in SENSOR_TYPES.items()})

MECHANISM = Struct(
    (
        Key("sigmafmu", Version(VERSION), "version of this format", required=True),
        Key("name", IDENTIFIER, "the FMU's model identifier", required=True),
        Key("description", Text(), "one sentence, for the FMU"),
        Key("gravity", vector("acceleration"), "in W", default="[0, 0, -9.81]"),
        Key("bodies", Named(BODY_KEYS, NAME), "rigid and flexible bodies", required=True),
        Key("joints", Named(JOINTS, NAME), "what ties them to each other and to the ground"),
        Key("forces", Named(FORCES, NAME), "what acts between them"),
        Key("loads", Named(LOAD, NAME), "constant forces and torques"),
        Key("couplings", Named(COUPLINGS, NAME), "gears and other equations between coordinates"),
        Key("drives", Named(DRIVE, COORDINATE), "prescribed coordinates, by the name of the joint"),
        Key("motions", Named(MOTION, NAME), "frames of the ground that move as prescribed"),
        Key("stations", Named(STATION, NAME), "points of flexible bodies whose places are outputs"),
        Key("sensors", Named(SENSORS, NAME), "what is measured at frames of bodies"),
        Key("expose", Either(Word(("auto", "all")), EXPOSE), "which variables the FMU has", default="auto"),
        Key("experiment", EXPERIMENT, "defaults of a run"),
        Key("integrator", _integrator(), "defaults of the FMU's integrator"),
    ),
    name="mechanism",
)

SHARED = (ORIENTATION, FRAME)

ELEMENTS = ("bodies", "joints", "forces", "loads", "couplings", "motions", "stations", "sensors")
"""Keys whose entries have names of their own."""
