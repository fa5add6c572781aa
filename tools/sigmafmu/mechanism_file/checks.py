"""What the keys of one mapping do not allow together."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sigmafmu.mechanism_file.kinds import Context
from sigmafmu.mechanism_file.structures import Check, Record

THIN = 1e-9
"""A rod or a lamina is on the boundary of what is possible: so much is allowed for the rounding of its data."""
NO_MOMENT = 1e-12
"""Of the largest moment: less is the zero of a thin rod about its axis."""
PERPENDICULAR = 1e-6
"""Cosine between axes of a universal joint; what is left of it is moved when the mechanism is assembled."""
OPTIONAL = ("orientation",)
"""Keys of geometry in W that have a default."""


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
    if not (moments[0] >= -NO_MOMENT * moments[2] and moments[1] > NO_MOMENT * moments[2]):
        context.refuse(
            line, where, f"has the principal moments {shown}; all must be positive, or one zero (a thin rod)"
        )
    elif moments[2] > (moments[0] + moments[1]) * (1 + THIN):
        context.refuse(
            line,
            where,
            f"has the principal moments {shown}; none may exceed the sum of the other two (triangle inequality)",
        )


def check_ends(ends: Sequence[Any]) -> Check:
    """The check of an element by its ends (table.ends.End): bodies that differ, each end in W or by frames."""
    groups = {end.in_w: [e.frame for e in ends if e.in_w == end.in_w and e.frame] for end in ends}

    def check(element: Record, context: Context) -> None:
        bodies = element.get("bodies", [])
        if len(bodies) == 2 and bodies[0] == bodies[1]:
            context.refuse(
                element.line_of("bodies"), f"{element.where}.bodies", f"are {bodies[0]} twice; they must differ"
            )
        for in_w, frames in groups.items():
            given = [name for name in in_w if name in element]
            if any(frame in element for frame in frames):
                for name in given:
                    text = f"is in W; give it or {' and '.join(frames)}, not both"
                    context.refuse(element.line_of(name), f"{element.where}.{name}", text)
                continue
            for name in in_w:
                if name not in given and name not in OPTIONAL:
                    ways = [" and ".join(way) for way in (in_w, frames) if way]
                    text = f"{name} is missing; give {', or '.join(ways)}"
                    context.refuse(element.line, element.where, text)
        if "axis1" in element and "axis2" in element:
            _check_cross(element, context)
        _check_motions(element, ends, context)

    return check


def _check_motions(element: Record, ends: Sequence[Any], context: Context) -> None:
    """Only the ground has moving frames."""
    bodies = element["bodies"] if "bodies" in element else [element.get("body")]
    for end in ends:
        frame = element.get(end.frame, {})
        if "motion" in frame and (bodies[end.body] != "ground" or "node" in frame):
            text = "is a moving frame of the ground; neither bodies nor nodes have one"
            context.refuse(frame.line_of("motion"), f"{frame.where}.motion", text)


def check_motion(motion: Record, context: Context) -> None:
    """A moving frame is an input or has tables."""
    for key in ("x", "y", "z", "rx", "ry", "rz"):
        if motion.get("input") and key in motion:
            context.refuse(
                motion.line_of(key), f"{motion.where}.{key}", "is a table, and the motion an input; it must be one"
            )


def check_coupling(coupling: Record, context: Context) -> None:
    """Coordinates differ, and polynomials are as many."""
    joints = coupling["joints"]
    for name in {name for name in joints if joints.count(name) > 1}:
        text = f"has {name} twice; coordinates must differ"
        context.refuse(coupling.line_of("joints"), f"{coupling.where}.joints", text)
    polynomials = coupling.get("polynomials", joints)
    if len(polynomials) != len(joints):
        text = f"has {len(polynomials)} entries; it must have one for each of the {len(joints)} joints"
        context.refuse(coupling.line_of("polynomials"), f"{coupling.where}.polynomials", text)


def check_tendon(tendon: Record, context: Context) -> None:
    """Coordinates differ, and coefficients are as many and not zero."""
    joints, coefficients = tendon["joints"], tendon["coefficients"]
    for name in {name for name in joints if joints.count(name) > 1}:
        text = f"has {name} twice; coordinates must differ"
        context.refuse(tendon.line_of("joints"), f"{tendon.where}.joints", text)
    line, where = tendon.line_of("coefficients"), f"{tendon.where}.coefficients"
    if len(coefficients) != len(joints):
        text = f"has {len(coefficients)} entries; it must have one for each of the {len(joints)} joints"
        context.refuse(line, where, text)
    elif 0.0 in coefficients:
        context.refuse(line, where, "has a 0; coefficients must not be 0")


def check_mimics(couplings: Mapping[str, Record], context: Context) -> None:
    """No coordinate follows itself, over whatever others."""
    mimics = [coupling for coupling in couplings.values() if coupling["type"] == "mimic"]
    leader_of = dict(coupling["joints"] for coupling in mimics)
    for coupling in mimics:
        first = coupling["joints"][0]
        way, at = [first], leader_of[first]
        while at in leader_of and at not in way:
            way.append(at)
            at = leader_of[at]
        if at == first:
            text = f"{' follows '.join([*way, first])}; a joint must not follow itself"
            context.refuse(coupling.line, coupling.where, text)


def _check_cross(joint: Record, context: Context) -> None:
    cosine = abs(float(np.dot(joint["axis1"], joint["axis2"])))
    if cosine > PERPENDICULAR:
        text = f"is at {np.degrees(np.arccos(min(cosine, 1))):.6g} degrees to axis1; it must be perpendicular"
        context.refuse(joint.line_of("axis2"), f"{joint.where}.axis2", text)


def check_shape(shape: Record, context: Context) -> None:
    """Only a mesh has a scale."""
    if "scale" in shape and "mesh" not in shape:
        context.refuse(shape.line_of("scale"), f"{shape.where}.scale", "is the scale of no mesh; leave it out")
