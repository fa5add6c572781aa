"""Reads XML descriptions: elements with their lines, numbers and poses in them, and what is wrong with them."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from lxml import etree

from sigmafmu.importers.inertia import Pose
from sigmafmu.importers.robot import DescriptionError
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.problems import one_line, shown

LARGEST_FILE = 50_000_000
"""Bytes."""


class Element:
    """An element of a file, which complains with its line."""

    def __init__(self, node: etree._Element, path: Path):
        self.node, self.path = node, path

    @property
    def tag(self) -> str:
        """Its name, without a name space."""
        return etree.QName(self.node).localname

    def error(self, text: str) -> DescriptionError:
        """What is wrong here, and what is allowed."""
        return DescriptionError(f"{self.path}:{self.node.sourceline}: {one_line(text)}")

    def children(self, tag: str | None = None) -> Iterator["Element"]:
        """Elements directly below, of a name or of all."""
        found = (Element(node, self.path) for node in self.node.iterchildren("*"))
        return (child for child in found if tag in (None, child.tag))

    def child(self, tag: str) -> "Element | None":
        """The first of a name."""
        return next(self.children(tag), None)

    def get(self, name: str, default: str | None = None) -> str:
        """An attribute; DescriptionError: it is missing and has no default."""
        value = self.node.get(name, default)
        if value is None:
            raise self.error(f"<{self.tag}> has no {name}; it must have one")
        return value

    def text(self) -> str:
        """What is between its tags."""
        return (self.node.text or "").strip()

    def numbers(self, name: str, count: int, default: str | None = None) -> np.ndarray:
        """The numbers of an attribute."""
        return self.parsed(self.get(name, default), count, f"{name} of <{self.tag}>")

    def number(self, name: str, default: str | None = None) -> float:
        """The number of an attribute."""
        return float(self.numbers(name, 1, default)[0])

    def parsed(self, text: str, count: int, what: str) -> np.ndarray:
        """Finite numbers with spaces between."""
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        if len(values) != count or not all(map(math.isfinite, values)):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers with spaces between"
            raise self.error(f"{what} is {shown(text)}; it must be {wanted}")
        return np.array(values)


def read(path: Path) -> Element:
    """The root; DescriptionError: it cannot be read or is no XML."""
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise DescriptionError(f"{path}: has more than {LARGEST_FILE} bytes; that is the most")
        parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
        root = etree.parse(path, parser).getroot()
    except OSError as error:
        raise DescriptionError(f"{path}: cannot be read: {error.strerror or one_line(str(error))}") from error
    except etree.XMLSyntaxError as error:
        raise DescriptionError(f"{path}:{error.lineno or 1}: is no XML: {one_line(error.msg or '')}") from error
    return Element(root, path)


def pose_of_rpy(p: np.ndarray, rpy: np.ndarray) -> Pose:
    """An origin, and Rz(yaw) Ry(pitch) Rx(roll)."""
    return Pose(p, rotations.matrix(rotations.of_orientation({"rpy": rpy})))


def axes_with_z(axis: np.ndarray) -> np.ndarray:
    """Axes whose z is a direction: turned about x or y of the old ones where that is enough."""
    z = axis / np.linalg.norm(axis)
    across = np.array([-z[1], z[0], 0.0])  # z of the old axes x the new z
    sine = float(np.linalg.norm(across))
    if sine < 1e-15:
        return np.eye(3) if z[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return rotations.matrix(rotations.of_vector(across / sine * math.atan2(sine, z[2])))


def color_of(rgba: np.ndarray) -> str:
    """As a mechanism file has it."""
    return "#" + "".join(f"{round(255 * float(min(max(x, 0), 1))):02x}" for x in rgba[:3])
