"""What is to be seen: a model, a mechanism file, an FMU, or a result with the mechanism that it is of."""

import csv
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.contents.scene_of import Scene, scene_of
from sigmafmu.fmu import Fmu
from sigmafmu.mechanism_file.cli import is_mechanism_file
from sigmafmu.result import Result, Statistics
from sigmafmu.view import columns
from sigmafmu.view.motion import variables_of

EVERYTHING = {"expose": {key: ["*"] for key in ("inputs", "outputs", "parameters")}}


@dataclass(frozen=True)
class Subject:
    """A mechanism that can be drawn and run."""

    source: Any
    """An `Fmu` or a `MechanismFile`."""
    scene: Scene

    @property
    def available(self) -> list[str]:
        """Names of all outputs."""
        if isinstance(self.source, Fmu):
            from sigmafmu.variables import outputs

            return [variable.name for variable in outputs(self.source)]
        from sigmafmu import _core
        from sigmafmu.mechanism_file.load import mechanism_of

        return list(_core.Outputs(mechanism_of(self.source.definition, self.source.resources)).names)

    def recorded(self, patterns: Iterable[str] = ()) -> list[str]:
        """What a run must record to be seen, beside what `patterns` name."""
        available = self.available
        known = set(available)
        vectors = [f"{vector}[{i}]" for vector in variables_of(self.scene.layout) for i in range(1, 100)]
        poses = [name for name in vectors if name in known]
        return list(dict.fromkeys([*poses, *columns.chosen(available, self.scene.layout, patterns)]))


def subject_of(target: str) -> Subject:
    """The subject of a model's name, a mechanism file or an FMU; raises SigmafmuError."""
    if is_mechanism_file(target):
        from sigmafmu.mechanism_file.load import load

        file = load(target)
        return drawn(replace(file, definition=file.definition | EVERYTHING))
    return drawn(Fmu.of(target))


def drawn(source: Any) -> Subject:
    """The subject of an open FMU or a loaded mechanism file; raises SigmafmuError if nothing tells its looks."""
    if isinstance(source, Fmu):
        resources = source.directory / "resources"
        try:
            mechanism = json.loads((resources / "mechanism.json").read_text(encoding="utf-8"))
        except OSError:
            raise SigmafmuError(
                f"{source.path.name} does not tell what its mechanism looks like: it has no resources/mechanism.json, "
                "as FMUs of sigmafmu have"
            ) from None
        shapes = resources / "shapes.json"
        looks = json.loads(shapes.read_text(encoding="utf-8")) if shapes.exists() else {}
        return Subject(source, scene_of(mechanism, resources, shapes=looks))
    from sigmafmu import _core
    from sigmafmu.mechanism_file.drawing import shapes_of
    from sigmafmu.mechanism_file.load import folder_of

    with folder_of(source.resources) as folder:
        scene = scene_of(json.loads(_core.to_json(source.mechanism)), folder, shapes=shapes_of(source))
    return Subject(source, scene)


def result_of(path: Path) -> Result:
    """A result that `sigmafmu run --output` wrote; raises SigmafmuError."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header = next(csv.reader(file), [])
            rows = np.loadtxt(file, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise SigmafmuError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if header[:1] != ["time"] or not len(rows) or rows.shape[1] != len(header):
        raise SigmafmuError(f"{path} is no result: its first column must be time, and every row as long as the header")
    span = float(rows[-1, 0] - rows[0, 0])
    return Result(path.stem, rows[:, 0], tuple(header[1:]), rows[:, 1:], Statistics(span, 0.0, len(rows) - 1))


def mechanism_of_result(result: Result, path: Path) -> Subject:
    """The model or the mechanism file beside a result whose bodies are those of the result; raises SigmafmuError."""
    bodies = {name.removesuffix(".quaternion[1]") for name in result.names if name.endswith(".quaternion[1]")}
    candidates = [*sigmafmu.models(), *(str(p) for p in sorted(path.absolute().parent.glob("*.yaml")))]
    found = []
    for candidate in candidates:
        try:
            subject = subject_of(candidate)
        except SigmafmuError:
            continue
        if set(subject.scene.layout.bodies) == bodies:
            found.append((candidate, subject))
    if len(found) != 1:
        names = ", ".join(name for name, _ in found)
        raise SigmafmuError(
            f"{path} does not tell its mechanism"
            + (f"; it may be {names}" if found else "")
            + "; name it: --of MODEL, a mechanism file or an FMU"
        )
    return found[0][1]
