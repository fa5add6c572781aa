"""Rotations as unit quaternions (w, x, y, z) and as matrices whose columns are the turned axes."""

from collections.abc import Mapping

import numpy as np

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def of_vector(psi: np.ndarray) -> np.ndarray:
    """The quaternion of a rotation vector [rad]."""
    psi = np.asarray(psi, dtype=float)
    half = np.linalg.norm(psi) / 2
    return np.array([np.cos(half), *(np.sinc(half / np.pi) / 2 * psi)])


def vector(q: np.ndarray) -> np.ndarray:
    """The rotation vector of a quaternion, at most half a turn [rad]."""
    q = q if q[0] >= 0 else -q
    sine = float(np.linalg.norm(q[1:]))
    return 2 * np.arctan2(sine, q[0]) / sine * q[1:] if sine > 0 else np.zeros(3)


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton's product: q first, then p."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def matrix(q: np.ndarray) -> np.ndarray:
    """R of a unit quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def quaternion(R: np.ndarray) -> np.ndarray:
    """The unit quaternion of a rotation matrix, w >= 0; its largest element comes from a square root (Shepperd)."""
    squares = np.array([np.trace(R), *np.diag(R)])
    largest = int(np.argmax(squares))
    antisymmetric = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    if largest == 0:
        q = np.array([1 + squares[0], *antisymmetric])
    else:
        i = largest - 1
        row = R[i] + R[:, i]  # 4 times the products of element i with the others
        row[i] = 1 + 2 * R[i, i] - np.trace(R)
        q = np.array([antisymmetric[i], *row])
    q /= np.linalg.norm(q)
    return q if q[0] >= 0 else -q


def of_orientation(orientation: Mapping | None) -> np.ndarray:
    """The quaternion of what a file says: `rotation_vector`, `quaternion` or `rpy`, at most one of them."""
    if not orientation:
        return IDENTITY.copy()
    if "quaternion" in orientation:
        q = np.array(orientation["quaternion"])
        return q / np.linalg.norm(q)
    if "rotation_vector" in orientation:
        return of_vector(orientation["rotation_vector"])
    roll, pitch, yaw = (of_vector(angle * axis) for angle, axis in zip(orientation["rpy"], np.eye(3), strict=True))
    return product(yaw, product(pitch, roll))


def axes_with_z(z: np.ndarray) -> np.ndarray:
    """Axes of a frame, the third along z, as columns; the first is perpendicular to the axis of W least along z.

    The same bits as the core's.
    """
    e3 = _unit(z)
    e1 = _unit(np.cross(np.eye(3)[np.argmin(np.abs(e3))], e3))
    return np.column_stack((e1, np.cross(e3, e1), e3))


def _unit(x: np.ndarray) -> np.ndarray:
    return x / np.sqrt((x[0] * x[0] + x[1] * x[1]) + x[2] * x[2])  # Eigen's order
