"""Work in several processes."""

from __future__ import annotations

import os

import pytest

from dataset import RoomsegError
from roomseg.cli.parallel import in_processes


def test_every_result_comes_once():
    assert sorted(in_processes(abs, [-3, 1, -2, 0], 2)) == [0, 1, 2, 3]


def test_a_process_that_dies_is_one_line():
    with pytest.raises(RoomsegError, match="a process died; call the command again"):
        list(in_processes(os._exit, [3, 3], 2))


def test_an_error_of_the_work_is_passed_on():
    with pytest.raises(ValueError, match="invalid literal"):
        list(in_processes(int, ["1", "one"], 2))
