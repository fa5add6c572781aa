"""A package that an optional command needs and that is not installed is told in a sentence, not in a traceback."""

import subprocess
import sys

import pytest

CASES = [
    ("scipy", "couple", "loop"),
    ("scipy", "sampling", "loop"),
    ("scipy", "modes check never.json", "modes"),
    ("distributed", "sweep HeavyTop", "sweep"),
    ("h5netcdf", "sweep HeavyTop", "sweep"),
    ("lxml", "ssp HeavyTop --output never.ssp", "loop"),
    ("pythonfmu", "ssp HeavyTop --output never.ssp", "loop"),
    ("mujoco", "convert robot.xml", "mjcf"),
]


@pytest.mark.parametrize(("package", "command", "extra"), CASES)
def test_the_extra_is_named(tmp_path, package, command, extra):
    (tmp_path / "robot.xml").write_text("<mujoco/>", encoding="utf-8")
    blocker = f"""
import importlib.abc, importlib.metadata, sys
class Blocked(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == {package!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Blocked())
version = importlib.metadata.version
def hidden(name):
    if name == {package!r}:
        raise importlib.metadata.PackageNotFoundError(name)
    return version(name)
importlib.metadata.version = hidden
from sigmafmu.cli import app
app({command.split()!r})
"""
    result = subprocess.run([sys.executable, "-c", blocker], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert result.returncode == 1, result.stderr
    assert result.stderr.splitlines()[-1] == (
        f"Error: {package} is not installed; pip install 'sigmafmu[{extra}]' brings it"
    )
    assert "Traceback" not in result.stderr
