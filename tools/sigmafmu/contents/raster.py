"""Pixels of solids as seen from far away (parallel projection): whatever lies nearest to the viewer is seen."""

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import to_rgb

from .solids import Faces, unit

LIGHT = np.array([0.25, 0.35, 0.9])
"""From the scene to the light, in axes of the picture: right, up, towards the viewer."""
FINE = 2
"""Pixels are computed so many times finer in both directions."""
COUNTS = np.array([2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536, 2048, 4096])
OUTLINE = 0.55


def view_from(azimuth: float, elevation: float) -> np.ndarray:
    """Rows right, up, towards the viewer; angles in degrees, as in Matplotlib's 3D axes."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0])
    return np.stack([right, np.cross(towards, right), towards])


@dataclass
class Camera:
    """A point x of W is at scale · (view x) + shift in the picture, in pixels to the right and up from its corner."""

    view: np.ndarray
    scale: float
    shift: np.ndarray
    width: int
    height: int

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels of points, … × 3."""
        return self.scale * (np.asarray(points, dtype=float) @ self.view[:2].T) + self.shift

    def lift(self, pixel: np.ndarray) -> np.ndarray:
        """The point in W that is at `pixel` and in the plane through W's origin."""
        return (np.asarray(pixel) - self.shift) / self.scale @ self.view[:2]


def paint(solids: list[tuple[Faces, str, bool]], camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """RGBA of (faces, colour, over all else), height × width × 4 with rows from the top, and which is seen, or -1."""
    corners = np.concatenate([faces for faces, _, _ in solids])
    sizes = [len(faces) for faces, _, _ in solids]
    owner = np.repeat(np.arange(len(solids)), sizes)
    colors = np.repeat([to_rgb(color) for _, color, _ in solids], sizes, axis=0)
    seen = np.concatenate([FINE * camera.project(corners), (corners @ camera.view[2])[..., None]], axis=-1)
    true = corners @ camera.view.T
    normals = np.cross(true[:, 2] - true[:, 0], true[:, 3] - true[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    front = normals[:, 2] > 1e-9 * lengths
    diffuse = np.clip(normals @ unit(LIGHT) / np.maximum(lengths, 1e-300), 0, 1)[:, None]
    shaded = np.clip(colors * (0.45 + 0.6 * diffuse) + 0.18 * diffuse**30, 0, 1)

    depth = seen[..., 2]
    low, high = depth.min(), depth.max()
    seen[..., 2] = (depth - low) / max(high - low, 1e-300)
    seen[..., 2] += np.repeat([float(over) for _, _, over in solids], sizes)[:, None]
    face = _nearest(seen, np.flatnonzero(front), FINE * camera.width, FINE * camera.height)

    solid = np.where(face < 0, -1, owner[face])
    rgba = np.pad(shaded, ((0, 1), (0, 1)), constant_values=1).astype(np.float32)[face]  # row -1: no face
    edge = np.zeros(face.shape, dtype=bool)
    edge[:, 1:] |= solid[:, 1:] != solid[:, :-1]
    edge[1:] |= solid[1:] != solid[:-1]
    rgba[edge, :3] *= OUTLINE
    rgba *= (solid >= 0)[..., None]
    rgba = rgba.reshape(camera.height, FINE, camera.width, FINE, 4).mean(axis=(1, 3))
    rgba[..., :3] /= np.maximum(rgba[..., 3:], 1e-9)
    return np.clip(rgba, 0, 1)[::-1], solid[::FINE, ::FINE][::-1]


def _nearest(corners: np.ndarray, faces: np.ndarray, width: int, height: int) -> np.ndarray:
    """Which of `faces` is seen in each pixel (rows from the bottom), -1 where none is; depths grow to the viewer."""
    u = np.linalg.norm(np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 3]])[..., :2], axis=2).max(0)
    v = np.linalg.norm(np.stack([corners[:, 3] - corners[:, 0], corners[:, 2] - corners[:, 1]])[..., :2], axis=2).max(0)
    # Points of a face lie less than a pixel apart; faces with equal numbers of points go together.
    across, along = (np.minimum(np.searchsorted(COUNTS, 1.4 * x + 1), len(COUNTS) - 1)[faces] for x in (u, v))
    best = np.full(width * height, -1, dtype=np.int64)
    for a, b in sorted(set(zip(across.tolist(), along.tolist(), strict=True))):
        chosen = faces[(across == a) & (along == b)]
        s, t = (np.linspace(0, 1, COUNTS[i]) for i in (a, b))
        s, t = s[:, None], t[None, :]
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]).reshape(4, -1)
        x, y, z = np.moveaxis(np.einsum("fkc,kp->cfp", corners[chosen], weights), 0, 0)
        column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        key = ((z * 2**29).astype(np.int64) << 32) + np.broadcast_to(chosen[:, None], z.shape)
        np.maximum.at(best, (row * width + column)[inside], key[inside])
    return np.where(best < 0, -1, best & 0xFFFFFFFF).reshape(height, width)
