"""Shaded solids for `draw.py`: meshes in W, seen from far away (parallel projection), far faces painted first."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

Faces = np.ndarray
"""Quadrilaterals in W, faces × 4 × 3, counterclockwise as seen from outside."""

LIGHT = np.array([0.25, 0.35, 0.9])
"""From the scene to the light, in axes of the picture: right, up, towards the viewer."""


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


def turned(profile: Sequence[tuple[float, float]], start: Sequence[float], axis: Sequence[float], n: int = 60) -> Faces:
    """Body of revolution: (distance from `start` along `axis`, radius) of its profile, end to end."""
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)]) @ frame_with_z(axis).T
    return mesh(np.stack([np.asarray(start) + z * unit(axis) + r * circle for z, r in profile]))


def cylinder(start: Sequence[float], end: Sequence[float], radius: float, n: int = 60) -> Faces:
    """Closed cylinder between two points; split along its length, so that sorting by depth works."""
    length = float(np.linalg.norm(np.subtract(end, start)))
    pieces = max(1, round(length / (2 * radius)))
    along = [(length * i / pieces, radius) for i in range(pieces + 1)]
    return turned([(0, 0), *along, (length, 0)], start, np.subtract(end, start), n)


def ball(centre: Sequence[float], radius: float) -> Faces:
    """Sphere."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 25)
    return turned([(radius * np.sin(a), radius * np.cos(a)) for a in latitude], centre, (0, 0, 1))


def box(centre: Sequence[float], size: Sequence[float], pieces: int = 8) -> Faces:
    """Box along the axes of W, its sides divided."""
    faces = []
    grid = np.linspace(-0.5, 0.5, pieces + 1)
    for normal in range(3):
        a, b = (normal + 1) % 3, (normal + 2) % 3
        for side in (-0.5, 0.5):
            points = np.zeros((pieces + 1, pieces + 1, 3))
            points[..., normal] = side
            points[..., a], points[..., b] = np.meshgrid(grid, grid, indexing="ij")
            quads = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(
                -1, 4, 3
            )
            faces.append(quads if side > 0 else quads[:, ::-1])
    return np.asarray(centre) + np.concatenate(faces) * np.asarray(size)


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
    s = np.linspace(0, 1, 40 * turns)
    inside = (s > 0.12) & (s < 0.88)
    grow = np.clip(np.minimum(s - 0.12, 0.88 - s) / 0.03, 0, 1) * inside * radius
    angle = 2 * np.pi * turns * (s - 0.12) / 0.76
    local = np.column_stack([grow * np.cos(angle), grow * np.sin(angle), s * length])
    return tube(start + local @ R.T, wire)


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
    angle = np.radians(np.linspace(start, end, 60))
    path = np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) @ R.T
    ahead = unit(path[-1] - path[-2])
    return np.concatenate([tube(path, wire), turned([(0, 0), (0, 2.4 * wire), (5 * wire, 0)], path[-1], ahead, 30)])


class Scene:
    """Solids seen from `azimuth` and `elevation` in degrees, as in Matplotlib's 3D axes."""

    def __init__(self, azimuth: float, elevation: float):
        a, e = np.radians([azimuth, elevation])
        towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0])
        self.view = np.stack([right, np.cross(towards, right), towards])  # rows: right, up, towards the viewer
        self.layers: tuple[list[tuple[Faces, str]], ...] = ([], [])  # the scene, and what is painted over it

    def add(self, faces: Faces, color: str, *, over: bool = False) -> None:
        """Put a solid into the scene, or over everything else."""
        self.layers[over].append((faces, color))

    def frame(self, origin: Sequence[float], length: float, rotation: np.ndarray | None = None) -> np.ndarray:
        """Three arrows along x (red), y (green), z (blue); returns their tips, 3 × 3."""
        R = np.eye(3) if rotation is None else rotation
        tips = np.asarray(origin) + length * R.T
        for tip, color in zip(tips, ("#c8372d", "#2e8b57", "#2b5fb3"), strict=True):
            self.add(arrow(origin, tip, length * 0.022), color, over=True)
        return tips

    def project(self, point: Sequence[float]) -> np.ndarray:
        """Where a point of W is in the picture."""
        return (self.view @ np.asarray(point, dtype=float))[:2]

    def draw(self, axes: Axes) -> None:
        """Paint the solids."""
        for layer in filter(None, self.layers):
            self._paint(axes, layer)
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.axis("off")

    def _paint(self, axes: Axes, layer: list[tuple[Faces, str]]) -> None:
        seen = np.concatenate([faces for faces, _ in layer]) @ self.view.T
        colors = np.concatenate([np.tile(to_rgb(color), (len(faces), 1)) for faces, color in layer])
        normals = np.cross(seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1])
        sizes = np.linalg.norm(normals, axis=1)
        front = (sizes > 0) & (normals[:, 2] > 0)
        seen, colors, normals = seen[front], colors[front], normals[front] / sizes[front, None]
        diffuse = np.clip(normals @ unit(LIGHT), 0, 1)[:, None]
        shaded = np.clip(colors * (0.45 + 0.6 * diffuse) + 0.18 * diffuse**30, 0, 1)
        order = np.argsort(seen[:, :, 2].mean(axis=1))
        axes.add_collection(
            PolyCollection(seen[order][:, :, :2], facecolors=shaded[order], edgecolors=shaded[order], linewidths=0.4)
        )
