"""Small tables that go with a map: border segments, and what the values of a label mean."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.importers.reading import read_text

__all__ = ["read_borders", "read_rows"]

Floats = NDArray[np.float64]

MOST_BYTES = 5_000_000
ENDS = ("x0", "y0", "x1", "y1")


def read_rows(path: Path, expected: str) -> list[dict[str, Any]]:
    """Rows of a CSV file with a header line, or of a JSON list of objects; at least one.

    Parameters
    ----------
    path : Path
    expected : str
        What an error says the file should be.

    Raises
    ------
    SceneError
        If the file is neither.
    """
    text = read_text(path, expected, MOST_BYTES)
    try:
        if text.lstrip()[:1] in ("[", "{"):
            rows = json.loads(text)
        else:
            rows = list(csv.DictReader(io.StringIO(text), skipinitialspace=True))
    except (ValueError, csv.Error, RecursionError):
        raise SceneError(f"{path}: neither CSV nor JSON; expected {expected}") from None
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise SceneError(f"{path}: expected {expected}")
    if not rows:
        raise SceneError(f"{path}: no row, or no line of column names first; expected {expected}")
    return rows


def read_borders(path: Path) -> Floats:
    """Border segments: CSV with a line ``x0,y0,x1,y1`` first, or a JSON list of such objects.

    Parameters
    ----------
    path : Path

    Returns
    -------
    array, shape (b, 2, 2)
        m.

    Raises
    ------
    SceneError
        If a value is missing, or no number within ±1000 m.
    """
    expected = "border segments: columns x0,y0,x1,y1 in metres (CSV with that line first, or JSON)"
    rows = read_rows(path, expected)
    segments = np.zeros((len(rows), 4))
    for index, row in enumerate(rows):
        for column, end in enumerate(ENDS):
            segments[index, column] = _metres(row.get(end), f"{path}: border {index + 1}: {end}")
    return segments.reshape(-1, 2, 2)


def _metres(value: Any, where: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not abs(number) <= 1000.0:
        shown = "missing" if value is None else repr(value)[:60]
        raise SceneError(f"{where}: {shown}; expected a number within ±1000 m")
    return number
