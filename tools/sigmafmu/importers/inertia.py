"""Mass, centre of mass and inertia of rigid bodies, as they are put together and taken apart."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

THIN, NO_MOMENT = 1e-9, 1e-12
"""What a mechanism file allows the largest principal moment beyond the sum of the others, and zero ones; relative."""


@dataclass(frozen=True)
class Pose:
    """A frame in another one: origin [m] and axes."""

    p: np.ndarray = field(default_factory=lambda: np.zeros(3))
    R: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __matmul__(self, other: Pose) -> Pose:
        """`other`, which is given in this frame, in the frame that this one is given in."""
        return Pose(self.p + self.R @ other.p, self.R @ other.R)

    def inverse(self) -> Pose:
        """The other frame in this one."""
        return Pose(-self.R.T @ self.p, self.R.T)


@dataclass(frozen=True)
class Inertia:
    """Of a rigid body, in a frame of it."""

    mass: float = 0.0
    center: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """Of mass [m]."""
    J: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    """About the centre of mass [kg m²]."""

    def about(self, point: np.ndarray) -> np.ndarray:
        """The inertia about another point (Steiner)."""
        return self.J + self.mass * _square(self.center - point)

    def seen_from(self, pose: Pose) -> Inertia:
        """In the frame in which the body's frame has this pose."""
        return Inertia(self.mass, pose.p + pose.R @ self.center, pose.R @ self.J @ pose.R.T)

    def __add__(self, other: Inertia) -> Inertia:
        return self._joined(other, 1)

    def __sub__(self, other: Inertia) -> Inertia:
        return self._joined(other, -1)

    def _joined(self, other: Inertia, sign: int) -> Inertia:
        if not np.any(other.J) and other.mass == 0:
            return self
        mass = self.mass + sign * other.mass
        moment = self.mass * self.center + sign * other.mass * other.center
        center = moment / mass if mass > 0 else self.center
        return Inertia(mass, center, self.about(center) + sign * other.about(center))

    def is_possible(self) -> bool:
        """Whether a mechanism file may have it."""
        low, middle, high = np.linalg.eigvalsh(self.J)
        if not (self.mass > 0 and middle > NO_MOMENT * high and low >= -NO_MOMENT * high):
            return False
        return bool(high <= (low + middle) * (1 + THIN))

    def margin(self) -> float:
        """How far its moments are from those that no body has, of the largest: 0 for thin rods and laminas."""
        low, middle, high = np.linalg.eigvalsh(self.J)
        return min(low, low + middle - high) / high if high > 0 else -1.0


def rod(mass: float, length: float, point: np.ndarray, axis: np.ndarray) -> Inertia:
    """A thin rod along an axis, its middle at a point."""
    return Inertia(mass, point, mass * length**2 / 12 * (np.eye(3) - np.outer(axis, axis)))


def nearest_possible(J: np.ndarray) -> np.ndarray:
    """The inertia with the same axes whose moments a body can have: small ones are raised to what the largest needs."""
    moments, axes = np.linalg.eigh(J)
    low, middle, high = moments
    if high <= 0:
        return J
    middle = max(middle, high / 2)
    low = max(low, (high - middle) * (1 + 1e-6), 1e-6 * high)
    return axes @ np.diag([low, middle, high]) @ axes.T


def _square(d: np.ndarray) -> np.ndarray:
    """d² - d dᵀ."""
    return d @ d * np.eye(3) - np.outer(d, d)
