"""What stands in README.md and the pages of docs/: fenced blocks, commands in a line of text, and sentences."""

import re
from dataclasses import dataclass
from pathlib import Path

from docs_site import EXAMPLE, example_of

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
_FENCE = re.compile(r"^```(?P<language>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"`((?:sigmafmu|python -m research|make) [^`]*)`")
PROGRAMS = ("sigmafmu", "python", "make", "pip", "cmake", "git")


@dataclass(frozen=True)
class Block:
    """A fenced block."""

    page: str
    line: int
    language: str
    text: str
    included: str = ""
    """The file of docs/examples that it shows."""

    @property
    def name(self) -> str:
        return f"{self.page}:{self.line}"


def read(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks() -> list[Block]:
    """All fenced blocks of all pages, in order."""
    found = []
    for page in PAGES:
        text = read(page)
        for match in _FENCE.finditer(text):
            line = text[: match.start()].count("\n") + 2
            example = EXAMPLE.search(match[0])
            file, body = (example["file"], example_of(example["file"])) if example else ("", match["text"])
            found.append(Block(page.name, line, match["language"], body, file))
    return found


def is_shell(block: Block) -> bool:
    """Whether it holds commands: without a language, and every line begins with a program."""
    return not block.language and all(line.split()[0] in PROGRAMS for line in command_lines(block))


def command_lines(block: Block) -> list[str]:
    """The commands of a block, without comments and with continued lines joined."""
    lines = re.sub(r"\\\n\s*", "", block.text).splitlines()
    return [command for line in lines if (command := line.partition(" #")[0].strip().removeprefix(".venv/bin/"))]


def inline_commands() -> list[tuple[str, str]]:
    """Page and command of every `sigmafmu …`, `python -m research …` and `make …` in a sentence."""
    found = []
    for page in PAGES:
        text = _FENCE.sub("", read(page))
        for match in _INLINE.finditer(text):
            found.append((page.name, " ".join(match[1].split())))
    return found


def prose(page: str) -> str:
    """A page with single spaces, for searching sentences."""
    path = ROOT / page if page == "README.md" else ROOT / "docs" / page
    return " ".join(read(path).split())
