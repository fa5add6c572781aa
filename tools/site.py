"""Put README.md and docs/ into a folder as pages of the site, and files that they link to beside them.

On the site README.md is the first page, and what lies outside docs/ is under `source/`.
"""

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"(?<=\]\()(?!\w+:|#)(?P<path>[^)#\s]+)")


def write(folder: Path) -> None:
    """Replace `folder` by the pages; raises FileNotFoundError where a link leads to no file."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder)
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        name = "index.md" if page.name == "README.md" else page.name
        text = LINK.sub(lambda link, page=page: on_site(page.parent / link["path"], folder), page.read_text("utf-8"))
        (folder / name).write_text(text, encoding="utf-8")


def on_site(file: Path, folder: Path) -> str:
    """Where a page of the site finds a file; one that is not in docs/ is copied."""
    file = file.resolve(strict=True)
    if file == ROOT / "README.md":
        return "index.md"
    if file.is_relative_to(ROOT / "docs"):
        return file.relative_to(ROOT / "docs").as_posix()
    path = Path("source") / file.relative_to(ROOT)
    if file.is_file():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, folder / path)
    return path.as_posix()


if __name__ == "__main__":
    write(Path(sys.argv[1]))
