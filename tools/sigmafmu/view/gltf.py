"""A result as animated glTF 2.0 in one binary file (.glb), which Blender and other programs open.

Each mesh is a node with its track of places; modes of flexible bodies are morph targets whose weights are the modal
coordinates. The glTF is in m and s; its y axis is up, as the standard has it.
"""

import json
import struct
from typing import Any

import numpy as np

from sigmafmu.contents.scene_of import Scene
from sigmafmu.result import Result
from sigmafmu.view import rotations
from sigmafmu.view.motion import Motion, motion_of
from sigmafmu.view.stage import Item, stage_of

MAGIC, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
FLOAT, UNSIGNED_INT = 5126, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3", "weights": "SCALAR"}
"""Types of tracks."""
Z_UP = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
"""Turns the z axis of W to the y axis of glTF; x, y, z, w as glTF writes quaternions."""


def gltf(scene: Scene, result: Result) -> bytes:
    """The file's content. Raises SigmafmuError if the result does not have the poses of all bodies."""
    motion = motion_of(result, scene.layout, ())
    stage = stage_of(scene, result.__contains__)
    file = _File()
    time = file.accessor(motion.time - motion.time[0], "SCALAR", extremes=True)
    nodes: list[dict[str, Any]] = [{"name": result.model, "rotation": Z_UP, "children": []}]
    colors = list(dict.fromkeys(item.color for item in stage.items))
    meshes, channels, samplers = [], [], []
    for item in stage.items:
        node = {"name": _name(item, list(motion.bodies)), "mesh": len(meshes)}
        meshes.append(_mesh(item, colors, file))
        for path, values in _tracks(item, motion).items():
            if path != "weights" and _is_constant(values):  # written once
                node[path] = values[0].tolist()
                continue
            samplers.append({"input": time, "output": file.accessor(values, KINDS[path])})
            channels.append({"sampler": len(samplers) - 1, "target": {"node": len(nodes), "path": path}})
        nodes[0]["children"].append(len(nodes))
        nodes.append(node)
    content = {
        "asset": {"version": "2.0", "generator": "sigmafmu"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(color) for color in colors],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": len(file.data)}],
    }
    if channels:
        content["animations"] = [{"name": "motion", "channels": channels, "samplers": samplers}]
    return _binary(content, bytes(file.data))


def _is_constant(values: np.ndarray) -> bool:
    """Whether a track (n × k) does not change."""
    return bool(np.ptp(values, axis=0).max(initial=0) <= 1e-9 * (1 + np.abs(values).max(initial=0)))


class _File:
    """Accessors and their data."""

    def __init__(self):
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self.data = bytearray()

    def accessor(self, values: np.ndarray, kind: str, *, target: int = 0, extremes: bool = False) -> int:
        """Put in an array of floats (or of indices, for INDICES); its number."""
        type_, code = ("<u4", UNSIGNED_INT) if target == INDICES else ("<f4", FLOAT)
        array = np.ascontiguousarray(values, dtype=type_)
        array = array.reshape(-1) if kind == "SCALAR" else array
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += array.tobytes()  # a multiple of four bytes, as alignment asks
        entry: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": code,
            "count": len(array),
            "type": kind,
        }
        if extremes:
            columns = array.reshape(len(array), -1)
            entry |= {"min": columns.min(axis=0).tolist(), "max": columns.max(axis=0).tolist()}
        self.accessors.append(entry)
        return len(self.accessors) - 1


def _name(item: Item, bodies: list[str]) -> str:
    body = item.carrier.point.body
    return f"{bodies[body] if body >= 0 else 'ground'}, {item.layer}"


def _mesh(item: Item, colors: list[str], file: _File) -> dict[str, Any]:
    mesh = item.mesh
    # Normals as the file has them must have length 1 to within single precision.
    normals = mesh.normals / np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    primitive: dict[str, Any] = {
        "attributes": {
            "POSITION": file.accessor(mesh.positions, "VEC3", target=VERTICES, extremes=True),
            "NORMAL": file.accessor(normals, "VEC3", target=VERTICES),
        },
        "indices": file.accessor(mesh.triangles, "SCALAR", target=INDICES),
        "material": colors.index(item.color),
    }
    if len(mesh.modes):
        primitive["targets"] = [
            {"POSITION": file.accessor(mode, "VEC3", target=VERTICES, extremes=True)} for mode in mesh.modes
        ]
    return {"primitives": [primitive]} | ({"weights": [0.0] * len(mesh.modes)} if len(mesh.modes) else {})


def _tracks(item: Item, motion: Motion) -> dict[str, np.ndarray]:
    """What changes of a node: translation, rotation (x, y, z, w), scale, weights."""
    carrier = item.carrier
    tracks = {"translation": carrier.point.path(motion)}
    if carrier.to is not None:
        gap = carrier.to.path(motion) - tracks["translation"]
        length = np.linalg.norm(gap, axis=1)
        tracks["rotation"] = _from_z(gap / np.maximum(length, 1e-300)[:, None])
        scale = np.maximum(length / carrier.length, 1e-6)
        tracks["scale"] = np.column_stack([np.ones_like(scale), np.ones_like(scale), scale])
    elif carrier.turns and carrier.point.body >= 0:
        tracks["rotation"] = np.roll(list(motion.bodies.values())[carrier.point.body].quaternion, -1, axis=1)
    if len(item.mesh.modes):
        tracks["weights"] = list(motion.bodies.values())[carrier.point.body].modal
    return tracks


def _from_z(directions: np.ndarray) -> np.ndarray:
    """Shortest turns (x, y, z, w) from z to unit vectors."""
    x, y, z = directions.T
    w = 1 + z
    q = np.where((w > 1e-9)[:, None], np.column_stack([w, -y, x, np.zeros_like(w)]), (0.0, 1.0, 0.0, 0.0))
    q = rotations.continuous(q / np.linalg.norm(q, axis=1, keepdims=True))
    return np.roll(q, -1, axis=1)


def _material(color: str) -> dict[str, Any]:
    srgb = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)  # as glTF has colours
    surface = {"baseColorFactor": [*linear.tolist(), 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.55}
    return {"name": color, "pbrMetallicRoughness": surface}


def _binary(content: dict[str, Any], data: bytes) -> bytes:
    """Header, the JSON chunk and the binary chunk, each padded to four bytes."""
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text + struct.pack("<II", len(data), BINARY_CHUNK) + data
    return struct.pack("<III", MAGIC, 2, 12 + len(chunks)) + chunks
