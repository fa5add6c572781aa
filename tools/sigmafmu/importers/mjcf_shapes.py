"""Shapes of MJCF: what is drawn of bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmafmu.importers.inertia import Pose
from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.robot import GROUND, Robot, Shape
from sigmafmu.importers.xml import color_of
from sigmafmu.mechanism_file import rotations

if TYPE_CHECKING:
    import mujoco


def add_shapes(m: mujoco.MjModel, bodies: Sequence[str], robot: Robot, meshes: Meshes) -> None:
    """Those that are seen alone; of a body without such, those that collide."""
    for i, name in enumerate(bodies):
        if name == GROUND:
            continue
        geoms = range(m.body_geomadr[i], m.body_geomadr[i] + m.body_geomnum[i])
        seen = [g for g in geoms if not (m.geom_contype[g] or m.geom_conaffinity[g])]
        for g in seen or geoms:
            color = m.mat_rgba[m.geom_matid[g]] if m.geom_matid[g] >= 0 else m.geom_rgba[g]
            for shape in _shapes(m, g, robot, meshes):
                shape.keys["color"] = color_of(color)
                robot.bodies[name].shapes.append(shape)


def _shapes(m: mujoco.MjModel, g: int, robot: Robot, meshes: Meshes) -> Iterator[Shape]:
    import mujoco

    kinds = mujoco.mjtGeom
    kind, size = kinds(m.geom_type[g]), [float(x) for x in m.geom_size[g]]
    place = Pose(np.array(m.geom_pos[g]), rotations.matrix(np.array(m.geom_quat[g])))
    keys: dict[str, Any]
    if kind == kinds.mjGEOM_SPHERE:
        keys = {"sphere": size[0]}
    elif kind in (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE):
        keys = {"cylinder": {"radius": size[0], "length": 2 * size[1]}}
        if kind == kinds.mjGEOM_CAPSULE:
            for side in (-1, 1):
                yield Shape({"sphere": size[0]}, place @ Pose(np.array([0, 0, side * size[1]])))
    elif kind == kinds.mjGEOM_BOX:
        keys = {"box": [2 * x for x in size]}
    elif kind == kinds.mjGEOM_ELLIPSOID:
        robot.tell("ellipsoids: drawn as boxes")
        keys = {"box": [2 * x for x in size]}
    elif kind == kinds.mjGEOM_MESH:
        mesh = int(m.geom_dataid[g])
        uri = _path(m, mesh)
        if not uri:
            robot.tell("meshes without a file")
        if not uri or not (path := meshes.path(uri)):
            return
        # the compiler has moved the mesh into its principal axes
        moved = Pose(np.array(m.mesh_pos[mesh]), rotations.matrix(np.array(m.mesh_quat[mesh])))
        place, keys = place @ moved.inverse(), {"mesh": path}
        scale = np.abs(m.mesh_scale[mesh])
        if np.ptp(m.mesh_scale[mesh]) > 1e-9 or scale[0] != m.mesh_scale[mesh][0]:
            robot.tell(f"the scale of a mesh differs by axis, here it is {scale[0]:g}")
        if scale[0] != 1:
            keys["scale"] = float(scale[0])
    else:
        robot.tell(f"shapes of the kind {kind.name.removeprefix('mjGEOM_').lower()}")
        return
    yield Shape(keys, place)


def _path(m: mujoco.MjModel, mesh: int) -> str:
    """The file of a mesh, as the model has it."""
    start = int(m.mesh_pathadr[mesh])
    return bytes(m.paths)[start:].split(b"\0", 1)[0].decode(errors="replace") if start >= 0 else ""
