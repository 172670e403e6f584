"""One job for Blender in a process of its own: a picture, a scene file read or written.

The caller runs `run_task`; the child, ``python -m render.task``, reads one line of
JSON (the task's name, its arguments, a folder for what is temporary), calls
``perform(bpy, **arguments)`` of the task's module, and answers with one line. Large
data go through files that the arguments name. As in `render.worker`, the end of the
child's input ends it at once, so that nothing is left running when the caller is stopped.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
import traceback
from contextlib import suppress
from queue import SimpleQueue
from threading import Thread
from typing import IO, Any, Literal

from dataset.errors import RoomsegError
from render.libraries import load_bpy
from render.process import start_child
from render.worker import leave, read_lines
from scenes.errors import SceneError

__all__ = ["Task", "main", "run_task"]

Task = Literal["cutaway", "piece_sheet", "scene_export", "scene_import"]
"""The module of `render` that has ``perform``."""


def run_task(task: Task, **arguments: Any) -> dict[str, Any]:
    """Run a task in a child process and return its answer.

    Parameters
    ----------
    task : str
        Module of `render` with a function ``perform(bpy, **arguments) -> dict``.
    **arguments
        What JSON can hold.

    Raises
    ------
    RoomsegError
        If the task says so, or the process ends without an answer.
    OSError
        If it could not write a file; what the user calls that is not said.
    """
    with (
        tempfile.TemporaryFile() as log,
        tempfile.TemporaryDirectory(prefix="roomseg-render-") as folder,
    ):
        child = start_child("render.task", log)
        assert child.stdin is not None and child.stdout is not None
        try:
            with suppress(BrokenPipeError):
                line = json.dumps({"task": task, "arguments": arguments, "folder": folder})
                child.stdin.write(line.encode() + b"\n")
                child.stdin.flush()
            answer = child.stdout.readline()
        finally:
            _end(child)
        if not answer:
            raise RoomsegError(f"Blender: {_last_words(log, child.returncode)}")
    fields: dict[str, Any] = json.loads(answer)
    if "unwritten" in fields:
        raise OSError(fields["unwritten"])
    if "error" in fields:
        raise RoomsegError(fields["error"])
    return fields


def _end(child: subprocess.Popen[bytes]) -> None:
    """Let the child go by closing its input."""
    assert child.stdin is not None and child.stdout is not None
    with suppress(BrokenPipeError):
        child.stdin.close()
    try:
        child.wait(10.0)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()
    child.stdout.close()


def _last_words(log: IO[bytes], status: int) -> str:
    log.seek(0)
    lines = log.read().decode(errors="replace").strip().splitlines()
    return f"the process ended with {status}: {' '.join(lines[-1:])}"


def _perform(task: Task, arguments: dict[str, Any]) -> dict[str, Any]:
    """Do a task; an error that a user can cause becomes the answer."""
    module = importlib.import_module(f"render.{task}")
    try:
        answer: dict[str, Any] = module.perform(load_bpy(), **arguments)
    except (RoomsegError, SceneError) as error:
        return {"error": str(error)}
    except OSError as error:
        return {"unwritten": error.strerror or str(error)}
    return answer


def main() -> None:
    """Serve one task; leaves the process without the interpreter's shutdown."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    request = json.loads(sys.stdin.readline())
    folder = os.environ["TMPDIR"] = request["folder"]
    Thread(target=read_lines, args=(SimpleQueue(), folder), daemon=True).start()
    try:
        answer = _perform(request["task"], request["arguments"])
        channel.write(json.dumps(answer).encode() + b"\n")
        channel.flush()
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        leave(folder, 1)
    leave(folder, 0)


if __name__ == "__main__":
    main()
