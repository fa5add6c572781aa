"""Runs in gemseo-fmu's environment, which has no sigmafmu: `python gemseo_run.py FOLDER`.

In a folder of its own, since a script finds the modules beside it first, and a tool's file here is called fmpy.py.
"""

import json
import sys
from pathlib import Path

import numpy as np
from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

folder = Path(sys.argv[1])
job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
parameters = job["parameters"]
inputs = [name for name in parameters if name not in job["fixed"]]
discipline = FMUDiscipline(
    job["path"],
    input_names=inputs or None,
    output_names=job["outputs"],
    final_time=job["steps"] * job["H"],
    time_step=job["H"],
)

references = {v.name: v.valueReference for v in discipline.model_description.modelVariables}
setup_experiment = discipline.model.setupExperiment


def setup(**arguments: float) -> None:
    """Sets the fixed parameters in the one state in which GEMSEO does not come back to them."""
    discipline.model.setReal([references[name] for name in job["fixed"]], [parameters[name] for name in job["fixed"]])
    setup_experiment(**arguments)


discipline.model.setupExperiment = setup
data = discipline.execute({name: np.array([parameters[name]]) for name in inputs})
np.savez(folder / "result.npz", **{name: data[name][1:] for name in job["outputs"]})
