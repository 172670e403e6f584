"""The error that every bad apartment ends in."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["SceneError"]


class SceneError(Exception):
    """Bad apartment; the message is one line: file, field, value, what would be right.

    ``problems`` are all that were found, one line each, without the file; empty where
    the first one was the end of reading.
    """

    def __init__(self, message: str, problems: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems)
