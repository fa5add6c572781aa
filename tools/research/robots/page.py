"""Converts, builds and compares every robot of the packages, and writes the page about it."""

import math
import tempfile
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import NamedTuple

from research.robots import STATES, Compared, humanoid, with_mujoco, with_pinocchio
from sigmafmu import SigmafmuError, load
from sigmafmu.importers.convert import convert
from sigmafmu.markdown import markdown_table
from sigmafmu.packing import build_fmu

SHOWN = 120
"""Characters of what was dropped, for each robot."""
COUNTED = {
    "no body has the principal moments": "impossible inertias",
    "beyond its limits": "starts beyond limits",
    "which is none": "mimics of absent joints",
    "one planar joint": "planar joints of slides",
}
"""What tells a sentence about one body or joint → what the table calls it."""
NO_DIFFERENCE = ("the root, has", "other names")
FMU_STEPS = 5
EMPTY = ("ur3.urdf",)
"""Files of the packages that have no link."""
NO_MECHANISM = ("msh.xml",)
"""Files in which nothing moves."""


class Package(NamedTuple):
    """Where robots come from, and who is the reference."""

    name: str
    folder: str
    ending: str
    compare: Callable[[Path, str], Compared]


PACKAGES = (
    Package("example-robot-data", "example-robot-data/robots/", ".urdf", with_pinocchio.compare),
    Package("gymnasium", "mujoco/assets/", ".xml", with_mujoco.compare),
)


def descriptions(package: Package) -> Iterator[tuple[str, Path]]:
    """Names and files of its robots; SigmafmuError: it is not installed."""
    try:
        found = files(package.name) or ()
    except PackageNotFoundError as error:
        raise SigmafmuError(f"the package {package.name} is missing; `make bench` installs it") from error
    for file in sorted(found, key=str):
        if package.folder in str(file) and file.name.endswith(package.ending) and file.name not in EMPTY:
            yield str(file).partition(package.folder)[2].removesuffix(package.ending), Path(str(file.locate()))


def runs() -> list[tuple[str, Path, Package]]:
    """All robots."""
    return [(name, path, package) for package in PACKAGES for name, path in descriptions(package)]


def measure(name: str, path: Path, package: Package) -> list[str]:
    """A row of the table: SigmafmuError if anything of it fails."""
    found = package.compare(path, package.name)
    return [
        f"`{name}`",
        str(found.bodies),
        str(found.degrees),
        f"{found.error:.1e}",
        f"{_size_of_fmu(path) / 1e6:.1f}",
        _short(found.told),
    ]


def _size_of_fmu(path: Path) -> int:
    """Bytes of the robot's FMU, which has run some steps."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "robot.yaml").write_text(convert(path, folder)[0], encoding="utf-8")
        build_fmu(folder / "robot.yaml", folder / "robot.fmu")
        result = load(folder / "robot.fmu").run(FMU_STEPS * 1e-3, step_size=1e-3)
        if len(result.time) != FMU_STEPS + 1 or not all(map(math.isfinite, result.values[-1])):
            raise SigmafmuError(f"{path.name}: its FMU does not run")
        return (folder / "robot.fmu").stat().st_size


def _short(told: list[str]) -> str:
    """What is different, by kind: sentences about single bodies and joints are counted."""
    counted = {what: sum(mark in sentence for sentence in told) for mark, what in COUNTED.items()}
    parts = [f"{what} ({count})" for what, count in counted.items() if count]
    marks = (*COUNTED, *NO_DIFFERENCE)
    parts += [sentence.partition(":")[0] for sentence in told if not any(mark in sentence for mark in marks)]
    text = "; ".join(parts)
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]} ..."


HEADER = ("robot", "bodies", "degrees of freedom", "difference", "FMU [MB]", "different, or not in the file")


def page(on_row: Callable[[], None]) -> str:
    """The page about all robots."""
    parts = []
    for package, title, text in zip(PACKAGES, TITLES, TEXTS, strict=True):
        rows = []
        for run in [run for run in runs() if run[2] is package]:
            rows.append(measure(*run))
            on_row()
        parts.append(f"## {title}\n\n{text}\n\n{markdown_table(HEADER, rows)}")
    (path,) = (path for name, path in descriptions(PACKAGES[0]) if name == humanoid.ROBOT)
    return INTRODUCTION + "\n".join([*parts, humanoid.section(path)])


INTRODUCTION = f"""# Robots that were converted

Written by `python -m research robots`: [descriptions of robots](convert.md) from packages become mechanism files and
FMUs, each FMU runs some steps, and accelerations are compared with those of another code at {STATES} random states of
each: angles and displacements within ±1 rad or m, rates within ±1 rad/s or m/s. The difference is the largest one of
all states, of the largest acceleration in the state; of free bodies, that of the centre of mass counts too. Friction
and limits of joints are left out on both sides, damping and armatures are not.

"""
TITLES = ("URDF beside Pinocchio", "MJCF beside MuJoCo")
TEXTS = (
    "Pinocchio's articulated-body algorithm. Joints that mimic others are eliminated from its matrices. Joints that\n"
    "move nothing with mass are locked there, and bodies with an inertia that none can have get that of the mechanism\n"
    "file.",
    "MuJoCo's accelerations without contacts, fluid and equalities.",
)
