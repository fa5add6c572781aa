"""Unit quaternions (w, x, y, z), one a row."""

import numpy as np


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton's product: q first, then p."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, vector], axis=-1)


def conjugate(q: np.ndarray) -> np.ndarray:
    """The inverse."""
    return q * np.array([1, -1, -1, -1])


def exponential(psi: np.ndarray) -> np.ndarray:
    """Quaternions of rotation vectors [rad]."""
    half = np.linalg.norm(psi, axis=-1, keepdims=True) / 2
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * psi], axis=-1)


def logarithm(q: np.ndarray) -> np.ndarray:
    """Rotation vectors of the shortest turns, at most π long [rad]."""
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0)


def matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrices, … × 3 × 3."""
    w, u = q[..., :1, None], q[..., 1:]
    cross = np.cross(np.eye(3), u[..., None, :])  # rows e_i × u: the matrix of u ×, which is antisymmetric
    outer = u[..., :, None] * u[..., None, :]
    scale = w**2 - (u * u).sum(axis=-1)[..., None, None]
    return scale * np.eye(3) + 2 * outer + 2 * w * cross


def of_matrix(R: np.ndarray) -> np.ndarray:
    """The unit quaternion of one rotation matrix: the eigenvector of Bar-Itzhack's (2000) symmetric matrix."""
    K = np.zeros((4, 4))
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    K[0, 0] = np.trace(R)
    K[0, 1:] = K[1:, 0] = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    return np.linalg.eigh(K)[1][:, -1]


def continuous(q: np.ndarray) -> np.ndarray:
    """The same rotations, with signs such that neighbours are close."""
    flips = np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(flips)])[:, None]
