"""What `pip install` of the wheel brings is enough to build FMUs of files: in a new environment, with no compiler."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from sigmafmu import _core

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "release"
USE = """
import sys, fmpy, sigmafmu
sigmafmu.build_fmu(open("mechanism.json", encoding="utf-8").read(), "Top.fmu")
print(fmpy.simulate_fmu("Top.fmu", stop_time=0.01)["top.position[2]"][-1])
"""

pytestmark = pytest.mark.release


def run(*command: str | Path, **options) -> str:
    done = subprocess.run(list(map(str, command)), text=True, capture_output=True, **options)
    assert done.returncode == 0, (done.stdout + done.stderr)[-8000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel of this source tree, with what `make build` has compiled."""
    folder = tmp_path_factory.mktemp("wheel")
    errors = re.search(r"SIGMAFMU_WERROR:BOOL=(\w+)", (BUILD / "CMakeCache.txt").read_text(encoding="utf-8"))[1]
    settings = [f"build-dir={BUILD}", f"cmake.define.SIGMAFMU_WERROR={errors}"]
    options = [f"--config-settings={setting}" for setting in settings]
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    pip = (sys.executable, "-m", "pip", "wheel", "-q", "--no-build-isolation", "--no-deps", "-w", folder)
    run(*pip, *options, ROOT, env=os.environ | {"PATH": path, "VIRTUAL_ENV": sys.prefix})
    (file,) = folder.glob("*.whl")
    return file


def test_a_wheel_in_a_new_environment_builds_fmus(wheel, tmp_path):
    run(sys.executable, "-m", "venv", tmp_path / "venv")
    python = tmp_path / "venv" / "bin" / "python"
    run(python, "-m", "pip", "install", "-q", wheel)
    mechanism = json.loads(_core.to_json(_core.mechanism("HeavyTop"))) | {"name": "Top"}
    (tmp_path / "mechanism.json").write_text(json.dumps(mechanism), encoding="utf-8")
    alone = {"PATH": str(tmp_path), "HOME": str(tmp_path)}
    (said,) = run(python, "-c", USE, cwd=tmp_path, env=alone).split()
    assert 0.5 < float(said) < 1.0
