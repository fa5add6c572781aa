"""Tells whether a stopped study and the one that wants to go on with it are the same."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from sigmafmu.sweeps.job import Task
from sigmafmu.sweeps.plan import Plan


def fingerprint(model: str, plan: Plan, task: Task) -> str:
    """A hash of all that results depend on; `model` is the hash of the FMU. Functions are told by their names."""
    told = {
        "model": model,
        "columns": {name: column.tolist() for name, column in plan.columns.items()},
        "constants": plan.constants,
        "stop_time": task.stop_time,
        "step_size": task.step_size,
        "outputs": task.kept,
        "scalars": [(s.name, s.kind, s.variable, _told(s.function)) for s in task.scalars],
        "inputs": _told(task.inputs),
    }
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()


def _told(value: Any) -> Any:
    if callable(value):
        return getattr(value, "__qualname__", type(value).__qualname__)
    if isinstance(value, Mapping):
        return {name: _told(v) for name, v in value.items()}
    if isinstance(value, tuple | list):
        return [_told(v) for v in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
