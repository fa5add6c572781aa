"""What a mechanism file says → the normalised definition: plain data, as FMUs carry it.

Bodies sit in their centres of mass there, points and axes are in bodies, numbers are SI.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.checks import inertia_matrix
from sigmafmu.mechanism_file.placement import Frame, Placement, Pose, coordinates, motion
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.coordinates import ACTING
from sigmafmu.mechanism_file.table.ends import GROUND, End
from sigmafmu.mechanism_file.table.forces import FORCE_TYPES
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES
from sigmafmu.mechanism_file.table.mechanism import VERSION
from sigmafmu.mechanism_file.table.outputs import SENSOR_ENDS
from sigmafmu.mechanism_file.table.prescribed import COUPLING_TYPES, INPUT, MOTIONS, MOVING, PARAMETERS

Json = dict[str, Any]

STANDARD_GRAVITY = [0.0, 0.0, -9.81]
REQUIRED = ("bodies", "joints")
"""Lists that the definition has even if they are empty."""
ANY_DIRECTION = ("spherical", "distance")
"""Joints whose frames have no direction: these have the axes of their bodies."""
DIRECTIONS = ("axis", "normal")
"""Keys in W that are the z axis of frames."""


def definition(file: Record, placement: Placement, modes: Mapping[str, int]) -> Json:
    """The definition of a whole file; `modes` has the number of modes of each file of modal data."""
    joints = file.get("joints", {})
    result: Json = {
        "sigmafmu": VERSION,
        "name": file["name"],
        "description": file.get("description", ""),
        "gravity": file.get("gravity", STANDARD_GRAVITY),
        "bodies": [_body(name, body, placement[name], modes) for name, body in file["bodies"].items()],
        "joints": [_joint(name, joint, placement) for name, joint in joints.items()],
        "loads": [{"name": name, **load} for name, load in file.get("loads", {}).items()],
        "forces": [_force(name, force, placement) for name, force in file.get("forces", {}).items()],
        "tendons": [_tendon(name, tendon, joints) for name, tendon in file.get("tendons", {}).items()],
        **{kind: [entry for name, joint in joints.items() for entry in _acting(kind, name, joint)] for kind in ACTING},
        "rotation_motors": [{"joint": name} for name, joint in joints.items() if joint.get("motor")],
        "drives": [_drive(name, drive, joints) for name, drive in file.get("drives", {}).items()],
        "couplings": [_coupling(name, coupling, joints) for name, coupling in file.get("couplings", {}).items()],
        "motions": [_motion(name, motion) for name, motion in file.get("motions", {}).items()],
        "stations": [{"name": name, **station} for name, station in file.get("stations", {}).items()],
        "sensors": [_sensor(name, sensor, placement) for name, sensor in file.get("sensors", {}).items()],
        "integrator": file.get("integrator", {}),
        "experiment": file.get("experiment", {}),
    }
    expose = file.get("expose", "auto")
    if expose != "auto":
        result["expose"] = {key: ["*"] for key in ("inputs", "outputs", "parameters")} if expose == "all" else expose
    return {key: value for key, value in result.items() if value != [] or key in REQUIRED}


def _list(array: np.ndarray) -> list:
    return (np.asarray(array) + 0.0).tolist()  # no negative zeros


def _body(name: str, body: Record, pose: Pose, modes: Mapping[str, int]) -> Json:
    result: Json = {"name": name, "description": body.get("description", "")}
    if "flexible" in body:
        file = modal_file(body)
        more = body["flexible"] if isinstance(body["flexible"], dict) else {}
        result["flexible"] = {**more, "file": file.rsplit("/", 1)[-1], "modes": modes[file]}
    else:
        R = rotations.matrix(rotations.of_orientation(body.get("inertia_axes")))
        J = inertia_matrix(body["inertia"])
        J = R @ J @ R.T if "inertia_axes" in body else J
        elements = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        result["mass"] = body["mass"]
        result["inertia"] = {key: float(J[at]) for key, at in elements.items()}
    return result | {
        "position": _list(pose.position),
        "orientation": {"quaternion": _list(pose.quaternion)},
        "velocity": _list(pose.velocity),
        "angular_velocity": _list(pose.angular_velocity),
    }


def modal_file(body: Record) -> str:
    """The file of a flexible body's modal data, as the mechanism file names it."""
    flexible = body["flexible"]
    return flexible["file"] if isinstance(flexible, dict) else flexible


def _fixed(origin: np.ndarray, axes: np.ndarray) -> Frame:
    return Frame(origin, axes, None, origin, axes)


def _frame(frame: Frame) -> Json:
    node = {} if frame.node is None else {"node": frame.node}
    return {"position": _list(frame.origin), "orientation": {"matrix": _list(frame.axes)}, **node}


def _joint(name: str, joint: Record, placement: Placement) -> Json:
    ends = JOINT_TYPES[joint["type"]].ends
    first, second = joint["bodies"]
    if any(end.frame in joint for end in ends):
        frames = _attached(joint, ends, placement)
    else:
        pair = _frames_in_w(joint, placement[first], placement[second])
        frames = {end.frame: _frame(frame) for end, frame in zip(ends, pair, strict=True)}
    more = {key: joint[key] for key in ("length", "pitch", "radius", "reaction") if key in joint}
    return {"name": name, "type": joint["type"], "bodies": joint["bodies"], **frames, **more}


def _frames_in_w(joint: Record, first: Pose, second: Pose) -> tuple[Frame, Frame]:
    """The frames of a joint whose geometry is in W: they differ by its coordinates.

    Frame 2 is at the point; displacements count from where frame 1 is then.
    """
    x, rates = coordinates(joint)
    turn, shift, _, _ = motion(joint["type"], x, rates)
    if "axis1" in joint:  # the cross has y of frame 1 and x of frame 2
        across = np.cross(joint["axis2"], joint["axis1"])
        across /= np.linalg.norm(across)
        axes1 = np.column_stack([np.cross(joint["axis1"], across), joint["axis1"], across]) @ _about(1, -x[0])
        axes2 = np.column_stack([joint["axis2"], np.cross(across, joint["axis2"]), across]) @ _about(0, x[1])
    elif "normal" in joint and "axis" in joint:  # of a plane and of a disk
        axes1, axes2 = (rotations.axes_with_z(np.array(joint[key])) for key in ("normal", "axis"))
    else:
        axes1 = _axes_in_w(joint)
        axes2 = axes1 @ turn
    points = [np.array(joint[key]) for key in ("point1", "point2") if key in joint] or [np.array(joint["point"])]
    origins = first.to_body(points[0] - axes1 @ shift), second.to_body(points[-1])
    turned = (axes1, axes2) if joint["type"] in ANY_DIRECTION else (first.R.T @ axes1, second.R.T @ axes2)
    one, two = (_fixed(origin, axes) for origin, axes in zip(origins, turned, strict=True))
    return one, two


def _acting(kind: str, name: str, joint: Record) -> Iterator[Json]:
    """What acts on the coordinates of a joint, of one list of the definition."""
    for i, c in enumerate(JOINT_TYPES[joint["type"]].coordinates):
        given: Json = {}
        for key in ACTING[kind]:
            value = joint.get(c.key(key.word))
            if value is not None:
                given |= dict(zip(key.into or (key.word,), value if key.into else (value,), strict=True))
        if given:
            yield {"joint": name, "coordinate": i, **given}


def _axes_in_w(element: Record) -> np.ndarray:
    """Axes of W that geometry there asks for: z is a direction if there is one."""
    direction = next((element[key] for key in DIRECTIONS if key in element), None)
    if direction is not None:
        return rotations.axes_with_z(np.array(direction))
    return rotations.matrix(rotations.of_orientation(element.get("orientation")))


def _about(axis: int, angle: float) -> np.ndarray:
    return rotations.matrix(rotations.of_vector(angle * np.eye(3)[axis]))


def _force(name: str, force: Record, placement: Placement) -> Json:
    kind = FORCE_TYPES[force["type"]]
    bodies = {key: force[key] for key in (kind.bodies.name,)}
    numbers = {key.name: force[key.name] for key in kind.keys if key.name in force}
    return {"name": name, "type": force["type"], **bodies, **_attached(force, kind.ends, placement), **numbers}


def _sensor(name: str, sensor: Record, placement: Placement) -> Json:
    result = {"name": name, **sensor, **_attached(sensor, SENSOR_ENDS, placement)}
    if "reference_frame" in sensor:
        result["reference_frame"] = _frame(placement.frame(sensor.get("reference", GROUND), sensor["reference_frame"]))
    return {key: value for key, value in result.items() if key not in SENSOR_ENDS[0].in_w}


def _attached(element: Record, ends: Sequence[End], placement: Placement) -> Json:
    """Frames and points of an element in its bodies."""
    bodies = element["bodies"] if "bodies" in element else [element["body"]]
    result: Json = {}
    for end in ends:
        body = bodies[end.body]
        if end.many:
            points = element[end.in_w[0]]
            result[end.in_w[0]] = [_list(placement[body].to_body(np.array(point))) for point in points]
            continue
        if any(key in element for key in end.in_w):
            frame = _frame_in_w(element, end.in_w, placement[body])
        else:
            frame = placement.frame(body, element.get(end.frame))
        if end.is_frame:
            result[end.frame] = _frame(frame)
        else:
            point = end.in_w[0]
            result[point] = _list(frame.origin)
            if frame.node is not None:
                result[point.replace("point", "node")] = frame.node
    return result


def _frame_in_w(element: Record, in_w: Sequence[str], pose: Pose) -> Frame:
    """A frame of a body that the file gives in W: z is the direction, if there is one."""
    axes = _axes_in_w(element)
    origin = pose.to_body(np.array(element[in_w[0]]))
    return _fixed(origin, pose.R.T @ axes)


def split_coordinate(name: str, joints: Mapping[str, Record]) -> tuple[str, int]:
    """Joint and coordinate of `joint` or `joint.angle`."""
    if name in joints:
        return name, 0
    joint, _, word = name.rpartition(".")
    words = [c.word for c in JOINT_TYPES[joints[joint]["type"]].coordinates]
    return joint, words.index(word)


def _drive(name: str, drive: Record, joints: Mapping[str, Record]) -> Json:
    joint, coordinate = split_coordinate(name, joints)
    result = {"joint": joint, "coordinate": coordinate, "motion": drive["motion"]}
    if "table" in drive:
        return result | {"table": _table(drive["table"])}
    if drive["value"] == INPUT:
        return result | {"value": 0.0, "input": True}
    return result | {"value": drive["value"]}


def _table(points: tuple[list[float], list[float]]) -> Json:
    return dict(zip(("times", "values"), points, strict=True))


def _motion(name: str, motion: Record) -> Json:
    axes = rotations.matrix(rotations.of_orientation(motion.get("orientation")))
    return {
        "name": name,
        "position": motion.get("position", [0.0, 0.0, 0.0]),
        "orientation": {"matrix": _list(axes)},
        **({"input": True} if motion.get("input") else {}),
        **{key: _table(motion[key]) for key in MOVING if key in motion},
    }


def _tendon(name: str, tendon: Record, joints: Mapping[str, Record]) -> Json:
    terms = []
    for coordinate, coefficient in zip(tendon["joints"], tendon["coefficients"], strict=True):
        joint, index = split_coordinate(coordinate, joints)
        terms.append({"joint": joint, "coordinate": index, "coefficient": coefficient})
    numbers = {key: tendon[key] for key in ("stiffness", "damping", "free_length") if key in tendon}
    return {"name": name, "terms": terms, **numbers}


def _coupling(name: str, coupling: Record, joints: Mapping[str, Record]) -> Json:
    kind = COUPLING_TYPES[coupling["type"]]
    terms = []
    for coordinate, polynomial in zip(coupling["joints"], kind.polynomials(coupling), strict=True):
        joint, index = split_coordinate(coordinate, joints)
        terms.append({"joint": joint, "coordinate": index, "polynomial": polynomial})
    offset = kind.offset(coupling)
    type_ = {"type": coupling["type"]} if coupling["type"] in PARAMETERS else {}
    return {"name": name, **type_, "terms": terms, **({} if offset is None else {"offset": offset})}


def value_dimension(name: str, drive: Record, joints: Mapping[str, Record]) -> str:
    """The dimension of a drive's value."""
    joint, coordinate = split_coordinate(name, joints)
    return JOINT_TYPES[joints[joint]["type"]].coordinates[coordinate].dimension(*MOTIONS[drive["motion"]])
