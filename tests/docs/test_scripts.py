"""The scripts of docs/examples run as they are, in a folder with the files beside them."""

import runpy
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from .pages import ROOT, blocks

EXAMPLES = ROOT / "docs" / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
NEEDS = {"regulator.py": "control", "flexible_body.py": "scipy"}
LAST_LINES = {
    "first_fmu.py": "largest force in the crank's pivot: 73.97 N",
    "own_mechanism.py": "160 N/m: at rest the lower bar is at -0.037 m",
    "two_fmus.py": "6 iterations: energy off by ",
}
"""What some print at the end, as far as it is the same everywhere."""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_script(script: Path, tmp_path, monkeypatch, capsys):
    if (needed := NEEDS.get(script.name)) and not find_spec(needed):
        pytest.skip(f"not installed: {needed}")
    for file in EXAMPLES.iterdir():
        if file.suffix != ".py":
            shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    assert LAST_LINES.get(script.name, "") in capsys.readouterr().out.splitlines()[-1]


def test_every_file_is_shown_by_a_page():
    included = {block.included for block in blocks()}
    assert {f"docs/examples/{path.name}" for path in EXAMPLES.iterdir()} == included - {""}
