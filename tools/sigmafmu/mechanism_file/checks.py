"""What the keys of one mapping do not allow together."""

from collections.abc import Sequence

import numpy as np

from sigmafmu.mechanism_file.kinds import Check, Context, Key, Record

THIN = 1e-9
"""A rod or a lamina is on the boundary of what is possible: so much is allowed for the rounding of its data."""
PERPENDICULAR = 1e-6
"""Cosine between axes of a universal joint; what is left of it is moved when the mechanism is assembled."""


def check_body(body: Record, context: Context) -> None:
    """A rigid body has a mass and an inertia that a body can have; a flexible one has neither."""
    if "flexible" in body:
        for key in ("mass", "inertia", "inertia_axes", "center_of_mass"):
            if key in body:
                context.refuse(body.line_of(key), f"{body.where}.{key}", "comes from the modal data; leave it out")
        return
    for key in ("mass", "inertia"):
        if key not in body:
            context.refuse(body.line, body.where, f"{key} is missing; a body must have it, or the key flexible")
    if "inertia" in body:
        _check_inertia(body, context)


def check_orientation(orientation: Record, context: Context) -> None:
    """A quaternion has a length."""
    if "quaternion" in orientation and not np.linalg.norm(orientation["quaternion"]) > 1e-6:
        line, where = orientation.line_of("quaternion"), f"{orientation.where}.quaternion"
        context.refuse(line, where, "its length must be at least 1e-6; it is normalized")


def inertia_matrix(inertia: Record | list[float]) -> np.ndarray:
    """J [kg m²] of what a file says."""
    if isinstance(inertia, list):
        return np.diag(inertia)
    J = np.diag([inertia[name] for name in ("xx", "yy", "zz")])
    for i, j, name in ((0, 1, "xy"), (0, 2, "xz"), (1, 2, "yz")):
        J[i, j] = J[j, i] = inertia.get(name, 0.0)
    return J


def _check_inertia(body: Record, context: Context) -> None:
    moments = np.linalg.eigvalsh(inertia_matrix(body["inertia"]))
    line, where = body.line_of("inertia"), f"{body.where}.inertia"
    shown = ", ".join(f"{moment:.6g}" for moment in moments) + " kg m²"
    if not moments[0] > 0:
        context.refuse(line, where, f"has the principal moments {shown}; all must be positive")
    elif moments[2] > (moments[0] + moments[1]) * (1 + THIN):
        context.refuse(
            line,
            where,
            f"has the principal moments {shown}; none may exceed the sum of the other two (triangle inequality)",
        )


def check_pair(record: Record, context: Context) -> None:
    """Two bodies that differ."""
    first, second = record["bodies"]
    if first == second:
        context.refuse(record.line_of("bodies"), f"{record.where}.bodies", f"are {first} twice; they must differ")


def check_frames(geometry: Sequence[Key]) -> Check:
    """The check of a joint: all of its geometry in W, or frames."""
    names = [key.name for key in geometry]

    def check(joint: Record, context: Context) -> None:
        check_pair(joint, context)
        given = [name for name in names if name in joint]
        if "frame1" in joint or "frame2" in joint:
            for name in given:
                context.refuse(joint.line_of(name), f"{joint.where}.{name}", "is in W; give it or frames, not both")
            return
        for name in names:
            if name not in given:
                context.refuse(
                    joint.line, joint.where, f"{name} is missing; give {' and '.join(names)}, or frame1 and frame2"
                )
        if len(given) == len(names) and "axis1" in given:
            cosine = abs(float(np.dot(joint["axis1"], joint["axis2"])))
            if cosine > PERPENDICULAR:
                context.refuse(
                    joint.line_of("axis2"),
                    f"{joint.where}.axis2",
                    f"is at {np.degrees(np.arccos(cosine)):.6g} degrees to axis1; it must be perpendicular",
                )

    return check


def check_ends(ends: Sequence[str]) -> Check:
    """The check of a force: each end is a point in W or a frame of its body."""

    def check(force: Record, context: Context) -> None:
        check_pair(force, context)
        for i, end in enumerate(ends, 1):
            if end in force and f"frame{i}" in force:
                context.refuse(force.line_of(end), f"{force.where}.{end}", f"is in W; give it or frame{i}, not both")

    return check


def check_shape(shape: Record, context: Context) -> None:
    """Only a mesh has a scale."""
    if "scale" in shape and "mesh" not in shape:
        context.refuse(shape.line_of("scale"), f"{shape.where}.scale", "is the scale of no mesh; leave it out")
