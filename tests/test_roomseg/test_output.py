"""Lines of figures while bars are shown."""

from __future__ import annotations

import io
import sys

import pytest

from roomseg.cli.output import follow, progress_bar, tell


class Terminal(io.StringIO):
    """A stream that says that somebody looks at it."""

    def isatty(self) -> bool:
        return True


def told(monkeypatch, out, err) -> tuple[str, str]:
    """What a line of figures and one on an error leave on both streams."""
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "stderr", err)
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar("runs") as bar:
        follow(bar, "maps")(0, 2)
        bar.refresh()
        tell(bar, "a.h5: 7 nodes [x] :ok:")
        tell(bar, "alas", err=True)
    return out.getvalue(), err.getvalue()


def test_on_a_terminal_a_line_begins_where_the_bar_was(monkeypatch):
    out, err = told(monkeypatch, Terminal(), Terminal())
    assert out == ""
    assert "\x1b[2Ka.h5: 7 nodes [x] :ok:\n" in err and "\x1b[2Kalas\n" in err


@pytest.mark.parametrize("err", [Terminal, io.StringIO])
def test_figures_go_to_the_file(monkeypatch, err):
    out, shown = told(monkeypatch, io.StringIO(), err())
    assert out == "a.h5: 7 nodes [x] :ok:\n"
    assert "a.h5" not in shown and "alas\n" in shown


@pytest.mark.parametrize("err", [Terminal, io.StringIO])
def test_bars_without_a_line_leave_nothing(monkeypatch, err):
    stream = err()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with progress_bar("images"):
        pass
    assert "\n" not in stream.getvalue()
