"""What a user installs is what a user runs: nothing of `research`."""

import re
from importlib.metadata import files
from pathlib import Path

import research
import sigmafmu
from sigmafmu.cli import app
from sigmafmu.demo import CASES

PACKAGE, RESEARCH = (Path(module.__file__).parent for module in (sigmafmu, research))
COMMANDS = [
    *("list", "path", "info", "run", "demo", "sigma", "linearize", "trim", "campbell", "realtime", "view"),
    *("init", "check", "build"),
    *("loop", "ssp", "convert", "couple", "sampling", "modes", "compat", "sweep"),
]


def test_commands():
    registered = [c.name or c.callback.__name__ for c in app.registered_commands]
    assert sorted([*registered, *(group.name for group in app.registered_groups)]) == sorted(COMMANDS)


def test_no_module_of_research_is_installed():
    installed, research_has = ({path.name for path in folder.iterdir()} for folder in (PACKAGE, RESEARCH))
    assert installed & research_has <= {"__init__.py", "cli.py", "__pycache__"}
    wanted = re.compile(r"^\s*(import|from) (research|exudyn)\b", re.MULTILINE)
    assert [str(path) for path in PACKAGE.rglob("*.py") if wanted.search(path.read_text(encoding="utf-8"))] == []


def test_no_other_package_is_installed():
    folders = {path.parts[0] for path in files("sigmafmu")} - {".."}  # bin/sigmafmu
    assert folders == {"sigmafmu", f"sigmafmu-{sigmafmu.__version__}.dist-info"}


def test_the_references_are_those_of_the_demonstration():
    assert sorted(path.stem for path in (PACKAGE / "references").iterdir()) == sorted(case.model for case in CASES)
