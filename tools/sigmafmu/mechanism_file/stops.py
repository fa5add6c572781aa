"""How stiff stops are that do not say it: their coordinate would swing on them with a period that fits the step.

With the inertia m that a force on the coordinate feels, all other joints holding, the stiffness is m (2 pi / T)^2. Then
T is what a run has to resolve, whatever the mechanism's size, and a weight that the coordinate lifts sinks in alike.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from sigmafmu import _core
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

PERIOD = 0.02
"""T [s]."""
DIGITS = 2
"""Of the stiffness: nobody should take it for exact."""
HELD = 1e-10
"""Acceleration per force, of that of free bodies: with less a coordinate cannot move, and needs no stop."""


def with_stiff_stops(content: Json, mechanism: Any, joints: Mapping[str, Record]) -> Json:
    """The definition with the stiffness of all its stops; `mechanism` is that of the definition, where it starts."""
    stops = content.get("joint_stops", [])
    if all("stop_stiffness" in stop for stop in stops):
        return content
    q, v = _core.assemble(mechanism.multibody)
    system, inputs = _core.System(mechanism.multibody), list(_core.Outputs(mechanism).inputs)
    at_rest = system.accelerations(q, v, np.zeros(system.input_size))[0]
    indices = {name: i for i, name in enumerate(joints)}
    bodies = {body["name"]: body for body in content["bodies"] if "mass" in body}

    def stiffness(stop: Json) -> float:
        joint, c = stop["joint"], stop["coordinate"]
        coordinate = JOINT_TYPES[joints[joint]["type"]].coordinates[c]
        u = np.zeros(system.input_size)
        u[inputs.index(f"{joint}.{coordinate.dimension('motorTorque', 'actuatorForce')}{coordinate.number}")] = 1
        moved = system.accelerations(q, v, u)[0]
        found = [system.coordinate_acceleration(q, v, vdot, indices[joint], c) for vdot in (moved, at_rest)]
        gain = found[0] - found[1]
        ends = [bodies[name] for name in joints[joint]["bodies"] if name in bodies]
        free = sum(1 / (max(body["inertia"].values()) if coordinate.turns else body["mass"]) for body in ends)
        return float(f"{(2 * math.pi / PERIOD) ** 2 / gain:.{DIGITS}g}") if gain > HELD * free else 0.0

    filled = [stop if "stop_stiffness" in stop else stop | {"stop_stiffness": stiffness(stop)} for stop in stops]
    return {**content, "joint_stops": filled}
