"""What a scene is made of: solids in W at the start, each with a colour and with what carries it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .solids import Faces

FIRST, SECOND, BETWEEN, GROUND = range(4)
"""What carries a part of a joint or force: one of its two bodies, both together, or the ground."""


class Part(NamedTuple):
    """A solid; of a joint or force, also which of the two bodies carries it."""

    faces: Faces
    color: str
    end: int = SECOND
    between: tuple[np.ndarray, np.ndarray] | None = None
    """Of what reaches from a point on the first body to one on the second: these points, if not those of the link."""
    modes: np.ndarray | None = None
    """How the corners move with each modal coordinate, modes × the shape of `faces`, in W at the start."""


@dataclass(frozen=True)
class Place:
    """What carries a point or a solid: a body, or nodes of a flexible one (their mean); the ground without a body."""

    body: str | None = None
    nodes: tuple[int, ...] = ()
    turns: bool = True
    """Whether it turns with the body; else it keeps its direction in W."""


@dataclass(frozen=True)
class Solid:
    """A part with its place in the mechanism."""

    faces: Faces
    color: str
    layer: str
    """body, mark, joint, ground, force, load, station or sensor."""
    group: int
    """Which label names it; −1 without one."""
    place: Place
    other: Place | None = None
    """What carries the second of the points `between`."""
    between: tuple[np.ndarray, np.ndarray] | None = None
    modes: np.ndarray | None = None
