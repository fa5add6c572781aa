"""Other places to begin from when joints do not close from where the file has the bodies.

Newton's method finds the way from rough places, but not from everywhere: bodies that are turned by much end with an
axis the wrong way round. Along a tree of joints every body can be hung on its parent exactly, with the coordinates that
come nearest to its rough place, so that only the other joints of the loops are open. Which joints make the tree is a
choice: the first ones of the file, the last ones, and those that begin in the middle. Two more starts are bent by a
radian to and fro: what lies in a line may have nowhere to go.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.placement import Pose, motion
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.ends import GROUND
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

BEND = 1.0
"""Of angles that the file does not give [rad]."""


def tree_starts(content: Json, joints: Mapping[str, Record]) -> Iterator[Json]:
    """The definition with its bodies hung along different trees."""
    names = list(joints)
    half = len(names) // 2
    for order in (names, names[::-1], names[half:] + names[:half]):
        yield _hung(content, joints, order, 0.0)
    for bend in (BEND, -BEND):
        yield _hung(content, joints, names, bend)


def change(before: Json, after: Json) -> float:
    """The squared distance between the places of rigid bodies in the mass metric [kg m²]."""
    total = 0.0
    for one, two in zip(before["bodies"], after["bodies"], strict=True):
        if "mass" not in one:
            continue
        shift = np.subtract(two["position"], one["position"])
        psi = rotations.vector(rotations.product(_quaternion(one) * [1, -1, -1, -1], _quaternion(two)))
        J = one["inertia"]
        matrix = np.array([[J["xx"], J["xy"], J["xz"]], [J["xy"], J["yy"], J["yz"]], [J["xz"], J["yz"], J["zz"]]])
        total += one["mass"] * float(shift @ shift) + float(psi @ matrix @ psi)
    return total


def _quaternion(body: Json) -> np.ndarray:
    return np.array(body["orientation"]["quaternion"])


def _hung(content: Json, joints: Mapping[str, Record], order: list[str], bend: float) -> Json:
    """Bodies along the tree of the first joints in an order, with angles `bend` and -`bend` from the nearest ones."""
    rough = {body["name"]: Pose(_quaternion(body), np.array(body["position"])) for body in content["bodies"]} | {
        GROUND: Pose()
    }
    entries = {entry["name"]: entry for entry in content["joints"]}
    placed = {GROUND: rough[GROUND]}
    for name in rough:
        while (joint := _next(joints, order, placed)) is not None:
            _hang(entries[joint], joints[joint], rough, placed, bend)
            bend = -bend
        placed.setdefault(name, rough[name])  # nothing holds it to what is placed
    bodies = []
    for body in content["bodies"]:
        pose = placed[body["name"]]
        place = {"position": pose.position.tolist(), "orientation": {"quaternion": pose.quaternion.tolist()}}
        bodies.append(body | place)
    return {**content, "bodies": bodies}


def _next(joints: Mapping[str, Record], order: list[str], placed: Mapping[str, Pose]) -> str | None:
    """The first joint between a placed body and another."""
    for name in order:
        known = [body in placed for body in joints[name]["bodies"]]
        if JOINT_TYPES[joints[name]["type"]].places and any(known) and not all(known):
            return name
    return None


def _hang(entry: Json, joint: Record, rough: Mapping[str, Pose], placed: dict[str, Pose], bend: float) -> None:
    """The body that is not placed, by the coordinates that come nearest to where it is."""
    first, second = joint["bodies"]
    forward = first in placed
    frames = [
        (np.array(entry[key]["position"]), np.array(entry[key]["orientation"]["matrix"]))
        for key in ("frame1", "frame2")
    ]
    places = [placed.get(body, rough[body]) for body in (first, second)]
    points = [pose.position + pose.R @ p for pose, (p, _) in zip(places, frames, strict=True)]
    axes = [pose.R @ R for pose, (_, R) in zip(places, frames, strict=True)]
    between, shift = axes[0].T @ axes[1], axes[0].T @ (points[1] - points[0])
    turn, shift = _nearest(joint, between, shift, bend)
    child = second if forward else first
    p, R = frames[1 if forward else 0]
    if forward:
        new_axes, new_point = axes[0] @ turn, points[0] + axes[0] @ shift
    else:
        new_axes = axes[1] @ turn.T
        new_point = points[1] - new_axes @ shift
    quaternion = rotations.quaternion(new_axes @ R.T)
    pose = Pose(quaternion)
    pose.position = new_point - pose.R @ p
    placed[child] = pose


def _nearest(joint: Record, R: np.ndarray, d: np.ndarray, bend: float) -> tuple[np.ndarray, np.ndarray]:
    """Turn and displacement of a joint that come nearest to R and d, with the coordinates that the file gives."""
    kinds = JOINT_TYPES[joint["type"]].coordinates
    about_z = np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])
    angles = {2: about_z, 1: np.arctan2(-R[2, 0], R[0, 0]), 0: np.arctan2(-R[1, 2], R[1, 1])}
    x = [joint.get(c.key("coordinate"), angles[c.axis] + bend if c.turns else d[c.axis]) for c in kinds]
    turn, shift, _, _ = motion(joint["type"], x, [0.0] * len(x))
    turns_freely = joint["type"] in ("spherical", "point_on_line", "free")
    return (R if turns_freely else turn), shift
