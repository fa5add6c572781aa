"""What the tests of importers share."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from research.robots import State, accelerations, slave_at, without_one_sided
from sigmafmu.importers.convert import convert
from sigmafmu.importers.robot import DescriptionError, Robot
from sigmafmu.mechanism_file.load import MechanismFile, load_text


def converted(folder: Path, text: str, base: str | None = None) -> tuple[dict[str, Any], Robot, MechanismFile]:
    """The content of the mechanism file, the robot and what the loader makes of it."""
    path = folder / "robot.xml"
    path.write_text(text, encoding="utf-8")
    written, robot = convert(path, folder, base)
    return yaml.safe_load(written), robot, load_text(written, folder / "robot.yaml")


def refusal(folder: Path, text: str) -> str:
    """The message about a description, without its path."""
    try:
        converted(folder, text)
    except DescriptionError as error:
        return str(error).removeprefix(str(folder / "robot.xml"))
    raise AssertionError("this should have been refused:\n" + text)


def accelerations_at(folder: Path, text: str, state: State, base: str | None = None) -> np.ndarray:
    """Of the state's coordinates, then of its bodies, by a converted robot."""
    path = folder / "robot.xml"
    path.write_text(text, encoding="utf-8")
    content = without_one_sided(convert(path, folder, base)[0])
    return accelerations(slave_at(content, state), content, state.coordinates, state.bodies)


def degrees(file: MechanismFile) -> int:
    from sigmafmu import _core

    return _core.freedom(file.mechanism.multibody).degrees


def told(robot: Robot, start: str) -> str:
    """The only sentence that begins so."""
    (found,) = (text for text in robot.told if text.startswith(start))
    return found
