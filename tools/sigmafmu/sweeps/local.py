"""A local cluster in a process of its own: `python -m sigmafmu.sweeps.local WORKERS`.

It prints the scheduler's address and ends with its standard input, so with the process that started it, however that
ends. Since workers start from this module, a script that sweeps needs no `if __name__ == "__main__"`.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sigmafmu import SigmafmuError


@contextmanager
def local_cluster(workers: int) -> Iterator[str]:
    """Address of the scheduler of a cluster with that many processes."""
    path = os.pathsep.join([*filter(None, sys.path), str(Path.cwd())])  # modules of the user's functions
    command = [sys.executable, "-m", __name__, str(workers)]
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
        start_new_session=True,  # Ctrl-C is for the study alone
    ) as process:
        assert process.stdin
        assert process.stdout
        try:
            address = process.stdout.readline().strip()
            if not address:
                raise SigmafmuError(f"a local cluster of {workers} workers does not start; its messages are above")
            yield address
        finally:
            process.stdin.close()


def serve(workers: int) -> None:
    """Run a cluster until the standard input ends."""
    import dask
    from distributed import LocalCluster

    dask.config.set(
        {
            "distributed.scheduler.allowed-failures": 1,  # what kills a worker twice is run alone, and then given up
            "distributed.scheduler.worker-saturation": 1.0,  # nothing waits on a worker, to be blamed with what runs
            "distributed.worker.profile.enabled": False,  # this and the others watch what nobody looks at
            "distributed.admin.tick.interval": "1s",
            "distributed.admin.system-monitor.interval": "5s",
        }
    )
    with LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
    ) as cluster:
        sys.stdout.write(f"{cluster.scheduler_address}\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    serve(int(sys.argv[1]))
