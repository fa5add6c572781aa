"""R³×SO(3) and SE(3) with their coordinate maps in 50 digits, by definition: exponentials and Cayley maps of matrices.

The product's functions use closed forms instead. A pose is a homogeneous 4×4 matrix in both groups; velocities and
coordinates have six entries, translation first. Coordinates are scaled as in `fmu_src/lie/rotation_maps.h`: to first
order each is the rotation vector.
"""

from dataclasses import dataclass

import mpmath as mp
import numpy as np

from sigmafmu._core import lie

from .helpers import exact_exp, exact_hat, exact_tangent

I3, I4 = mp.eye(3), mp.eye(4)


@dataclass(frozen=True)
class Chart:
    """A group with a coordinate map."""

    group: str
    map: str

    def __str__(self) -> str:
        return f"{self.group}-{self.map}"

    @property
    def se3(self) -> bool:
        return self.group == "se3"

    @property
    def ours(self):
        """The product's functions."""
        return getattr(lie, f"{self.group}_{self.map}")


CHARTS = [Chart(group, coordinates) for group in ("r3xso3", "se3") for coordinates in ("exp", "cayley", "cayley2")]
"""Of Table 1: b, c and its second order, a, d and its second order."""


def block(rotation: mp.matrix, position: mp.matrix) -> mp.matrix:
    result = mp.eye(4)
    result[:3, :3], result[:3, 3] = rotation, position
    return result


def twist_matrix(X: mp.matrix) -> mp.matrix:
    """The 4×4 matrix of se(3)."""
    result = mp.zeros(4)
    result[:3, :3], result[:3, 3] = exact_hat(X[3:6]), X[:3]
    return result


def vee(m: mp.matrix) -> mp.matrix:
    """Six numbers of a 4×4 matrix of se(3), as a column."""
    return mp.matrix([m[0, 3], m[1, 3], m[2, 3], m[2, 1], m[0, 2], m[1, 0]])


def rotation_matrix(quaternion: mp.matrix) -> mp.matrix:
    """Eq. (40)."""
    m = exact_hat(quaternion[1:4])
    return I3 + 2 * (quaternion[0] * m + m * m)


def cayley(m: mp.matrix) -> mp.matrix:
    one = mp.eye(m.rows)
    return (one - m) ** -1 * (one + m)


def psi(chart: Chart, X: mp.matrix) -> mp.matrix:
    """The motion with coordinates X. Its exponential is that of `exact_exponential`, in a fast form."""
    if chart.map == "exp":
        rotation = rotation_matrix(exact_exp(X[3:6]))
        return block(rotation, exact_tangent(-X[3:6]) * X[:3] if chart.se3 else X[:3])
    order = {"cayley": 1, "cayley2": 2}[chart.map]
    m = twist_matrix(X) / (2 * order)
    return cayley(m) ** order if chart.se3 else block(cayley(m[:3, :3]) ** order, X[:3])


def exact_exponential(X: mp.matrix) -> mp.matrix:
    """Exponential of the 4×4 matrix, by its power series."""
    return mp.expm(twist_matrix(X), method="taylor")


def product(chart: Chart, one: mp.matrix, other: mp.matrix) -> mp.matrix:
    return one * other if chart.se3 else block(one[:3, :3] * other[:3, :3], one[:3, 3] + other[:3, 3])


def tangent_times(chart: Chart, X: mp.matrix, w: mp.matrix, step: str = "1e-20") -> mp.matrix:
    """T(X) w: the group's velocity when dX/dt = w, by a central difference; exact to step²."""
    s = mp.mpf(step)
    here, change = psi(chart, X), (psi(chart, X + s * w) - psi(chart, X - s * w)) / (2 * s)
    rotation = vee(block(here[:3, :3].T * change[:3, :3], mp.zeros(3, 1)))
    rotation[:3] = here[:3, :3].T * change[:3, 3] if chart.se3 else change[:3, 3]
    return rotation


def tangent(chart: Chart, X: mp.matrix) -> mp.matrix:
    result = mp.zeros(6)
    for i in range(6):
        result[:, i] = tangent_times(chart, X, mp.eye(6)[:, i])
    return result


def tangent_derivative(chart: Chart, X: mp.matrix, w: mp.matrix) -> mp.matrix:
    """d(T(X) w)/dX, by central differences of width 1e-12 in 80 digits: exact to 1e-24."""
    result = mp.zeros(6)
    with mp.workdps(80):
        s = mp.mpf("1e-12")
        for i in range(6):
            e = s * mp.eye(6)[:, i]
            change = tangent_times(chart, X + e, w, "1e-25") - tangent_times(chart, X - e, w, "1e-25")
            result[:, i] = change / (2 * s)
    return result


def pose_of_quaternion(q: np.ndarray) -> mp.matrix:
    """Pose of (position, quaternion); the quaternion's rounding is kept, its length is not."""
    quaternion = mp.matrix(q[3:].tolist())
    return block(rotation_matrix(quaternion / mp.norm(quaternion)), mp.matrix(q[:3].tolist()))


def pose_of_rotation_vector(q: np.ndarray) -> mp.matrix:
    """Pose of (position, rotation vector)."""
    return block(rotation_matrix(exact_exp(mp.matrix(q[3:].tolist()))), mp.matrix(q[:3].tolist()))
