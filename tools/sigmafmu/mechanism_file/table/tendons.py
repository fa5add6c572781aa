"""Tendons: springs on sums of coordinates."""

from sigmafmu.mechanism_file.checks import check_tendon
from sigmafmu.mechanism_file.kinds import Number
from sigmafmu.mechanism_file.structures import Key, List, Struct
from sigmafmu.mechanism_file.table.prescribed import COORDINATE
from sigmafmu.mechanism_file.table.quantities import least

TENDON = Struct(
    (
        Key("joints", List(COORDINATE, least=1), "joints, or `joint.angle2` and so on", required=True),
        Key(
            "coefficients",
            List(Number("length"), least=1),
            "one for each: length for a rad of an angle, or for a metre of a displacement",
            required=True,
        ),
        Key("stiffness", least("stiffness"), "of the tendon", default="0"),
        Key("damping", least("damping"), "of the tendon", default="0"),
        Key("free_length", Number("length"), "at which the spring has no force", default="0"),
    ),
    check_tendon,
    "tendon",
)
