"""Writes the `sources` folder of an FMU, run by the build: everything that another platform needs to make the binary.

The listed C++ files are copied with every header that they include, directly or not, from the given roots; so are the
CMake files that turn them into a binary. Standard library only.
"""

import argparse
import re
import shutil
from pathlib import Path
from xml.etree import ElementTree

CMAKE = Path(__file__).parents[1] / "cmake"
COPIED = ("FmuBinary.cmake", "fmi2.map")
TEMPLATE = "source_fmu.cmake.in"
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def place(file: Path, roots: list[Path]) -> Path:
    """Where a file goes: its path below the innermost root that holds it."""
    below = [file.relative_to(root) for root in roots if file.is_relative_to(root)]
    if not below:
        raise SystemExit(f"fmu_sources: {file} is in none of {', '.join(map(str, roots))}")
    return min(below, key=lambda path: len(path.parts))


def with_headers(sources: list[Path], roots: list[Path]) -> set[Path]:
    """The files and all that they include from the roots, also what the preprocessor would skip on this platform."""
    found: set[Path] = set()
    waiting = list(sources)
    while waiting:
        file = waiting.pop()
        if file in found:
            continue
        found.add(file)
        for name in INCLUDE.findall(file.read_text(encoding="utf-8", errors="replace")):
            candidates = [folder / name for folder in (file.parent, *roots)]
            waiting.extend([c.resolve() for c in candidates if c.is_file()][:1])  # none: a header of the system
    return found


def build_description(model: str, sources: list[str]) -> ElementTree.ElementTree:
    """`buildDescription.xml` of FMI 3.0, which FMI 2.0.4 adopted."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=model)
    files = ElementTree.SubElement(configuration, "SourceFileSet", language="C++17")
    for name in sources:
        ElementTree.SubElement(files, "SourceFile", name=name)
    ElementTree.SubElement(files, "IncludeDirectory", name=".")
    ElementTree.indent(root)
    return ElementTree.ElementTree(root)


def main() -> None:
    """Reads the command line that CMake gives."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", help="its name; @MODEL@ where that is to be filled in")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--root", type=Path, action="append", required=True, help="where include paths start")
    parser.add_argument("--own", action="append", required=True, help="a source, by its place, that tells FMUs apart")
    parser.add_argument("source", type=Path, nargs="+")
    options = parser.parse_args()
    roots = [root.resolve() for root in options.root]
    sources = [source.resolve() for source in options.source]
    out: Path = options.output

    shutil.rmtree(out, ignore_errors=True)
    for file in with_headers(sources, roots):
        target = out / place(file, roots)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)
    for name in COPIED:
        shutil.copyfile(CMAKE / name, out / name)
    names = [place(source, roots).as_posix() for source in sources]
    lists = (CMAKE / TEMPLATE).read_text()
    for key, text in {
        "MODEL": options.model,
        "MODEL_SOURCES": " ".join(options.own),
        "SHARED_SOURCES": "\n  ".join(name for name in names if name not in options.own),
    }.items():
        lists = lists.replace(f"@{key}@", text)
    (out / "CMakeLists.txt").write_text(lists)
    build_description(options.model, names).write(out / "buildDescription.xml", encoding="UTF-8", xml_declaration=True)


if __name__ == "__main__":
    main()
