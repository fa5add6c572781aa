"""Bodies, frames and markers of the mechanisms that are compared."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from research.mechanisms.parts import GROUND, add_body
from research.reference.exudyn_models import Model
from sigmafmu import _core

GRAVITY = np.array([0.0, 0.0, -9.81])
AXES = Rotation.from_rotvec([0.4, -0.3, 0.7]).as_matrix()
"""Of frames: along no axis of W or of a body."""


def mechanism(gravity: np.ndarray = GRAVITY) -> _core.Mechanism:
    """Without bodies."""
    result = _core.Mechanism("Compared")
    result.multibody.gravity = gravity
    return result


def add_first(m: _core.Mechanism, moving: float = 1.0) -> int:
    """A body that is inclined, moves and turns: that part of its velocity."""
    return add_body(
        m.multibody,
        "a",
        2.0,
        np.array([0.03, 0.04, 0.05]),
        np.array([0.1, -0.2, 0.3]),
        Rotation.from_rotvec([0.3, 0.2, -0.4]),
        np.array([0.3, -0.2, 0.5]) * moving,
        np.array([1.0, -2.0, 1.5]) * moving,
    )


def add_second(m: _core.Mechanism) -> int:
    """Another one beside it."""
    return add_body(
        m.multibody,
        "b",
        1.5,
        np.array([0.02, 0.03, 0.025]),
        np.array([0.7, 0.1, 0.2]),
        Rotation.from_rotvec([-0.2, 0.5, 0.1]),
        np.array([-0.1, 0.4, 0.2]),
        np.array([-1.0, 0.5, 2.0]),
    )


def pair() -> _core.Mechanism:
    """Both, without anything between them."""
    m = mechanism()
    add_first(m), add_second(m)
    return m


def frame_in(multibody: _core.Multibody, body: int, point: np.ndarray, axes: np.ndarray) -> _core.Frame:
    """The frame of a body that is at a point of W with these axes, at the start."""
    if body == GROUND:
        return _core.Frame(point, axes)
    place = multibody.body(body)
    R = Rotation.from_quat(place.initial_quaternion, scalar_first=True).as_matrix()
    return _core.Frame(R.T @ (point - place.initial_position), R.T @ axes)


def exudyn_body(model: Model, body: int) -> Any:
    """Exudyn's number of a body of ours; a new ground for the ground."""
    return model.add_ground() if body == GROUND else [*model.bodies.values()][body]


def frame_markers(model: Model, element: Any) -> list[Any]:
    """Exudyn's markers at both frames of an element or joint."""
    ends = ((element.body1, element.frame1), (element.body2, element.frame2))
    return [model.marker(exudyn_body(model, body), frame.origin, frame.axes) for body, frame in ends]


def point_markers(model: Model, element: Any) -> list[Any]:
    """Exudyn's markers at both points of an element."""
    ends = ((element.body1, element.point1), (element.body2, element.point2))
    return [model.marker(exudyn_body(model, body), point) for body, point in ends]
