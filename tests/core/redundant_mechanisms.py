"""Linkages whose joints say some things twice, and where their bodies are in minimal coordinates.

All are drawn in space with hinges whose axes are z of W, but for Bricard's.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .helpers import GROUND, Rotation

REVOLUTE, SPHERICAL = _core.JointType.revolute, _core.JointType.spherical
CYLINDRICAL = _core.JointType.cylindrical
Z = np.array([0.0, 0.0, 1.0])
GRAVITY = np.array([0.0, -9.81, 0.0])


def add_bar(
    multibody: _core.Multibody, name: str, ends: np.ndarray, mass: float, inertia: np.ndarray, velocity: np.ndarray
) -> int:
    """A bar in the xy plane with its mass at its middle, body x from end to end, whose ends have these velocities."""
    along = ends[1] - ends[0]
    length_squared = along @ along
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = name, mass, inertia
    body.initial_position = ends.mean(axis=0)
    body.initial_quaternion = Rotation.from_rotvec(np.arctan2(along[1], along[0]) * Z).as_quat(scalar_first=True)
    body.initial_velocity = velocity.mean(axis=0)
    body.initial_angular_velocity = np.cross(along, velocity[1] - velocity[0]) / length_squared
    return multibody.add(body)


def add_hinge(
    multibody: _core.Multibody,
    name: str,
    kind: _core.JointType,
    body1: int,
    body2: int,
    point: np.ndarray,
    axis: np.ndarray = Z,
) -> int:
    """A joint at a point of W whose z is an axis there."""
    sides = []
    for body in (body1, body2):
        position, turn = np.zeros(3), Rotation.identity()
        if body != GROUND:
            place = multibody.body(body)
            position, turn = place.initial_position, Rotation.from_quat(place.initial_quaternion, scalar_first=True)
        R = turn.as_matrix()
        sides += [body, _core.Frame(R.T @ (point - position), R.T @ _core.axes_with_z(axis))]
    return multibody.add(_core.Joint(name, kind, *sides))


def in_plane(*points: tuple[float, float]) -> np.ndarray:
    return np.array([(*p, 0.0) for p in points])


# --- planar four-bar -------------------------------------------------------------------------------------------------

CRANK, COUPLER, ROCKER, BASE = 0.2, 0.5, 0.4, 0.6
MASSES = {"crank": 0.5, "coupler": 1.2, "rocker": 0.8}
LENGTHS = {"crank": CRANK, "coupler": COUPLER, "rocker": ROCKER}
SPIN = 8.0
START = 1.0


def bar_inertia(mass: float, length: float) -> np.ndarray:
    """A slender bar along x that is a little thick."""
    return mass * np.array([1e-4, length**2 / 12, length**2 / 12 + 1e-4])


def four_bar_corners(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the coupler (crank pin and rocker pin) at crank angle theta, open branch."""
    pin = CRANK * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    across = np.array([BASE, 0.0]) - pin
    distance = np.linalg.norm(across, axis=-1, keepdims=True)
    along = (COUPLER**2 - ROCKER**2 + distance**2) / (2 * distance)
    height = np.sqrt(COUPLER**2 - along**2)
    normal = np.stack([-across[..., 1], across[..., 0]], axis=-1)
    return pin, pin + (along * across + height * normal) / distance


def planar_four_bar(kinds: tuple = (REVOLUTE,) * 4) -> _core.Mechanism:
    """Crank 0.2 m, coupler 0.5 m, rocker 0.4 m on a base of 0.6 m: the crank turns fully. It starts at 1 rad with
    8 rad/s."""
    m = _core.Mechanism()
    m.name = "PlanarFourBar"
    m.multibody.gravity = GRAVITY
    step = 1e-6  # velocities of the pins: the projection at the start corrects what differences leave
    corners, ahead, behind = (
        [np.append(p, 0.0) for p in four_bar_corners(np.array(START + d))] for d in (0.0, step, -step)
    )
    rates = [SPIN * (a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    still, right = np.zeros(3), np.array([BASE, 0.0, 0.0])
    points = [still, *corners, right]
    moving = [still, *rates, still]
    for i, (name, mass) in enumerate(MASSES.items()):
        ends = np.array(points[i : i + 2])
        add_bar(m.multibody, name, ends, mass, bar_inertia(mass, LENGTHS[name]), np.array(moving[i : i + 2]))
    chain = (GROUND, 0, 1, 2, GROUND)
    for i, kind in enumerate(kinds):
        add_hinge(m.multibody, f"hinge{i + 1}", kind, chain[i], chain[i + 1], points[i])
    return m


# --- cranks with couplers between them -------------------------------------------------------------------------------


def four_bar_row(count: int, kinds: tuple = (REVOLUTE,) * 3) -> _core.Mechanism:
    """`count` squares side by side: cranks upright on the ground, couplers between their tips that start with 1 m/s.

    All bars have 1 m, 1 kg and, about axes across them, 1/12 kg m². The kinds are those of a crank's pivot and of a
    coupler's left and right pin.
    """
    m = _core.Mechanism()
    m.name = "DoubleFourBar" if count == 2 else "FourBarRow"
    m.multibody.gravity = GRAVITY
    m.integrator.step_size = 1e-3
    push, still = np.array([1.0, 0, 0]), np.zeros(3)
    inertia = np.array([1e-4, 1 / 12, 1 / 12])
    bottom = [np.array([float(i), 0, 0]) for i in range(count + 1)]
    top = [b + np.array([0, 1.0, 0]) for b in bottom]
    for i in range(count + 1):
        add_bar(m.multibody, f"crank{i + 1}", np.array([bottom[i], top[i]]), 1.0, inertia, np.array([still, push]))
    for i in range(count):
        add_bar(m.multibody, f"coupler{i + 1}", np.array([top[i], top[i + 1]]), 1.0, inertia, np.array([push, push]))
    for i in range(count + 1):
        add_hinge(m.multibody, f"pivot{i + 1}", kinds[0], GROUND, i, bottom[i])
    for i in range(count):
        coupler = count + 1 + i
        add_hinge(m.multibody, f"left{i + 1}", kinds[1], i, coupler, top[i])
        add_hinge(m.multibody, f"right{i + 1}", kinds[2], coupler, i + 1, top[i + 1])
    return m


def flat_row(count: int, speeds: np.ndarray) -> _core.Mechanism:
    """The same row at the start in one line along x, each crank with a speed of its tip upwards [m/s]."""
    m = _core.Mechanism()
    m.name = "FlatRow"
    m.multibody.gravity = GRAVITY
    inertia = np.array([1e-4, 1 / 12, 1 / 12])
    points, up = np.array([[float(i), 0, 0] for i in range(count + 3)]), speeds[:, None] * np.array([0, 1.0, 0])
    for i in range(count + 1):
        add_bar(m.multibody, f"crank{i + 1}", points[i : i + 2], 1.0, inertia, np.array([0 * up[i], up[i]]))
    for i in range(count):
        add_bar(m.multibody, f"coupler{i + 1}", points[i + 1 : i + 3], 1.0, inertia, up[i : i + 2])
    for i in range(count + 1):
        add_hinge(m.multibody, f"pivot{i + 1}", REVOLUTE, GROUND, i, points[i])
    for i in range(count):
        add_hinge(m.multibody, f"left{i + 1}", REVOLUTE, i, count + 1 + i, points[i + 1])
        add_hinge(m.multibody, f"right{i + 1}", REVOLUTE, count + 1 + i, i + 1, points[i + 2])
    return m


# --- Bricard's -------------------------------------------------------------------------------------------------------

BRICARD_POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], dtype=float)
BRICARD_AXES = np.eye(3)[[1, 2, 0, 1, 2, 0]]


def bricard(kinds: tuple = (REVOLUTE,) * 6) -> _core.Mechanism:
    """Five bars along the edges of a cube, six hinges (IFToMM A04)."""
    m = _core.Mechanism()
    m.name = "Bricard"
    m.multibody.gravity = GRAVITY
    x, y, z = np.eye(3)
    turns = [0 * x, -np.pi / 2 * z, -np.pi / 2 * y, np.pi * z, np.pi / 2 * z]
    for i, turn in enumerate(turns):
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = f"bar{i + 1}", 1.0, np.array([1 / 600, 1.01 / 12, 1.01 / 12])
        body.initial_position = BRICARD_POINTS[i : i + 2].mean(axis=0)
        body.initial_quaternion = Rotation.from_rotvec(turn).as_quat(scalar_first=True)
        m.multibody.add(body)
    chain = (GROUND, 0, 1, 2, 3, 4, GROUND)
    for i, kind in enumerate(kinds):
        add_hinge(m.multibody, f"hinge{i + 1}", kind, chain[i], chain[i + 1], BRICARD_POINTS[i], BRICARD_AXES[i])
    return m


# --- a door ----------------------------------------------------------------------------------------------------------

DOOR_MASS, DOOR_HEIGHT = 20.0, 2.0


def door() -> _core.Mechanism:
    """20 kg, 0.8 m by 2 m, on a hinge at its foot and a ball at its top; the axis is upright, z of W."""
    m = _core.Mechanism()
    m.name = "Door"
    m.multibody.gravity = np.array([0.0, 0.0, -9.81])
    body = _core.RigidBody()
    body.name, body.mass = "door", DOOR_MASS
    width = 0.8
    body.inertia = DOOR_MASS / 12 * np.array([DOOR_HEIGHT**2, width**2 + DOOR_HEIGHT**2, width**2])
    body.initial_position = np.array([width / 2, 0.0, DOOR_HEIGHT / 2])
    body.initial_angular_velocity = np.array([0.0, 0.0, 1.5])
    body.initial_velocity = np.array([0.0, 1.5 * width / 2, 0.0])
    m.multibody.add(body)
    add_hinge(m.multibody, "hinge", REVOLUTE, GROUND, 0, np.zeros(3))
    add_hinge(m.multibody, "ball", SPHERICAL, GROUND, 0, np.array([0.0, 0.0, DOOR_HEIGHT]))
    return m


# --- independent solutions -------------------------------------------------------------------------------------------


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
