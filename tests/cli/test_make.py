"""What `make setup` and `make build` show: a line for each package and compiled file, and the end of what failed."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PIP = """\
Collecting numpy>=2.1 (from -r requirements.txt (line 1))
  Downloading numpy-2.3.5-cp311-cp311-manylinux_2_28_x86_64.whl.metadata (62 kB)
  Downloading numpy-2.3.5-cp311-cp311-manylinux_2_28_x86_64.whl (16.9 MB)
  Using cached rich-14.2.0-py3-none-any.whl (243 kB)
Installing collected packages: numpy, rich
Successfully installed numpy-2.3.5 rich-14.2.0
"""
NINJA = """\
  *** Configuring CMake...
  [0/2] Re-checking globbed directories...
  [1/43] Building CXX object CMakeFiles/sigmafmu_core.dir/fmu_src/integrator/integrator.cpp.o
  [3/43] Linking CXX static library libsigmafmu_core.a
  [6/43] Writing modelDescription.xml of HeavyTop
  [23/43] Packing HeavyTop.fmu
"""

pytestmark = pytest.mark.skipif(not shutil.which("make") or not shutil.which("bash"), reason="needs make and bash")


def make(recipe: str, text: str = "", *options: str) -> subprocess.CompletedProcess:
    command = ["make", "--no-print-directory", "-C", str(ROOT), f"--eval=check:\n\t@{recipe}", *options, "check"]
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name and name != "V"}
    return subprocess.run(command, input=text, env=environment, capture_output=True, text=True, check=False)


def test_a_line_for_each_package():
    assert make("$(PACKAGES)", PIP).stdout.splitlines() == [
        "  download numpy-2.3.5-cp311-cp311-manylinux_2_28_x86_64.whl (16.9 MB)",
        "  cached   rich-14.2.0-py3-none-any.whl",
        "  installing",
    ]


def test_a_line_for_each_step_of_the_build():
    assert make("$(STEPS)", NINJA).stdout.splitlines() == [
        "  [1/43] fmu_src/integrator/integrator.cpp.o",
        "  [3/43] libsigmafmu_core.a",
        "  [6/43] Writing modelDescription.xml of HeavyTop",
        "  [23/43] Packing HeavyTop.fmu",
    ]


def test_all_of_it_on_demand():
    assert make("$(STEPS)", NINJA, "V=1").stdout == NINJA


def test_what_failed_is_told(tmp_path):
    """The filters hide everything else, but not the failure nor its cause."""
    log = tmp_path / "log"
    recipe = "(echo a; echo 'error: no such thing'; exit 3) $(SAVED) | $(STEPS) $(OR_TELL)"
    result = make(recipe, "", f"LOG={log}")
    assert result.returncode != 0
    assert "error: no such thing" in result.stdout
    assert str(log) in result.stdout
