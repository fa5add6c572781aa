"""What is wrong with a mechanism file: every complaint with its line, one line each."""

from dataclasses import dataclass, field
from pathlib import Path

from sigmafmu import SigmafmuError


@dataclass(frozen=True, order=True)
class Problem:
    """`text` says what is wrong and what is allowed; `where` is the path of keys to it, empty for the whole file."""

    line: int
    where: str
    text: str


class FileError(SigmafmuError):
    """A file that cannot be used; its message has lines `FILE:LINE: what`, which editors understand."""


class MechanismFileError(FileError):
    """A mechanism file that cannot be used; its message has a line `FILE:LINE: where: what; allowed` per problem."""

    def __init__(self, path: Path | str, problems: list[Problem]):
        self.path, self.problems = Path(path), sorted(set(problems))
        lines = (f"{path}:{p.line}: {p.where + ': ' if p.where else ''}{p.text}" for p in self.problems)
        super().__init__("\n".join(lines))


@dataclass
class Problems:
    """Collects what is found, so that one reading tells all of it."""

    path: Path | str
    found: list[Problem] = field(default_factory=list)

    def add(self, line: int, where: str, text: str) -> None:
        """Note one more."""
        self.found.append(Problem(line, one_line(where), one_line(text)))

    def stop(self) -> None:
        """Raise MechanismFileError if there are any."""
        if self.found:
            raise MechanismFileError(self.path, self.found)


def one_line(text: str) -> str:
    """A text without line breaks and control characters, whatever a file holds."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))


def shown(value: object) -> str:
    """A value in a message: its beginning, on one line."""
    text = f'"{value}"' if isinstance(value, str) else f"{value:g}" if isinstance(value, float) else str(value)
    text = one_line(text)
    return text if len(text) <= 60 else text[:56] + " ..."
