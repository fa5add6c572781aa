"""Where the bodies of research.mechanisms.linkages are: independent solutions in few coordinates."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from research.mechanisms.linkages import (
    BASE,
    BRICARD_AXES,
    BRICARD_POINTS,
    COUPLER,
    CRANK,
    GRAVITY,
    LENGTHS,
    MASSES,
    ROCKER,
    SPIN,
    START,
    bar_inertia,
    bricard,
    four_bar_corners,
)
from research.mechanisms.parts import GROUND


def reduced_motion(
    mass: Callable, slope: Callable, force: Callable, start: tuple[float, float], times: np.ndarray
) -> np.ndarray:
    """Angle and rate of a mechanism with one freedom: m(θ) θ'' + m'(θ) θ'²/2 + V'(θ) = 0."""

    def rhs(_: float, y: np.ndarray) -> list[float]:
        theta, rate = y
        return [rate, -(0.5 * slope(theta) * rate**2 + force(theta)) / mass(theta)]

    return solve_ivp(rhs, (times[0], times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-14).y


def four_bar_motion(times: np.ndarray) -> np.ndarray:
    """Crank angle and its rate of planar_four_bar().

    With the directions of coupler and rocker φ and ψ the closure CRANK e(θ) + COUPLER e(φ) = (BASE, 0) + ROCKER e(ψ)
    gives their first and second derivatives by θ from linear equations, and these m(θ) and m'(θ).
    """
    g = -GRAVITY[1]

    def unit(angle: float) -> np.ndarray:
        return np.array([np.cos(angle), np.sin(angle)])

    def normal(angle: float) -> np.ndarray:
        return np.array([-np.sin(angle), np.cos(angle)])

    def geometry(theta: float) -> list[tuple]:
        """Per bar: mass, inertia, (angle, its first and second derivative), those of the center's x, y."""
        pin, other = four_bar_corners(np.array(theta))
        phi = np.arctan2(*(other - pin)[::-1])
        psi = np.arctan2(other[1], other[0] - BASE)
        turned = np.column_stack([COUPLER * normal(phi), -ROCKER * normal(psi)])
        dphi, dpsi = np.linalg.solve(turned, -CRANK * normal(theta))
        bent = CRANK * unit(theta) + COUPLER * unit(phi) * dphi**2 - ROCKER * unit(psi) * dpsi**2
        ddphi, ddpsi = np.linalg.solve(turned, bent)
        crank = CRANK / 2 * normal(theta), -CRANK / 2 * unit(theta)
        coupler = (
            2 * crank[0] + COUPLER / 2 * normal(phi) * dphi,
            2 * crank[1] + COUPLER / 2 * (normal(phi) * ddphi - unit(phi) * dphi**2),
        )
        rocker = ROCKER / 2 * normal(psi) * dpsi, ROCKER / 2 * (normal(psi) * ddpsi - unit(psi) * dpsi**2)
        turns = ((1.0, 0.0), (dphi, ddphi), (dpsi, ddpsi))
        return [
            (mass, bar_inertia(mass, LENGTHS[name])[2], turn, center)
            for (name, mass), turn, center in zip(MASSES.items(), turns, (crank, coupler, rocker), strict=True)
        ]

    return reduced_motion(
        lambda theta: sum(m * c[0] @ c[0] + j * a[0] ** 2 for m, j, a, c in geometry(theta)),
        lambda theta: 2 * sum(m * c[0] @ c[1] + j * a[0] * a[1] for m, j, a, c in geometry(theta)),
        lambda theta: sum(m * g * c[0][1] for m, _, _, c in geometry(theta)),
        (START, SPIN),
        times,
    )


def four_bar_row_motion(count: int, times: np.ndarray, start: tuple[float, float] = (np.pi / 2, -1.0)) -> np.ndarray:
    """Angle of all cranks from the x axis: couplers stay level, all in one straight line as well."""
    cranks, couplers, g = count + 1, count, -GRAVITY[1]
    mass = cranks / 3 + couplers
    return reduced_motion(
        lambda _: mass,
        lambda _: 0.0,
        lambda theta: g * (cranks / 2 + couplers) * np.cos(theta),
        start,
        times,
    )


def bricard_motion(times: np.ndarray) -> np.ndarray:
    """Centers of Bricard's five bars (times x 5 x 3), from Gauss's principle of least constraint.

    Velocities of all bars, in W: the accelerations nearest to free fall in the mass metric among those that hinges
    allow, by a pseudo-inverse that leaves out the equation that follows from others. Hinges are three equations for
    their point and three for their axis.
    """
    n = 5
    mass, J = 1.0, np.diag([1 / 600, 1.01 / 12, 1.01 / 12])
    definition = bricard().multibody
    turns = [Rotation.from_quat(body.initial_quaternion, scalar_first=True).as_matrix() for body in definition.bodies]
    centers = np.array([body.initial_position for body in definition.bodies])
    chain = (GROUND, 0, 1, 2, 3, 4, GROUND)
    hinges = []
    for k in range(n + 1):
        sides = []
        for body in chain[k : k + 2]:
            if body == GROUND:
                sides.append((body, BRICARD_POINTS[k], BRICARD_AXES[k]))
            else:
                R = turns[body]
                sides.append((body, R.T @ (BRICARD_POINTS[k] - centers[body]), R.T @ BRICARD_AXES[k]))
        hinges.append(sides)

    def hat(x: np.ndarray) -> np.ndarray:
        return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])

    def rhs(_: float, y: np.ndarray) -> np.ndarray:
        _, quaternions, v, w = np.split(y, [3 * n, 7 * n, 10 * n])
        quaternions, v, w = quaternions.reshape(n, 4), v.reshape(n, 3), w.reshape(n, 3)
        R = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
        rows, gamma = np.zeros((6 * (n + 1), 6 * n)), np.zeros(6 * (n + 1))
        for k, sides in enumerate(hinges):
            for sign, (body, point, axis) in zip((1, -1), sides, strict=True):
                if body == GROUND:
                    continue
                arm, along = R[body] @ point, R[body] @ axis
                of_point, of_axis = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
                rows[of_point, 6 * body : 6 * body + 3] = sign * np.eye(3)
                rows[of_point, 6 * body + 3 : 6 * body + 6] = -sign * hat(arm)
                rows[of_axis, 6 * body + 3 : 6 * body + 6] = -sign * hat(along)
                for part, x in ((of_point, arm), (of_axis, along)):
                    gamma[part] -= sign * np.cross(w[body], np.cross(w[body], x))
        free, root = np.zeros(6 * n), np.zeros((6 * n, 6 * n))
        for i in range(n):
            inertia = R[i] @ J @ R[i].T
            values, axes = np.linalg.eigh(inertia)
            free[6 * i : 6 * i + 3] = GRAVITY
            free[6 * i + 3 : 6 * i + 6] = -np.linalg.solve(inertia, np.cross(w[i], inertia @ w[i]))
            root[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = np.eye(3) / np.sqrt(mass)
            root[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = axes @ np.diag(values**-0.5) @ axes.T
        forced = root @ (np.linalg.pinv(rows @ root, rcond=1e-7) @ (gamma - rows @ free))
        vdot = (free + forced).reshape(n, 6)
        spin = np.array([[-p[1:] @ o, *(p[0] * o + np.cross(o, p[1:]))] for p, o in zip(quaternions, w, strict=True)])
        return np.concatenate([v.ravel(), 0.5 * spin.ravel(), vdot[:, :3].ravel(), vdot[:, 3:].ravel()])

    quaternions = [body.initial_quaternion for body in definition.bodies]
    start = np.concatenate([centers.ravel(), np.concatenate(quaternions), np.zeros(6 * n)])
    solution = solve_ivp(rhs, (times[0], times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-12)
    return solution.y[: 3 * n].T.reshape(-1, n, 3)
