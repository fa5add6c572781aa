"""FMUs of mechanisms that are files, put together from what is in the package: no compiler, no `_core`.

The binary is the same for every mechanism: it reads `resources/mechanism.json` when it is instantiated. Another library
of the package, with a C interface, tells what modelDescription.xml has to say (modelDescription/describe.h).
"""

import hashlib
import json
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sigmafmu import SigmafmuError, native
from sigmafmu.contents.description import Description
from sigmafmu.contents.layout import NO_SHAPES, Shapes
from sigmafmu.contents.model_description import model_description
from sigmafmu.contents.write import write
from sigmafmu.mechanism_file import MECHANISM_FILES
from sigmafmu.native import PARTS
from sigmafmu.platform import PLATFORM

PACKAGE = Path(__file__).parent
TEXTS = PACKAGE / "texts"
PLACEHOLDER = "@MODEL@"
"""Stands for the model identifier in files of `sources`."""
MECHANISM, IDENTITY, SHAPES = "mechanism.json", "identity.json", "shapes.json"
NO_DATE = (1980, 1, 1, 0, 0, 0)
"""The first that a zip file can have, so that the same mechanism is the same file."""


def build_fmu(
    mechanism: str | Path | dict[str, Any],
    path: Path | str | None = None,
    *,
    resources: Path | str | None = None,
    source: Path | str | None = None,
    shapes: Shapes = NO_SHAPES,
) -> Path:
    """Makes the FMU `path` (FMI 2.0, co-simulation) of a mechanism; returns the path, by default the mechanism's name.

    `mechanism` is a mechanism file (.yaml, .yml or .json), or the mechanism in JSON, as `mechanism.json` in an FMU has
    it, or its content; its name is the model identifier. For the latter two, the file `source`, of which the mechanism
    was made, goes into the FMU's documentation, and the folder `resources` has the modal data of flexible bodies;
    default: that of `source`; `shapes` tell what bodies look like (`sigmafmu.contents.shapes`), for pictures and
    `sigmafmu view`. Raises SigmafmuError with one sentence for a mechanism that is wrong, and for files that cannot be
    read or written; for a mechanism file with mistakes a line for each.
    """
    if isinstance(mechanism, Path) or (isinstance(mechanism, str) and mechanism.endswith(MECHANISM_FILES)):
        from sigmafmu.mechanism_file.drawing import shapes_of
        from sigmafmu.mechanism_file.load import folder_of, load

        file = load(mechanism)
        with folder_of(file.resources) as data:
            return build_fmu(file.definition, path, resources=data, source=file.path, shapes=shapes_of(file))
    text = mechanism if isinstance(mechanism, str) else json.dumps(mechanism)
    folder = Path(resources) if resources is not None else Path(source or ".").parent
    description = describe(text, folder)
    target = Path(path or f"{description.model}.fmu")
    try:
        with tempfile.TemporaryDirectory(prefix=f"{description.model}-") as name:
            tree = Path(name)
            _fill(tree, description, folder, Path(source) if source is not None else None, shapes)
            _pack(tree, target)
    except OSError as error:
        raise SigmafmuError(f"{error.filename or target}: {error.strerror or error}") from error
    return target


def fill_runnable(mechanism: dict[str, Any], resources: Path, tree: Path, shapes: Shapes = NO_SHAPES) -> None:
    """Write into the folder `tree` what a run on this machine needs of a mechanism's FMU; raises SigmafmuError."""
    description = describe(json.dumps(mechanism), resources)
    _fill_binary(tree, description, PLATFORM)
    _fill_resources(tree, description, resources, [], shapes)


def describe(mechanism: str, resources: Path) -> Description:
    """The description of a mechanism in JSON whose modal data are in a folder; raises SigmafmuError."""
    try:
        return Description(native.describe(mechanism, resources))
    except (ValueError, RuntimeError) as error:
        raise SigmafmuError(str(error)) from error


def _fill(tree: Path, description: Description, resources: Path, source: Path | None, shapes: Shapes) -> None:
    """Writes all that the FMU has into a folder."""
    _fill_binary(tree, description)
    shutil.copytree(PARTS / "sources", tree / "sources")
    for name in ("CMakeLists.txt", "buildDescription.xml"):
        file = tree / "sources" / name
        _write_text(file, file.read_text(encoding="utf-8").replace(PLACEHOLDER, description.model))
    sources = sorted(path.relative_to(tree / "sources").as_posix() for path in tree.glob("sources/**/*.cpp"))
    _fill_resources(tree, description, resources, sources, shapes)
    write(description, resources, TEXTS, tree, source=source, ours=False, shapes=shapes)


def _fill_binary(tree: Path, description: Description, platform: str = "*") -> None:
    for slave in sorted(PARTS.glob(f"{platform}/slave.*")):
        (tree / "binaries" / slave.parent.name).mkdir(parents=True)
        shutil.copyfile(slave, tree / "binaries" / slave.parent.name / f"{description.model}{slave.suffix}")


def _fill_resources(tree: Path, description: Description, resources: Path, sources: list[str], shapes: Shapes) -> None:
    """The mechanism, its modal data and shapes, and the XML; `sources` are named in the latter."""
    files = tree / "resources"
    files.mkdir()
    _write_text(files / MECHANISM, description.mechanism)
    for name in _modal_files(description):
        if name in {MECHANISM, IDENTITY, SHAPES}:
            raise SigmafmuError(f"a file of modal data is called {name}, as a file that every FMU has")
        shutil.copyfile(resources / name, files / name)
    if shapes:
        _write_text(files / SHAPES, json.dumps(shapes) + "\n")
    made_of = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(files.iterdir()))).hexdigest()
    try:
        xml, guid = model_description(description, sources, made_of)
    except ValueError as error:  # lxml's, about control characters
        raise SigmafmuError(f"the descriptions of the mechanism cannot be written as XML: {error}") from error
    _write_text(tree / "modelDescription.xml", xml)
    identity = {"guid": guid, **description.told["checksums"]}
    _write_text(files / IDENTITY, json.dumps(identity, indent=2) + "\n")


def _modal_files(description: Description) -> Iterator[str]:
    """Names of the files that the flexible bodies have."""
    for body in json.loads(description.mechanism)["bodies"]:
        if "flexible" in body:
            yield body["flexible"]["file"]


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _pack(tree: Path, target: Path) -> None:
    """Zips a folder; the target is there when it is complete."""
    part = target.with_name(f"{target.name}.part")
    try:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(path for path in tree.rglob("*") if path.is_file()):
                info = zipfile.ZipInfo(path.relative_to(tree).as_posix(), NO_DATE)
                info.compress_type = zipfile.ZIP_DEFLATED
                info.external_attr = 0o100644 << 16
                archive.writestr(info, path.read_bytes())
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
