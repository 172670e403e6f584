"""Work in several processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from dataset import RoomsegError
from roomseg.cli.parallel import in_processes


def test_every_result_comes_once():
    assert sorted(in_processes(abs, [-3, 1, -2, 0], 2)) == [0, 1, 2, 3]


def test_an_error_of_the_work_is_passed_on():
    with pytest.raises(ValueError, match="invalid literal"):
        list(in_processes(int, ["1", "one"], 2))


def die_over_three(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_a_process_that_dies_loses_its_own_work_only():
    found = in_processes(die_over_three, [1, 2, 3, 4, 5, 6], 2, lost=lambda number: -number)
    assert sorted(found) == [-3, 1, 2, 4, 5, 6]


def test_a_process_that_dies_is_one_line_where_nobody_minds():
    with pytest.raises(RoomsegError, match="a process died, twice; call the command again"):
        list(in_processes(die_over_three, [3], 2))


def die_once(number: int, marker: Path) -> int:
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_what_was_killed_is_tried_again(tmp_path):
    work = partial(die_once, marker=tmp_path / "died")
    assert sorted(in_processes(work, [1, 2, 3, 4], 2)) == [1, 2, 3, 4]


def children_of(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in text.split()]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="reads /proc")
def test_processes_end_with_their_parent():
    code = (
        "import time; from roomseg.cli.parallel import in_processes\n"
        "if __name__ == '__main__': list(in_processes(time.sleep, [60, 60], 2))"
    )
    parent = subprocess.Popen([sys.executable, "-c", code])
    deadline = time.monotonic() + 30.0
    while len(children_of(parent.pid)) < 3 and time.monotonic() < deadline:
        time.sleep(0.1)
    # Two workers, and what Python keeps to look after shared resources.
    children = children_of(parent.pid)
    assert len(children) == 3
    time.sleep(1.0)
    parent.kill()
    parent.wait()
    while any(Path(f"/proc/{child}").exists() for child in children):
        assert time.monotonic() < deadline
        time.sleep(0.1)
