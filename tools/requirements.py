"""Print what development needs of pyproject.toml (build, run time, extras, GROUPS), one a line, for `pip install -r`.

The development environment builds without isolation, so it needs the build requirements too; pip has no way to install
them from pyproject.toml by itself.
"""

import sys
from pathlib import Path

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    from pip._vendor import tomli as tomllib


GROUPS = ("research", "test")


def requirements(pyproject: dict) -> list[str]:
    """Requirements of `pyproject`."""
    project = pyproject["project"]
    groups = [
        pyproject["build-system"]["requires"],
        project["dependencies"],
        *project["optional-dependencies"].values(),
        *(pyproject["dependency-groups"][name] for name in GROUPS),
    ]
    return [line for group in groups for line in group]


if __name__ == "__main__":
    text = (Path(__file__).resolve().parent.parent / "pyproject.toml").read_text(encoding="utf-8")
    sys.stdout.write("\n".join(requirements(tomllib.loads(text))) + "\n")
