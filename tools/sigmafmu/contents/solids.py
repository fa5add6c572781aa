"""Solids for `symbols.py` and `scene_of.py`: closed meshes of quadrilaterals in W."""

from collections.abc import Sequence

import numpy as np

Faces = np.ndarray
"""Quadrilaterals in W, faces × 4 × 3, counterclockwise as seen from outside."""


def unit(x: Sequence[float]) -> np.ndarray:
    """x at length 1."""
    return np.asarray(x, dtype=float) / np.linalg.norm(x)


def frame_with_z(axis: Sequence[float]) -> np.ndarray:
    """A right-handed rotation matrix whose third column is along `axis`."""
    z = unit(axis)
    x = unit(np.cross(z, np.eye(3)[np.argmin(np.abs(z))]))
    return np.column_stack([x, np.cross(z, x), z])


def mesh(points: np.ndarray) -> Faces:
    """Faces of a grid of points, m × n × 3; the second index runs around, closed."""
    around = np.roll(points, -1, axis=1)
    quads = np.stack([points[:-1], around[:-1], around[1:], points[1:]], axis=2)
    return quads.reshape(-1, 4, 3)


def turned(profile: Sequence[tuple[float, float]], start: Sequence[float], axis: Sequence[float], n: int = 48) -> Faces:
    """Body of revolution: (distance from `start` along `axis`, radius) of its profile, end to end."""
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)]) @ frame_with_z(axis).T
    return mesh(np.stack([np.asarray(start) + z * unit(axis) + r * circle for z, r in profile]))


def cylinder(start: Sequence[float], end: Sequence[float], radius: float, n: int = 32) -> Faces:
    """Closed cylinder between two points."""
    length = float(np.linalg.norm(np.subtract(end, start)))
    return turned([(0, 0), (0, radius), (length, radius), (length, 0)], start, np.subtract(end, start), n)


def ball(centre: Sequence[float], radius: float) -> Faces:
    """Sphere."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 17)
    return turned([(radius * np.sin(a), radius * np.cos(a)) for a in latitude], centre, (0, 0, 1), 28)


def lofted(corners: np.ndarray) -> Faces:
    """Closed body with four edges through `corners`, sections × 4 × 3, counterclockwise as seen from the last one."""
    return np.concatenate([mesh(corners), corners[-1:], corners[:1, ::-1]])


def box(centre: Sequence[float], size: Sequence[float], rotation: np.ndarray | None = None) -> Faces:
    """Box with edges of lengths `size` along the columns of `rotation`, by default the axes of W."""
    x, y, z = np.asarray(size) / 2
    corners = np.array([[(x, y, h), (-x, y, h), (-x, -y, h), (x, -y, h)] for h in (-z, z)])
    return lofted(np.asarray(centre) + corners @ (np.eye(3) if rotation is None else rotation).T)


def tube(path: np.ndarray, radius: float, n: int = 12) -> Faces:
    """Tube around a curve, points × 3."""
    tangents = np.gradient(path, axis=0)
    side = frame_with_z(tangents[0])[:, 0]
    rings = []
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)[:, None]
    for point, tangent in zip(path, tangents, strict=True):
        t = unit(tangent)
        side = unit(side - t * (side @ t))
        rings.append(point + radius * (np.cos(angle) * side + np.sin(angle) * np.cross(t, side)))
    return mesh(np.stack([np.repeat(path[:1], n, axis=0), *rings, np.repeat(path[-1:], n, axis=0)]))


def spring(start: Sequence[float], end: Sequence[float], radius: float, wire: float, turns: int = 6) -> Faces:
    """Coil spring between two points, with straight ends."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    R, length = frame_with_z(end - start), np.linalg.norm(end - start)
    s = np.linspace(0, 1, 20 * turns)
    inside = (s > 0.12) & (s < 0.88)
    grow = np.clip(np.minimum(s - 0.12, 0.88 - s) / 0.03, 0, 1) * inside * radius
    angle = 2 * np.pi * turns * (s - 0.12) / 0.76
    local = np.column_stack([grow * np.cos(angle), grow * np.sin(angle), s * length])
    return tube(start + local @ R.T, wire, 8)


def arrow(start: Sequence[float], end: Sequence[float], radius: float) -> Faces:
    """Arrow with a conical head."""
    length = float(np.linalg.norm(np.subtract(end, start)))
    neck = length - 5 * radius
    profile = [(0, 0), (0, radius), (neck, radius), (neck, 2.4 * radius), (length, 0)]
    return turned(profile, start, np.subtract(end, start), 30)


def turning_arrow(
    centre: Sequence[float], axis: Sequence[float], radius: float, wire: float, start: float, end: float
) -> Faces:
    """Arrow along a circle about `axis`, from angle `start` to `end` in degrees."""
    R = frame_with_z(axis)
    angle = np.radians(np.linspace(start, end, 40))
    path = np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) @ R.T
    ahead = unit(path[-1] - path[-2])
    return np.concatenate([tube(path, wire), turned([(0, 0), (0, 2.4 * wire), (5 * wire, 0)], path[-1], ahead, 30)])
