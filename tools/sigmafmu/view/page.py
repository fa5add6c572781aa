"""One HTML file with all that the page needs: the viewer, the scene and the frames."""

import json
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.contents.scene_of import Scene
from sigmafmu.result import Result
from sigmafmu.view import columns
from sigmafmu.view.motion import Motion, motion_of
from sigmafmu.view.packed import Packed
from sigmafmu.view.stage import Item, Point, Stage, body_colors, stage_of

VIEWER = "viewer.js"
"""The bundle that tools/viewer/build.py makes; not there in an installation that was built without npm."""
FINE = 1e-6
"""Positions are kept to this part of the mechanism's size."""
QUATERNION = 1 / 32767
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; {connect}script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:">
<link rel="icon" href="data:,">
<title>{title}</title>
</head>
<body>
<script type="application/json" id="scene">{scene}</script>
<script type="text/plain" id="numbers">{numbers}</script>
<script>{viewer}</script>
</body>
</html>
"""


def page(scene: Scene, result: Result, patterns: Iterable[str] = (), *, live: bool = False) -> str:
    """The HTML text for a result; `patterns` name what is plotted at first.

    A `live` one has poses alone, and its server sends what they really are (live.py).

    Raises SigmafmuError if the result has no poses, or this installation no viewer.
    """
    viewer = viewer_source()
    patterns = tuple(patterns)
    names = [] if live else columns.chosen(list(result.names), scene.layout, patterns)
    motion = motion_of(result, scene.layout, names)
    stage = stage_of(scene, result.__contains__)
    packed = Packed()
    content = described(result.model, stage, motion, packed) | ({"live": True} if live else {})
    content["plotted"] = columns.plotted(names, scene.layout, patterns)
    # Within <script>, only these would end the element or begin a comment.
    text = json.dumps(content, separators=(",", ":")).replace("<", "\\u003c")
    connect = "connect-src 'self'; " if live else ""
    return PAGE.format(title=escape(result.model), connect=connect, scene=text, numbers=packed.text(), viewer=viewer)


def viewer_source() -> str:
    """The JavaScript of the page, with three.js and its licence."""
    file = files("sigmafmu.view").joinpath(VIEWER)
    if not file.is_file():
        raise SigmafmuError(
            "this installation has no viewer, because npm could not be reached when it was built; build it again with "
            "a network, or write glTF with --gltf"
        )
    return file.read_text(encoding="utf-8")


def described(name: str, stage: Stage, motion: Motion, packed: Packed) -> dict[str, Any]:
    """The scene as the page reads it; arrays are in `packed`."""
    layout = stage.scene.layout
    colors = body_colors(stage.scene)
    fine = FINE * layout.size
    view = stage.scene.best_view()
    strength = float(np.linalg.norm(layout.gravity))
    return {
        "name": name,
        "size": layout.size,
        "thickness": layout.thickness,
        "up": (-layout.gravity / strength if strength else np.array([0, 0, 1.0])).tolist(),
        "towards": view[2].tolist(),
        "time": packed.add(motion.time, float(np.ptp(motion.time)) / 2.0**29 or 1.0),
        "bodies": [
            {
                "name": body,
                "color": color,
                "position": packed.add(track.position, fine),
                "quaternion": packed.add(track.quaternion, QUATERNION),
                "modal": packed.add(track.modal) if track.modal.shape[1] else None,
            }
            for (body, track), color in zip(motion.bodies.items(), colors, strict=True)
        ],
        "items": [_item(item, packed) for item in stage.items],
        "tags": [
            {"name": tag.name, "detail": tag.detail, "layer": tag.layer, "color": tag.color, "point": _point(tag.point)}
            for tag in stage.tags
        ],
        "arrows": [{"variable": a.variable, "torque": a.torque, "point": _point(a.point)} for a in stage.arrows],
        "traces": [{"name": trace, "point": _point(point)} for trace, point in stage.traces],
        "columns": [
            {"name": column, "unit": motion.units.get(column, ""), "values": packed.add(values)}
            for column, values in motion.columns.items()
        ],
    }


def _point(point: Point) -> dict[str, Any]:
    found: dict[str, Any] = {"body": point.body, "at": point.at.tolist()}
    return found | ({"modes": point.modes.tolist()} if len(point.modes) else {})


def _item(item: Item, packed: Packed) -> dict[str, Any]:
    mesh = item.mesh
    extent = max(float(np.ptp(mesh.positions, axis=0).max()), 1e-300)
    carrier: dict[str, Any] = {"point": _point(item.carrier.point), "turns": item.carrier.turns}
    if item.carrier.to:
        carrier |= {"to": _point(item.carrier.to), "length": item.carrier.length}
    return {
        "carrier": carrier,
        "layer": item.layer,
        "color": item.color,
        "positions": packed.add(mesh.positions, extent / 20000),
        "normals": packed.add(mesh.normals, 1 / 127),
        "triangles": packed.add(mesh.triangles, 1.0),
        "modes": [packed.add(mode) for mode in mesh.modes],
    }
