"""Draws models/images/<Model>.png, the figure of the documentation, and <Model>.icon.png, the icon of the FMU.

    .venv/bin/python tools/fmu_contents/draw.py [MODEL ...]

Places and sizes are those of models/<Model>.cpp; what carries no number there (the thickness of a rod) is drawn to look
like what it is. Names in the figures are those of the variables.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from solids import Scene, arrow, ball, box, cylinder, spring, tube, turned, turning_arrow

from sigmafmu.compare import read_reference

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "models" / "images"

BLUE, ORANGE, GREEN, GREY, DARK, RED, PURPLE = (
    "#5b8fc4",
    "#e0973f",
    "#62ab73",
    "#b9bec4",
    "#5d646c",
    "#c8372d",
    "#8a5fb0",
)
ICON_PIXELS = 256


def vec(x: float, y: float, z: float) -> np.ndarray:
    """A vector in W."""
    return np.array([x, y, z], dtype=float)


class Notes:
    """Text beside points of a scene; icons have none."""

    def __init__(self, scene: Scene, axes: Axes | None):
        self.scene, self.axes = scene, axes

    def __call__(
        self, point, text: str, offset: tuple[float, float] = (0, 0), *, leader: bool = False, **style
    ) -> None:
        """Write `text` at `offset` (in pt) from a point in W; Matplotlib's mathtext works."""
        if self.axes is None:
            return
        line = {"arrowstyle": "-", "color": "#777777", "linewidth": 0.7, "shrinkA": 1, "shrinkB": 2} if leader else None
        style = {"ha": "center", "va": "center", "fontsize": 9.5, "color": "#222222"} | style
        place = {"textcoords": "offset points", "annotation_clip": False, "zorder": 10}
        self.axes.annotate(text, self.scene.project(point), offset, arrowprops=line, **place, **style)

    def frame(self, name: str, tips: np.ndarray, origin: np.ndarray, *offsets: tuple[float, float]) -> None:
        """Names of a frame's axes, at offsets (in pt) from places just beyond the tips."""
        for axis, tip, offset in zip("xyz", tips, offsets or ((0, 0),) * 3, strict=True):
            self(origin + 1.13 * (tip - origin), rf"${axis}_\mathsf{{{name}}}$", offset, fontsize=8.5)


def heavy_top(axes: Axes | None) -> Scene:
    """A thin disk (its inertia is that of one with radius 0.25 m) on a rod, held at the origin of W."""
    scene = Scene(azimuth=-24, elevation=20)
    note = Notes(scene, axes)
    pivot, centre = np.zeros(3), vec(0, 1, 0)
    scene.add(
        turned([(-0.62, 0), (-0.62, 0.2), (-0.58, 0.2), (-0.58, 0.035), (-0.05, 0.035), (-0.05, 0)], pivot, (0, 0, 1)),
        GREY,
    )
    scene.add(ball(pivot, 0.065), DARK)
    scene.add(cylinder(pivot, centre, 0.022), BLUE)
    scene.add(
        turned(
            [(-0.025, 0), (-0.025, 0.12), (-0.025, 0.25), (0.025, 0.25), (0.025, 0.12), (0.025, 0)],
            centre,
            (0, 1, 0),
            120,
        ),
        BLUE,
    )
    scene.add(turning_arrow(centre + vec(0, 0.28, 0), (0, 1, 0), 0.1, 0.012, 200, 480), RED)
    if axes is None:
        return scene
    _, history = read_reference(ROOT / "tests" / "references" / "HeavyTop.csv")
    path = np.column_stack([history[f"top.position[{i}]"] for i in (1, 2, 3)])[:75]
    scene.add(tube(path, 0.006), ORANGE)
    scene.frame(pivot, 0.45)
    note.frame("W", pivot + 0.45 * np.eye(3), pivot, (0, 0), (-8, 9), (0, 0))
    scene.frame(centre, 0.4)
    note.frame("B", centre + 0.4 * np.eye(3), centre)
    scene.add(arrow((0, -0.4, 0.6), (0, -0.4, 0.3), 0.012), DARK)
    note((0, -0.4, 0.45), "gravity", (-26, 0))
    note(pivot, "pivot\nspherical joint\nat the origin of W", (-84, 14), leader=True)
    note(centre + vec(0, 0.1, -0.2), "top\n1 m from the pivot", (62, -34), leader=True)
    note(centre + vec(0, 0.37, 0), "spin 150 rad/s", (28, 24), color=RED)
    note(path[40], "path of the centre of mass\nin the first 0.75 s", (-92, 2), color="#b26f1c", leader=True)
    return scene


def high_speed_rotor(axes: Axes | None) -> Scene:
    """A steel disk of radius 0.05 m and width 0.02 m on a shaft between two spring supports."""
    scene = Scene(azimuth=-62, elevation=18)
    note = Notes(scene, axes)
    left, right, reach, block = vec(-0.11, 0, 0), vec(0.09, 0, 0), 0.055, 0.012
    scene.add(cylinder(left, right, 0.0055), BLUE)
    scene.add(
        turned(
            [(-0.01, 0), (-0.01, 0.0255), (-0.01, 0.05), (0.01, 0.05), (0.01, 0.0255), (0.01, 0)],
            (0, 0, 0),
            (1, 0, 0),
            120,
        ),
        BLUE,
    )
    for point, directions in ((left, ((-1, 0, 0), (0, 1, 0), (0, 0, -1))), (right, ((0, 1, 0), (0, 0, -1)))):
        scene.add(turned([(-0.006, 0), (-0.006, 0.0095), (0.006, 0.0095), (0.006, 0)], point, (1, 0, 0)), DARK)
        for direction in np.array(directions, dtype=float):
            scene.add(spring(point + 0.009 * direction, point + reach * direction, 0.0065, 0.0011), ORANGE)
            size = np.where(np.abs(direction) > 0, 0.006, 2 * block)
            scene.add(box(point + (reach + 0.003) * direction, size, 4), GREY)
    scene.add(turning_arrow((0.045, 0, 0), (1, 0, 0), 0.02, 0.0016, 120, 400), RED)
    if axes is None:
        return scene
    origin = np.zeros(3)
    scene.frame(origin, 0.085)
    note.frame("W", origin + 0.085 * np.eye(3), origin, (24, 12), (0, 0), (0, 0))
    scene.add(turning_arrow((0, 0, 0.068), (0, 0, 1), 0.016, 0.0013, 20, 300), PURPLE)
    note((0, 0, 0.068), "load.torque", (58, 4), color=PURPLE)
    note((0.045, 0, 0.02), "spin 20944 rad/s\n(200 000 rpm)", (70, 46), color=RED, leader=True)
    note((-0.008, -0.03, -0.035), "rotor\nB lies in W at the start", (-44, -36), leader=True)
    note(
        left + vec(0, 0, -0.03),
        "leftSupport\nat x = −0.11 m: springs\nand dampers along x, y, z",
        (-86, -34),
        leader=True,
    )
    note(
        right + vec(0, 0, -0.03), "rightSupport\nat x = 0.09 m: springs\nand dampers along y, z", (84, -30), leader=True
    )
    return scene


def slider_crank(axes: Axes | None, flexible: bool = False) -> Scene:
    """Crank, rod and slider at the start, θ = 0."""
    scene = Scene(azimuth=-50, elevation=22)
    note = Notes(scene, axes)
    a, b, c = vec(0, 0.1, 0.12), vec(0, 0.1, 0.2), vec(0.2, 0, 0)
    x_rod, y_rod = (c - b) / 0.3, vec(0, 2, -1) / np.sqrt(5)
    z_rod = np.cross(x_rod, y_rod)
    ex = vec(1, 0, 0)

    scene.add(box((-0.045, 0.1, 0.035), (0.016, 0.03, 0.17), 10), GREY)  # the crank's bearing
    scene.add(cylinder(a - 0.075 * ex, a - 0.028 * ex, 0.016), GREY)
    scene.add(cylinder(a - 0.028 * ex, a + 0.012 * ex, 0.008), DARK)
    scene.add(box((a + b) / 2, (0.012, 0.018, 0.098), 8), ORANGE)
    scene.add(ball(b, 0.0135), DARK)
    rotation = np.column_stack([x_rod, y_rod, z_rod])

    def along(xi: float) -> np.ndarray:
        """Point of the bent rod's centre line."""
        return b + rotation @ vec(0.3 * xi, 0.008 * np.sin(2 * np.pi * xi), 0.018 * np.sin(np.pi * xi))

    if flexible:
        scene.add(tube(np.array([along(xi) for xi in np.linspace(0.04, 0.9, 40)]), 0.0065), BLUE)
        for xi in (0.2, 0.4, 0.6, 0.8):
            scene.add(ball(along(xi), 0.009), ORANGE)
        scene.add(ball(along(0.5), 0.009), RED)
    else:
        scene.add(cylinder(b + 0.012 * x_rod, c - 0.03 * x_rod, 0.0065), BLUE)
    for side in (-1, 1):  # fork at the rod's end, axis of the cross along the rod's y
        scene.add(cylinder(c - 0.03 * x_rod + side * 0.011 * y_rod, c + side * 0.011 * y_rod, 0.0035), BLUE)
    scene.add(cylinder(c - 0.03 * x_rod - 0.0145 * y_rod, c - 0.03 * x_rod + 0.0145 * y_rod, 0.0045), BLUE)
    scene.add(cylinder(c - 0.013 * y_rod, c + 0.013 * y_rod, 0.0032), DARK)
    scene.add(cylinder(c - 0.022 * ex, c + 0.022 * ex, 0.0032), DARK)
    for side in (-1, 1):
        scene.add(box(c + vec(side * 0.022, 0, -0.011), (0.007, 0.02, 0.042), 4), GREEN)
    scene.add(box(c + vec(0, 0, -0.037), (0.06, 0.034, 0.012), 10), GREEN)
    scene.add(box((0.17, 0, -0.048), (0.3, 0.016, 0.01), 30), GREY)  # the guide's rail
    if axes is None:
        return scene

    scene.frame(np.zeros(3), 0.075)
    note.frame("W", 0.075 * np.eye(3), np.zeros(3))
    centres = {
        "crank": ((a + b) / 2, np.eye(3)),
        "rod": (b if flexible else (b + c) / 2, rotation),
        "slider": (c, np.eye(3)),
    }
    for centre, axes_of_body in centres.values():
        scene.frame(centre, 0.045, axes_of_body)
    scene.add(turning_arrow(a - 0.088 * ex, ex, 0.026, 0.0018, 150, 380), RED)
    note(a - 0.088 * ex, r"crankPivot.angle $\theta$", (-40, 34), color=RED)
    scene.add(arrow((0.235, 0, -0.037), (0.285, 0, -0.037), 0.0018), RED)
    note((0.285, 0, -0.037), "guide.displacement $s$", (46, 14), color=RED)
    scene.add(arrow((0.27, 0, 0.16), (0.27, 0, 0.105), 0.0018), DARK)
    note((0.27, 0, 0.13), "gravity", (28, 0))
    note((a + b) / 2 + vec(0, 0, 0.022), "crank\n0.08 m", (-70, 26), leader=True)
    if flexible:
        note(along(0.28), "rod, 0.3 m\n(bending exaggerated)", (96, -2), leader=True)
        note(along(0.5), "middle", (52, 14), leader=True, color=RED)
    else:
        note(b + 0.5 * (c - b), "rod\n0.3 m", (54, 34), leader=True)
    note(c + vec(0.0, -0.017, -0.04), "slider", (-4, -40), leader=True)
    note(a - 0.05 * ex, "crankPivot\nrevolute joint", (-84, -30), leader=True)
    note(b, "crankPin\nspherical joint", (60, 20), leader=True)
    note(c, "wristPin\nuniversal joint", (84, 34), leader=True)
    note((0.09, 0, -0.05), "guide\nprismatic joint", (-40, -34), leader=True)
    place = "B in every centre of mass" + (",\nthat of the rod in crankPin" if flexible else "")
    note((0.27, 0, 0.28), f"frames: x red, y green, z blue;\n{place}", (14, 0), fontsize=8.5)
    return scene


def bent_beam(origin: np.ndarray, rotation: np.ndarray, length: float, half: float, deflection) -> np.ndarray:
    """Faces of a beam with a square section along x of its frame; deflection(ξ) is a vector in the frame."""
    xi = np.linspace(0, 1, 40)
    middle = np.column_stack([length * xi, 0 * xi, 0 * xi]) + np.array([deflection(x) for x in xi])
    corners = np.array([(0, half, half), (0, -half, half), (0, -half, -half), (0, half, -half)])
    rings = (middle[:, None] + corners) @ rotation.T + origin  # 40 x 4 x 3
    sides = [
        np.stack([rings[:-1, a], rings[1:, a], rings[1:, b], rings[:-1, b]], axis=1)
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
    ]
    return np.concatenate([*sides, rings[-1][None], rings[0][None, ::-1]])


def flexible_pendulum(axes: Axes | None) -> Scene:
    """The beam at the start, and bent later on, as the reference has it."""
    scene = Scene(azimuth=-60, elevation=18)
    note = Notes(scene, axes)
    pivot = np.zeros(3)
    scene.add(
        turned([(0.1, 0), (0.1, 0.09), (0.13, 0.09), (0.13, 0.03), (0.03, 0.03), (0.03, 0)], pivot, (0, 0, 1)), GREY
    )
    scene.add(ball(pivot, 0.035), DARK)
    _, history = read_reference(ROOT / "tests" / "references" / "FlexiblePendulum.csv")
    row, times = 7, 5  # 0.07 s; the bending is drawn five times as large
    z = [times * history[f"beam.modal[{i}]"][row] for i in (1, 2, 3, 4)]
    quaternion = np.array([history[f"beam.quaternion[{i}]"][row] for i in (1, 2, 3, 4)])
    rotation = matrix(quaternion)

    def bent(xi: float) -> np.ndarray:
        """Deflection in B."""
        return vec(0, z[0] * xi**2 + z[1] * xi**3, z[2] * xi**2 + z[3] * xi**3)

    if axes is not None:
        scene.add(bent_beam(pivot, np.eye(3), 1.0, 0.02, lambda _: np.zeros(3)), GREY)
    scene.add(bent_beam(pivot, rotation, 1.0, 0.02, bent), BLUE)
    for xi in (0.2, 0.4, 0.6, 0.8):
        scene.add(ball(rotation @ (bent(xi) + vec(xi, 0, 0)), 0.026), ORANGE)
    tip = rotation @ (bent(1.0) + vec(1, 0, 0))
    scene.add(ball(tip, 0.03), RED)
    if axes is None:
        return scene
    scene.add(tube(np.array([pivot, rotation @ vec(0.5, 0, 0), rotation @ vec(1, 0, 0)]), 0.004), DARK)
    scene.frame(pivot, 0.28)
    note.frame("W", 0.28 * np.eye(3), pivot)
    scene.frame(pivot, 0.28, rotation)
    note.frame("B", pivot + 0.28 * rotation.T, pivot, (8, 6), (0, 0), (-10, 8))
    scene.add(arrow((-0.2, 0, 0.45), (-0.2, 0, 0.2), 0.008), DARK)
    note((-0.2, 0, 0.33), "gravity", (-26, 0))
    note(pivot, "pivot\nspherical joint\nat the origin of W", (-70, -50), leader=True)
    note((0.75, 0, 0), "beam at t = 0", (30, -34), leader=True)
    note(rotation @ (bent(0.6) + vec(0.6, 0, 0)), "beam.station1 … 4", (10, 44), leader=True, color="#b26f1c")
    note(tip, "tip", (16, 14), color=RED)
    after = rotation @ (bent(0.3) + vec(0.3, 0, 0.02))
    note(after, "beam after 0.07 s\n(bending 5 times as large)", (24, 76), leader=True)
    return scene


def matrix(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrix of a unit quaternion (w, x, y, z)."""
    w, u = quaternion[0], quaternion[1:]
    return (w * w - u @ u) * np.eye(3) + 2 * np.outer(u, u) + 2 * w * np.cross(np.eye(3), u)


def flexible_slider_crank(axes: Axes | None) -> Scene:
    """The slider-crank at the start with its rod bent in both planes, much exaggerated."""
    return slider_crank(axes, flexible=True)


def spin_up_beam(axes: Axes | None) -> Scene:
    """Hub and beam, bent backwards as while it is spun up, much exaggerated."""
    scene = Scene(azimuth=-72, elevation=34)
    note = Notes(scene, axes)
    hub = np.zeros(3)
    scene.add(
        turned([(-0.45, 0), (-0.45, 0.8), (0.45, 0.8), (0.45, 0.5), (0.45, 0)], hub, (0, 0, 1), 80),
        DARK if axes is None else GREY,
    )

    def bent(xi: float) -> np.ndarray:
        """Deflection in B."""
        return vec(0, -1.6 * xi**2 * (1.5 - 0.5 * xi), 0)

    if axes is not None:
        scene.add(tube(np.array([(0.8, 0, 0), (4.4, 0, 0), (8.0, 0, 0)]), 0.02), GREY)
    scene.add(bent_beam(hub, np.eye(3), 8.0, 0.14, bent), BLUE)
    for xi in (0.2, 0.4, 0.6, 0.8):
        scene.add(ball(bent(xi) + vec(8 * xi, 0, 0), 0.19), ORANGE)
    tip = bent(1.0) + vec(8, 0, 0)
    scene.add(ball(tip, 0.22), RED)
    scene.add(turning_arrow((0, 0, 0.7), (0, 0, 1), 1.1, 0.06, -20, 230), RED)
    if axes is None:
        return scene
    scene.frame(hub, 2.2)
    note.frame("B", 2.2 * np.eye(3), hub, (6, 10), (0, 0), (0, 0))
    note((0, 0, 0.7), "hubPivot.motorTorque", (-66, 30), color=RED)
    note(vec(-0.5, -0.5, -0.2), "hub\n1000 kg m²", (-50, -34), leader=True)
    note(bent(0.6) + vec(4.8, 0, 0), "beam.station1 … 4", (-10, -46), leader=True, color="#b26f1c")
    note(tip, "tip", (16, -8), color=RED)
    note(0.5 * (tip + vec(8, 0, 0)), "tip.deflection", (48, 6))
    note((5.6, 0, 0), "beam, 8 m", (20, 30), leader=True)
    return scene


SCENES = {
    "FlexiblePendulum": flexible_pendulum,
    "FlexibleSliderCrank": flexible_slider_crank,
    "HeavyTop": heavy_top,
    "HighSpeedRotor": high_speed_rotor,
    "SliderCrank": slider_crank,
    "SpinUpBeam": spin_up_beam,
}


def draw_figure(model: str) -> None:
    """The figure with frames and names."""
    figure = Figure(figsize=(7.2, 5.0), dpi=130)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    SCENES[model](axes).draw(axes)
    save(figure, IMAGES / f"{model}.png", facecolor="white", bbox_inches="tight", pad_inches=0.08)


def draw_icon(model: str) -> None:
    """The square icon, transparent around the mechanism."""
    figure = Figure(figsize=(ICON_PIXELS / 100,) * 2, dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    SCENES[model](None).draw(axes)
    axes.margins(0)
    save(figure, IMAGES / f"{model}.icon.png", transparent=True)


def save(figure: Figure, path: Path, **options) -> None:
    """Write a PNG without date and version, so that the same picture is the same file."""
    figure.savefig(path, metadata={"Software": None}, **options)


if __name__ == "__main__":
    for chosen in sys.argv[1:] or SCENES:
        draw_figure(chosen)
        draw_icon(chosen)
        sys.stdout.write(f"drew {chosen}\n")
