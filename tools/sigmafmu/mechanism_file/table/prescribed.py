"""Couplings of coordinates, drives, and frames of the ground that move."""

from collections.abc import Callable
from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_coupling, check_motion
from sigmafmu.mechanism_file.kinds import Flag, Kind, Number, Reference, Word, WordOr
from sigmafmu.mechanism_file.structures import ByType, Key, Later, List, Points, Record, Struct, vector
from sigmafmu.mechanism_file.table.ends import ORIENTATION

COORDINATE = Reference("coordinate")

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
        Key(
            "table",
            _later("table", "list of [time, number of the motion], or a CSV file"),
            "a natural cubic spline through points",
        ),
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
        lambda c: [[0.0, c["ratio"]], [0.0, -1.0]],
    ),
    "rack_and_pinion": CouplingType(
        "the rack moves by the radius for each rad",
        ("pinion", "rack"),
        (Key("radius", Number("length"), "of the pinion", required=True),),
        lambda c: [[0.0, c["radius"]], [0.0, -1.0]],
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
        lambda c: [[0.0, -1.0], c["polynomial"]],
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


PARAMETERS = ("gear", "rack_and_pinion", "mimic")
"""Types whose numbers are parameters of the FMU."""

COUPLINGS = ByType({name: _coupling(name, coupling) for name, coupling in COUPLING_TYPES.items()})
