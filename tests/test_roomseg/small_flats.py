"""Apartments that are cleaned in a moment."""

from __future__ import annotations

import itertools
import json
from pathlib import Path


def two_rooms(name: str = "two", **others: object) -> dict[str, object]:
    """Two bare rooms of 1.6 m x 1.6 m, a doorway between them."""
    corners = [(-0.06, -0.06), (3.38, -0.06), (3.38, 1.66), (-0.06, 1.66), (-0.06, -0.06)]
    walls = [{"start": a, "end": b} for a, b in itertools.pairwise(corners)]
    walls.append({"start": (1.66, -0.06), "end": (1.66, 1.66)})
    return {
        "name": name,
        "rooms": [
            {"name": "a", "polygon": [[0, 0], [1.6, 0], [1.6, 1.6], [0, 1.6]]},
            {"name": "b", "polygon": [[1.72, 0], [3.32, 0], [3.32, 1.6], [1.72, 1.6]]},
        ],
        "walls": walls,
        "passages": [{"position": [1.66, 0.8]}],
        "start": {"position": [0.5, 0.5]},
    } | others


def write_rooms(name: str = "two", **others: object) -> str:
    """A file of two rooms; its name."""
    Path(f"{name}.json").write_text(json.dumps(two_rooms(name, **others)))
    return f"{name}.json"
