"""Motions of mechanisms in as few coordinates as they have degrees of freedom.

All that is told is where bodies are at given coordinates; d'Alembert's principle and differences of sixth order do the
rest. So nothing is shared with the multibody core: no joint equations, no multipliers, no quaternions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

H = 1e-2
"""Step in coordinates of size 1. First differences err by 1e-14 and, rounded, by 1e-13; second ones by 1e-11."""
OFFSETS = H * np.array([-3, -2, -1, 0, 1, 2, 3])
FIRST = np.array([-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60]) / H
SECOND = np.array([1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90]) / H**2


@dataclass(frozen=True)
class Minimal:
    """A mechanism; arrays may have axes in front, which are kept."""

    masses: np.ndarray
    inertias: np.ndarray  # bodies x 3 x 3, about the centres of mass, in the bodies' axes
    gravity: np.ndarray
    places: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    """Coordinates (..., n) → centres of mass (..., bodies, 3) and R (..., bodies, 3, 3), in W."""
    springs: Callable[[np.ndarray], np.ndarray] = lambda q: q[..., :0]
    """Coordinates → stretches s (..., m) that cost k s²/2 and take d s'."""
    stiffness: np.ndarray | float = 0.0
    damping: np.ndarray | float = 0.0
    loads: np.ndarray | float = 0.0
    """Constant forces along the stretches."""

    def equations(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """M and f of M q'' = f, from Σ δx·m (g - x'') - δφ·(J w' + w × J w) + δs·(...) = 0 for every δq.

        With x'' = X q'' + bend and w' = W q'' + twist, where bend and twist are those of a motion with constant rates.
        """
        n = len(q)
        speed = np.linalg.norm(v)
        along = v / speed if speed > 0 else np.eye(n)[0]
        directions = np.vstack([np.eye(n), along])
        samples = q + directions[:, None] * OFFSETS[:, None]
        x, R = self.places(samples)
        dx = np.einsum("k,ikbc->ibc", FIRST, x[:-1])
        R0 = R[0, 3]
        dR = np.einsum("k,ikbcd->ibcd", FIRST, R[:-1]) @ R0.swapaxes(-1, -2)
        turn = _axial(dR)
        bend = speed**2 * np.einsum("k,kbc->bc", SECOND, x[-1])
        twist = speed**2 * _axial(np.einsum("k,kbcd->bcd", SECOND, R[-1]) @ R0.swapaxes(-1, -2))
        J = R0 @ self.inertias @ R0.swapaxes(-1, -2)
        w = np.einsum("i,ibc->bc", v, turn)
        momentum = np.einsum("bcd,bd->bc", J, w)
        M = np.einsum("ibc,b,jbc->ij", dx, self.masses, dx) + np.einsum("ibc,bcd,jbd->ij", turn, J, turn)
        f = np.einsum("ibc,b,bc->i", dx, self.masses, self.gravity - bend)
        f -= np.einsum("ibc,bc->i", turn, np.einsum("bcd,bd->bc", J, twist) + np.cross(w, momentum))
        s = self.springs(samples[:-1])
        ds = np.einsum("k,ikm->im", FIRST, s)
        return M, f + ds @ (self.loads - self.stiffness * s[0, 3] - self.damping * (v @ ds))

    def motion(self, q: np.ndarray, v: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at times from q and v at the first of them, (times, n) each."""
        n = len(q)

        def rhs(_: float, y: np.ndarray) -> np.ndarray:
            return np.concatenate([y[n:], np.linalg.solve(*self.equations(y[:n], y[n:]))])

        found = solve_ivp(rhs, (times[0], times[-1]), np.concatenate([q, v]), "DOP853", times, rtol=1e-10, atol=1e-11)
        assert found.success
        return found.y[:n].T, found.y[n:].T

    def rolling(
        self, q: np.ndarray, u: np.ndarray, times: np.ndarray, allowed: Callable[[np.ndarray], np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates where these are N(q) u alone: Nᵀ (M (N u' + N' u) - f) = 0."""
        n = len(q)

        def rhs(_: float, y: np.ndarray) -> np.ndarray:
            q, u = y[:n], y[n:]
            N = allowed(q)
            v = N @ u
            speed = np.linalg.norm(v)
            turning = speed * FIRST @ np.array([allowed(q + s * v / speed) @ u for s in OFFSETS])
            M, f = self.equations(q, v)
            return np.concatenate([v, np.linalg.solve(N.T @ M @ N, N.T @ (f - M @ turning))])

        start = np.concatenate([q, u])
        found = solve_ivp(rhs, (times[0], times[-1]), start, "DOP853", times, rtol=1e-10, atol=1e-11)
        assert found.success
        q = found.y[:n].T
        return q, np.array([allowed(x) @ y for x, y in zip(q, found.y[n:].T, strict=True)])

    def drive(self, q: np.ndarray, v: np.ndarray, vdot: np.ndarray) -> np.ndarray:
        """Generalized forces that such a motion takes."""
        M, f = self.equations(q, v)
        return M @ vdot - f


def _axial(m: np.ndarray) -> np.ndarray:
    """Vectors of the skew parts."""
    return 0.5 * np.stack([m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], -1)


def unit(x: np.ndarray) -> np.ndarray:
    """Directions."""
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of the last axes."""
    return np.sum(a * b, axis=-1)


def turned(vector: np.ndarray) -> np.ndarray:
    """R of rotation vectors (Rodrigues)."""
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vector, -1, 0)
    o = np.zeros_like(x)
    K = np.stack([np.stack([o, -z, y], -1), np.stack([z, o, -x], -1), np.stack([-y, x, o], -1)], -2)
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * K @ K


def about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """R of turns about an axis."""
    return turned(np.asarray(angle)[..., None] * unit(np.asarray(axis, dtype=float)))


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """Of rotations by less than a third of a turn."""
    sine = _axial(R)
    size = np.linalg.norm(sine, axis=-1, keepdims=True)
    return sine / np.sinc(np.arcsin(size) / np.pi)


def axes_of(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Columns: the first direction, what of the second is perpendicular to it, and their product."""
    x = unit(one)
    y = unit(two - x * dot(x, two)[..., None])
    return np.stack([x, y, np.cross(x, y)], -1)


def on_universal(
    end: np.ndarray, base: np.ndarray, axis1: np.ndarray, axis2: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """R since the start of a leg from a universal joint at `base` to `end`; axis1 is the ground's, axis2 its own."""
    u, u0 = unit(end - base), unit(start - base)
    axis1, axis2 = unit(axis1), unit(axis2)
    p = unit(u - axis1 * dot(u, axis1)[..., None])
    e = np.cross(axis1, p)
    p0 = unit(u0 - axis1 * (u0 @ axis1))
    side = np.sign(axis2 @ np.cross(axis1, p0))
    cosine = (dot(axis2, u0) / dot(p, u))[..., None]
    cross = cosine * p + side * np.sqrt(1 - cosine**2) * e
    return axes_of(u, cross) @ axes_of(u0, axis2).swapaxes(-1, -2)
