"""Studies on processes: the same bits on any number of them, whatever is killed meanwhile; runs that fail are rows."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import threading

import dask
import numpy as np
import pytest
import xarray
from distributed import Client, LocalCluster
from typer.testing import CliRunner

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.cli import app
from sigmafmu.sweeps.cluster import WAITING, Crew
from sigmafmu.sweeps.job import STATUSES, Job, packed, run_chunk

QUICK = {"stop_time": 0.05, "step_size": 0.01}
COARSE = {"integrator.stepSize": 1e-3}
MASSES = np.linspace(0.1, 0.3, 24)
STOPS = {"integrator.stepSize": 5e-3, "integrator.maxNewtonIterations": 3, "integrator.maxHalvings": 0}
"""With them a crank that turns fast stops at 0.015 s."""


@pytest.fixture(scope="module")
def crank():
    return sigmafmu.load("SliderCrank")


@pytest.fixture(scope="module")
def cluster():
    """Three processes; a task that ends one is not tried again by Dask."""
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0, "distributed.scheduler.worker-saturation": 1.0}),
        LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def study(crank, output, **options):
    return sigmafmu.sweep(
        crank,
        {"crank.mass": MASSES, **COARSE},
        outputs=["guide.displacement", "crankPivot.reactionForce"],
        scalars={"peak": "max(crankPivot.reactionForce)", "steps": count_steps},
        output=output,
        **QUICK | options,
    )


def count_steps(result):
    return result.statistics.steps


@pytest.fixture(scope="module")
def file_of_three(crank, cluster, tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep") / "three.nc"
    study(crank, path, scheduler=cluster, chunk=2).close()
    return path


def content(path):
    """Every bit that is in the dataset; pieces of the file may be in another order."""
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        told = [json.dumps({name: str(value) for name, value in data.attrs.items()})]
        for name, variable in sorted(data.variables.items()):
            values = variable.values
            told.append((name, variable.dims, str(variable.attrs), values.tobytes() if values.dtype != object else 0))
        assert {"guide.displacement", "crankPivot.reactionForce", "peak", "status", "message"} <= set(data.variables)
    return hashlib.sha256(repr(told).encode()).hexdigest()


def test_every_run_has_the_bits_of_a_run_alone(crank, file_of_three):
    with xarray.open_dataset(file_of_three, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"run": 24, "time": 6, "crankPivot.reactionForce_": 3}
        assert data["crankPivot.reactionForce"].dims == ("run", "time", "crankPivot.reactionForce_")
        assert data["guide.displacement"].attrs["units"] == "m"
        assert data["peak"].attrs["units"] == "N"
        np.testing.assert_array_equal(data.coords["crank.mass"], MASSES)
        assert data.coords["crank.mass"].attrs["units"] == "kg"
        for i in (0, 13, 23):
            alone = crank.run(parameters={"crank.mass": MASSES[i], **COARSE}, **QUICK)
            for name in ("guide.displacement", "crankPivot.reactionForce"):
                np.testing.assert_array_equal(data[name][i], alone[name])
            np.testing.assert_array_equal(data.time, alone.time)
            assert data["peak"][i] == np.linalg.norm(alone["crankPivot.reactionForce"], axis=1).max()
            assert data["steps"][i] == alone.statistics.steps


def test_a_local_cluster_and_one_process_write_the_same_file(crank, file_of_three, tmp_path):
    study(crank, tmp_path / "one.nc", workers=1, chunk=7).close()
    assert content(tmp_path / "one.nc") == content(file_of_three)
    assert list(tmp_path.iterdir()) == [tmp_path / "one.nc"]  # the parts are gone


def test_a_worker_that_is_killed_costs_nothing(crank, cluster, file_of_three, tmp_path):
    victim = next(iter(cluster.run(os.getpid).values()))
    killed = []

    def kill(finished, runs, failed):
        if finished >= runs // 3 and not killed:
            os.kill(victim, signal.SIGKILL)
            killed.append(finished)

    study(crank, tmp_path / "killed.nc", scheduler=cluster, chunk=1, on_progress=kill).close()
    assert killed
    assert killed[0] < len(MASSES)
    assert content(tmp_path / "killed.nc") == content(file_of_three)
    cluster.wait_for_workers(3, timeout=60)
    assert victim not in cluster.run(os.getpid).values()


def test_a_run_that_ends_its_process_is_a_row(crank, cluster):
    def deadly(result):
        if abs(result["crank.mass"][0] - MASSES[3]) < 1e-9:
            os._exit(1)
        return result["guide.displacement"][-1]

    data = sigmafmu.sweep(
        crank,
        {"crank.mass": MASSES[:6], **COARSE},
        scalars={"end": lambda result: deadly(result), "mass": "final(crank.mass)"},
        scheduler=cluster,
        chunk=3,
        **QUICK,
    )
    assert [STATUSES[i] for i in data.status.values] == ["done"] * 3 + ["killed"] + ["done"] * 2
    assert "ended its worker's process" in str(data.message.values[3])
    assert np.isfinite(data["end"].values).tolist() == [True] * 3 + [False] + [True] * 2


def test_chunks_on_their_way_are_few(crank, cluster, tmp_path, monkeypatch):
    submit, sent, most = Crew._submit, [], []
    monkeypatch.setattr(Crew, "_submit", lambda self, settings: sent.append(1) or submit(self, settings))
    monkeypatch.setattr("sigmafmu.sweeps.parts.Parts.save", _counting(sent, most))
    study(crank, tmp_path / "few.nc", scheduler=cluster, chunk=1)
    assert len(sent) == len(MASSES)
    assert max(most) <= WAITING * 3


def _counting(sent, most):
    from sigmafmu.sweeps.parts import Parts

    save, saved = Parts.save, []

    def counting(self, start, chunk):
        most.append(len(sent) - len(saved))
        saved.append(start)
        save(self, start, chunk)

    return counting


def test_what_cannot_be_sent_is_told(crank, cluster):
    lock = threading.Lock()
    with pytest.raises(SigmafmuError, match=r"the workers cannot take the study .*lock.*: a function cannot be sent"):
        sigmafmu.sweep(crank, {"crank.mass": [0.1]}, scalars={"x": lambda _: lock.locked()}, scheduler=cluster, **QUICK)


SCRIPT = """
import sigmafmu, numpy as np
def count_steps(result):
    return result.statistics.steps
sigmafmu.sweep(
    "SliderCrank",
    {"crank.mass": np.linspace(0.1, 0.3, 24), "integrator.stepSize": 1e-3},
    outputs=["guide.displacement", "crankPivot.reactionForce"],
    scalars={"peak": "max(crankPivot.reactionForce)", "steps": count_steps},
    output="study.nc", stop_time=0.05, step_size=0.01, workers=1, chunk=1,
    on_progress=lambda *told: print(*told, flush=True),
)
"""
"""Without `if __name__ == "__main__"`."""


def test_a_study_that_is_killed_goes_on(crank, cluster, file_of_three, tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    with subprocess.Popen([sys.executable, "script.py"], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        while (line := process.stdout.readline()) and int(line.split()[0]) < 5:
            pass
        process.kill()
        children = process.stdout.read()  # its cluster has the same output, and ends with it
    assert children is not None
    output = tmp_path / "study.nc"
    assert not output.exists()
    finished = sorted((tmp_path / "study.nc.parts").glob("*.npz"))
    assert 5 <= len(finished) < 24
    with pytest.raises(SigmafmuError, match="a study was stopped here: go on with resume"):
        study(crank, output, scheduler=cluster)
    with pytest.raises(SigmafmuError, match="belongs to a study of another model, or with other parameters"):
        study(crank, output, scheduler=cluster, resume=True, stop_time=0.04)
    told = []
    study(crank, output, scheduler=cluster, resume=True, on_progress=lambda *a: told.append(a)).close()
    assert told[0] == (len(finished), 24, 0)
    assert content(output) == content(file_of_three)
    told.clear()
    study(crank, output, scheduler=cluster, resume=True, on_progress=lambda *a: told.append(a)).close()
    assert told == []  # it was complete


@pytest.fixture
def job(crank):
    """A worker's part in this process."""
    from sigmafmu.sweeps.study import _task, communication_steps

    made = []

    def make(outputs=(), scalars=(), inputs=None, stop_time=0.05):
        task = _task(crank.fmu, communication_steps(crank.fmu, stop_time, 0.01), inputs or {}, outputs, scalars)
        made.append(Job(f"test-{len(made)}", packed(crank.fmu), task))
        made[-1].setup(None)
        return made[-1].name

    yield make
    for one in made:
        one.teardown(None)


def test_runs_that_fail_are_rows_and_change_nothing(crank, job):
    def picky(result):
        if result["guide.displacement"][-1] < 10:
            raise ValueError("too short")

    name = job(["guide.displacement"], {"far": "max(guide.displacement)"})
    settings = [{}, {"crank.mass": -1.0}, {}, {**STOPS, "crankPivot.initialAngularRate": 100.0}, {}]
    chunk = run_chunk(name, settings)
    assert [STATUSES[i] for i in chunk.status] == ["done", "refused", "done", "stopped", "done"]
    assert chunk.messages[1] == "SliderCrank refuses: crank.mass is -1 kg; it must be finite, above 0."
    assert chunk.messages[3].startswith("SliderCrank stopped at t = 0.015 s")
    alone = crank.run(0.05, step_size=0.01)["guide.displacement"]
    for i in (0, 2, 4):
        np.testing.assert_array_equal(chunk.values[i, :, 0], alone)
        assert chunk.scalars[i, 0] == alone.max()
    assert np.isfinite(chunk.values[3, :, 0]).tolist() == [True, True, False, False, False, False]
    assert np.isnan(chunk.values[1]).all()
    assert np.isnan(chunk.scalars[[1, 3]]).all()

    chunk = run_chunk(job(["guide.displacement"], {"far": picky}), [{}])
    assert (STATUSES[chunk.status[0]], chunk.messages[0]) == ("error", "far: ValueError: too short")
    np.testing.assert_array_equal(chunk.values[0, :, 0], alone)


def test_inputs_are_those_of_a_run(crank, job):
    def torque(parameters):
        return {"crankPivot.motorTorque": ([0.0, 0.05], [0.0, parameters["crank.mass"]])}

    chunk = run_chunk(job(["guide.displacement"], inputs=torque), [{"crank.mass": m} for m in (0.1, 0.2)])
    for i, mass in enumerate((0.1, 0.2)):
        inputs = torque({"crank.mass": mass})
        alone = crank.run(0.05, step_size=0.01, parameters={"crank.mass": mass}, inputs=inputs)
        np.testing.assert_array_equal(chunk.values[i, :, 0], alone["guide.displacement"])


def test_an_instance_is_kept(job, monkeypatch):
    from sigmafmu.sweeps import job as module

    made = []
    monkeypatch.setattr(module, "Instance", lambda *a: made.append(1) or sigmafmu.Instance(*a))
    run_chunk(job(["guide.displacement"]), [{"crank.mass": m} for m in (0.1, 0.2, 0.3)])
    assert len(made) == 1


def test_the_command(cluster, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = "sweep SliderCrank --vary crank.mass=0.1,-1 --zip rod.mass=0.5,0.6 --zip integrator.formulation=index3,"
    command += "stabilizedIndex2 --sample slider.mass~U(0.1,0.2) --runs 2 --set integrator.stepSize=1e-3 --scalar "
    command += "peak=max(crankPivot.reactionForce) --variables guide.* --stop-time 0.02 --step-size 0.01 --scheduler "
    ran = CliRunner().invoke(app, [*command.split(), cluster.scheduler.address])
    assert ran.exit_code == 0, ran.output
    assert "wrote study.nc (8 runs of 3 rows, 4 of them failed; the first: SliderCrank refuses: " in ran.stdout
    assert "8 of 8 runs (4 failed)" in ran.stderr
    with xarray.open_dataset(tmp_path / "study.nc", engine="h5netcdf") as data:
        assert data["rod.mass"].values.tolist() == [0.5, 0.5, 0.6, 0.6] * 2
        assert data["integrator.formulation"].values.tolist() == ["index3", "index3", *["stabilizedIndex2"] * 2] * 2
        assert np.isfinite(data["peak"].values).tolist() == [True] * 4 + [False] * 4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--vary crank.mass=0.1:0.2", "'crank.mass' needs a number, not '0.1:0.2'"),
        ("--vary crank.mass=0.1:x:3", "'0.1:x:3' is no range; write first:last:number"),
        ("--set crank.mass=1 --vary crank.mass=1,2", "'crank.mass' is given twice"),
        (
            "--zip crank.mass=1,2 --zip rod.mass=1",
            "--zip needs as many values of each, but crank.mass has 2, rod.mass has 1",
        ),
        ("--sample crank.mass", "--sample crank.mass: write it as NAME~DISTRIBUTION"),
        ("--sample crank.mass~N(1,2)", "crank.mass is sampled: give the number of runs"),
    ],
)
def test_mistakes_in_the_command_are_told(options, message):
    ran = CliRunner().invoke(app, ["sweep", "SliderCrank", *options.split()])
    assert ran.exit_code == 1
    assert message in ran.output


def test_a_zarr_store_has_the_same(crank, cluster, file_of_three, tmp_path):
    study(crank, tmp_path / "study.zarr", scheduler=cluster).close()
    with (
        xarray.open_zarr(tmp_path / "study.zarr") as store,
        xarray.open_dataset(file_of_three, engine="h5netcdf") as file,
    ):
        xarray.testing.assert_identical(store.load(), file.load())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"output": "study.csv"}, r"must end with \.nc or \.zarr"),
        ({"output": "nowhere/study.nc"}, "there is no folder nowhere"),
        ({"chunk": 0}, "a chunk has 1 run or more, not 0"),
        ({"outputs": ["crank.mass"]}, "'crank.mass' is varied, so it is a coordinate"),
        ({"scalars": {"status": "max(guide.rate)"}}, "a scalar cannot have the name 'status'"),
        ({"inputs": {"guide.rate": 1.0}}, "'guide.rate' is no input"),
        ({"scheduler": "tcp://127.0.0.1:1"}, "there is no scheduler at tcp://127.0.0.1:1"),
    ],
)
def test_mistakes_are_told(crank, options, message, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sigmafmu.sweeps.cluster.PATIENCE", 0.2)
    with pytest.raises(SigmafmuError, match=message):
        sigmafmu.sweep(crank, {"crank.mass": [0.1, 0.2]}, **QUICK | options)
