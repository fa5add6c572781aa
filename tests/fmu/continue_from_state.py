"""Another process: restores serialized FMU states, goes on from each and writes outputs and counters.

    python continue_from_state.py MODEL START H COUNT STATE...    (FILE -> FILE.npy)

Knows nothing of the tests' helpers, so that nothing but the bytes is handed over.
"""

import sys
from pathlib import Path

import numpy as np

from sigmafmu.fmu import Fmu


def main(model: str, start: str, H: str, count: str, *files: str) -> None:
    fmu = Fmu.of_model(model)
    variables = fmu.description.modelVariables
    reals = [v.valueReference for v in variables if v.causality == "output"]
    counters = [v.valueReference for v in variables if v.causality == "local" and v.type == "Integer"]
    for file in files:
        slave = fmu.instantiate()
        state = slave.deSerializeFMUstate(Path(file).read_bytes())
        slave.setFMUstate(state)
        rows = []
        for i in range(int(count) + 1):
            if i > 0:
                slave.doStep(float(start) + (i - 1) * float(H), float(H))
            rows.append([*slave.getReal(reals), *slave.getInteger(counters)])
        np.save(f"{file}.npy", np.array(rows))
        slave.freeFMUstate(state)
        slave.freeInstance()


if __name__ == "__main__":
    main(*sys.argv[1:])
