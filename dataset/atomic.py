"""Files that are either old or new, never half written, and have one writer.

A new file is written beside the old one, forced to disk, and renamed over it;
a rename within one folder is atomic on every POSIX file system. The lock is
`flock` on ``FILE.lock``: the kernel drops it when the process dies, so a crash
never leaves a map locked, even if the empty lock file stays behind.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dataset.errors import RoomsegError

__all__ = ["locked", "replacing", "unwritten", "write_text"]


@contextmanager
def locked(
    path: str | Path,
    *,
    wait: bool = False,
    busy: str = "another process is writing to it; wait until it has finished",
) -> Iterator[None]:
    """Hold the one writer's lock of a file.

    Parameters
    ----------
    path : path
        The file that will be written; it need not exist yet.
    wait : bool
        For another writer to finish, instead of raising.
    busy : str
        What is said of the file if there is another writer.

    Raises
    ------
    RoomsegError
        If another process is writing to it.
    """
    # Through a link or directly: one file, one lock.
    lock = Path(f"{Path(path).resolve()}.lock")
    try:
        descriptor = _open_lock(lock, wait)
    except BlockingIOError as error:
        raise RoomsegError(f"{path}: {busy}") from error
    except OSError as error:
        raise unwritten(path, error) from error
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)


def _open_lock(lock: Path, wait: bool) -> int:
    """Take the lock; a lock file removed by its last holder meanwhile is made again."""
    while True:
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError:
            os.close(descriptor)
            raise
        with suppress(FileNotFoundError):
            if os.fstat(descriptor).st_ino == lock.stat().st_ino:
                return descriptor
        os.close(descriptor)


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Write a file beside ``path`` and rename it to ``path`` if all went well.

    A link stays, and the file that it leads to is replaced.

    Yields
    ------
    Path
        Where to write. If the body raises, that file is removed and ``path``
        is as it was.

    Raises
    ------
    RoomsegError
        If the file cannot be written, or what is there is no regular file.
    """
    target = Path(path).resolve()
    if Path(path).exists() and not Path(path).is_file():
        raise RoomsegError(f"{path}: is no regular file, expected another file name")
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield part
        force_to_disk(part)
        part.replace(target)
        force_to_disk(target.parent)
    except OSError as error:
        # Others are of files that the body reads.
        if error.filename is None or Path(os.fsdecode(error.filename)) in (part, target.parent):
            raise unwritten(path, error) from error
        raise
    finally:
        part.unlink(missing_ok=True)


def unwritten(path: str | Path, error: OSError) -> RoomsegError:
    """One line on a file that cannot be written, by the name that the user knows."""
    return RoomsegError(f"{path}: cannot be written: {error.strerror or error}")


def remove_leftovers(path: str | Path) -> None:
    """Remove parts that killed writers of ``path`` left; only under its lock."""
    path = Path(path).resolve()
    prefix = f".{path.name}."
    for part in path.parent.iterdir():
        if part.name.startswith(prefix) and part.name.endswith(".part"):
            part.unlink(missing_ok=True)


def force_to_disk(path: Path) -> None:
    """Make the content of a file or folder survive a power cut."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file atomically, UTF-8."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")
