"""Draws a mechanism as it is at the start: the figure of its documentation and the icon of its FMU."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.image import imsave
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from .labels import leader_end, place
from .layout import NO_SHAPES, Shapes
from .raster import Camera, paint
from .scene_of import Scene, scene_of
from .solids import Faces, arrow
from .symbols import DARK

DPI = 130
HALO = [withStroke(linewidth=2.5, foreground="white")]
WIDTH = 960
HEIGHTS = (420, 820)
MARGIN = np.array([150, 80])
"""Space for labels around the mechanism, in pixels."""
DETAILED, CROWD = 16, 40
"""Up to so many labels have details and large letters."""
UNNAMED = 120
"""More labels than these would hide the picture: it has none."""
APART = 28
"""Between the points where labels belong, in pixels."""
EDGE = 12
"""Around all that is drawn."""
ICON = 256
ICON_BOLD = 1.5
NO_DATE = {"Software": None}
"""Metadata of a PNG, so that the same picture is the same file."""


@dataclass
class Text:
    """A text in a figure, the point it belongs to and its box, in pixels, y up."""

    text: str
    color: str
    anchor: np.ndarray
    centre: np.ndarray = field(default_factory=lambda: np.zeros(2))
    size: np.ndarray = field(default_factory=lambda: np.zeros(2))

    @property
    def name(self) -> str:
        """Its first line."""
        return self.text.split("\n")[0]


@dataclass
class Picture:
    """A drawn figure, its camera, its pixels without text, and its texts."""

    figure: Figure
    camera: Camera
    pixels: np.ndarray
    texts: list[Text]

    def save(self, path: Path) -> None:
        """Write a PNG."""
        self.figure.savefig(path, metadata=NO_DATE)


def camera_for(scene: Scene, width: int, height: int | None, margin: np.ndarray) -> Camera:
    """The camera that fits all solids between margins; without a height, one that suits the mechanism."""
    view = scene.best_view()
    low, high = _extremes(scene, view)
    extent = np.maximum(high - low, 1e-9 * scene.layout.size)
    if height is None:
        wanted = (width - 2 * margin[0]) * extent[1] / extent[0] + 2 * margin[1]
        height = int(np.clip(wanted, *HEIGHTS))
    page = np.array([width, height])
    scale = float(((page - 2 * margin) / extent).min())
    return Camera(view, scale, page / 2 - scale * (low + high) / 2, width, height)


def _extremes(scene: Scene, view: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest coordinates of the solids to the right and up [m]."""
    corners = np.concatenate([solid.faces.reshape(-1, 3) for solid in scene.solids]) @ view[:2].T
    return corners.min(axis=0), corners.max(axis=0)


def still(scene: Scene) -> Scene:
    """A scene that does not move: without the marks by which a spin is seen."""
    return replace(scene, solids=[solid for solid in scene.solids if solid.layer != "mark"])


def painted(scene: Scene) -> list[tuple[Faces, str, bool]]:
    """The solids of a scene as `paint` takes them."""
    return [(solid.faces, solid.color, False) for solid in scene.solids]


def draw_icon(mechanism: dict[str, Any], resources: Path, path: Path, shapes: Shapes = NO_SHAPES) -> None:
    """The square icon without text, transparent around the mechanism."""
    scene = still(scene_of(mechanism, resources, ICON_BOLD, shapes))
    pixels, _ = paint(painted(scene), camera_for(scene, ICON, ICON, np.array([6, 6])))
    imsave(path, pixels, metadata=NO_DATE)


def draw_figure(mechanism: dict[str, Any], resources: Path, shapes: Shapes = NO_SHAPES) -> Picture:
    """The figure with names, W's axes and gravity."""
    scene = still(scene_of(mechanism, resources, shapes=shapes))
    if len(scene.labels) > UNNAMED:
        scene.labels.clear()
    many = len(scene.labels)
    camera = camera_for(scene, WIDTH if many <= CROWD else 3 * WIDTH // 2, None, MARGIN)
    extra, notes = _directions(scene, camera)
    pixels, seen = paint(painted(scene) + extra, camera)

    groups = [solid.group for solid in scene.solids]
    group_of = np.append(groups, np.full(len(extra) + 1, -1))  # the last is for pixels without a solid
    groups = group_of[seen][::-1]
    for label, anchor in zip(scene.labels, _anchors(scene, camera, groups), strict=True):
        text = f"{label.name}\n{label.detail}" if label.detail and many <= DETAILED else label.name
        notes.append(Text(text, label.color, anchor))
    points = 9.5 if many <= DETAILED else 8.0 if many <= CROWD else 6.5
    sizes = _extents([note.text for note in notes], points)
    anchors = np.array([note.anchor for note in notes])
    centres = place(anchors, sizes, (seen >= 0)[::-1], len(notes) - many)

    rows, columns = np.nonzero((seen >= 0)[::-1])
    used = np.concatenate([np.column_stack([columns, rows]), centres - sizes / 2, centres + sizes / 2])
    page = (camera.width, camera.height)
    low = np.clip(used.min(axis=0) - EDGE, 0, page).astype(int)
    high = np.clip(used.max(axis=0) + EDGE, 0, page).astype(int)
    cut = pixels[camera.height - high[1] : camera.height - low[1], low[0] : high[0]]
    figure = Figure(figsize=tuple((high - low) / DPI), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.figimage(np.round(255 * cut).astype(np.uint8), origin="upper")
    for note, centre, size in zip(notes, centres - low, sizes, strict=True):
        note.anchor, note.centre, note.size = note.anchor - low, centre, size
        end = leader_end(note.anchor, centre, size)
        if np.linalg.norm(end - note.anchor) > 5:
            xs, ys = (np.column_stack([note.anchor, end]).T / (high - low)).T
            style = {"linewidth": 0.07 * points, "marker": "o", "markersize": 2.2, "markevery": [0]}
            figure.add_artist(Line2D(xs, ys, color="#555555", **style))
        style = {"ha": "center", "va": "center", "fontsize": points, "linespacing": 1.1, "path_effects": HALO}
        figure.text(*(centre / (high - low)), note.text, color=note.color, **style)
    return Picture(figure, replace(camera, shift=camera.shift - low, width=len(cut[0]), height=len(cut)), cut, notes)


def _directions(scene: Scene, camera: Camera) -> tuple[list[tuple[Faces, str, bool]], list[Text]]:
    """Arrows of W's axes, at the origin if the picture has it, and of gravity, with their names' anchors."""
    size, pixel = np.array([camera.width, camera.height]), 1 / camera.scale
    origin = camera.project(np.zeros(3))
    within = (origin > 60).all() and (origin < size - 60).all()
    start = np.zeros(3) if within else camera.lift(np.array([70, 60]))
    solids, notes = [], []
    for axis, name, color in zip(np.eye(3), "xyz", ("#c8372d", "#2e8b57", "#2b5fb3"), strict=True):
        tip = start + 62 * pixel * axis
        solids.append((arrow(start, tip, 1.5 * pixel), color, True))
        end = camera.project(tip)
        ahead = end - camera.project(start)
        notes.append(Text(rf"${name}_\mathsf{{W}}$", color, end + 13 * ahead / max(np.linalg.norm(ahead), 1.0)))
    if scene.layout.gravity.any():
        direction = scene.layout.gravity / np.linalg.norm(scene.layout.gravity)
        corner = camera.scale * _extremes(scene, camera.view)[1] + camera.shift
        start = camera.lift(corner + np.array([70, 30]))
        solids.append((arrow(start, start + 60 * pixel * direction, 2 * pixel), DARK, True))
        notes.append(Text("gravity", "#222222", camera.project(start + 30 * pixel * direction) - (38, 0)))
    return solids, notes


def _anchors(scene: Scene, camera: Camera, groups: np.ndarray) -> np.ndarray:
    """A visible pixel of every labelled part, in its middle but apart from others; where the part is, if hidden."""
    anchors = camera.project(np.array([label.point for label in scene.labels]).reshape(-1, 3))
    rows, columns = np.nonzero(groups >= 0)
    owners = groups[rows, columns]
    order = np.argsort(owners, kind="stable")
    starts = np.searchsorted(owners[order], np.arange(len(anchors) + 1))
    pixels = np.column_stack([columns, rows])[order] + 0.5
    done: list[np.ndarray] = []
    for i in np.argsort(np.diff(starts), kind="stable"):  # large parts have other places
        own = pixels[starts[i] : starts[i + 1]]
        if len(own):
            cost = ((own - np.median(own, axis=0)) ** 2).sum(axis=1)
            for other in done:
                cost += 1e6 * (((own - other) ** 2).sum(axis=1) < APART**2)
            anchors[i] = own[np.argmin(cost)]
        done.append(anchors[i])
    return anchors


def _extents(texts: list[str], points: float) -> np.ndarray:
    """Widths and heights of texts in pixels, n × 2."""
    measure = FigureCanvasAgg(Figure(dpi=DPI)).get_renderer().get_text_width_height_descent
    font, extents = FontProperties(size=points), []
    for text in texts:
        lines = text.split("\n")
        width = max(measure(line, font, line.startswith("$"))[0] for line in lines)
        extents.append((width, 1.35 * points * DPI / 72 * len(lines)))
    return np.array(extents)
