"""Where in a TOML text a value stands.

TOML libraries give no lines of values. So the parser itself is asked: a key is in the
first beginning of the text that has it when parsed. That takes a second for a thousand
lines, but only once there is something to complain about, and knows all of TOML.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

__all__ = ["Keys", "dotted", "known_part", "line_of", "value_at"]

Keys = tuple[str | int, ...]
"""Names in tables and indices in lists, from the outside to the inside."""


def line_of(text: str, keys: Sequence[str | int]) -> int:
    """Line, from 1, on which the statement of a value begins.

    Of what is not there, that of the table that it would be in.

    Parameters
    ----------
    text : str
        Good TOML.
    keys : Keys
    """
    wanted = known_part(tomllib.loads(text), keys)
    lines = [f"{line}\n" for line in text.split("\n")] if wanted else []
    begin = 1
    for end in range(1, len(lines) + 1):
        try:
            data = tomllib.loads("".join(lines[:end]))
        except tomllib.TOMLDecodeError:
            continue  # within a statement of several lines
        if known_part(data, wanted) == wanted:
            return begin
        begin = end + 1
    return 1


def known_part(data: Any, keys: Sequence[str | int]) -> Keys:
    """The first of the keys, as far as there is something."""
    count = 0
    while count < len(keys) and value_at(data, keys[: count + 1]) is not None:
        count += 1
    return tuple(keys[:count])


def value_at(data: Any, keys: Sequence[str | int]) -> Any:
    """The value of the keys; None if there is none."""
    for key in keys:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def dotted(keys: Sequence[str | int]) -> str:
    """``places[1].seeds``."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)
    return text.removeprefix(".")
