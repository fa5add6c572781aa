"""The library behind `sigmafmu run`: communication grid, statistics, comparison with a reference."""

import numpy as np
import pytest

from sigmafmu import SigmafmuError
from sigmafmu.compare import distance, find_reference
from sigmafmu.model import Model
from sigmafmu.result import Result, Statistics
from sigmafmu.steps import communication_steps


@pytest.mark.parametrize(
    ("stop_time", "step_size", "count", "last"),
    [(1.0, 0.1, 10, 0.1), (1.0, 0.3, 4, 0.1), (0.3, 0.1, 3, 0.1), (2.0, 5.0, 1, 2.0), (1e-3, 1e-5, 100, 1e-5)],
)
def test_communication_steps_reach_the_stop_time(fmu, stop_time, step_size, count, last):
    steps = communication_steps(fmu("HeavyTop"), stop_time, step_size)
    assert len(steps) == count
    assert steps[-1][1] == pytest.approx(last, rel=1e-12)
    assert sum(steps[-1]) == pytest.approx(stop_time, rel=1e-15)
    assert all(size == step_size for _, size in steps[:-1])


def test_statistics_count_what_the_integrator_did(fmu):
    s = (
        Model(fmu("SliderCrank"))
        .run(stop_time=0.1, step_size=0.01, parameters={"integrator.stepSize": 0.001})
        .statistics
    )
    assert (s.simulated_time, s.communication_steps, s.steps, s.retries) == (pytest.approx(0.1), 10, 100, 0)
    assert s.newton_per_step == s.newton_iterations / 100 >= 1
    assert s.real_time_factor == pytest.approx(s.simulated_time / s.wall_time)


def test_every_model_runs_and_progress_reaches_the_end(fmu, model):
    times: list[float] = []
    result = Model(fmu(model)).run(stop_time=0.01, step_size=0.001, on_time=times.append)
    assert times == list(result.time[1:])
    assert np.isfinite(result.values).all()
    assert result.values.shape == (11, len(result.names))


def test_distance_uses_the_common_times_only():
    time = np.arange(5) * 0.1
    result = Result("M", time, ("p[1]", "p[2]"), np.column_stack((time, np.zeros(5))), Statistics(0.4, 0.0, 4))
    history = {"time": np.array([0.0, 0.2, 0.25, 0.4]), "p[1]": np.array([0.0, 0.2, 9.0, 0.1]), "p[2]": np.full(4, 0.4)}
    common, error = distance(result, history, "p")
    np.testing.assert_allclose(common, [0.0, 0.2, 0.4])
    np.testing.assert_allclose(error, [0.4, 0.4, 0.5])
    with pytest.raises(SigmafmuError, match="'q'"):
        distance(result, history, "q")


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
def test_installed_references_state_their_error(model):
    value, unit = find_reference(model).stated_position_error.split()
    assert 0 <= float(value) < 1e-6
    assert unit == "m"
