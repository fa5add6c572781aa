"""Reads a mechanism file: everything that is wrong with it at once, or a mechanism that starts."""

import json
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from sigmafmu import native
from sigmafmu.mechanism_file import tree
from sigmafmu.mechanism_file.assembly import Move, assemble
from sigmafmu.mechanism_file.checks import check_mimics
from sigmafmu.mechanism_file.definition import Json, definition, modal_file, value_dimension
from sigmafmu.mechanism_file.kinds import Context
from sigmafmu.mechanism_file.placement import Placement
from sigmafmu.mechanism_file.problems import MechanismFileError, Problems, shown
from sigmafmu.mechanism_file.stops import with_stiff_stops
from sigmafmu.mechanism_file.structures import Pending, Record
from sigmafmu.mechanism_file.table.ends import GROUND
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES
from sigmafmu.mechanism_file.table.mechanism import ELEMENTS, MECHANISM
from sigmafmu.mechanism_file.table.prescribed import prescribed
from sigmafmu.mechanism_file.tree import Node


@dataclass(frozen=True)
class MechanismFile:
    """A mechanism that was read from a file."""

    path: Path
    definition: Json
    """Normalised (definition.py): what an FMU carries."""
    resources: dict[str, Path]
    """Files that belong to it, by the names that the definition has for them."""
    shapes: dict[str, list[dict]]
    """What is drawn, by body: the key `shapes` of the file, in the body's frame; numbers are SI."""
    offsets: dict[str, list[float]]
    """Centres of mass in the bodies' frames of the file, which `shapes` count from [m]."""
    placed_by: dict[str, str]
    """Joints that placed bodies, by the body."""
    moves: tuple[Move, ...]
    """What had to move so that the mechanism can start."""

    @property
    def text(self) -> str:
        """The definition in JSON."""
        return json.dumps(self.definition)

    @cached_property
    def mechanism(self) -> Any:
        """The same as `_core.Mechanism`, with the modal data of its files; only where that is installed."""
        from sigmafmu import _core

        mechanism = _core.from_json(self.text)
        with folder_of(self.resources) as folder:
            _core.load_modal_files(mechanism, str(folder))
        mechanism.validate()
        return mechanism


def load(path: Path | str) -> MechanismFile:
    """Read a mechanism file; raises MechanismFileError with all that is wrong."""
    path = Path(path)
    return load_text(tree.read_text(path), path)


def load_text(text: str, path: Path | str) -> MechanismFile:
    """The same from a text, as if it were in the file `path`."""
    path = Path(path)
    root = tree.parse(text, path)
    problems = Problems(path)
    file = _read(root, problems)
    problems.stop()
    resources, data = _modal_data(file, path.parent, problems)
    problems.stop()
    nodes = {name: data[modal_file(body)][0] for name, body in file["bodies"].items() if "flexible" in body}
    placement = Placement(file["bodies"], file.get("joints", {}), nodes, file.get("motions", {}))
    content = definition(file, placement, {name: modes for name, (_, modes) in data.items()})
    try:
        joints = file.get("joints", {})
        with folder_of(resources) as folder:
            content, moves = assemble(content, folder, joints)
            content = with_stiff_stops(content, folder, joints)
            native.check(json.dumps(content), folder)
    except (ValueError, RuntimeError) as error:
        line, where = _place_of(str(error), file)
        problems.add(line, where, str(error).rstrip("."))
        raise MechanismFileError(path, problems.found) from error
    bodies = file["bodies"].items()
    return MechanismFile(
        path,
        content,
        resources,
        {name: body["shapes"] for name, body in bodies if "shapes" in body},
        {name: placement[name].offset.tolist() for name, _ in bodies},
        {name: pose.placed_by for name, pose in placement.poses.items() if pose.placed_by},
        moves,
    )


@contextmanager
def folder_of(resources: Mapping[str, Path]) -> Iterator[Path]:
    """A folder that has the files under the names of the definition, as long as it is needed."""
    with tempfile.TemporaryDirectory() as folder:
        for name, source in resources.items():
            shutil.copyfile(source, Path(folder) / name)
        yield Path(folder)


def _read(root: Node, problems: Problems) -> Record:
    """All of the file by the table."""
    names = _names(root)
    context = Context(problems, names)
    file = MECHANISM.read(root, "", context)
    _check_names(root, problems)
    if file is not None:
        joints = file.get("joints", {})
        for name, drive in file.get("drives", {}).items():
            for key, kind in prescribed(value_dimension(name, drive, joints)).items():
                if isinstance(drive.get(key), Pending):
                    drive[key] = drive[key].read(kind, context)
        check_mimics(file.get("couplings", {}), context)
    return file


def _children(root: Node, key: str) -> dict[str, Node]:
    """The entries below a key, as far as there are any."""
    value = root.value.get(key) if isinstance(root.value, dict) else None
    return value.value if value is not None and isinstance(value.value, dict) else {}


def _names(root: Node) -> dict[str, tuple[str, ...]]:
    """What the file gives names to, before any of it is checked."""
    bodies, joints = tuple(_children(root, "bodies")), _children(root, "joints")
    coordinates = []
    for name, joint in joints.items():
        kind = joint.value.get("type") if isinstance(joint.value, dict) else None
        known = JOINT_TYPES.get(kind.value) if kind is not None and isinstance(kind.value, str) else None
        words = [c.word for c in known.coordinates] if known else []
        coordinates += [name, *(f"{name}.{word}" for word in words)] if words or not known else []
    return {
        "body": bodies,
        "body or ground": (*bodies, GROUND),
        "coordinate": tuple(coordinates),
        "motion": tuple(_children(root, "motions")),
    }


def _check_names(root: Node, problems: Problems) -> None:
    """No two elements have the same name, and none is called ground."""
    first: dict[str, tuple[str, int]] = {}
    for key in ELEMENTS:
        lines = root.value[key].key_lines if _children(root, key) else {}
        for name, line in lines.items():
            if name in first:
                other, where = first[name]
                problems.add(
                    line, f"{key}.{name}", f"{name} is in {other} too, in line {where}; every name must be used once"
                )
            first.setdefault(name, (key, line))
            if name == GROUND:
                problems.add(line, f"{key}.{name}", f"{GROUND} is the inertial frame; give it another name")


def _modal_data(
    file: Record, folder: Path, problems: Problems
) -> tuple[dict[str, Path], dict[str, tuple[np.ndarray, int]]]:
    """Files of modal data by the names they have in an FMU; nodes and number of modes by the names in the file."""
    resources: dict[str, Path] = {}
    data: dict[str, tuple[np.ndarray, int]] = {}
    for name, body in file["bodies"].items():
        if "flexible" not in body:
            continue
        text, line, where = modal_file(body), body.line_of("flexible"), f"bodies.{name}.flexible"
        short, source = text.rsplit("/", 1)[-1], folder / text
        if resources.setdefault(short, source) != source:
            problems.add(line, where, f"{shown(text)} has the name of another file; an FMU has one folder for all")
            continue
        try:
            content = json.loads(source.read_text(encoding="utf-8"))
            nodes, shapes = np.array(content["X"], dtype=float).reshape(-1, 3), np.array(content["Phi"], dtype=float)
            data[text] = nodes, shapes.shape[2]
        except OSError as error:
            problems.add(
                line, where, f"{shown(text)} cannot be read: {error.strerror}; it must be a file of modal data"
            )
        except (ValueError, KeyError, TypeError, IndexError, RecursionError):
            problems.add(line, where, f"{shown(text)} holds no modal data; `sigmafmu modes` makes such files")
    return resources, data


def _place_of(message: str, file: Record) -> tuple[int, str]:
    """Line and path of what a message of the core names: the element whose name comes first, the longest if several.

    The reader of definitions names `forces[2]`, which is an element of the file too.
    """
    numbered = re.match(r"(\w+)\[(\d+)\]", message)
    if numbered and numbered[1] in ELEMENTS:
        name = list(file.get(numbered[1], {}))[int(numbered[2])]
        return file[numbered[1]][name].line, f"{numbered[1]}.{name}"
    words = message.replace(",", " ").replace(";", " ").split()
    best: tuple[int, int, int, str] | None = None
    for key in (*ELEMENTS, "integrator", "experiment"):
        entries = file.get(key, {})
        for name in entries:
            full = f"{key}.{name}" if key in ("integrator", "experiment") else name
            line = entries.line_of(name) if isinstance(entries, Record) else entries[name].line
            for i, word in enumerate(words):
                if word.strip('":.') == full or word.startswith(f"{full}."):
                    found = (i, -len(full), line, full if full != name else f"{key}.{name}")
                    best = min(best, found) if best else found
                    break
    return (best[2], best[3]) if best else (file.line, "")
