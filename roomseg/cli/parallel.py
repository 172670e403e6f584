"""Work on several things at once, each in a process of its own."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from typing import TypeVar

__all__ = ["in_processes"]

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_processes(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    jobs: int,
    lost: Callable[[Item], Result] | None = None,
) -> Iterator[Result]:
    """Yield the results of ``work`` as they come, in whatever order.

    If a process dies (killed, out of memory), the others are begun anew. What was being
    worked on then is tried again at the end, one thing at a time.

    Parameters
    ----------
    work : callable
        A function of a module, which is sent by its name.
    items : sequence
    jobs : int
        How many processes.
    lost : callable, optional
        Makes the result of an item over which a process died twice.

    Raises
    ------
    RoomsegError
        If a process died twice over an item and there is no ``lost``.
    """
    from dataset.errors import RoomsegError

    suspects: list[Item] = []
    yield from _work_through(work, deque(items), jobs, suspects)
    for item in suspects:
        dead: list[Item] = []
        yield from _work_through(work, deque([item]), 1, dead)
        if dead and lost is None:
            raise RoomsegError("a process died, twice; call the command again to go on")
        yield from map(lost, dead) if lost else ()


def _work_through(
    work: Callable[[Item], Result], rest: deque[Item], jobs: int, dead: list[Item]
) -> Iterator[Result]:
    """Results of all items but those that a process died over, which are added to ``dead``."""
    while rest:
        # Spawned, not forked: threads of numerical libraries do not survive a fork.
        pool = ProcessPoolExecutor(jobs, get_context("spawn"), initializer=_begin)
        running: dict[Future[Result], Item] = {}
        try:
            while rest or running:
                while rest and len(running) < jobs:
                    running[pool.submit(work, rest[0])] = rest[0]
                    rest.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    del running[future]
                    yield result
        except BrokenProcessPool:
            finished = [f for f in running if f.done() and f.exception() is None]
            dead.extend(item for future, item in running.items() if future not in finished)
            yield from (future.result() for future in finished)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """What a process does first."""
    # Ctrl-C reaches the whole process group; only the parent has something to say about it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that was killed cannot tell its processes to end."""
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
