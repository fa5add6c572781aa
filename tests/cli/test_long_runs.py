"""Runs that are too long: bounded memory, and a question before hours of work or gigabytes are begun."""

import shutil
import tracemalloc
from collections import namedtuple

import numpy as np
import pytest
from typer.testing import CliRunner

from sigmafmu import SigmafmuError, cli, console, estimate
from sigmafmu.cli import app
from sigmafmu.model import Model
from sigmafmu.recorder import CHUNK_ROWS
from sigmafmu.steps import communication_steps

HUGE = ["run", "HeavyTop", "--stop-time", "1e9"]


def invoke(arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


def test_a_billion_seconds_are_not_begun_without_consent():
    result = invoke(HUGE)
    assert result.exit_code == 1
    assert "days" in result.stderr
    assert "--yes runs it all the same" in result.stderr


def test_at_a_terminal_the_user_is_asked(monkeypatch):
    questions = []
    monkeypatch.setattr(console, "sys", namedtuple("Sys", "stdin")(namedtuple("Stdin", "isatty")(lambda: True)))
    monkeypatch.setattr(console.typer, "confirm", lambda text, err: questions.append(text) or False)
    assert invoke(HUGE).exit_code == 1
    (question,) = questions
    assert "days" in question


def test_with_yes_nothing_is_asked(monkeypatch):
    monkeypatch.setattr(cli, "PLOTTED_ROWS", 10)
    monkeypatch.setattr(estimate, "SECONDS_TO_ASK", 0.0)
    long = ["run", "HeavyTop", "--stop-time", "30", "--step-size", "0.1", "--variables", "energy.total"]
    assert invoke(long).exit_code == 1
    assert invoke([*long, "--yes"]).exit_code == 0


def test_a_file_that_the_disk_has_no_room_for_is_refused(tmp_path):
    message = invoke([*HUGE, "--yes", "--output", tmp_path / "out.csv"]).stderr
    assert "GB" in message
    assert "free" in message
    assert not (tmp_path / "out.csv").exists()


def test_the_estimate_is_right(fmu, tmp_path):
    """Size within a fifth; time within a factor of 30, for what a short run takes on a busy machine is chance."""
    arguments = {"stop_time": 40.0, "step_size": 1e-3, "parameters": {}, "outputs": ("top.position",)}
    found = estimate.cost(Model(fmu("HeavyTop")), **arguments, output=tmp_path / "out.csv")
    options = ["--stop-time", 40, "--step-size", 1e-3, "--variables", "top.position"]
    assert invoke(["run", "HeavyTop", *options, "--output", tmp_path / "out.csv"]).exit_code == 0
    assert found.file_size == pytest.approx((tmp_path / "out.csv").stat().st_size, rel=0.2)
    taken = Model(fmu("HeavyTop")).run(**arguments).statistics.wall_time
    assert taken / 30 < found.seconds < 30 * taken


def test_memory_is_that_of_the_rows_kept(fmu):
    rows = []
    options = {"stop_time": 5.0, "step_size": 2.5e-4, "on_rows": lambda _names, r: rows.append(len(r))}
    tracemalloc.start()
    result = Model(fmu("HeavyTop")).run(keep_every=1000, **options)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sum(rows) == 20001
    assert len(result.time) == 21
    whole = sum(rows) * (len(result.names) + 1) * 8
    assert peak < 0.3 * whole, "rows that went on are not kept"


@pytest.mark.parametrize("keep_every", [1, 7, CHUNK_ROWS, CHUNK_ROWS + 1, 10**6])
def test_kept_rows_are_every_nth_and_the_last(fmu, keep_every):
    pieces = []
    options = {"stop_time": 0.3, "step_size": 1e-4, "outputs": ["energy.kinetic", "integrator.steps"]}
    result = Model(fmu("HeavyTop")).run(keep_every=keep_every, on_rows=lambda _n, r: pieces.append(r.copy()), **options)
    every = np.concatenate(pieces)
    assert len(every) == 3001
    wanted = sorted({*range(0, 3001, keep_every), 3000})
    np.testing.assert_array_equal(np.column_stack((result.time, result.values)), every[wanted])
    assert result.statistics.communication_steps == 3000


def test_rows_that_no_memory_can_hold_are_refused(fmu):
    with pytest.raises(SigmafmuError, match=r"rows of 2 columns take .* GB, and this machine has"):
        Model(fmu("HeavyTop")).run(stop_time=1e9, step_size=1e-3, outputs=["energy.total"])


def test_communication_steps_are_computed_when_asked_for(fmu):
    steps = communication_steps(fmu("HeavyTop"), 1e9, 3e-4)
    assert len(steps) == 3333333333334
    assert sum(steps[-1]) == pytest.approx(1e9, rel=1e-15)
    with pytest.raises(SigmafmuError, match="too small"):
        communication_steps(fmu("HeavyTop"), 1e9, 1e-8)


def test_a_thinned_figure_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(cli, "PLOTTED_ROWS", 10)
    options = [
        "--stop-time",
        "0.1",
        "--step-size",
        "0.001",
        "--output",
        tmp_path / "o.csv",
        "--plot",
        tmp_path / "o.png",
    ]
    result = invoke(["run", "HeavyTop", *options])
    assert "(101 rows" in result.stdout
    assert "(every 10th row)" in result.stdout
    assert len((tmp_path / "o.csv").read_text().splitlines()) == 102


def test_disk_is_asked_where_the_file_will_be(fmu, tmp_path, monkeypatch):
    asked = []
    usage = namedtuple("usage", "free")(0)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: asked.append(folder) or usage)
    with pytest.raises(SigmafmuError, match="0 GB are free there"):
        estimate.cost(Model(fmu("HeavyTop")), 100.0, 1e-3, {}, ("energy.total",), tmp_path / "out.csv")
    assert asked == [tmp_path]
