"""Solids of the key `shapes` of mechanism files."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .solids import Faces, ball, box, cylinder


def faces_of(shape: Mapping[str, Any], position: np.ndarray, rotation: np.ndarray) -> Faces:
    """A shape on a body that is at `position` of W and turned by `rotation`.

    It has `box`, `cylinder`, `sphere` or `triangles` (n × 3 × 3, of a mesh); its own `position` and `orientation` (a
    matrix) in the body's frame.
    """
    R = rotation @ np.array(shape.get("orientation", np.eye(3)), dtype=float)
    centre = position + rotation @ np.array(shape.get("position", (0, 0, 0)), dtype=float)
    if "box" in shape:
        return box(centre, shape["box"], R)
    if "sphere" in shape:
        return ball(centre, shape["sphere"])
    if "cylinder" in shape:
        half = shape["cylinder"]["length"] / 2 * R[:, 2]
        return cylinder(centre - half, centre + half, shape["cylinder"]["radius"], 48)
    triangles = np.array(shape["triangles"], dtype=float).reshape(-1, 3, 3)
    return centre + triangles[:, [0, 1, 2, 2]] @ R.T
