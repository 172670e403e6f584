"""Ctrl-C waits for the safe point, and is not lost."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator

import pytest

from dataset.interrupts import interrupts_held


@pytest.fixture(autouse=True)
def usual_handler() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def press() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def test_nothing_pressed_nothing_raised():
    with interrupts_held() as interrupt:
        interrupt()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_the_body_goes_on_until_it_asks():
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_held() as interrupt:
        press()
        done.append("before")
        interrupt()
        done.append("after")
    assert done == ["before"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_the_end_of_the_body_is_a_safe_point():
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        press()
        done.append("whole")
    assert done == ["whole"]


def test_one_hold_within_another_hands_on():
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        with interrupts_held():
            press()
        done.append("after the inner one")
    assert done == ["after the inner one"]


def test_an_error_does_not_hide_it():
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        press()
        raise ValueError


def test_ignored_stays_ignored():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interrupts_held() as interrupt:
        press()
        interrupt()


def test_other_threads_are_left_alone():
    seen = []

    def hold() -> None:
        with interrupts_held() as interrupt:
            interrupt()
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=hold)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]
