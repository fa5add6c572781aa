"""Shapes that URDF and SDF have alike, which differ in how they write numbers."""

from collections.abc import Callable
from typing import Any

import numpy as np

from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.robot import Robot
from sigmafmu.importers.xml import Element

Numbers = Callable[[Element, str, int, str], np.ndarray]
"""Numbers of a form by name, with how many they are and what holds without them."""


def shape_keys(
    form: Element, uri: str, numbers: Numbers, meshes: Meshes, robot: Robot, link: str
) -> dict[str, Any] | None:
    """The keys of a shape in a mechanism file; None: there is no such shape, which has been told."""

    def number(name: str, default: str) -> float:
        return float(numbers(form, name, 1, default)[0])

    keys: dict[str, Any]
    if form.tag == "box":
        keys = {"box": numbers(form, "size", 3, "1 1 1")}
    elif form.tag == "sphere":
        keys = {"sphere": number("radius", "1")}
    elif form.tag in ("cylinder", "capsule"):
        keys = {"cylinder": {"radius": number("radius", "0.5"), "length": number("length", "1")}}
    elif form.tag == "mesh" and uri:
        path, scale = meshes.path(uri), numbers(form, "scale", 3, "1 1 1")
        if not path:
            return None
        if np.ptp(scale) > 1e-9 or scale[0] <= 0:
            robot.tell(f"{link}: the scale of a mesh differs by axis, here it is {abs(scale[0]):g}")
        keys = {"mesh": path} | ({"scale": abs(scale[0])} if abs(scale[0]) != 1 else {})
    else:
        robot.tell(f"shapes of the kind {form.tag}")
        return None
    sizes = [*np.atleast_1d(keys.get("box", 1)), keys.get("sphere", 1), *keys.get("cylinder", {}).values()]
    if min(sizes) <= 0 or keys.get("scale", 1) <= 0:
        robot.tell(f"{link}: a shape without size")
        return None
    return keys
