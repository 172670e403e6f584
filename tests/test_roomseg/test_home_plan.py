"""The plan of an apartment: names, areas, signs and a true scale."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
from matplotlib.transforms import Bbox

from roomseg.cli.home_plan import SINGLE, group_of, home_plan
from roomseg.cli.main import main
from roomseg.figures import figure_bytes, home_plan_figure
from roomseg.figures.labels import place_label
from roomseg.figures.plan import GROUPS, plan_scale
from scenes import Apartment, floor_area, generate_apartment, load_apartment
from scenes.pieces import KINDS

INNER_WALL = {"start": (3.05, -0.1), "end": (3.05, 2.1), "thickness": 0.1}


def home(**changes) -> Apartment:
    """Two rooms of 3 m x 2 m and 1 m x 2 m, a doorway between them, a closed door outside."""
    corners = [(-0.1, -0.1), (4.2, -0.1), (4.2, 2.1), (-0.1, 2.1)]
    fields = {
        "name": "home",
        "rooms": [
            {"name": "parlour", "polygon": [(0, 0), (3, 0), (3, 2), (0, 2)]},
            {"name": "cell", "polygon": [(3.1, 0), (4.1, 0), (4.1, 2), (3.1, 2)]},
        ],
        "walls": [
            *(
                {"start": a, "end": b, "thickness": 0.2}
                for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
            ),
            INNER_WALL,
        ],
        "passages": [
            {"position": (3.05, 0.8), "width": 0.8, "frame": {}},
            {"position": (-0.1, 1.0), "width": 0.9, "closed": True},
        ],
        "start": {"position": (0.5, 0.5), "heading_deg": 90},
    }
    return Apartment.model_validate(fields | changes)


def figure_of(apartment: Apartment):
    figure = home_plan_figure(home_plan(apartment))
    figure_bytes(figure, ".png", 50)
    return figure


def named(figure, name):
    return figure.findobj(lambda artist: artist.get_gid() == name)


def legend_of(figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def area_of(patch) -> float:
    """Area in m², rings of holes subtracting."""
    rings = patch.get_path().to_polygons(closed_only=True)
    shape = shapely.Polygon()
    for ring in rings:
        shape = shape.symmetric_difference(shapely.Polygon(ring))
    return shape.area


def test_rooms_have_their_names_and_areas():
    figure = figure_of(home())
    assert [label.get_text() for label in named(figure, "room-label")] == [
        "parlour\n6.0 m²",
        "cell\n2.0 m²",
    ]
    assert [area_of(patch) for patch in named(figure, "room")] == pytest.approx([6.0, 2.0])


def test_a_threshold_is_a_strip_in_its_doorway():
    sill = {"position": (3.05, 0.8), "width": 0.8, "threshold": {"depth": 0.05}}
    (strip,) = named(figure_of(home(passages=[sill])), "threshold")
    assert area_of(strip) == pytest.approx(0.8 * 0.05)
    assert not named(figure_of(home()), "threshold")


def test_the_building_without_its_openings_is_black():
    figure = figure_of(home(windows=[{"position": (1.5, -0.1), "width": 1.2}]))
    outside, rooms = 4.5 * 2.4, 8.0
    openings = 0.8 * 0.1 + 0.9 * 0.2 + 1.2 * 0.2
    (walls,) = named(figure, "walls")
    assert area_of(walls) == pytest.approx(outside - rooms - openings, abs=1e-6)
    assert area_of(named(figure, "window")[0]) == pytest.approx(1.2 * 0.2)
    assert sum(area_of(door) for door in named(figure, "door")) == pytest.approx(0.26)
    (leaf,) = named(figure, "door-leaf")
    low, high = leaf.get_path().vertices.min(axis=0), leaf.get_path().vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [(-0.12, 0.55), (-0.08, 1.45)])


def test_a_frame_lines_its_doorway():
    (frame,) = named(figure_of(home()), "door-frame")
    vertices = frame.get_path().vertices
    # 2 cm in front of either wall face, 7 cm beyond either side of the clear width.
    np.testing.assert_allclose(vertices.min(axis=0), (2.98, 0.33))
    np.testing.assert_allclose(vertices.max(axis=0), (3.12, 1.27))
    middle = (vertices[:, 1] > 0.4 + 1e-9) & (vertices[:, 1] < 1.2 - 1e-9)
    assert not middle.any()


def test_the_legend_names_what_is_there_and_nothing_else():
    assert legend_of(figure_of(home())) == ["doorway", "closed door", "overhead", "base station"]
    furniture = [
        {"kind": "sofa", "position": (1.5, 1.5)},
        {"kind": "toilet", "position": (3.6, 1.6)},
        {"kind": "picture", "position": (1.5, 0.02), "elevation": 1.4},
    ]
    passages = [{"position": (3.05, 0.8), "width": 0.8, "lintel_height": None}]
    lamps = [{"position": (1, 1)}]
    figure = figure_of(home(furniture=furniture, passages=passages, lamps=lamps))
    expected = ["seating", "bathroom", "lamps", "decoration", "hung", "doorway", "base station"]
    assert legend_of(figure) == expected
    step = {"polygon": [(0, 0), (1, 0), (1, 1), (0, 1)], "bottom": 2.2}
    column = {"polygon": [(2, 1), (2.3, 1), (2.3, 1.3)], "material": "stone"}
    border = [((2.0, 0.0), (2.0, 1.0))]
    figure = figure_of(home(passages=passages, blocks=[step, column], borders=border))
    expected = ["doorway", "column, block", "overhead", "room border", "base station"]
    assert legend_of(figure) == expected
    assert area_of(named(figure, "overhead")[0]) == pytest.approx(1.0)


def test_furniture_is_drawn_where_it_stands_higher_parts_last():
    furniture = [
        {"kind": "chair", "position": (1.0, 1.0)},
        {"kind": "table", "position": (1.0, 1.2)},
    ]
    drawn = named(figure_of(home(furniture=furniture)), "furniture")
    areas = [area_of(patch) for patch in drawn]
    # The table's top covers the seat; only the chair's back is higher.
    assert areas.index(pytest.approx(1.4 * 0.8)) > areas.index(pytest.approx(0.44 * 0.48, rel=0.3))
    union = shapely.union_all(
        [shapely.Polygon(patch.get_path().to_polygons()[0]) for patch in drawn]
    )
    np.testing.assert_allclose(union.bounds, (0.3, 0.76, 1.7, 1.6), atol=1e-6)


@pytest.mark.parametrize(("extent", "scale"), [(0.9, 20), (6.8, 20), (8.0, 50), (20.0, 100)])
def test_scale_is_the_largest_that_fits(extent, scale):
    assert plan_scale(extent) == scale


@pytest.mark.parametrize("place", ["demo1", "sim4"])
def test_a_metre_measures_what_the_scale_says(place):
    figure = figure_of(load_apartment(place))
    scale = int(named(figure, "scale")[0].get_text().removeprefix("1:"))
    ax = figure.axes[0]
    (x0, y0), (x1, y1) = ax.transData.transform([(0.0, 0.0), (1.0, 1.0)]) / figure.dpi * 0.0254
    assert x1 - x0 == pytest.approx(1.0 / scale, rel=1e-6)
    assert y1 - y0 == pytest.approx(1.0 / scale, rel=1e-6)


def test_printed_drawing_keeps_the_scale():
    drawn = figure_bytes(home_plan_figure(home_plan(home())), ".svg")
    root = ET.fromstring(drawn.decode())
    room = root.find(".//*[@id='walls']/*")
    numbers = [float(word) for word in room.get("d").split() if word[0] in "-0123456789"]
    x = np.array(numbers).reshape(-1, 2)[:, 0]
    # Points (1/72 inch) of the paper: 4.5 m at 1:20.
    assert np.ptp(x) * 0.0254 / 72.0 == pytest.approx(4.5 / 20.0, rel=1e-3)


@pytest.mark.parametrize("rooms", [3, 8, 12])
def test_labels_stay_in_their_rooms_and_off_each_other(rooms):
    apartment = generate_apartment(5, rooms=rooms, area=12.5 * rooms)
    figure = figure_of(apartment)
    labels = named(figure, "room-label")
    assert [label.get_text().split("\n")[0] for label in labels] == [
        room.name for room in apartment.rooms
    ]
    ax = figure.axes[0]
    boxes = []
    for label, room in zip(labels, apartment.rooms, strict=True):
        corners = ax.transData.inverted().transform(label.get_window_extent().get_points())
        assert shapely.Polygon(room.polygon).buffer(0.05).covers(shapely.box(*corners.ravel()))
        boxes.append(label.get_window_extent())
    assert not any(Bbox.intersection(a, b) for i, a in enumerate(boxes) for b in boxes[:i])
    areas = [float(label.get_text().split("\n")[1].removesuffix(" m²")) for label in labels]
    assert sum(areas) == pytest.approx(floor_area(apartment), abs=0.05 * len(areas))


def test_label_turns_in_a_narrow_room_and_is_never_left_out():
    narrow = shapely.box(0.0, 0.0, 0.6, 5.0)
    label = place_label(narrow, shapely.Polygon(), ["corridor"], 0.5)
    assert label.rotation == 90
    assert narrow.contains(shapely.Point(label.x, label.y))
    hole = shapely.box(0.0, 0.0, 0.1, 0.1)
    assert place_label(hole, hole, ["a_very_long_name_of_a_tiny_room"], 0.5).size == 4.0


def test_every_kind_of_piece_has_a_group():
    groups = {kind: group_of(kind) for kind in KINDS}
    assert set(groups.values()) <= set(GROUPS) - {"other"}
    assert set(SINGLE) <= set(KINDS)
    wanted = {"sofa": "seating", "bed": "beds", "toilet": "bathroom", "radiator": "heating"}
    assert wanted.items() <= groups.items()


def test_same_figure_same_bytes():
    for suffix in (".png", ".svg", ".pdf"):
        first, second = (
            figure_bytes(home_plan_figure(home_plan(home())), suffix, 60) for _ in range(2)
        )
        assert first == second
        assert first[:4] == {".png": b"\x89PNG", ".svg": b"<?xm", ".pdf": b"%PDF"}[suffix]


def test_view_of_an_apartment(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("plan.png", "plan.svg", "plan.pdf"):
        assert main(["view", "demo1", "-o", name, "--dpi", "60"]) == 0
    picture = cv2.imread("plan.png")
    assert picture.shape[1] > 200
    assert picture.min() < 60 < 250 < picture.max()
    ET.parse(io.BytesIO(Path("plan.svg").read_bytes()))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.pdf", "plan.png", "plan.svg"]
