"""The cut-away picture: what is cut, how light becomes colour, and one real picture."""

from __future__ import annotations

import hashlib

import cv2
import numpy as np
import pytest
import shapely

from dataset.errors import RoomsegError
from render.cutaway import EXPOSURE, LID, cut_solids, draw_cutaway, to_srgb
from render.scene_export import write_scene
from scenes import Apartment, Prism, apartment_solids
from scenes.solids import WALL

SIZE = 320
RED = (0.6, 0.02, 0.02)
CORNERS = [(-0.1, -0.1), (7.2, -0.1), (7.2, 3.1), (-0.1, 3.1)]


def place(**changes) -> Apartment:
    """A red-floored room [0, 4] x [0, 3] and a blue-floored one [4.1, 7.1] x [0, 3]."""
    fields = {
        "name": "two",
        "rooms": [
            {"name": "a", "polygon": [(0, 0), (4, 0), (4, 3), (0, 3)], "floor": "red"},
            {"name": "b", "polygon": [(4.1, 0), (7.1, 0), (7.1, 3), (4.1, 3)], "floor": "blue"},
        ],
        "walls": [
            *(
                {"start": a, "end": b, "thickness": 0.2}
                for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)
            ),
            {"start": (4.05, -0.1), "end": (4.05, 3.1), "thickness": 0.1},
        ],
        "passages": [{"position": (4.05, 0.8), "width": 0.8}],
        "furniture": [{"kind": "wardrobe", "position": (6.3, 2.6)}],
        "materials": {"red": {"colour": RED}, "blue": {"colour": RED[::-1]}},
        "start": {"position": (1, 1)},
    }
    return Apartment.model_validate(fields | changes)


def test_nothing_is_left_above_the_cut():
    solids = apartment_solids(place())
    left = list(cut_solids(solids, 1.6))
    assert max(prism.top for prism in left) == 1.6
    # What is below the cut is there as it was: by volume, to every solid.
    below = sum(p.footprint.area * max(0.0, min(p.top, 1.6) - p.bottom) for p in solids)
    assert sum(prism.volume for prism in left) == pytest.approx(below, rel=1e-12)


def test_cut_walls_have_lids_and_furniture_has_not():
    solids = apartment_solids(place())
    lids = [prism for prism in cut_solids(solids, 1.6) if prism.material == LID]
    walls = [prism for prism in solids if prism.material == WALL and prism.bottom < 1.6]
    assert shapely.union_all([lid.footprint for lid in lids]).equals_exact(
        shapely.union_all([wall.footprint for wall in walls]), 1e-9
    )
    assert all(lid.top == 1.6 for lid in lids)


def test_what_begins_above_the_cut_or_ends_below_it_stays_whole_or_goes():
    low = Prism(shapely.box(0, 0, 1, 1), 0.0, 0.7, "wood")
    high = Prism(shapely.box(0, 0, 1, 1), 2.0, 2.7, WALL)
    thin = Prism(shapely.box(0, 0, 1, 1), 1.59, 2.7, WALL)
    assert list(cut_solids([low, high, thin], 1.6)) == [low]


def test_middle_grey_stays_and_highlights_roll_off():
    grey = np.full((1, 1, 4), 0.18 / EXPOSURE, np.float32)
    assert to_srgb(grey).tolist() == [[[118, 118, 118]]]  # sRGB of 18 %
    ramp = np.linspace(0.0, 30.0, 4000, dtype=np.float32)[:, None, None] * np.ones((1, 1, 3))
    tones = to_srgb(ramp)[:, 0, 0].astype(int)
    assert tones[0] == 0
    assert tones[-1] == 255
    assert (np.diff(tones) >= 0).all()
    assert to_srgb(np.full((1, 1, 3), -1.0, np.float32)).max() == 0


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    path = tmp_path_factory.mktemp("cutaway") / "two.png"
    draw_cutaway(place(), path, size=SIZE, samples=4)
    assert [item.name for item in path.parent.iterdir()] == ["two.png"]
    return cv2.imread(str(path))[..., ::-1].astype(int)


def pixel(picture, x: float, y: float):
    """The pixel about a point of the plan: the building's box fills all but the margins."""
    rows, columns, _ = picture.shape
    column = columns * (0.04 + 0.92 * (x + 0.2) / 7.5)
    row = rows * (1.0 - 0.08 - 0.84 * (y + 0.2) / 3.4)
    return picture[round(row), round(column)]


def test_picture_is_as_large_as_asked_for_and_as_long_as_the_building(picture):
    rows, columns, _ = picture.shape
    assert columns == SIZE
    assert 7.5 / 3.4 * 0.7 < columns / rows < 7.5 / 3.4 * 1.1


def test_floors_are_seen_without_ceilings_each_in_its_place(picture):
    for x in (1.0, 2.0, 3.0):
        red, green, blue = pixel(picture, x, 1.5)
        assert red > 90
        assert red > 2 * max(green, blue)
    for x in (5.0, 6.2):
        red, green, blue = pixel(picture, x, 1.3)
        assert blue > 90
        assert blue > 2 * max(red, green)


def test_walls_are_cut_dark_and_the_wall_between_has_its_gap(picture):
    rows, columns, _ = picture.shape
    brightness = picture.max(axis=2)
    # The wall at x = 4.05 is seen as a dark stripe at y = 2.4 but not at the passage.
    middle = slice(round(0.5 * columns), round(0.62 * columns))
    assert brightness[round(0.3 * rows), middle].min() < 85
    assert brightness[round(0.66 * rows), middle].min() > 85
    dark = brightness < 85
    assert 0.1 < dark.mean() < 0.35


def test_the_building_is_in_the_picture_whole_and_fills_it(picture):
    brightness = picture.max(axis=2)
    rim = np.concatenate([brightness[0], brightness[-1], brightness[:, 0], brightness[:, -1]])
    assert rim.min() > 150
    columns = np.flatnonzero((brightness < 85).any(axis=0))
    assert columns[0] < 0.08 * SIZE
    assert columns[-1] > 0.92 * SIZE


def test_a_scene_of_its_own_is_cut_as_well(tmp_path, picture):
    blend, path = tmp_path / "two.blend", tmp_path / "two.png"
    write_scene(place(), blend)
    file = {"file": blend.name, "sha256": hashlib.sha256(blend.read_bytes()).hexdigest()}
    draw_cutaway(place(scene_file=file), path, size=SIZE, samples=4, folder=tmp_path)
    own = cv2.imread(str(path))[..., ::-1].astype(int)
    assert own.shape == picture.shape
    assert np.abs(own - picture).mean() < 8


def test_bad_names_and_missing_scene_files_are_refused_and_leave_nothing(tmp_path):
    with pytest.raises(RoomsegError, match=r"two.gif: not a picture's name.* \.png"):
        draw_cutaway(place(), tmp_path / "two.gif")
    scanned = place(scene_file={"file": "scan.blend", "sha256": "0" * 64})
    with pytest.raises(RoomsegError, match=r"scan.blend: the 3D scene of 'two'"):
        draw_cutaway(scanned, tmp_path / "two.png", size=64, folder=tmp_path)
    assert not list(tmp_path.iterdir())
