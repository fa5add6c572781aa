"""Parts of pages that a command writes, between two comments."""

from pathlib import Path

from sigmafmu import SigmafmuError

END = "<!-- end of what was measured -->"


def check(page: Path, command: str) -> tuple[str, str]:
    """What stands before and behind `<!-- measured: <command> -->` and END; SigmafmuError if they are not there."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(f"<!-- measured: {command} -->")
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise SigmafmuError(f"{page} has no place for what is measured: <!-- measured: {command} --> … {END}")
    return before + begin, end + after


def put(page: Path, command: str, text: str) -> None:
    """Replace what is between them; raises SigmafmuError."""
    before, after = check(page, command)
    page.write_text(f"{before}\n\n{text.strip()}\n\n{after}", encoding="utf-8")
