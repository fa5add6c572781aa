"""The mechanism that the build writes beside modelDescription.xml is that of the FMU."""

import os
from pathlib import Path

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import assert_same_bits, real_outputs

ROOT = Path(__file__).parents[2]


@pytest.fixture
def mechanism(fmu, fmus_dir, model) -> _core.Mechanism:
    """Read from the file of the build that made the FMU: another compiler's have other bits."""
    build = fmus_dir.parent if "SIGMAFMU_FMUS" in os.environ else ROOT / "build" / "release"
    file = build / "fmu" / model / "mechanism.json"
    if not file.is_file():
        pytest.skip("the folder of the build is not here")
    read = _core.from_json(file.read_text(encoding="utf-8"))
    _core.load_modal_files(read, str(fmu(model).directory / "resources"))
    return read


def test_the_file_of_the_build_runs_like_the_fmu(mechanism, new, fmu, model):
    """The same variables in the same order, start values and outputs as the same bits."""
    slave, instance = _core.Slave(mechanism), new(model)
    variables = fmu(model).description.modelVariables
    assert slave.names == [v.name for v in variables]
    for v in variables:
        if v.causality == "parameter":
            assert slave.get(v.name) == float(v.start), v.name
    instance.start()
    slave.start()
    H = mechanism.communication_step
    assert float(fmu(model).description.defaultExperiment.stepSize) == H
    names = real_outputs(fmu(model))
    for _ in range(20):
        assert_same_bits(np.array([slave.get(name) for name in names]), instance.reals(names), names)
        slave.do_step(instance.time, H)
        instance.step(H)
