"""Put README.md and docs/ into a folder as pages of the site, and files that they link to beside them.

On the site README.md is the first page, and what lies outside docs/ is under `source/`. A fenced block with nothing
but a comment that names a file of docs/examples becomes that file.
"""

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"(?<=\]\()(?!\w+:|#)(?P<path>[^)#\s]+)")
EXAMPLE = re.compile(r"(?<=\n)(?:# |<!-- )(?P<file>docs/examples/[\w.]+)(?: -->)?\n(?=```)")


def write(folder: Path) -> None:
    """Replace `folder` by the pages; raises FileNotFoundError with page and link where there is no such file."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder)
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        name = "index.md" if page.name == "README.md" else page.name
        text = LINK.sub(lambda link, page=page: on_site(page, link["path"], folder), page.read_text(encoding="utf-8"))
        text = EXAMPLE.sub(lambda example: example_of(example["file"]), text)
        (folder / name).write_text(text, encoding="utf-8")


def example_of(file: str) -> str:
    """What stands in a file of docs/examples."""
    return (ROOT / file).read_text(encoding="utf-8")


def on_site(page: Path, path: str, folder: Path) -> str:
    """Where the site has the file that `page` links to; one that is not in docs/ is copied into `folder`."""
    file = (page.parent / path).resolve()
    if not file.exists():
        raise FileNotFoundError(f"{page.name} links to {path}, which is not there")
    if file == ROOT / "README.md":
        return "index.md"
    if file.is_relative_to(ROOT / "docs"):
        return file.relative_to(ROOT / "docs").as_posix()
    copy = Path("source") / file.relative_to(ROOT)
    (folder / copy).parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, folder / copy)
    return copy.as_posix()


if __name__ == "__main__":
    try:
        write(Path(sys.argv[1]))
    except FileNotFoundError as error:
        sys.exit(f"docs: {error}")
