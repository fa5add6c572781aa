"""Takes out of a robot what a mechanism file does not need or cannot have.

Links that are fixed to their parents become part of them. A massless link at the end of a branch goes with its joint.
Between two joints it stays as a body, since these keep their coordinates, and gets mass without any change of the
dynamics: what lies on the axis of a hinge moves with the bodies on both sides of it, so that a thin rod on that axis
can be taken from the one and given to the other. Two slides one after the other become a planar joint.
"""

from dataclasses import replace

import numpy as np

from sigmafmu.importers.inertia import Inertia, Pose, nearest_possible, rod
from sigmafmu.importers.robot import GROUND, Body, Coupling, DescriptionError, Joint, Robot
from sigmafmu.mechanism_file.table.coordinates import PLANE

PERPENDICULAR = 1e-9
ROUNDING = 1e-14
TAKEN = 0.1
"""Part of a body's mass that a massless neighbour gets, if the rest can be a body; else less."""
SPARE = 1e-3
"""How far the rest's moments stay away from those that no body has, of the largest one; less if they are closer."""
OF_GROUND = 1e-6
"""Part of the largest mass that a rod on the axis of a hinge at the ground has."""
LAST_RESORT = 1e-6
"""Of the neighbour's mass and inertia, where nothing can be taken without a change."""


def reduce(robot: Robot) -> None:
    """All of it, in place."""
    merge_fixed(robot)
    drop_massless_ends(robot)
    join_slides(robot)
    give_mass(robot)
    for body in robot.bodies.values():
        if not body.inertia.mass > 0:
            raise DescriptionError(f"{robot.source}: {body.name} is free and has no mass; it must have some")
    for body in robot.bodies.values():
        make_possible(robot, body)


def merge_fixed(robot: Robot) -> None:
    """Bodies that a fixed joint carries become part of their parents."""
    for joint in [j for j in robot.tree() if j.type == "fixed"]:
        parent, child = joint.bodies
        pose = joint.frames[0] @ joint.frames[1].inverse()
        del robot.joints[joint.name]
        _let_go(robot, joint.name)
        merge(robot, robot.bodies.pop(child), parent, pose)
    if robot.in_ground:
        robot.tell(f"part of the ground, not drawn: {', '.join(robot.in_ground)}")


def _let_go(robot: Robot, name: str) -> None:
    """What follows a fixed joint stays where this has it; a fixed joint follows nothing."""
    for coupling in [c for c in robot.couplings if c.type == "mimic" and name in c.joints]:
        follower, _ = coupling.joints
        if follower == name:
            robot.couplings.remove(coupling)
        else:
            coupling.type, coupling.joints = "sum", [follower]
            coupling.keys = {"polynomials": [[0, 1]], "offset": coupling.keys["polynomial"][0]}


def merge(robot: Robot, body: Body, into: str, pose: Pose) -> None:
    """A body that has been taken out becomes part of another one, or of the ground, where it has this pose."""
    if into == GROUND:
        robot.in_ground += [body.name, *body.merged]
    else:
        other = robot.bodies[into]
        other.inertia = other.inertia + body.inertia.seen_from(pose)
        other.shapes += [replace(shape, pose=pose @ shape.pose) for shape in body.shapes]
        other.merged += [body.name, *body.merged]
        if body.inertia.mass > 0 or np.any(body.inertia.J):
            other.inertia_axes = None
    for element in robot.attached():
        for i in (0, 1):
            if element.bodies[i] == body.name:
                element.bodies = _with(element.bodies, i, into)
                element.frames = _with(element.frames, i, pose @ element.frames[i])


def _with(pair: tuple, i: int, value: object) -> tuple:
    return (value, pair[1]) if i == 0 else (pair[0], value)


def drop_massless_ends(robot: Robot) -> None:
    """Links without mass that carry nothing go, with their joints and what couples these."""
    gone: list[Joint] = []
    while True:
        holding = {element.bodies[0] for element in robot.attached()}
        holding |= {j.bodies[1] for j in robot.joints.values() if j.closes} | {f.bodies[1] for f in robot.forces}
        ends = [j for j in robot.tree() if robot.bodies[j.bodies[1]].inertia.mass == 0 and j.bodies[1] not in holding]
        if not ends:
            break
        for joint in ends:
            del robot.joints[joint.name], robot.bodies[joint.bodies[1]]
        gone += ends
    if gone:
        listed = ", ".join(f"{joint.name} with {joint.bodies[1]}" for joint in gone)
        robot.tell(f"joints that move nothing with mass: {listed}")
    names = {joint.name for joint in gone}
    couplings = [c for c in robot.couplings if names & set(c.joints)]  # tendons are MJCF's, where all links have mass
    robot.couplings = [c for c in robot.couplings if c not in couplings]
    if couplings:
        robot.tell(f"couplings of these: {', '.join(c.name for c in couplings)}")
    attached = {body for element in robot.attached() for body in element.bodies}
    for name in [n for n, body in robot.bodies.items() if body.inertia.mass == 0 and n not in attached]:
        robot.tell(f"{name}: has no mass and nothing is at it")
        del robot.bodies[name]


def _carried(robot: Robot, body: str) -> list[Joint]:
    """Joints of the tree by which a body carries others."""
    return [joint for joint in robot.tree() if joint.bodies[0] == body]


def join_slides(robot: Robot) -> None:
    """Two perpendicular slides with nothing between, and a hinge across both after them, become a planar joint."""
    for first in [joint for joint in robot.tree() if joint.type == "prismatic"]:
        second = _only_next(robot, first) if first.name in robot.joints else None
        if second is None or second.type != "prismatic":
            continue
        way = first.frames[0] @ first.frames[1].inverse() @ second.frames[0]
        x, y = first.frames[0].R[:, 2], way.R[:, 2]
        if abs(x @ y) > PERPENDICULAR:
            continue
        hinge, normal = _only_next(robot, second), np.cross(x, y)
        if hinge is not None and hinge.type == "revolute":
            way = way @ second.frames[1].inverse() @ hinge.frames[0]
            axis = way.R[:, 2]
            if abs(abs(axis @ normal) - 1) > PERPENDICULAR:
                hinge = None
        else:
            hinge = None
        slides, last = (first, second), hinge or second
        if hinge is not None and axis @ normal < 0:
            slides, x, y, normal = (second, first), y, x, -normal
        if hinge is None:
            way = first.frames[0] @ first.frames[1].inverse() @ second.frames[0]
        frame1 = Pose(way.p, np.column_stack([x, y, normal]))
        to_last = way @ last.frames[1].inverse()
        frame2 = Pose(last.frames[1].p, to_last.R.T @ frame1.R)
        joint = Joint("", "planar", (first.bodies[0], last.bodies[1]), (frame1, frame2))
        _replace(robot, joint, [*([hinge] if hinge else []), *slides])


def _only_next(robot: Robot, joint: Joint) -> Joint | None:
    """The joint after a massless body that does nothing but connect two."""
    middle = joint.bodies[1]
    attached = [element for element in robot.attached() if middle in element.bodies]
    following = _carried(robot, middle)
    return following[0] if robot.bodies[middle].inertia.mass == 0 and following and len(attached) == 2 else None


def _replace(robot: Robot, planar: Joint, old: list[Joint]) -> None:
    """A planar joint in place of its coordinates' joints: perhaps a hinge, then the slides along x and y."""
    in_order = [joint for joint in robot.tree() if joint in old]
    planar.name = name = "_".join(joint.name for joint in in_order)
    words = {}
    for c, joint in zip(PLANE[-len(old) :], old, strict=True):
        planar.keys |= {c.key(key): value for key, value in joint.keys.items()}
        words[joint.name] = c.word
        robot.coordinates[joint.name] = f"{name}\0{c.word}"
    for joint in old:
        if joint.bodies[1] != planar.bodies[1]:
            del robot.bodies[joint.bodies[1]]
    joints = [planar if joint is in_order[0] else joint for joint in robot.joints.values()]
    robot.joints = {joint.name: joint for joint in joints if joint not in old}
    for element in robot.on_coordinates():
        element.joints = [f"{name}\0{words[x]}" if x in words else x for x in element.joints]
    what = ", ".join(f"{joint} is {name}.{word}" for joint, word in words.items())
    robot.tell(f"{name}: one planar joint in place of joints with nothing between them; {what}")
    if len(old) == 2:
        held = {"polynomials": [[0, 1]], "offset": 0}
        robot.couplings.append(Coupling(f"{name}_angle", "sum", [f"{name}\0angle"], held))


def give_mass(robot: Robot) -> None:
    """Massless bodies between joints get mass, from the ends of the tree on."""
    for joint in reversed(list(robot.tree())):
        body = robot.bodies[joint.bodies[1]]
        if body.inertia.mass > 0:
            continue
        body.inertia = _without_a_change(robot, joint, body) or _last_resort(robot, body)
        body.inertia_axes = None
        if body.name not in robot.changed:
            body.comment = "without mass in the description; a rod on a hinge's axis, taken from a neighbour"


def _without_a_change(robot: Robot, joint: Joint, body: Body) -> Inertia | None:
    """What a massless body after a joint can get without any change of the dynamics."""
    after = _carried(robot, body.name)
    for following in after:
        if found := _from_child(robot, following):
            return found
    return _from_parent(robot, joint) or _turning(robot, joint, after)


def _from_child(robot: Robot, after: Joint) -> Inertia | None:
    """A rod on the axis of the hinge that comes after, which moves with the bodies on both sides."""
    return _rod_of(robot, after, after.bodies[1], 1) if after.type == "revolute" else None


def _from_parent(robot: Robot, joint: Joint) -> Inertia | None:
    """A rod on the axis of the hinge before: it turns with what comes after alone, which must hold it."""
    after = _carried(robot, joint.bodies[1])
    if joint.type != "revolute" or not after or any(next_.type != "revolute" for next_ in after):
        return None
    axis = joint.frames[1].R[:, 2]
    if all(abs(abs(axis @ next_.frames[0].R[:, 2]) - 1) < PERPENDICULAR for next_ in after):
        return None
    return _rod_of(robot, joint, joint.bodies[0], 0)


def _rod_of(robot: Robot, hinge: Joint, donor: str, side: int) -> Inertia | None:
    """A rod on a hinge's axis, taken from the body on that side of it; in the frame of the other body."""
    here, there = hinge.frames[side], hinge.frames[1 - side]
    if donor == GROUND:  # a rod that never moves, so light that it does not matter for the centre of mass
        largest = max((body.inertia for body in robot.bodies.values()), key=lambda inertia: inertia.mass)
        length = float(np.sqrt(np.trace(largest.J) / largest.mass)) if largest.mass > 0 else 1.0
        return rod(OF_GROUND * largest.mass or 1.0, length, there.p, there.R[:, 2])
    body = robot.bodies[donor]
    if not body.inertia.mass > 0:
        return None
    length = float(np.sqrt(np.trace(body.inertia.J) / body.inertia.mass))
    mass = TAKEN * body.inertia.mass
    least = min(SPARE, body.inertia.margin() / 2)
    for _ in range(20 if least > 0 else 0):
        rest = body.inertia - rod(mass, length, here.p, here.R[:, 2])
        if rest.mass > 0 and rest.margin() > least:
            body.inertia, body.inertia_axes = rest, None
            return rod(mass, length, there.p, there.R[:, 2])
        mass /= 2
    return None


def _turning(robot: Robot, joint: Joint, after: list[Joint]) -> Inertia | None:
    """Between a hinge and a slide: a rod on the hinge's axis, and a part of what turns with both sides of the slide."""
    slide = next((next_ for next_ in after if next_.type == "prismatic"), None)
    if slide is None or joint.type != "revolute":
        return None
    carried = robot.bodies[slide.bodies[1]]
    if not carried.inertia.mass > 0:
        return None
    held = _rod_of(robot, joint, joint.bodies[0], 0)
    if held is None:
        return None
    R = slide.frames[0].R @ slide.frames[1].R.T
    part = TAKEN * carried.inertia.J
    carried.inertia = replace(carried.inertia, J=carried.inertia.J - part)
    return replace(held, J=held.J + R @ part @ R.T)


def _last_resort(robot: Robot, body: Body) -> Inertia:
    """A little mass, which changes the motion as little."""
    others = [other.inertia for other in robot.bodies.values() if other.inertia.mass > 0]
    mass = LAST_RESORT * (min(other.mass for other in others) if others else 1.0)
    size = min((float(np.trace(other.J)) / other.mass for other in others), default=1.0)
    robot.tell(f"{body.name}: has no mass between joints that need some; it has {mass:.3g} kg now")
    robot.changed.append(body.name)
    return Inertia(mass, np.zeros(3), mass * size / 3 * np.eye(3))


def make_possible(robot: Robot, body: Body) -> None:
    """An inertia that no body can have is changed."""
    inertia = body.inertia
    if inertia.is_possible() and not _is_point(inertia):
        return
    moments = ", ".join(f"{moment:.4g}" for moment in np.linalg.eigvalsh(inertia.J))
    J = nearest_possible(inertia.J)
    if _is_point(inertia):
        J = inertia.mass * 1e-6 * np.eye(3)  # a ball of 1.6 mm
    body.inertia = replace(inertia, J=J)
    robot.changed.append(body.name)
    new = ", ".join(f"{moment:.4g}" for moment in np.linalg.eigvalsh(J))
    robot.tell(f"{body.name}: no body has the principal moments {moments} kg m²; they are {new} now")


def _is_point(inertia: Inertia) -> bool:
    """Whether its inertia is nothing but rounding."""
    return bool(np.abs(inertia.J).max() <= ROUNDING * inertia.mass * (1e-6 + inertia.center @ inertia.center))
