"""Meshes that the key `shapes` names: STL, OBJ, PLY, glTF and what else trimesh reads without further packages."""

from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError


def triangles_of(path: Path) -> np.ndarray:
    """Triangles of a file in its own unit, n × 3 × 3, counterclockwise from outside; raises SigmafmuError."""
    import trimesh  # of the extra `meshes`

    try:
        mesh = trimesh.load(path, force="mesh")
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise SigmafmuError(f"the mesh {path} cannot be read: {error}") from error
    triangles = np.asarray(getattr(mesh, "triangles", ()), dtype=float)
    if not len(triangles):
        raise SigmafmuError(f"the mesh {path} has no triangles")
    return triangles
