"""Triangles with smooth normals, as graphics cards want them, from the quadrilaterals of solids."""

from dataclasses import dataclass

import numpy as np

from sigmafmu.contents.solids import Faces

CREASE = np.cos(np.radians(40))
"""Faces that meet at a larger angle have an edge between them."""


@dataclass(frozen=True)
class Mesh:
    """Vertices (v × 3) with normals, triangles (n × 3, indices), and displacements of the modes (f × v × 3)."""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    modes: np.ndarray


def mesh_of(faces: Faces, modes: np.ndarray) -> Mesh:
    """Triangles of quadrilaterals (n × 4 × 3) and of how modes move their corners (f × n × 4 × 3)."""
    corners = faces.reshape(-1, 3)
    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    areas = np.linalg.norm(normal, axis=1)
    unit = normal / np.maximum(areas, 1e-300)[:, None]
    size = max(float(np.ptp(corners, axis=0).max()), 1e-300)
    # Corners at one place, whose normals become the mean of those that are nearly parallel.
    _, place = np.unique(np.round(corners / (1e-6 * size)).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(place.ravel(), kind="stable")
    starts = np.flatnonzero(np.diff(place.ravel()[order], prepend=-1))
    of_corner = np.repeat(unit, 4, axis=0)
    weighted = np.repeat(normal, 4, axis=0)
    smooth = np.empty_like(of_corner)
    for first, end in zip(starts, np.append(starts[1:], len(order)), strict=True):
        here = order[first:end]
        near = of_corner[here] @ of_corner[here].T > CREASE
        smooth[here] = near @ weighted[here]
    lengths = np.linalg.norm(smooth, axis=1, keepdims=True)
    smooth = np.where(lengths > 0, smooth / np.maximum(lengths, 1e-300), (0.0, 0.0, 1.0))

    moved = np.moveaxis(modes.reshape(len(modes), len(corners), 3), 0, 1).reshape(len(corners), -1)
    keys = np.column_stack([corners / size, smooth, moved / max(float(np.abs(moved).max(initial=0)), 1e-300)])
    _, chosen, index = np.unique(np.round(keys * 1e5).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    quads = index.reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return Mesh(corners[chosen], smooth[chosen], triangles, modes.reshape(len(modes), len(corners), 3)[:, chosen])


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one; they have equally many modes."""
    firsts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=False)]),
        np.concatenate([mesh.modes for mesh in meshes], axis=1),
    )
