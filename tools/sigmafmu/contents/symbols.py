"""Solids that stand for joints, springs and the ground; t is the radius of the mechanism's bars in m."""

from collections.abc import Callable, Iterable

import numpy as np

from .layout import Link
from .parts import BETWEEN, FIRST, GROUND, SECOND, Part
from .solids import ball, box, cylinder, frame_with_z, spring, tube, turned, unit

GREY, DARK, ORANGE, TEAL = "#b9bec4", "#5d646c", "#e0973f", "#4fa3a5"
FOOT = 9.0
"""Length of a foot, in t."""
GUIDED = ("prismatic", "cylindrical", "screw", "point_on_line")
"""Joints that have a rail along z of their first frame."""


def foot(point: np.ndarray, direction: np.ndarray, t: float, length: float = FOOT) -> Iterable[Part]:
    """A post from a point to a hatched plate on the ground, `length` in t."""
    R = frame_with_z(direction)
    end = point + length * t * R[:, 2]
    profile = [(0, 0), (0, 0.9 * t), (0.8 * length * t, 2.2 * t), (length * t, 2.2 * t), (length * t, 0)]
    yield Part(turned(profile, point, R[:, 2]), GREY, GROUND)
    yield Part(box(end, (9 * t, 9 * t, 0.8 * t), R), GREY, GROUND)
    for x in (-3.6, -1.2, 1.2, 3.6):
        for y in (-4.2, 4.2):
            start = end + R @ (t * np.array([x, y, 0.4]))
            yield Part(cylinder(start, start + R @ (t * np.array([-1.6, 0, 2.2])), 0.25 * t, 8), DARK, GROUND)


def foot_direction(link: Link, t: float, down: np.ndarray) -> np.ndarray:
    """Where a foot goes: not into the body, rather down than up, across an axis; along it if the middle turns there."""
    i = 0 if link.bodies[0] is None else 1
    other = link.bodies[1 - i]
    away = np.zeros(3) if other is None else link.points[i] - other.centre
    gap = float(np.linalg.norm(away))
    axis = link.axes[i][:, 2] if link.type in ("revolute", *GUIDED) else np.zeros(3)

    def merit(d: np.ndarray) -> float:
        along_axis = abs(d @ axis) * (0.9 if gap > t else -0.9)
        return round(2 * min(d @ away / max(gap, t) + 0.2, 0) + 0.7 * (d @ down) - along_axis, 6)

    return max([down, -down, *np.eye(3), *-np.eye(3)], key=merit)


def spherical(link: Link, t: float) -> Iterable[Part]:
    """Ball."""
    yield Part(ball(link.points[1], 2.2 * t), DARK)


def revolute(link: Link, t: float) -> Iterable[Part]:
    """Hinge along z."""
    z, point = link.axes[0][:, 2], link.points[1]
    yield Part(cylinder(point - 4 * t * z, point + 4 * t * z, 1.3 * t), DARK, FIRST)
    yield Part(cylinder(point - 2.4 * t * z, point + 2.4 * t * z, 2.2 * t), GREY)


def universal(link: Link, t: float) -> Iterable[Part]:
    """Cross along y of the first and x of the second frame."""
    for end, axis in ((FIRST, link.axes[0][:, 1]), (SECOND, link.axes[1][:, 0])):
        yield Part(cylinder(link.points[1] - 4.8 * t * axis, link.points[1] + 4.8 * t * axis, 0.9 * t), DARK, end)
        for side in (-4.8, 4.8):
            yield Part(ball(link.points[1] + side * t * axis, 1.3 * t), DARK, end)


def _guide(link: Link, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends of a rail along z of the first frame that holds both points and goes on beyond the bodies."""
    z = link.axes[0][:, 2]
    travel = float((link.points[1] - link.points[0]) @ z)
    beyond = max(14 * t, *(2.5 * body.gyration for body in link.bodies if body is not None))
    return link.points[0] + (min(travel, 0) - beyond) * z, link.points[0] + (max(travel, 0) + beyond) * z


def prismatic(link: Link, t: float) -> Iterable[Part]:
    """Rail along z with a sleeve."""
    start, end = _guide(link, t)
    R, length = link.axes[0], float(np.linalg.norm(end - start))
    yield Part(box((start + end) / 2, (2 * t, 2 * t, length), R), GREY, FIRST)
    yield Part(box(link.points[1], (3.4 * t, 3.4 * t, 7 * t), link.axes[1]), DARK)


def cylindrical(link: Link, t: float) -> Iterable[Part]:
    """Round rail along z with a sleeve."""
    yield Part(cylinder(*_guide(link, t), 1.1 * t), GREY, FIRST)
    z = link.axes[0][:, 2]
    yield Part(cylinder(link.points[1] - 3.5 * t * z, link.points[1] + 3.5 * t * z, 2.1 * t), DARK)


def planar(link: Link, t: float) -> Iterable[Part]:
    """Plate across z with a puck."""
    R = link.axes[0]
    offset = R.T @ (link.points[1] - link.points[0])
    centre, size = R @ (offset / 2 * (1, 1, 0)), np.abs(offset) + 16 * t
    yield Part(box(link.points[0] + centre - t * R[:, 2], (size[0], size[1], 0.8 * t), R), GREY, FIRST)
    yield Part(cylinder(link.points[1] - 0.6 * t * R[:, 2], link.points[1] + t * R[:, 2], 3 * t), DARK)


def fixed(link: Link, t: float) -> Iterable[Part]:
    """Plate towards the second body."""
    body = link.bodies[1]
    ahead = link.points[1] - body.centre if body is not None else np.zeros(3)
    R = frame_with_z(ahead if np.linalg.norm(ahead) > t else link.axes[0][:, 2])
    yield Part(box(link.points[1], (6 * t, 6 * t, 2 * t), R), DARK)


def distance(link: Link, t: float) -> Iterable[Part]:
    """Rod between two balls."""
    for end, point in enumerate(link.points):
        yield Part(ball(point, 1.8 * t), DARK, end)
    if np.linalg.norm(link.points[1] - link.points[0]) > t:
        yield Part(cylinder(*link.points, 0.7 * t), DARK, BETWEEN)


def point_on_line(link: Link, t: float) -> Iterable[Part]:
    """Ball on a round rail along z."""
    yield Part(cylinder(*_guide(link, t), 1.1 * t), GREY, FIRST)
    yield Part(ball(link.points[1], 2.2 * t), DARK)


def screw(link: Link, t: float) -> Iterable[Part]:
    """Threaded rod along z with a nut."""
    start, end = _guide(link, t)
    z, length = link.axes[0][:, 2], float(np.linalg.norm(end - start))
    yield Part(cylinder(start, end, 0.9 * t), GREY, FIRST)
    yield Part(spring(start, end, 1.1 * t, 0.3 * t, int(np.clip(length / (1.2 * t), 6, 40))), DARK, FIRST)
    yield Part(cylinder(link.points[1] - 2 * t * z, link.points[1] + 2 * t * z, 2.8 * t, 6), DARK)


def constant_velocity(link: Link, t: float) -> Iterable[Part]:
    """Ball in a ring, and both shafts."""
    point, z = link.points[1], link.axes[0][:, 2]
    yield Part(ball(point, 2.4 * t), DARK)
    yield Part(cylinder(point - 0.9 * t * z, point + 0.9 * t * z, 3.4 * t), GREY, FIRST)
    for end, axis in ((FIRST, -z), (SECOND, link.axes[1][:, 2])):
        yield Part(cylinder(point, point + 5 * t * axis, 1.1 * t), DARK, end)


def point_in_plane(link: Link, t: float) -> Iterable[Part]:
    """Ball in a plate across z."""
    R = link.axes[0]
    offset = R.T @ (link.points[1] - link.points[0])
    centre, size = R @ (offset / 2 * (1, 1, 0)), np.abs(offset) + 16 * t
    yield Part(box(link.points[0] + centre, (size[0], size[1], 0.8 * t), R), GREY, FIRST)
    yield Part(ball(link.points[1], 2.2 * t), DARK)


def rolling_disk(link: Link, t: float) -> Iterable[Part]:
    """Rim of a disk about z of the second frame, with an edge, spokes and an axle."""
    centre, R, r = link.points[1], link.axes[1], link.radius
    z, inside = R[:, 2], max(r - 1.8 * t, 0.8 * r)
    profile = [(-0.8 * t, inside), (0.0, r), (0.8 * t, inside), (-0.8 * t, inside)]
    yield Part(turned(profile, centre, z, 60), DARK)
    for angle in np.pi / 3 * np.arange(3):
        spoke = inside * (R @ [np.cos(angle), np.sin(angle), 0.0])
        yield Part(cylinder(centre - spoke, centre + spoke, 0.4 * t, 8), GREY)
    yield Part(cylinder(centre - 2 * t * z, centre + 2 * t * z, 0.9 * t), DARK)


def free(_link: Link, _t: float) -> Iterable[Part]:
    """Nothing: it holds nothing."""
    yield from ()


def other(link: Link, t: float) -> Iterable[Part]:
    """A small ball for what has no symbol."""
    yield Part(ball(link.points[1], 1.8 * t), DARK)


JOINTS: dict[str, Callable[[Link, float], Iterable[Part]]] = {
    f.__name__: f
    for f in (
        *(spherical, revolute, universal, prismatic, fixed, cylindrical, planar, distance, point_on_line, free),
        *(screw, constant_velocity, point_in_plane, rolling_disk),
    )
}


def joint(link: Link, t: float) -> Iterable[Part]:
    """A joint."""
    return JOINTS.get(link.type, other)(link, t)


def feet(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """What holds a joint on the ground."""
    for body, point in zip(link.bodies, link.points, strict=True):
        if body is not None or link.type in ("free", "rolling_disk"):
            continue
        if link.type in GUIDED:
            for end in _guide(link, t):
                yield from foot(end, foot_direction(link, t, down), t, 5.0)
        else:
            yield from foot(point, foot_direction(link, t, down), t)


def spring_damper(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A coil between two points; where they coincide, one along every axis of W in which the spring acts."""
    start, end = link.points
    gap = end - start
    if np.linalg.norm(gap) > 6 * t:
        turns = int(np.clip(np.linalg.norm(gap) / (2.2 * t), 5, 16))
        radius = min(2.4 * t, 0.2 * float(np.linalg.norm(gap)))
        yield Part(spring(start, end, radius, 0.4 * t, turns), ORANGE, BETWEEN)
        for i, (body, point, way) in enumerate(zip(link.bodies, link.points, (-gap, gap), strict=True)):
            yield Part(ball(point, 1.2 * t), DARK, i)
            if body is None:
                yield from foot(point, unit(way), t, 2.0)
        return
    body = link.bodies[1] or link.bodies[0]
    i = SECOND if link.bodies[1] else FIRST
    yield Part(ball(end, 2.4 * t), DARK, i)
    for axis, acting in zip(np.eye(3), link.stiff, strict=True):
        if not acting:
            continue
        outward = float((end - body.centre) @ axis)
        way = axis * (np.sign(outward) if abs(outward) > t else np.sign(down @ axis) or 1.0)
        points = (end + 2.4 * t * way, end + 14 * t * way)
        ends = points if i == FIRST else points[::-1]
        yield Part(spring(*points, 2.2 * t, 0.4 * t), ORANGE, BETWEEN, ends)
        yield from foot(end + 13.6 * t * way, way, t, 1.0)


def spiral(link: Link, t: float) -> Iterable[Part]:
    """A spiral spring about a joint's axis, beside the hinge."""
    turn = np.linspace(0, 5 * np.pi, 90)
    radius = t * np.linspace(2.2, 5, 90)
    path = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(90, 3.2 * t)])
    yield Part(tube(link.points[1] + path @ link.axes[0].T, 0.4 * t, 8), ORANGE)


def torsion_spring(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A spiral spring about z of the first frame."""
    yield from spiral(link, t)


def bushing(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A ring of rubber about z of the first frame, and a pin through it."""
    z, point = link.axes[0][:, 2], link.points[1]
    yield Part(cylinder(point - 2 * t * z, point + 2 * t * z, 3.2 * t), ORANGE, FIRST)
    yield Part(cylinder(point - 3.4 * t * z, point + 3.4 * t * z, 1.2 * t), DARK)


def bearing(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A journal about z of the first frame, and its shell."""
    z, point = link.axes[0][:, 2], link.points[1]
    yield Part(cylinder(point - 5 * t * z, point + 5 * t * z, 1.4 * t), DARK)
    yield Part(cylinder(point - 1.6 * t * z, point + 1.6 * t * z, 3.4 * t), ORANGE, FIRST)


def plane_contact(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A plate of the plane, below the sphere."""
    z = link.axes[0][:, 2]
    foot_point = link.points[1] - z * float((link.points[1] - link.points[0]) @ z)
    yield Part(box(foot_point - 0.5 * t * z, (22 * t, 22 * t, t), link.axes[0]), GREY, FIRST)
    yield Part(ball(link.points[1], 1.6 * t), ORANGE)


def sphere_contact(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """The centres of both spheres."""
    for end, point in enumerate(link.points):
        yield Part(ball(point, 1.6 * t), ORANGE, end)


FORCES: dict[str, Callable[[Link, float, np.ndarray], Iterable[Part]]] = {
    f.__name__: f for f in (torsion_spring, bushing, bearing, plane_contact, sphere_contact)
}
FORCES["cloud_contact"] = plane_contact


def force(link: Link, t: float, down: np.ndarray) -> Iterable[Part]:
    """A force between two bodies; a coil for what acts between points."""
    return FORCES.get(link.type, spring_damper)(link, t, down)


def sensor(point: np.ndarray, axes: np.ndarray, t: float) -> Iterable[Part]:
    """A small cube and its three axes."""
    yield Part(box(point, (2.6 * t, 2.6 * t, 2.6 * t), axes), TEAL)
    for axis in axes.T:
        yield Part(cylinder(point, point + 5 * t * axis, 0.45 * t, 8), TEAL)
