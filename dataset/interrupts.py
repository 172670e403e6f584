"""Ctrl-C at safe points only.

Python raises `KeyboardInterrupt` in whatever Python code runs next, also in the little
that compiled code calls: numba as it makes a tuple, HDF5 as it writes to a Python file.
There nobody looks for an exception, and the process crashes.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["interrupts_held"]


@contextmanager
def interrupts_held() -> Iterator[Callable[[], None]]:
    """Hold Ctrl-C back until the end of the body, or until it asks.

    Does nothing in threads other than the main one, which Python never interrupts, and
    where Ctrl-C is ignored or ends the process at once.

    Yields
    ------
    callable
        Lets a Ctrl-C that came meanwhile do what it does: as a rule raise `KeyboardInterrupt`.
    """
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield lambda: None
        return
    came: list[FrameType | None] = []

    def look() -> None:
        if came:
            usual(signal.SIGINT, came.pop())

    signal.signal(signal.SIGINT, lambda _, frame: came.append(frame))
    try:
        yield look
    finally:
        signal.signal(signal.SIGINT, usual)
        look()
