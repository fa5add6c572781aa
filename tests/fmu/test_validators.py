"""What the ecosystem's own checkers say about each FMU."""

import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

FMUTOOL = shutil.which("fmutool", path=str(Path(sys.executable).parent)) or shutil.which("fmutool")


def test_fmpy_finds_no_problem(fmu, model):
    assert validate_fmu(str(fmu(model).path)) == []


@pytest.mark.skipif(FMUTOOL is None, reason="fmu-manipulation-toolbox is not installed")
def test_fmu_manipulation_toolbox_finds_nothing(fmu, model, tmp_path):
    result = subprocess.run(
        [FMUTOOL, "-input", str(fmu(model).path), "-check"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    report = result.stdout + result.stderr
    assert result.returncode == 0, report
    assert "compliant with FMI-2.0" in report
    assert "No semantic error" in report
    for line in report.splitlines():
        assert not line.startswith(("WARNING", "ERROR", "CRITICAL", "FATAL")), report


def test_fmpy_simulates_with_the_default_experiment(fmu, model):
    """The way most people try an FMU first: hardly more than the name of the file."""
    result = fmpy.simulate_fmu(str(fmu(model).path), stop_time=0.1)
    assert result["time"][-1] == pytest.approx(0.1)
    names = [name for name in result.dtype.names if name != "time"]
    assert names, "outputs are recorded without asking for them"
    assert all(np.isfinite(result[name]).all() for name in names)
