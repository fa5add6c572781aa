"""Gives chunks to the workers of a scheduler, and takes what they have done."""

from __future__ import annotations

import math
import os
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from typing import Any

import distributed
from distributed import Client, KilledWorker

from sigmafmu import SigmafmuError
from sigmafmu.sweeps.job import Chunk, Job, Task, run_chunk
from sigmafmu.sweeps.local import local_cluster

WAITING = 3
"""Chunks that are on their way for each thread of a worker: results in memory are no more than these."""
LOOK_AGAIN = 5.0
"""Seconds after which workers are counted again."""
PATIENCE = 60.0
"""Seconds to wait for a scheduler and its first worker."""


@contextmanager
def connected(scheduler: str | Client | None, workers: int | None) -> Iterator[Client]:
    """A client of a scheduler: an address, a client that is there already, or a local cluster of its own."""
    with ExitStack() as stack:
        if isinstance(scheduler, Client):
            client = scheduler
        else:
            address = scheduler or stack.enter_context(local_cluster(workers or len(os.sched_getaffinity(0))))
            try:
                client = stack.enter_context(Client(address, timeout=PATIENCE, set_as_default=False))
            except (OSError, ValueError) as error:
                raise SigmafmuError(f"there is no scheduler at {address}: {error}") from error
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except distributed.TimeoutError as error:  # asyncio's in Python 3.10
            raise SigmafmuError(f"the scheduler has no worker after {PATIENCE:g} s") from error
        yield client


class Crew:
    """The workers of a study."""

    def __init__(self, client: Client, fmu: bytes, task: Task):
        self._client, self._task = client, task
        self._job = Job(f"sigmafmu-{uuid.uuid4().hex}", fmu, task)
        self._window, self._counted = 0, -math.inf

    def __enter__(self) -> Crew:
        try:
            self._client.register_plugin(self._job)
        except Exception as error:  # pickle and workers have all kinds
            what = "a function cannot be sent, or a worker lacks this version of sigmafmu or of a module"
            raise SigmafmuError(f"the workers cannot take the study ({error!r}): {what}") from error
        return self

    def __exit__(self, *_: object) -> None:
        if self._client.status == "running":
            self._client.unregister_worker_plugin(self._job.name)

    def run(
        self,
        starts: Iterator[int],
        settings: Callable[[int], Sequence[dict[str, Any]]],
        take: Callable[[int, Chunk], None],
    ) -> None:
        """Run the chunks that begin at `starts`; `take` gets each when it is finished, in any order."""
        pending: dict[Any, int] = {}
        finished = distributed.as_completed(loop=self._client.loop)
        while True:
            while len(pending) < self._room() and (start := next(starts, None)) is not None:
                future = self._submit(settings(start))
                pending[future] = start
                finished.add(future)
            if not pending:
                return
            future = next(finished)
            start = pending.pop(future)
            try:
                chunk = self._result(future)
            except KilledWorker:
                chunk = self._one_by_one(settings(start))
            take(start, chunk)

    def _submit(self, settings: Sequence[dict[str, Any]]) -> Any:
        return self._client.submit(run_chunk, self._job.name, settings, key=f"{self._job.name}-{uuid.uuid4().hex}")

    def _result(self, future: Any) -> Chunk:
        try:
            return future.result()
        except CancelledError as error:
            raise SigmafmuError("the connection to the scheduler was lost; resume goes on") from error

    def _one_by_one(self, settings: Sequence[dict[str, Any]]) -> Chunk:
        """A chunk that has killed its workers: the run that does it is found, and told."""
        whole = self._task.empty(len(settings))
        for i, values in enumerate(settings):
            try:
                one = self._result(self._submit([values]))
            except KilledWorker:
                one = self._task.empty(1, "killed", "the run ended its worker's process each time it was tried")
            whole.status[i], whole.messages[i] = one.status[0], one.messages[0]
            whole.values[i], whole.scalars[i] = one.values[0], one.scalars[0]
        return whole

    def _room(self) -> int:
        """How many chunks may be on their way: workers come and go."""
        if time.monotonic() - self._counted > LOOK_AGAIN:
            self._window = WAITING * max(1, sum(self._client.nthreads().values()))
            self._counted = time.monotonic()
        return self._window
