"""Files read whole: size first, then text, then JSON, one line for what is wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from scenes.errors import SceneError

__all__ = ["read_bytes", "read_json", "read_text"]

LARGEST_TEXT = 20_000_000
"""Bytes; the largest plans of the data sets read here have a few hundred thousand."""


def read_bytes(path: str | Path, limit: int, expected: str) -> bytes:
    """The content of a file.

    Parameters
    ----------
    path : path
    limit : int
        Bytes that it may have.
    expected : str
        What an error says the file should be.

    Raises
    ------
    SceneError
        If it cannot be read, or has more than ``limit`` bytes.
    """
    try:
        size = Path(path).stat().st_size
        if size > limit:
            raise SceneError(
                f"{path}: {size / 1e6:.1f} MB; expected {expected}, at most {limit / 1e6:g} MB"
            )
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{path}: cannot be read: {reason}") from None


def read_text(path: str | Path, expected: str, limit: int = LARGEST_TEXT) -> str:
    """The text of a file, UTF-8; errors as `read_bytes`.

    Raises
    ------
    SceneError
        If it is empty, or no text, too.
    """
    data = read_bytes(path, limit, expected)
    if not data.strip():
        raise SceneError(f"{path}: the file is empty; expected {expected}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: byte {error.start} is not text; expected {expected}") from None


def read_json(path: str | Path, expected: str) -> Any:
    """The data of a JSON file; errors as `read_text`.

    Raises
    ------
    SceneError
        If it is no JSON, or has a number that is not finite, too.
    """

    def constant(name: str) -> Any:
        raise SceneError(f"{path}: {name} is not a JSON number; expected a finite one")

    text = read_text(path, expected)
    try:
        return json.loads(text, parse_constant=constant)
    except json.JSONDecodeError as error:
        if _is_cut_off(text, error):
            last = text.count("\n", 0, len(text.rstrip())) + 1
            raise SceneError(
                f"{path}: the JSON ends in the middle, in line {last}: the file is damaged or cut "
                "off; expected all of it"
            ) from None
        where = f"line {error.lineno}, column {error.colno}"
        raise SceneError(f"{path}: {where}: not JSON: {error.msg}; expected {expected}") from None
    except (RecursionError, ValueError):
        raise SceneError(
            f"{path}: nested too deeply or a number too long; expected {expected}"
        ) from None


def _is_cut_off(text: str, error: json.JSONDecodeError) -> bool:
    """Whether more text could have mended it: JSON has begun, and is well until the end."""
    begun = text.lstrip().startswith(("{", "["))
    rest = text[error.pos :].strip()
    words = ("true", "false", "null", "-", ".", "e-", "e+", "E-", "E+")
    ended = any(word.startswith(rest) for word in words)
    in_text = error.msg.startswith("Unterminated string")
    in_escape = error.msg.startswith("Invalid \\u") and len(rest) <= len("uFFFF")
    return begun and (ended or in_text or in_escape)
