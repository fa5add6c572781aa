"""Where elements attach to bodies: frames, and geometry in W."""

from dataclasses import dataclass

from sigmafmu.mechanism_file.checks import check_orientation
from sigmafmu.mechanism_file.kinds import Number, Reference, Whole
from sigmafmu.mechanism_file.structures import Direction, Key, List, Struct, vector

GROUND = "ground"

BODY, ANY_BODY = Reference("body"), Reference("body or ground")

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


@dataclass(frozen=True)
class End:
    """Where an element attaches to one of its bodies: by keys in W, or by a frame of the body.

    Ends with the same keys in W share them: all of these are given by them, or all by frames.
    """

    in_w: tuple[str, ...]
    frame: str
    """Its key; empty: there is none."""
    body: int = 0
    """Which of the element's bodies."""
    is_frame: bool = True
    """Whether the element attaches to a frame there; else to its origin, by the key that is the first in W."""
    many: bool = False
    """Whether that key has a list of points."""


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
        Key("points2", List(vector("length"), least=1), "on the second body, in W, at the start"),
        Key("axis", Direction(), "in W, at the start"),
        Key("normal", Direction(), "in W, at the start"),
        Key("orientation", ORIENTATION, "of the axes, in W, at the start", default="those of W"),
        Key("axis1", Direction(), "fixed in the first body; in W, at the start"),
        Key("axis2", Direction(), "fixed in the second body, perpendicular; in W, at the start"),
    )
}
"""Geometry in W of elements, by its keys."""


def keys_of(ends: tuple[End, ...]) -> tuple[Key, ...]:
    """Keys of ends."""
    names = dict.fromkeys(name for end in ends for name in end.in_w)
    which = {0: "the first body", 1: "the second body"} if len(ends) > 1 else {0: "the body"}
    frames = (
        Key(end.frame, FRAME, f"in {which[end.body]}, in place of geometry in W; z is the axis")
        for end in ends
        if end.frame
    )
    return (*(IN_W[name] for name in names), *frames)


PAIR = Key("bodies", List(ANY_BODY, 2), "first and second body, or ground", required=True)
