"""What is to be seen: a model, a mechanism file or an FMU, and results with the mechanism that they are of."""

import csv
import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.contents.scene_of import Scene, scene_of
from sigmafmu.fmu import Fmu
from sigmafmu.mechanism_file import MECHANISM_FILES
from sigmafmu.model import Model, fmu_of_mechanism_file
from sigmafmu.result import Result, Statistics
from sigmafmu.variables import select
from sigmafmu.view import columns
from sigmafmu.view.motion import variables_of


def model_of(target: str) -> Model:
    """As `sigmafmu.load`, with everything that can be seen: all outputs and meshes of a mechanism file."""
    if target.endswith(MECHANISM_FILES):
        return Model(fmu_of_mechanism_file(Path(target), seen=True))
    return sigmafmu.load(target)


def scene_of_fmu(fmu: Fmu) -> Scene:
    """The scene of an FMU; raises SigmafmuError if nothing tells what its mechanism looks like."""
    resources = fmu.directory / "resources"
    try:
        mechanism = json.loads((resources / "mechanism.json").read_text(encoding="utf-8"))
    except OSError:
        raise SigmafmuError(
            f"{fmu.path.name} does not tell what its mechanism looks like: it has no resources/mechanism.json, "
            "as FMUs of sigmafmu have"
        ) from None
    shapes = resources / "shapes.json"
    looks = json.loads(shapes.read_text(encoding="utf-8")) if shapes.exists() else {}
    return scene_of(mechanism, resources, shapes=looks)


def to_record(model: Model, scene: Scene, patterns: Iterable[str] = ()) -> list[str]:
    """What a run must record to be seen, and what `patterns` name; SigmafmuError if one names nothing."""
    patterns = tuple(patterns)
    select(model.fmu, patterns)
    vectors = set(variables_of(scene.layout))
    poses = [name for name in (*model.outputs, *model.inputs) if name.partition("[")[0] in vectors]
    return list(dict.fromkeys([*poses, *columns.chosen(list(model.outputs), scene.layout, patterns)]))


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


def mechanism_of_result(result: Result, path: Path) -> tuple[Model, Scene]:
    """The model of the package, or the mechanism file beside `path`, whose bodies are those of a result.

    Raises SigmafmuError if there is none or more than one.
    """
    bodies = {name.removesuffix(".quaternion[1]") for name in result.names if name.endswith(".quaternion[1]")}
    files = (str(file) for file in sorted(path.absolute().parent.glob("*.yaml")))
    found = []
    for candidate in (*sigmafmu.models(), *files):
        try:
            model = model_of(candidate)
            scene = scene_of_fmu(model.fmu)
        except SigmafmuError:
            continue
        if set(scene.layout.bodies) == bodies:
            found.append((candidate, model, scene))
    if len(found) != 1:
        names = " or ".join(name for name, _, _ in found)
        guess = f"; it may be of {names}" if found else ""
        raise SigmafmuError(
            f"{path} does not tell its mechanism{guess}; name it: --of MODEL, a mechanism file or an FMU"
        )
    return found[0][1], found[0][2]
