"""The scene of a mechanism: solids of its bodies, joints and forces, and what names them."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

from . import symbols
from .layout import NO_SHAPES, Body, Layout, Link, Shapes
from .parts import BETWEEN, GROUND, Part, Place, Solid
from .raster import LIGHT, view_from
from .shapes import faces_of
from .solids import Faces, arrow, ball, box, cylinder, lofted, turning_arrow, unit
from .symbols import DARK, ORANGE

BODIES = ("#5b8fc4", "#62ab73", "#8a5fb0", "#c9b23f", "#4fa3a5", "#b8738a")
RED = "#c8372d"
SECTIONS = 24
"""Bands of a flexible body at most."""
STATIONS = 8
"""So many stations are named at most."""
SEEN_TURN = 1e-3
"""A body that turns less in the whole experiment [rad] does not spin: a picture of 1000 pixels shows no such turn.

What rounding leaves of a rate that the joints make zero is far below it.
"""


@dataclass
class Label:
    """A name for the solids of `group`, which are at `point` of W; below it a detail."""

    name: str
    detail: str
    point: np.ndarray
    group: int
    place: Place
    layer: str
    color: str = "#222222"


@dataclass
class Scene:
    """Solids and labels: what the picture shows at the start and the viewer in motion."""

    layout: Layout
    solids: list[Solid] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    faces_to: list[np.ndarray] = field(default_factory=list)
    """Axes of disks and hinges, which are best seen at an angle."""

    def add(
        self,
        parts: Iterable[Part],
        layer: str,
        on: Link | Place,
        name: str = "",
        detail: str = "",
        point=(0, 0, 0),
        **style: str,
    ) -> None:
        """Put in the parts of a link, or of what one place carries; with a label if they have a name."""
        group = len(self.labels) if name else -1
        ends = on.places if isinstance(on, Link) else [on, on]
        for part in parts:
            solid = Solid(part.faces, part.color, layer, group, Place(), modes=part.modes)
            if part.end == BETWEEN:
                between = part.between or (on.points[0], on.points[1])
                solid = replace(solid, place=ends[0], other=ends[1], between=between)
            elif part.end != GROUND:
                solid = replace(solid, place=ends[part.end])
            elif isinstance(on, Link):  # the ground at this end: at rest, or one of its moving frames
                on_ground = (place for place, body in zip(on.places, on.bodies, strict=True) if body is None)
                solid = replace(solid, place=next(on_ground, Place()))
            self.solids.append(solid)
        if name:
            self.labels.append(Label(name, detail, np.asarray(point, dtype=float), group, ends[1], layer, **style))

    def best_view(self) -> np.ndarray:
        """The direction from which points lie farthest apart and disks are neither lines nor circles."""
        points = self.layout.points
        points = points[:: max(1, len(points) // 60)]
        pairs = np.array([p - q for p, q in product(points, points)])
        lengths = np.linalg.norm(pairs, axis=1)
        pairs, lengths = pairs[lengths > 0.02 * self.layout.size], lengths[lengths > 0.02 * self.layout.size]

        def merit(angles: tuple[float, float]) -> float:
            azimuth, elevation = angles
            view = view_from(azimuth, elevation)
            value = -0.1 * abs(azimuth + 55) / 90 - 0.1 * abs(elevation - 22) / 20
            if len(pairs):
                ratios = np.linalg.norm(pairs @ view[:2].T, axis=1) / lengths
                value += (ratios @ lengths) / lengths.sum() + 0.4 * ratios.min()
            for axis in self.faces_to:
                seen = abs(float(axis @ view[2]))
                lit = float(view @ axis @ unit(LIGHT)) * (1 if axis @ view[2] > 0 else -1)
                value += (min(lit, 0.5) - 2 * max(0.3 - seen, 0) - 2 * max(seen - 0.75, 0)) / len(self.faces_to)
            return round(value, 6)

        return view_from(*max(product(range(-75, 105, 10), (14, 22, 32)), key=merit))


def scene_of(mechanism: dict[str, Any], resources: Path, bold: float = 1.0, shapes: Shapes = NO_SHAPES) -> Scene:
    """What a `mechanism.json` shows, with bars `bold` times as thick; modal data are in the folder `resources`.

    Bodies look as `shapes` say, else as their inertia and their joints do.
    """
    layout = Layout(mechanism, resources, bold, shapes)
    scene, t = Scene(layout), layout.thickness
    strength = float(np.linalg.norm(layout.gravity))
    down = layout.gravity / strength if strength else np.array([0.0, 0.0, -1.0])
    for i, body in enumerate(layout.bodies.values()):
        color, place = color_of(i), Place(body.name)
        detail = f"{body.mass:.4g} kg" if body.nodes is None else "flexible"
        scene.add(_body(body, scene, color), "body", place, body.name, detail, body.centre)
        scene.add(_mark(body, t, layout.size), "mark", place)
        speed = _spin_of(body)
        if speed * layout.stop_time > SEEN_TURN:
            scene.add(_spin(body, t), "body", place)
            scene.labels[-1].detail += f", {speed:.5g} rad/s"
    for link in layout.joints:
        scene.add(symbols.joint(link, t), "joint", link, link.name, f"{link.type} joint", link.points[1])
        scene.add(symbols.feet(link, t, down), "ground", link)
        scene.faces_to += [link.axes[0][:, 2]] if link.type == "revolute" else []
    for link in layout.forces:
        scene.add(symbols.force(link, t, down), "force", link, link.name, "", link.points[1], color="#a8641a")
    for follower in layout.followers:
        parts = _arrows(follower.force, follower.torque, follower.point, follower.point, t)
        parts = [Part(ball(follower.point, 1.2 * t), RED), *parts]
        scene.add(parts, "load", follower.place, follower.name, "", follower.point, color=RED)
    joints = {link.name: link for link in layout.joints}
    for name, joint in layout.on_joints:
        if joint in joints:
            link = joints[joint]
            scene.add(symbols.spiral(link, t), "force", link, name, "", link.points[1], color="#a8641a")
    for load in layout.loads:
        place, centre = Place(load["body"], turns=False), layout.bodies[load["body"]].centre
        scene.add(_load(load, layout), "load", place, load["name"], _strength(load), centre, color=RED)
    for name, point, place in layout.stations:
        shown = name if len(layout.stations) <= STATIONS else ""
        scene.add([Part(ball(point, 2.4 * t), ORANGE)], "station", place, shown, "", point, color="#a8641a")
    for name, kind, point, axes, place in layout.sensors:
        shown, detail = name if len(layout.sensors) <= STATIONS else "", "IMU" if kind == "imu" else ""
        scene.add(symbols.sensor(point, axes, t), "sensor", place, shown, detail, point, color="#3f6f73")
    return scene


def color_of(body: int) -> str:
    """The colour of a body by its number."""
    return BODIES[body % len(BODIES)]


def _body(body: Body, scene: Scene, color: str) -> Iterable[Part]:
    """What the file says to draw; else bars from the centre of mass to every end and the solid that has the body's
    inertia, and bands of a flexible one.
    """
    t, size = scene.layout.thickness, scene.layout.size
    if body.shapes:
        for shape in body.shapes:
            yield Part(faces_of(shape, body.position, body.rotation), shape.get("color", color))
        return
    if body.nodes is not None:
        for i, (faces, modes) in enumerate(_bands(body, t)):
            yield Part(faces, color if i % 2 else _lighter(color), modes=modes)
        return
    for end in body.ends:
        if np.linalg.norm(end - body.centre) > t:
            yield Part(cylinder(body.centre, end, t), color)
    faces, axis = equal_solid(body, t, size)
    scene.faces_to += [] if axis is None else [axis]
    yield Part(faces, color)


def _mark(body: Body, t: float, size: float) -> Iterable[Part]:
    """Lines along the surface of a disk or shaft, without which its spin could not be seen."""
    moments, axes = np.linalg.eigh(body.inertia)
    alone = _alone(moments)
    if body.shapes or body.nodes is not None or body.guided or alone is None or body.mass <= 0:
        return
    faces, _ = equal_solid(body, t, size)
    z, x = axes[:, alone], axes[:, (alone + 1) % 3]
    local = (faces.reshape(-1, 3) - body.centre) @ np.column_stack([x, np.cross(z, x), z])
    half, radius = local[:, 2].max(), np.linalg.norm(local[:, :2], axis=1).max()
    wide, R = 0.12 * radius, np.column_stack([x, np.cross(z, x), z])
    yield Part(box(body.centre + 0.5 * radius * x, (1.02 * radius, wide, 2.04 * half), R), DARK)


def equal_solid(body: Body, t: float, size: float) -> tuple[Faces, np.ndarray | None]:
    """The cylinder, ball or box of the body's inertia, neither tiny nor huge beside the mechanism; a disk's axis."""
    moments, axes = np.linalg.eigh(body.inertia)
    if body.mass <= 0 or moments[-1] <= 0:
        return ball(body.centre, 2 * t), None
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    edges = np.sqrt(np.clip(6 * (moments.sum() - 2 * moments) / body.mass, 0, None))
    longest = edges.max()
    slender = longest > 3 * np.sort(edges)[1]
    least = 9 * t if body.guided else 2.6 * t
    limits = np.full(3, 0.44 * size)
    if slender:  # and between its joints, so that these can be seen
        free = 2 * body.reach - 8 * t
        limits[:] = max(0.07 * longest, 3.2 * t)
        limits[edges == longest] = min(size, free if free > 0.4 * longest else size)
    edges = np.clip(edges, np.minimum(least, limits), limits)
    if body.ends and not slender:  # joints that it would just hide are on its surface
        depths = np.abs((np.array(body.ends) - body.centre) @ axes / (edges / 2)).max(axis=1)
        edges = edges * min(depths[(depths > 0.5) & (depths < 1)], default=1.0)
    alone = _alone(moments)
    if body.guided or (alone is None and moments[-1] > 1.02 * moments[0]):
        return box(body.centre, edges, axes), None
    if alone is None:
        return ball(body.centre, edges[0] * np.sqrt(2.5 / 6)), None
    across = edges[(alone + 1) % 3] / np.sqrt(3)  # radius of the disk with the square's inertia
    half = (edges[alone] / 2) * axes[:, alone]
    return cylinder(body.centre - half, body.centre + half, across, 72), None if slender else axes[:, alone]


def _alone(moments: np.ndarray) -> int | None:
    """Which principal axis is one of symmetry, if one alone is; moments ascend."""
    low, high = (moments[i + 1] - moments[i] < 0.02 * moments[2] for i in (0, 1))
    return None if low == high else 2 if low else 0


def _bands(body: Body, t: float) -> Iterable[tuple[Faces, np.ndarray]]:
    """Boxes through the nodes' outline along their longest direction, and how modes move their corners."""
    _, _, directions = np.linalg.svd(body.nodes - body.centre, full_matrices=False)
    R = np.column_stack([directions[0], directions[1], np.cross(directions[0], directions[1])])
    local = (body.nodes - body.centre) @ R
    along = (local[:, 0] - local[:, 0].min()) / max(float(np.ptp(local[:, 0])), 1e-300)
    bins = np.round(SECTIONS * along).astype(int)
    parts = [local[bins == i] for i in np.unique(bins)]
    middles = np.array([(part.min(axis=0) + part.max(axis=0)) / 2 for part in parts])
    halves = np.array([np.ptp(part, axis=0) / 2 for part in parts])[:, 1:]
    # A beam is drawn slender, so that joints and stations can be seen on it.
    most = 1.1 * t if np.ptp(local[:, 0]) > 10 * halves.max() else np.inf
    halves = np.pad(np.clip(halves, t, max(most, t)), ((0, 0), (1, 0)))
    corners = middles[:, None] + halves[:, None] * np.array([(0, 1, 1), (0, -1, 1), (0, -1, -1), (0, 1, -1)])
    corners = body.centre + corners @ R.T
    sections = zip(np.unique(bins), corners, strict=True)
    moved = np.array([_section_modes(body, bins == i, section) for i, section in sections])
    for pair, moves in zip(pairwise(corners), pairwise(moved), strict=True):
        # lofted() only arranges points, so it arranges displacements in the same way
        modes = [lofted(np.array(moves)[..., f]) for f in range(body.modes.shape[2])]
        yield lofted(np.array(pair)), np.array(modes)


def _section_modes(body: Body, chosen: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Displacements of points of a section, points × 3 × modes: it moves and turns as its nodes do on average."""
    nodes, modes = body.nodes[chosen], body.modes[chosen]
    middle, mean = nodes.mean(axis=0), modes.mean(axis=0)
    arms, moves = nodes - middle, modes - mean
    # least squares: the sum of arm × move is the second moment of the arms times the turn
    second = (arms**2).sum() * np.eye(3) - arms.T @ arms
    turns = np.linalg.pinv(second, rcond=1e-9) @ np.cross(arms[:, :, None], moves, axis=1).sum(axis=0)
    return mean + np.cross(turns[None], (corners - middle)[:, :, None], axis=1)


def _spin_of(body: Body) -> float:
    """How fast a body of revolution spins about its axis [rad/s], 0 if it rather turns otherwise."""
    moments, axes = np.linalg.eigh(body.inertia)
    alone = _alone(moments)
    spin = 0.0 if alone is None else abs(float(axes[:, alone] @ body.spin))
    return spin if spin > 0.95 * np.linalg.norm(body.spin) else 0.0


def _spin(body: Body, t: float) -> Iterable[Part]:
    """Red arrow about the axis of a body that spins, beyond it."""
    axis = unit(body.spin)
    half = np.sqrt(max(1.5 * (np.trace(body.inertia) - 2 * axis @ body.inertia @ axis) / body.mass, 0))
    place = body.centre + (half + 11 * t) * axis
    yield Part(turning_arrow(place, body.spin, 5 * t, 0.7 * t, 120, 400), RED)


def _load(load: dict[str, Any], layout: Layout) -> Iterable[Part]:
    """Arrows of a constant force and torque at the body's centre."""
    t, body = layout.thickness, layout.bodies[load["body"]]
    force, torque = (np.array(load.get(key, (0, 0, 0)), dtype=float) for key in ("force", "torque"))
    beside = body.centre + (1.5 * body.gyration + 2 * t) * unit(torque) if torque.any() else body.centre
    return _arrows(force, torque, body.centre, beside, t)


def _arrows(force: np.ndarray, torque: np.ndarray, point: np.ndarray, beside: np.ndarray, t: float) -> Iterable[Part]:
    """A force at a point and a torque beside it, where they are not zero."""
    if force.any():
        yield Part(arrow(point, point + 26 * t * unit(force), 0.8 * t), RED)
    if torque.any():
        yield Part(turning_arrow(beside, torque, 6 * t, 0.7 * t, 20, 300), RED)


def _strength(load: dict[str, Any]) -> str:
    """Magnitudes of a load."""
    force, torque = (float(np.linalg.norm(load.get(key, 0.0))) for key in ("force", "torque"))
    return ", ".join(f"{value:.4g} {unit}" for value, unit in ((force, "N"), (torque, "N m")) if value)


def _lighter(color: str) -> str:
    """A third of the way to white."""
    return "#" + "".join(f"{(2 * int(color[i : i + 2], 16) + 255) // 3:02x}" for i in (1, 3, 5))
