"""Bodies: rigid or flexible, and what is drawn of them."""

from sigmafmu.mechanism_file.checks import check_body, check_shape
from sigmafmu.mechanism_file.kinds import Number, Text
from sigmafmu.mechanism_file.structures import Either, Key, List, Struct, vector
from sigmafmu.mechanism_file.table.ends import ORIENTATION
from sigmafmu.mechanism_file.table.quantities import least, positive

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
