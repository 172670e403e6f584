"""The contact sheet of all kinds, very small."""

from __future__ import annotations

from pathlib import Path

import cv2

from render.piece_sheet import draw_piece_sheet
from scenes.pieces import KINDS


def test_every_cell_shows_a_piece(tmp_path: Path) -> None:
    path = tmp_path / "sheet.jpg"
    draw_piece_sheet(path, columns=10, cell=24, samples=2)
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    rows = -(-len(KINDS) // 10)
    assert picture.shape == (round(rows * 24 * 1.12), 240)
    height = picture.shape[0] / rows
    for place in range(len(KINDS)):
        row, column = divmod(place, 10)
        # The upper part of a cell, without its label.
        cell = picture[round(row * height) : round((row + 0.8) * height), 24 * column :][:, :24]
        assert cell.std() > 1.0, list(KINDS)[place]
