"""From a description of a robot to the text of a mechanism file."""

from pathlib import Path

from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.reduce import reduce
from sigmafmu.importers.robot import DescriptionError, Robot, rename
from sigmafmu.importers.write import mechanism_text
from sigmafmu.importers.xml import read


def convert(path: Path, folder: Path, base: str | None = None) -> tuple[str, Robot]:
    """The text of the mechanism file that is to be in `folder`, and the robot in it; DescriptionError.

    `base` is `fixed` or `free` for the root of a URDF file.
    """
    root, meshes = read(path), Meshes(path, folder)
    if base and root.tag != "robot":
        raise root.error("whether the base is fixed is only asked of URDF; MJCF and SDF say it themselves")
    if root.tag == "robot":
        from sigmafmu.importers.urdf import read_urdf

        robot = read_urdf(root, meshes, base)
    elif root.tag == "mujoco":
        from sigmafmu.importers.mjcf import read_mjcf

        robot = read_mjcf(path, meshes)
    elif root.tag == "sdf":
        from sigmafmu.importers.sdf import read_sdf

        robot = read_sdf(root, meshes)
    else:
        raise root.error(f"the root is <{root.tag}>; it must be <robot> (URDF), <mujoco> (MJCF) or <sdf>")
    reduce(robot)
    rename(robot)
    if not robot.bodies:
        raise DescriptionError(f"{path}: nothing moves; a mechanism needs a body with mass and a joint or a free base")
    return mechanism_text(robot), robot
