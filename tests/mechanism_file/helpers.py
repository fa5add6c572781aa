"""What the tests of mechanism files share."""

from pathlib import Path

from sigmafmu.mechanism_file.load import MechanismFile, load_text
from sigmafmu.mechanism_file.problems import MechanismFileError

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "models" / "library"
PATH = Path("some.yaml")

HEAD = "sigmafmu: 1\nname: Some\n"
BALL = "{mass: 2, inertia: [1, 2, 2.5]}"


def read(text: str, path: Path = PATH) -> MechanismFile:
    return load_text(text, path)


def complaints(text: str | bytes, path: Path = PATH) -> list[str]:
    """The lines of the error that a text gives; it must give one, and no other kind."""
    try:
        load_text(text, path)
    except MechanismFileError as error:
        return str(error).splitlines()
    raise AssertionError("this should have been refused:\n" + str(text))


def complaint(text: str) -> str:
    """The only complaint."""
    lines = complaints(text)
    assert len(lines) == 1, lines
    return lines[0]
