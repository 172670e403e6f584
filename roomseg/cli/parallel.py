"""Work on several things at once, each in a process of its own."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

__all__ = ["in_processes"]

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_processes(
    work: Callable[[Item], Result], items: Sequence[Item], jobs: int
) -> Iterator[Result]:
    """Yield the results of ``work`` as they come, in whatever order.

    Parameters
    ----------
    work : callable
        A function of a module, which is sent by its name.
    items : sequence
    jobs : int
        How many processes.

    Raises
    ------
    RoomsegError
        If a process dies.
    """
    from dataset.errors import RoomsegError

    # Spawned, not forked: threads of numerical libraries do not survive a fork.
    pool = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_die_quietly)
    try:
        for future in as_completed([pool.submit(work, item) for item in items]):
            yield future.result()
    except BrokenProcessPool as error:
        raise RoomsegError("a process died; call the command again to go on") from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _die_quietly() -> None:
    """Ctrl-C reaches the whole process group; only the parent has something to say about it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
