"""Mechanisms of the library, told once more as `few_coordinates` has it: from the numbers of their files alone."""

from collections.abc import Callable

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from .few_coordinates import Minimal, about, axes_of, dot, on_universal, rotation_vectors, turned, unit
from .helpers import LIBRARY

X, Y, Z = np.eye(3)


def file(name: str) -> dict:
    """What is in a file of the library; texts with units stay texts."""
    return yaml.safe_load((LIBRARY / f"{name}.yaml").read_text(encoding="utf-8"))


def centres(content: dict) -> np.ndarray:
    """Of mass, in the bodies' frames."""
    return np.array([body.get("center_of_mass", [0, 0, 0]) for body in content["bodies"].values()], dtype=float)


def minimal(content: dict, places, **more) -> Minimal:
    """With masses and inertias of a file; `places` are those of the bodies' frames."""
    bodies = content["bodies"].values()
    inertias = []
    for body in bodies:
        axes = Rotation.from_rotvec(body.get("inertia_axes", {}).get("rotation_vector", [0, 0, 0])).as_matrix()
        inertias.append(axes @ np.diag(body["inertia"]) @ axes.T)
    levers = centres(content)

    def of_centres(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, R = places(q)
        return x + np.einsum("...bcd,bd->...bc", R, levers), R

    gravity = np.array(content.get("gravity", [0, 0, -9.81]), dtype=float)
    return Minimal(np.array([body["mass"] for body in bodies]), np.array(inertias), gravity, of_centres, **more)


def about_point(R: np.ndarray, moved: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    """Origin of a frame that was W's when its point `drawn` was where that is, and turned by R since."""
    return moved - np.einsum("...cd,d->...c", R, drawn)


def stewart_platform(forces: np.ndarray) -> Minimal:
    """By the platform's displacement and rotation vector; constant forces stretch the legs."""
    content = file("StewartPlatform")
    joints, centre = content["joints"], np.array(content["bodies"]["platform"]["center_of_mass"])
    bases, balls, first, second = (
        np.array([joints[f"{joint}{i}"][key] for i in range(1, 7)])
        for joint, key in (("base", "point"), ("ball", "point"), ("base", "axis1"), ("base", "axis2"))
    )

    def ends(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        R = turned(q[..., 3:])
        return centre + q[..., None, :3] + np.einsum("...cd,id->...ic", R, balls - centre), R

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at, R = ends(q)
        x, turns = [centre + q[..., :3] - np.einsum("...cd,d->...c", R, centre)], [R]
        for i in range(6):
            leg = on_universal(at[..., i, :], bases[i], first[i], second[i], balls[i])
            x += [about_point(leg, bases[i], bases[i]), about_point(leg, at[..., i, :], balls[i])]
            turns += [leg, leg]
        return np.stack(x, -2), np.stack(turns, -3)

    def stretches(q: np.ndarray) -> np.ndarray:
        return np.linalg.norm(ends(q)[0] - bases, axis=-1) - np.linalg.norm(balls - bases, axis=-1)

    return minimal(content, places, springs=stretches, stiffness=20e3, damping=200.0, loads=forces)


def double_wishbone() -> Minimal:
    """By displacement and rotation vector of the lower arm, of its frame's origin, and the wheel's angle."""
    content = file("DoubleWishbone")
    joints, forces = content["joints"], content["forces"]
    points = {name: np.array(joints[name]["point"], dtype=float) for name in joints}
    P0, Q0, T0, inner, pivot = (
        points[name] for name in ("lowerBall", "upperBall", "tieOuter", "tieInner", "upperPivot")
    )
    axis = unit(np.array(joints["upperPivot"]["axis"], dtype=float))
    centre = pivot + axis * ((Q0 - pivot) @ axis)  # of the circle of the upper ball
    arm0 = Q0 - centre

    def upper(P: np.ndarray) -> np.ndarray:
        """Angle at which the upper ball is as far from the lower one as at the start."""
        apart = P - centre
        cosine, sine = dot(apart, arm0), dot(apart, np.cross(axis, arm0))
        wanted = 0.5 * (dot(apart, apart) + arm0 @ arm0 - (P0 - Q0) @ (P0 - Q0))
        middle, width = np.arctan2(sine, cosine), np.arccos(wanted / np.hypot(cosine, sine))
        start = P0 - centre
        side = np.sign(-np.arctan2(start @ np.cross(axis, arm0), start @ arm0))  # the angle is 0 there
        return middle + side * width

    def tie(P: np.ndarray, Q: np.ndarray) -> np.ndarray:
        """The point that is as far from P, Q and the inner joint as at the start."""
        squares = [(T0 - end) @ (T0 - end) for end in (P0, Q0, inner)]
        a, b = Q - P, inner - P
        normal = np.cross(a, b)
        da = 0.5 * (dot(a, a) + squares[0] - squares[1])
        db = 0.5 * (dot(b, b) + squares[0] - squares[2])
        n2 = dot(normal, normal)[..., None]
        flat = np.cross(da[..., None] * b - db[..., None] * a, normal) / n2
        side = np.sign((T0 - P0) @ np.cross(Q0 - P0, inner - P0))
        return P + flat + side * normal * np.sqrt((squares[0] - dot(flat, flat))[..., None] / n2)

    def lower(q: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        return q[..., :3] + np.einsum("...cd,d->...c", turned(q[..., 3:6]), drawn)

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        P = lower(q, P0)
        above = about(axis, upper(P))
        Q = pivot + np.einsum("...cd,d->...c", above, Q0 - pivot)
        T = tie(P, Q)
        knuckle = axes_of(Q - P, T - P) @ axes_of(Q0 - P0, T0 - P0).T
        rod = on_universal(T, inner, X, Z, T0)
        wheel = knuckle @ about(Y, q[..., 6])
        hub = P + np.einsum("...cd,d->...c", knuckle, points["hub"] - P0)
        x = [q[..., :3], about_point(above, pivot, pivot), about_point(knuckle, P, P0), about_point(rod, inner, inner)]
        x.append(about_point(wheel, hub, points["hub"]))
        return np.stack(x, -2), np.stack([turned(q[..., 3:6]), above, knuckle, rod, wheel], -3)

    strut = [np.array(forces["strut"][f"point{i}"], dtype=float) for i in (1, 2)]
    tire = np.array(forces["tire"]["point1"])
    bushings = [forces[name] for name in ("lowerFront", "lowerRear")]

    def stretches(q: np.ndarray) -> np.ndarray:
        x, R = places(q)
        found = [np.linalg.norm(lower(q, strut[1]) - strut[0], axis=-1)[..., None] - 0.53]
        found.append((x[..., 2, :] + np.einsum("...cd,d->...c", R[..., 2, :, :], tire) - tire)[..., 2:])
        for bushing in bushings:
            at = np.array(bushing["point"], dtype=float)
            found += [lower(q, at) - at, rotation_vectors(turned(q[..., 3:6]))]
        return np.concatenate(found, -1)

    def constants(strut: float, tire: float, word: str) -> np.ndarray:
        return np.concatenate([[strut, tire], *([*b[word], *b[f"torsional_{word}"]] for b in bushings)])

    return minimal(
        content,
        places,
        springs=stretches,
        stiffness=constants(25e3, 2e5, "stiffness"),
        damping=constants(1500.0, 200.0, "damping"),
    )


def robot_arm() -> Minimal:
    """By the angles of its hinges."""
    content = file("RobotArm")
    frames = [joint["frame1"] for joint in content["joints"].values()]
    turns = {"90 deg": np.pi / 2, "-90 deg": -np.pi / 2}
    tilts = [turns.get(frame.get("orientation", {}).get("rpy", [0])[0], 0.0) for frame in frames]

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, R = np.zeros((*q.shape[:-1], 3)), np.broadcast_to(np.eye(3), (*q.shape[:-1], 3, 3))
        origins, axes = [], []
        for i, frame in enumerate(frames):
            x = x + np.einsum("...cd,d->...c", R, np.array(frame["position"], dtype=float))
            R = R @ about(X, np.array(tilts[i])) @ about(Z, q[..., i])
            origins.append(x), axes.append(R)
        return np.stack(origins, -2), np.stack(axes, -3)

    return minimal(content, places, springs=lambda q: q, damping=0.5)


def planar(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Points of the plane z = 0."""
    return np.stack([x, y, np.zeros_like(x)], -1)


def crank_rocker_angles(crank: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions of coupler and rocker, the latter from its end at the coupler (cosine rule)."""
    r, coupler, rocker, base = 0.1, 0.3, 0.25, 0.3
    dx, dy = base - r * np.cos(crank), -r * np.sin(crank)
    diagonal = np.hypot(dx, dy)
    towards = np.arctan2(dy, dx)
    phi = towards + np.arccos((diagonal**2 + coupler**2 - rocker**2) / (2 * diagonal * coupler))
    psi = towards - np.arccos((diagonal**2 + rocker**2 - coupler**2) / (2 * diagonal * rocker))
    return phi, psi


def crank_rocker() -> Minimal:
    """By the crank's angle."""

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        crank = q[..., 0]
        phi, psi = crank_rocker_angles(crank)
        pin = 0.1 * np.stack([np.cos(crank), np.sin(crank)])
        end = pin + 0.3 * np.stack([np.cos(phi), np.sin(phi)])
        x = np.stack([planar(0 * crank, 0 * crank), planar(*pin), planar(*end)], -2)
        return x, np.stack([about(Z, angle) for angle in (crank, phi, psi)], -3)

    return minimal(file("CrankRocker"), places)


BEND = np.pi / 6
"""Of each joint of the CardanShaft."""


def cardan_shaft() -> Minimal:
    """By the input's angle; the shaft's by vectors along the crosses."""
    content = file("CardanShaft")
    joint2 = np.array(content["joints"]["joint2"]["point"])
    m = unit(joint2)  # along the shaft; frames of its parts are at the first joint, x along it

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = q[..., 0]
        fork = np.cos(angle)[..., None] * Z - np.sin(angle)[..., None] * Y  # of the input, turned about x
        cross = unit(np.cross(fork, m))  # of the shaft
        last = unit(np.cross(X, cross))  # of the output: z at the start
        along = np.broadcast_to(m, cross.shape)
        shaft = np.stack([along, cross, np.cross(along, cross)], -1)
        x = np.broadcast_to(X, cross.shape)
        output = np.stack([x, np.cross(last, x), last], -1)
        origins = np.zeros((*q.shape[:-1], 4, 3))
        origins[..., 3, :] = about_point(output, joint2, joint2)
        return origins, np.stack([about(X, angle), shaft, shaft, output], -3)

    return minimal(content, places)


def rolling_coin() -> tuple[Minimal, Callable[[np.ndarray], np.ndarray]]:
    """By place, heading, lean and turn, R = Rz Rx Ry; and N, with which it rolls for rates of the last three."""
    content = file("RollingCoin")
    r = content["joints"]["table"]["radius"]

    def places(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y, heading, lean, turn = np.moveaxis(q, -1, 0)
        R = about(Z, heading) @ about(X, lean) @ about(Y, turn)
        return np.stack([x, y, r * np.cos(lean)], -1)[..., None, :], R[..., None, :, :]

    def allowed(q: np.ndarray) -> np.ndarray:
        """The centre moves as w x r e, e from the point of contact to it."""
        heading, lean = q[2:4]
        ahead, aside = (turned(heading * Z) @ axis for axis in (X, Y))
        along = r * np.array([np.sin(lean) * ahead, -np.cos(lean) * aside, ahead])
        return np.vstack([along[:, :2].T, np.eye(3)])

    return minimal(content, places), allowed
