"""Writes a robot as a mechanism file that people can read and edit."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from sigmafmu.importers.inertia import Pose
from sigmafmu.importers.robot import Body, Force, Joint, Robot
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.problems import one_line

DIGITS = 15
"""Of numbers: more would be rounding."""
ROUNDING = 4e-15
"""Of elements of a rotation."""
WIDTH = 110
"""Of comment lines."""
UNITS = {
    "damping": ("N m s/rad", "N s/m"),
    "stiffness": ("N m/rad", "N/m"),
    "friction": ("N m", "N"),
    "armature": ("kg m²", "kg"),
}
"""Of what acts on an angle, on a displacement."""


def mechanism_text(robot: Robot) -> str:
    """The whole file."""
    return "\n".join(_lines(robot)) + "\n"


def _lines(robot: Robot) -> Iterator[str]:
    yield f"# Made by sigmafmu convert of {one_line(robot.source)}."
    if robot.told:
        yield "# What is different, or not here:"
        for text in robot.told:
            yield from _wrapped(text, "# -")
    yield "sigmafmu: 1"
    yield f"name: {robot.name}"
    yield f"gravity: {_vector(robot.gravity)}"
    yield ""
    yield "bodies:"
    for body in robot.bodies.values():
        yield from _body(body)
    for heading, elements in (("joints", robot.joints.values()), ("forces", robot.forces)):
        if elements:
            yield ""
            if heading == "joints":
                yield "# Frames are in the bodies; z is the axis. A body is where the first joint that has it holds it."
            yield f"{heading}:"
            for element in elements:
                yield from _between(element)
    if robot.couplings:
        yield ""
        yield "couplings:"
        for coupling in robot.couplings:
            joints = ", ".join(coupling.joints)
            yield f"  {coupling.name}: {{ type: {coupling.type}, joints: [{joints}]{_more(coupling.keys)} }}"
    if robot.tendons:
        yield ""
        yield "tendons:"
        for tendon in robot.tendons:
            yield f"  {tendon.name}: {{ joints: [{', '.join(tendon.joints)}]{_more(tendon.keys)} }}"
    yield ""
    yield f"integrator: {{ stepSize: {number(robot.step_size)} }}"


def _more(keys: Mapping[str, Any]) -> str:
    return "".join(f", {key}: {_value(value)}" for key, value in keys.items())


def _wrapped(text: str, begin: str) -> Iterator[str]:
    """Lines of a comment."""
    line = begin
    for word in one_line(text).split():
        if len(line) + 1 + len(word) > WIDTH:
            yield line
            line = "#" + " " * (len(begin) - 1)
        line += f" {word}"
    yield line


def _body(body: Body) -> Iterator[str]:
    yield f"  {body.name}:{f' # {body.comment}' if body.comment else ''}"
    if body.merged:
        yield from (f"    {line}" for line in _wrapped(f"with {', '.join(body.merged)}", "#"))
    inertia = body.inertia
    yield f"    mass: {number(inertia.mass)}"
    J, axes = inertia.J, None
    if body.inertia_axes is not None:
        J, axes = body.inertia_axes.R.T @ J @ body.inertia_axes.R, orientation(body.inertia_axes.R)
    if np.abs(J - np.diag(np.diag(J))).max() <= ROUNDING * np.abs(J).max():
        yield f"    inertia: {_vector(np.diag(J))}"
    else:
        J = np.where(np.abs(J) > ROUNDING * np.abs(J).max(), J, 0.0)
        names = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        yield f"    inertia: {{ {', '.join(f'{key}: {number(J[at])}' for key, at in names.items())} }}"
    if axes:
        yield f"    inertia_axes: {axes}"
    if np.any(inertia.center):
        yield f"    center_of_mass: {_vector(inertia.center)}"
    if body.start is not None:
        yield f"    position: {_vector(body.start.p)}"
        if turned := orientation(body.start.R):
            yield f"    orientation: {turned}"
    if body.shapes:
        yield "    shapes:"
        for shape in body.shapes:
            keys = {key: _value(value) for key, value in shape.keys.items()} | _place(shape.pose)
            yield f"      - {{ {', '.join(f'{key}: {value}' for key, value in keys.items())} }}"


def _place(pose: Pose) -> dict[str, str]:
    keys = {}
    if np.abs(pose.p).max() > 0:
        keys["position"] = _vector(pose.p)
    if turned := orientation(pose.R):
        keys["orientation"] = turned
    return keys


def _between(element: Joint | Force) -> Iterator[str]:
    """A joint or a force between frames of two bodies."""
    yield f"  {element.name}:"
    yield f"    type: {element.type}{f' # {one_line(element.comment)}' if element.comment else ''}"
    yield f"    bodies: [{', '.join(element.bodies)}]"
    frames = [_place(frame) for frame in element.frames]
    if not any(frames):
        frames[0] = {"position": "[0, 0, 0]"}
    for i, keys in enumerate(frames, 1):
        if keys:
            yield f"    frame{i}: {{ {', '.join(f'{key}: {value}' for key, value in keys.items())} }}"
    for key, value in element.keys.items():
        unit = UNITS.get(key)
        slides = element.type == "prismatic"
        yield f"    {key}: {_value(value)}{f' # {unit[slides]}' if unit and isinstance(element, Joint) else ''}"


def number(x: float) -> str:
    """A number without the noise of its last digit."""
    x = float(f"{float(x):.{DIGITS}g}")
    if x == int(x) and abs(x) < 1e6:
        return str(int(x))
    mantissa, e, exponent = repr(x).partition("e")
    return f"{mantissa}{'' if '.' in mantissa or not e else '.0'}{e}{exponent}"  # YAML 1.1 wants a point


def _vector(values: Iterable[float]) -> str:
    values = np.array(list(values), dtype=float)
    small = 1e-15 * np.abs(values).max(initial=0)
    return f"[{', '.join(number(x if abs(x) > small else 0.0) for x in values)}]"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=not value.isprintable())
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key}: {_value(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, np.ndarray):
        return _vector(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(inner) for inner in value)}]"
    return number(value)


def orientation(R: np.ndarray) -> str:
    """The shortest of what says a rotation exactly; empty for none."""
    if np.abs(R - np.eye(3)).max() <= ROUNDING:
        return ""
    q = rotations.quaternion(R)
    candidates = (("rotation_vector", rotations.vector(q)), ("rpy", _rpy(R)))
    for key, angles in candidates:  # those with degrees that are whole numbers are the easiest to read
        degrees = np.degrees(angles)
        whole = np.round(degrees)
        found = {key: np.radians(whole)}
        if np.abs(degrees - whole).max() < 1e-9 and _is(R, found):
            return f"{{ {key}: [{', '.join(f'{chr(34)}{int(x)} deg{chr(34)}' if x else '0' for x in whole)}] }}"
    for key, angles in reversed(candidates):
        shown = [float(number(x)) for x in np.where(np.abs(angles) < 1e-16, 0, angles)]
        if _is(R, {key: np.array(shown)}):
            return f"{{ {key}: {_vector(shown)} }}"
    return f"{{ quaternion: [{', '.join(repr(float(x)) for x in q)}] }}"


def _is(R: np.ndarray, angles: Mapping[str, np.ndarray]) -> bool:
    return bool(np.abs(rotations.matrix(rotations.of_orientation(angles)) - R).max() <= ROUNDING)


def _rpy(R: np.ndarray) -> np.ndarray:
    return np.array(
        [math.atan2(R[2, 1], R[2, 2]), math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0])), math.atan2(R[1, 0], R[0, 0])]
    )
