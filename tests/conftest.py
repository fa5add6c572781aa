"""Fixtures shared by all tests.

The FMUs are those of the installed package, or of the directory that $SIGMAFMU_FMUS names. A test with an argument
`model` runs once for each of them.
"""

import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

# Before NumPy is there: tests run in as many processes as there are cores, and threads of BLAS in each of them would
# wait for each other, for most of the time of what takes eigenvalues.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sigmafmu
from sigmafmu.fmu import Fmu

# For `research`; behind the installed packages, since tools also holds the sources of `sigmafmu`.
sys.path.append(str(Path(__file__).parents[1] / "tools"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    own = any("model" in mark.args[0] for mark in metafunc.definition.iter_markers("parametrize"))
    if "model" in metafunc.fixturenames and not own:
        models = sigmafmu.models()
        if not models:
            raise pytest.UsageError(f"no FMUs in {sigmafmu.fmus_dir()}; run `make build` first")
        metafunc.parametrize("model", models)


@pytest.fixture(scope="session")
def fmus_dir() -> Path:
    """Directory of the FMUs under test."""
    return sigmafmu.fmus_dir()


@pytest.fixture(scope="session")
def models() -> list[str]:
    """Names of the FMUs under test."""
    return sigmafmu.models()


@pytest.fixture(scope="session")
def fmu() -> Callable[[str], Fmu]:
    """Function that opens the FMU of a model; each is unzipped once in a session.

    What is tested of one mechanism needs its FMU: a test that asks for one that $SIGMAFMU_FMUS lacks is skipped.
    """

    @cache
    def open_fmu(model: str) -> Fmu:
        if model not in sigmafmu.models():
            pytest.skip(f"{model} is not among the FMUs under test")
        return Fmu.of_model(model)

    return open_fmu
