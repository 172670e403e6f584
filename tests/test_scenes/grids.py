"""Grid maps for tests: written as ``map_server`` has them."""

from pathlib import Path

import numpy as np

HEADER = {
    "image": "map.pgm",
    "resolution": "0.05",
    "origin": "[0.0, 0.0, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def pgm(cells):
    """Bytes of a P5 picture."""
    rows, columns = cells.shape
    return (
        b"P5\n# made by a test\n%d %d\n255\n" % (columns, rows) + cells.astype(np.uint8).tobytes()
    )


def two_rooms():
    """60 x 40 cells: two rooms of 27 x 36 cells, a door of 16 cells, a chair leg."""
    cells = np.full((40, 60), 205)
    cells[1:39, 1:59] = 0
    cells[2:38, 2:29] = 254
    cells[2:38, 31:58] = 254
    cells[12:28, 29:31] = 254
    cells[30, 10] = 0
    return cells


def write_map(folder: Path, cells, **fields):
    """Write ``map.yaml`` and ``map.pgm``; a field that is None is left out."""
    (folder / "map.pgm").write_bytes(pgm(cells))
    lines = [f"{k}: {v}" for k, v in (HEADER | fields).items() if v is not None]
    path = folder / "map.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
