"""Sensors beside those of MuJoCo, on the second link of a moving arm."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from research.bench.trees import mujoco_model, text
from research.elements.joints import arm
from research.elements.parts import AXES
from sigmafmu import _core

PLACES = {"b": np.array([0.1, -0.05, 0.2]), "a": np.array([0.05, 0.1, 0.0])}
"""Of the sensor in the second link, of the observer in the first."""
THERE = {
    ("imu", "specificForce"): ("accelerometer", {}),
    ("imu", "angularVelocity"): ("gyro", {}),
    ("motion", "position"): ("framepos", {"reftype": "site", "refname": "a"}),
    ("motion", "velocity"): ("framelinvel", {"reftype": "site", "refname": "a"}),
    ("motion", "angularVelocity"): ("frameangvel", {"reftype": "site", "refname": "a"}),
}
"""Sensor and output of ours → what measures the same in MuJoCo."""
RATES = np.array([1.5, -2.0])
"""Of both hinges [rad/s]."""


def _arm() -> _core.Mechanism:
    m = arm()
    d = m.multibody
    axes = [joint.frame1.axes[:, 2] for joint in d.joints]
    first = RATES[0] * axes[0]
    both = first + RATES[1] * axes[1]
    joint = np.array([0.4, 0.0, 0.0])
    for i, (w, v) in enumerate(
        (
            (first, np.cross(first, d.body(0).initial_position)),
            (both, np.cross(first, joint) + np.cross(both, d.body(1).initial_position - joint)),
        )
    ):
        d.body(i).initial_velocity, d.body(i).initial_angular_velocity = v, w
    frames = {name: _core.Frame(place, AXES) for name, place in PLACES.items()}
    m.add(_core.Sensor("imu", _core.SensorType.imu, 1, frames["b"]))
    m.add(_core.Sensor("motion", _core.SensorType.motion, 1, frames["b"], 0, frames["a"]))
    return m


def compare() -> list[dict[str, str | float]]:
    """A row for each output: the largest difference over its components, in its unit."""
    import mujoco as mj

    quaternion = text(Rotation.from_matrix(AXES).as_quat(scalar_first=True))

    def edit(root: ElementTree.Element) -> None:
        for name, place in PLACES.items():
            body = root.find(f".//body[@name='{name}']")
            assert body is not None
            ElementTree.SubElement(body, "site", name=name, pos=text(place), quat=quaternion)
        sensors = ElementTree.SubElement(root, "sensor")
        for kind, more in THERE.values():
            on_site = {"objtype": "site", "objname": "b"} if more else {"site": "b"}
            ElementTree.SubElement(sensors, kind, on_site | more)

    m = _arm()
    model, rates = mujoco_model(m.multibody, edit)
    data = mj.MjData(model)
    data.qvel[:] = rates
    mj.mj_forward(model, data)
    slave = _core.Slave(m)
    slave.start()
    rows: list[dict[str, str | float]] = []
    for ((sensor, output), (there, _)), values in zip(THERE.items(), data.sensordata.reshape(-1, 3), strict=True):
        found = np.array([slave.get(f"{sensor}.{output}[{i}]") for i in (1, 2, 3)])
        size = float(np.abs(values).max())
        rows.append({"sensor": sensor, "output": output, "there": there, "size": size})
        rows[-1]["difference"] = float(np.abs(found - values).max())
    return rows
