"""Mechanisms of no FMU for the tests of drawings, as `mechanism.json` has them."""

import numpy as np

TYPES = (
    "spherical",
    "revolute",
    "universal",
    "prismatic",
    "fixed",
    "cylindrical",
    "planar",
    "distance",
    "point_on_line",
    "free",
    "ratchet",
)
"""The last is none that there is."""


def body(name, position, inertia=(0.02, 0.05, 0.04), mass=1.5, quaternion=(1, 0, 0, 0), **more):
    xx, yy, zz = inertia
    return {
        "name": name,
        "mass": mass,
        "inertia": {"xx": xx, "yy": yy, "zz": zz},
        "position": [float(x) for x in position],
        "orientation": {"quaternion": list(quaternion)},
        **more,
    }


def joint(name, kind, bodies, point1, point2, matrices=((), ())):
    frames = [
        {"position": [float(x) for x in point], "orientation": {"matrix": matrix or np.eye(3).tolist()}}
        for point, matrix in zip((point1, point2), matrices, strict=True)
    ]
    return {"name": name, "type": kind, "bodies": list(bodies), "frame1": frames[0], "frame2": frames[1]}


def rotation(q):
    w, u = q[0], np.asarray(q[1:])
    return (w * w - u @ u) * np.eye(3) + 2 * np.outer(u, u) + 2 * w * np.cross(np.eye(3), u)


def random_tree(seed, count=12):
    """An assembled tree of bodies with joints of every type, springs, a load and what acts on a joint."""
    random = np.random.default_rng(seed)
    names, places, turns = ["ground"], [np.zeros(3)], [np.eye(3)]
    bodies, joints = [], []
    for i in range(count):
        parent = int(random.integers(max(0, i - 3), i + 1))
        q = random.normal(size=4)
        q /= np.linalg.norm(q)
        R, axes = rotation(q), rotation(np.array([0.8, 0.0, 0.6, 0.0]))
        kind = TYPES[i % len(TYPES)]
        point1, point2 = random.normal(size=3) * 0.25, random.normal(size=3) * 0.25
        gap = {"prismatic": 0.2, "cylindrical": -0.2, "distance": 0.3, "point_on_line": 0.2, "free": 0.3}.get(kind, 0.0)
        place = places[parent] + turns[parent] @ (point1 + gap * axes[:, 2]) - R @ point2
        inertia = np.sort(random.uniform(0.005, 0.02, 3)) + 0.003
        name = f"body{i + 1}"
        bodies.append(body(name, place, inertia, float(random.uniform(0.8, 3)), q))
        matrices = axes.tolist(), (R.T @ turns[parent] @ axes).tolist()
        joints.append(joint(f"joint{i + 1}", kind, (names[parent], name), point1, point2, matrices))
        names, places, turns = [*names, name], [*places, place], [*turns, R]
    coil = {"type": "spring_damper", "point1": [0.1, 0.2, 0.9], "point2": [0, 0, 0.1], "stiffness": [10.0, 10.0, 10.0]}
    forces = [
        {"name": "coil", "bodies": ["ground", "body2"], **coil},
        {"name": "between", "bodies": ["body3", "body4"], **coil},
        {"name": "torsion", "type": "coordinate_spring", "joint": "joint2", "stiffness": 2.0},
        *forces_of_all_types("body5", "body6"),
    ]
    load = {"name": "push", "body": "body1", "force": [0.0, 5.0, 0.0], "torque": [0.0, 0.0, 0.0]}
    tree = {"bodies": bodies, "joints": joints, "forces": forces, "loads": [load], "gravity": [0.0, 0.0, -9.81]}
    tree["sensors"] = [{"name": "imu", "type": "imu", "body": "body7", "frame": {"position": [0.1, 0.0, 0.1]}}]
    tree["sensors"].append({"name": "eye", "type": "motion", "body": "ground", "reference": "body7"})
    return tree


def forces_of_all_types(one, two):
    """Between two bodies, or on the second."""
    turned = {"orientation": {"matrix": rotation(np.array([0.8, 0.0, 0.6, 0.0])).tolist()}}
    points = {"bodies": [one, two], "point1": [0.1, 0.0, 0.0], "point2": [0.0, 0.3, 0.0]}
    frames = {"bodies": [one, two], "frame1": {"position": [0.1, 0.0, 0.0], **turned}, "frame2": turned}
    return [
        {"name": "leg", "type": "line_spring", "stiffness": 5.0, **points},
        {"name": "curve", "type": "table_spring", "length": [0.0, 1.0], "force": [0.0, 9.0], **points},
        {"name": "coil2", "type": "torsion_spring", "stiffness": 5.0, **frames},
        {"name": "pad", "type": "bushing", "stiffness": [5.0, 5.0, 5.0], **frames},
        {"name": "seal", "type": "bearing", "stiffness": [5.0, 5.0, 5.0], **frames},
        {"name": "air", "type": "drag", "body": two, "coefficient": [1.0, 1.0, 1.0]},
        {"name": "jet", "type": "follower_force", "body": two, "point": [0.0, 0.1, 0.0], "force": [0.0, 5.0, 0.0]},
        {"name": "floor", "type": "plane_contact", "bodies": ["ground", two], "radius": 0.2},
        {"name": "hit", "type": "sphere_contact", "radius1": 0.2, "radius2": 0.2, **points},
        {"name": "hull", "type": "cloud_contact", "bodies": ["ground", two], "points2": [[0, 0, 0]], "radius": 0.2},
    ]


def chain(count=50):
    """Links of 1 m that hang in an arc from the ground."""
    angles = np.linspace(-1.3, 0.9, count)
    ends = np.concatenate([[np.zeros(3)], np.cumsum([[np.cos(a), 0, np.sin(a)] for a in angles], axis=0)])
    bodies, joints = [], []
    for i, angle in enumerate(angles):
        turn = [np.cos(angle / 2), 0.0, -np.sin(angle / 2), 0.0]
        bodies.append(body(f"link{i + 1}", (ends[i] + ends[i + 1]) / 2, (0.001, 0.08, 0.08), 1.0, turn))
        joints.append(
            joint(
                f"pin{i + 1}",
                "spherical",
                ("ground" if i == 0 else f"link{i}", f"link{i + 1}"),
                [0.5 * (i > 0), 0, 0],
                [-0.5, 0, 0],
            )
        )
    return {"bodies": bodies, "joints": joints, "gravity": [0.0, 0.0, -9.81]}


def free_body():
    """A single body without joints."""
    return {"bodies": [body("stone", [3.0, 2.0, 1.0])]}


def wheel():
    """A disk without mass away from its hinge: nothing but its inertia tells how large it is."""
    disk = body("wheel", [0, 0, 0], (0.1, 0.1, 0.2), 2.0, angular_velocity=[0, 0, 5.0])
    return {"bodies": [disk], "joints": [joint("axle", "revolute", ("ground", "wheel"), [0, 0, 0], [0, 0, 0])]}


def block_on_a_rail():
    """A block, larger than its joints are apart, on an inclined rail, with a pendulum."""
    rail = rotation(np.array([np.cos(1.0), 0.0, np.sin(1.0), 0.0])).tolist()
    block = body("block", [0, 0, 0], (4e-3, 5e-3, 6e-3), 2.0)
    pendulum = body("pendulum", [0, 0, -0.25], (5e-3, 5e-3, 2e-4), 0.5)
    joints = [
        joint("rail", "prismatic", ("ground", "block"), (0, 0, 0), (0, 0, 0), (rail, rail)),
        joint("hook", "universal", ("block", "pendulum"), (0, 0, -0.035), (0, 0, 0.215)),
    ]
    return {"bodies": [block, pendulum], "joints": joints, "gravity": [0.0, 0.0, -9.81]}
