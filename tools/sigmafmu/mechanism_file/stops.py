"""How stiff stops are that do not say it: their coordinate would swing on them with a period that fits the step.

With the inertia m that a force on the coordinate feels, all other joints holding, the stiffness is m (2 pi / T)^2. Then
T is what a run has to resolve, whatever the mechanism's size, and a weight that the coordinate lifts sinks in alike.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path

from sigmafmu import native
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

PERIOD = 0.02
"""T [s]."""
DIGITS = 2
"""Of the stiffness: nobody should take it for exact."""
HELD = 1e-10
"""Acceleration per force, of that of free bodies: with less a coordinate cannot move, and needs no stop."""


def with_stiff_stops(content: Json, resources: Path, joints: Mapping[str, Record]) -> Json:
    """The definition, at its start, with the stiffness of all its stops; raises RuntimeError with the core's sentence.

    The modal data are in the folder `resources`.
    """
    open_ones = [stop for stop in content.get("joint_stops", []) if "stop_stiffness" not in stop]
    if not open_ones:
        return content
    first, count = {}, 0
    for name, joint in joints.items():
        first[name] = count
        count += len(JOINT_TYPES[joint["type"]].coordinates)
    bodies = {body["name"]: body for body in content["bodies"] if "mass" in body}

    def stiffness(stop: Json, gain: float) -> float:
        joint = joints[stop["joint"]]
        turns = JOINT_TYPES[joint["type"]].coordinates[stop["coordinate"]].turns
        ends = [bodies[name] for name in joint["bodies"] if name in bodies]
        free = sum(1 / (max(body["inertia"].values()) if turns else body["mass"]) for body in ends)
        return float(f"{(2 * math.pi / PERIOD) ** 2 / gain:.{DIGITS}g}") if gain > HELD * free else 0.0

    gains = native.mobility(
        json.dumps(content), resources, [first[stop["joint"]] + stop["coordinate"] for stop in open_ones]
    )
    found = iter([stiffness(stop, gain) for stop, gain in zip(open_ones, gains, strict=True)])
    filled = [
        stop if "stop_stiffness" in stop else stop | {"stop_stiffness": next(found)} for stop in content["joint_stops"]
    ]
    return {**content, "joint_stops": filled}
