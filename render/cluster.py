"""Dask workers for `render.pool`: some of this machine, or those of a scheduler that is there.

Own workers listen on the loopback interface only, without a dashboard, and end with
this process even if it is killed. Dask's messages are pickles: whoever reaches a scheduler or
a worker can run what they like there. A scheduler of the user's is as safe as its network.
"""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

import dask
from distributed import Client, LocalCluster

from dataset.errors import RoomsegError

__all__ = ["crew_threads", "workers_of"]

PATIENCE_S = 10
CONFIG = {
    # Parcels are sent as tasks, which Dask makes anew where workers die with their only copy.
    "distributed.admin.large-graph-warning-threshold": "10GB",
    "distributed.scheduler.allowed-failures": 10,
    "distributed.scheduler.work-stealing": False,
    "distributed.worker.profile.enabled": False,
}


def crew_threads(jobs: int, scheduler: str | None) -> int:
    """Threads of each rendering process, if nobody says: all cores together, or one."""
    # A worker of a cluster is given as many chunks at once as it has threads.
    return 1 if scheduler else max(1, len(os.sched_getaffinity(0)) // jobs)


@contextmanager
def workers_of(jobs: int, scheduler: str | None = None) -> Iterator[Client]:
    """Reach a scheduler, or start ``jobs`` workers here, which end with the block.

    Raises
    ------
    RoomsegError
        If no scheduler answers.
    """
    quiet = logging.getLogger("distributed")
    level = quiet.level
    quiet.setLevel(logging.CRITICAL)
    try:
        with dask.config.set(CONFIG), _remote(scheduler) if scheduler else _local(jobs) as client:
            yield client
    finally:
        quiet.setLevel(level)


class _ClosedClient(Client):  # type: ignore[misc]
    """A client that closes itself if no scheduler answers.

    Dask leaves that to the garbage collector, which may come while the next client starts,
    in its new thread: both then wait for one lock, and no client starts any more.
    """

    def start(self, **options: Any) -> None:
        try:
            super().start(**options)
        except BaseException:
            self.close()
            raise


@contextmanager
def _remote(scheduler: str) -> Iterator[Client]:
    try:
        client = _ClosedClient(scheduler, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise RoomsegError(
            f"--scheduler {scheduler}: no scheduler of Dask answers; expected tcp://HOST:PORT, "
            "as `dask scheduler` tells when it starts"
        ) from error
    with client:
        yield client


@contextmanager
def _local(jobs: int) -> Iterator[Client]:
    # Else the first worker starts it, which unblocks signals.
    resource_tracker.ensure_running()
    # What this thread blocks now stays blocked in the workers: Ctrl-C is told to them
    # by the pool, which wants their frames first.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        cluster = LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            # Its server for metrics comes all the same, and would warn if its port is taken.
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    with cluster, Client(cluster, set_as_default=False) as client:
        yield client
