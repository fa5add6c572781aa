"""Draws a mechanism at its start, as the FMUs' documentation shows it."""

import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np

from sigmafmu import SigmafmuError, native
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.load import MechanismFile, folder_of


def draw(file: MechanismFile, path: Path) -> None:
    """Write a PNG; raises SigmafmuError."""
    from sigmafmu.contents.draw import draw_figure  # Matplotlib takes a second to load

    with folder_of(file.resources) as folder:
        picture = draw_figure(json.loads(native.describe(file.text, folder)["mechanism"]), folder, shapes_of(file))
    try:
        picture.save(path)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error


def shapes_of(file: MechanismFile, *, meshes: bool = True) -> dict[str, list[dict[str, Any]]]:
    """What the file says to draw, by body, as `sigmafmu.contents.shapes` reads it.

    Places count from the centre of mass, orientations are matrices, and meshes are their triangles. Without `meshes`,
    or if trimesh is not installed, those are left out. Raises SigmafmuError for a mesh that cannot be read.
    """
    meshes = meshes and importlib.util.find_spec("trimesh") is not None
    found = {
        body: [_shape(shape, file, body) for shape in shapes if meshes or "mesh" not in shape]
        for body, shapes in file.shapes.items()
    }
    return {body: shapes for body, shapes in found.items() if shapes}


def _shape(shape: dict[str, Any], file: MechanismFile, body: str) -> dict[str, Any]:
    offset = np.array(file.offsets[body]) if "flexible" not in _entry(file, body) else np.zeros(3)
    found = {key: shape[key] for key in ("box", "cylinder", "sphere", "color") if key in shape}
    if "mesh" in shape:
        from sigmafmu.mechanism_file.meshes import triangles_of

        found["triangles"] = (float(shape.get("scale", 1)) * triangles_of(file.path.parent / shape["mesh"])).tolist()
    found["position"] = (np.array(shape.get("position", (0, 0, 0)), dtype=float) - offset).tolist()
    if "orientation" in shape:
        found["orientation"] = rotations.matrix(rotations.of_orientation(shape["orientation"])).tolist()
    return found


def _entry(file: MechanismFile, body: str) -> dict[str, Any]:
    return next(entry for entry in file.definition["bodies"] if entry["name"] == body)
