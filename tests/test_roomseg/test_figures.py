"""The figures show what they should: counted artists, colours, places, and no warnings."""

from __future__ import annotations

import sys
import warnings
from itertools import permutations

import cv2
import numpy as np
import pytest
import shapely
from cleaned_flat import (
    cleaned_flat,
    fisheye_image,
    floor,
    kept_edges,
    lanes,
    obstacles,
)
from matplotlib.colors import to_rgb
from numpy.testing import assert_allclose, assert_array_equal

from dataset.camera import FisheyeCamera
from roomseg.figures import (
    RocCurve,
    add_map_legend,
    draw_cleaning_run,
    draw_edge_pixels,
    draw_floor,
    draw_graph,
    draw_impurity_bars,
    draw_impurity_surface,
    draw_lintel_histogram,
    draw_lintel_search,
    draw_obstacle_map,
    draw_panorama,
    draw_passage_width,
    draw_roc,
    draw_room_counts,
    draw_rooms,
    finish_plan,
    match_rooms,
    new_figure,
    png_bytes,
    wrong_nodes,
)
from roomseg.figures.plans import draw_circles, lane_tracks, plan_rings
from roomseg.figures.style import BORDER_EDGE_GREEN, EDGE_RED, OBSTACLE_BLUE, room_colours
from roomseg.passage_width import passageway_widths
from roomseg.passageway import LintelParameters, LintelSearch, edge_pixels
from roomseg.report import search_lintel
from roomseg.report.views import measure_passage


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.fixture(scope="module")
def flat():
    return cleaned_flat()


@pytest.fixture(scope="module")
def real_flat():
    return cleaned_flat(real=True)


@pytest.fixture
def ax():
    return new_figure(3.0, 3.0).subplots()


def artist(ax, name):
    """The one artist of that name; drawing it must not fail."""
    png_bytes(ax.figure, dpi=40)
    found = ax.findobj(lambda a: a.get_gid() == name)
    assert len(found) == 1, f"{len(found)} artists named {name}"
    return found[0]


def test_cleaning_run_has_every_lane_with_its_start_and_arrowhead(ax, flat):
    draw_cleaning_run(ax, flat, obstacles(), title="run")
    tracks = [points for _, _, points in lanes()]
    drawn = artist(ax, "lanes").get_segments()
    assert len(drawn) == len(tracks)
    for got, want in zip(drawn, tracks, strict=True):
        assert_allclose(got, want)
    assert_allclose(artist(ax, "lane-starts").get_offsets(), [track[0] for track in tracks])
    tips = [path.vertices[0] for path in artist(ax, "lane-arrows").get_paths()]
    assert_allclose(tips, [track[-1] for track in tracks])
    assert_allclose(to_rgb(EDGE_RED), artist(ax, "lanes").get_colors()[0, :3])


def test_arrowheads_point_along_their_lanes(ax, flat):
    draw_cleaning_run(ax, flat)
    tracks = [points for _, _, points in lanes()]
    heads = [path.vertices[:3] for path in artist(ax, "lane-arrows").get_paths()]
    for head, track in zip(heads, tracks, strict=True):
        pointing, driving = head[0] - head[1:3].mean(axis=0), track[-1] - track[-2]
        assert pointing @ driving > 0.99 * np.linalg.norm(pointing) * np.linalg.norm(driving)


def test_movements_join_the_lanes_on_the_way(flat):
    tracks, travels = lane_tracks(flat.path)
    assert len(travels) == len(tracks)  # one to the first lane, one between any two
    for before, travel, after in zip(tracks, travels[1:], tracks[1:], strict=False):
        assert_allclose(travel[0], before[-1])
        assert_allclose(travel[-1], after[0])


def test_base_station_stands_where_it_is_put_or_where_the_path_begins(ax, flat):
    draw_cleaning_run(ax, flat)
    begin = flat.path.true_pose[0, :2]
    assert_allclose(artist(ax, "base-station").get_center(), begin)
    other = new_figure().subplots()
    draw_cleaning_run(other, flat, base_station=(1.0, 2.0))
    assert_allclose(artist(other, "base-station").get_center(), (1.0, 2.0))


def test_a_real_robots_run_is_drawn_from_its_nodes(ax, real_flat):
    draw_cleaning_run(ax, real_flat)
    drawn = artist(ax, "lanes").get_segments()
    assert len(drawn) == len(lanes())
    assert_allclose(np.vstack(drawn), real_flat.nodes.position)


def test_outlines_are_the_rings_of_the_plan(ax, flat):
    draw_cleaning_run(ax, flat, obstacles())
    lines = artist(ax, "obstacle-outlines")
    length = sum(
        np.linalg.norm(np.diff(ring, axis=0), axis=1).sum() for ring in lines.get_segments()
    )
    assert length == pytest.approx(obstacles().boundary.length)
    assert_allclose(lines.get_colors()[0, :3], to_rgb(OBSTACLE_BLUE))


def test_plans_may_be_arrays_and_are_closed():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    (ring,) = plan_rings([square])
    assert_array_equal(ring, [*square, square[0]])
    with pytest.raises(ValueError, match="outline"):
        plan_rings([np.zeros(4)])


def test_graph_has_every_edge_in_place(ax, flat):
    draw_graph(ax, flat, outlines=obstacles())
    segments = np.array(artist(ax, "edges").get_segments())
    assert_allclose(segments, flat.nodes.true_pose[:, :2][flat.edges])
    assert len(artist(ax, "borders").get_segments()) == len(flat.ground_truth.borders) == 6


def test_classified_edges_are_green_dashed_and_not_red(ax, flat):
    kept = kept_edges(flat)
    border = flat.ground_truth.edge_is_border[kept]
    draw_graph(ax, flat, edges=flat.edges[kept], is_border=border)
    green = artist(ax, "border-edges")
    assert 0 < len(green.get_segments()) == border.sum()
    assert len(artist(ax, "edges").get_segments()) == (~border).sum()
    assert_allclose(green.get_colors()[0, :3], to_rgb(BORDER_EDGE_GREEN))
    assert green.get_linestyles()[0][1] is not None  # dashes
    drawn = shapely.linestrings(np.array(green.get_segments()))
    lines = shapely.union_all(shapely.linestrings(flat.ground_truth.borders))
    assert shapely.intersects(drawn, lines).all()


def test_drawn_borders_lie_on_the_estimates_that_they_cross(ax, real_flat):
    draw_graph(ax, real_flat, outlines=obstacles())
    segments = np.array(artist(ax, "edges").get_segments())
    assert_allclose(segments, real_flat.nodes.position[real_flat.edges])
    assert not ax.findobj(lambda a: a.get_gid() == "obstacle-outlines")  # another frame


def test_graph_refuses_a_wrong_number_of_marks(ax, flat):
    with pytest.raises(ValueError, match="is_border"):
        draw_graph(ax, flat, is_border=[True])


def test_rooms_are_coloured_one_by_one_at_true_positions(ax, flat):
    room = flat.ground_truth.room
    draw_rooms(ax, flat.nodes, room, outlines=obstacles())
    colours = set()
    for name in np.unique(room):
        circles = artist(ax, f"room-{name}")
        assert_allclose(circles.get_offsets(), flat.nodes.true_pose[room == name, :2])
        colours.add(tuple(circles.get_facecolor()[0]))
    assert len(colours) == 3


def test_predicted_rooms_take_the_true_colours_and_ring_the_wrong_nodes(ax, flat):
    truth = flat.ground_truth.room
    renamed = np.array([7, 3, 5])[truth]
    wrong = (flat.nodes.true_pose[:, 0] > 6.0) & (truth == 2)
    predicted = np.where(wrong, 7, renamed)  # 7 is the true room 0
    draw_rooms(ax, flat.nodes, predicted, truth=truth)
    other = new_figure().subplots()
    draw_rooms(other, flat.nodes, truth)
    ringed = 0
    for name in range(3):
        circles = artist(ax, f"room-{name}")
        assert_allclose(circles.get_facecolor(), artist(other, f"room-{name}").get_facecolor())
        ringed += int((np.ravel(circles.get_linewidths()) > 0.5).sum())
    assert ringed == wrong.sum() > 0
    assert_array_equal(wrong_nodes(predicted, truth), wrong)


def test_a_real_robots_rooms_are_drawn_on_its_obstacle_points(ax, real_flat):
    draw_rooms(
        ax,
        real_flat.nodes,
        real_flat.ground_truth.room,
        points=real_flat.obstacles.position,
        outlines=obstacles(),
    )
    assert_allclose(artist(ax, "obstacle-points").get_offsets(), real_flat.obstacles.position)
    assert not ax.findobj(lambda a: a.get_gid() == "obstacle-outlines")


def test_match_rooms_maximises_overlap_over_all_assignments():
    rng = np.random.default_rng(3)
    truth = rng.integers(0, 4, 60)
    predicted = np.where(rng.random(60) < 0.5, truth[::-1], (truth + 1) % 4)
    best = max(int((np.array(names)[predicted] == truth).sum()) for names in permutations(range(4)))
    assert (match_rooms(predicted, truth) == truth).sum() == best


def test_match_rooms_names_spare_rooms_anew_and_copes_with_fewer():
    assert_array_equal(match_rooms([5, 5, 5, 8, 9, 9], [1, 1, 1, 1, 2, 2]), [1, 1, 1, 3, 2, 2])
    assert_array_equal(match_rooms([0, 0, 0], [4, 4, 6]), [4, 4, 4])
    # What is left of both has nothing in common.
    assert_array_equal(match_rooms([7, 7, 8, 8], [1, 1, 1, 2]), [1, 1, 2, 2])
    assert_array_equal(match_rooms([7, 7, 7, 8], [1, 2, 2, 2]), [2, 2, 2, 3])
    with pytest.raises(ValueError, match="predicted"):
        match_rooms([0, 1], [0, 1, 2])


def test_room_colours_differ_and_stay_colours():
    colours = room_colours(27)
    assert ((colours >= 0) & (colours <= 1)).all()
    distance = np.linalg.norm(colours[:, None] - colours[None], axis=2)
    assert distance[~np.eye(27, dtype=bool)].min() > 0.03
    assert room_colours(0).shape == (0, 3)


def test_floor_is_the_free_area(ax):
    draw_floor(ax, floor(), obstacles())
    polygons = artist(ax, "floor").get_path().to_polygons()
    area = shapely.Polygon()
    for ring in polygons:
        area = area.symmetric_difference(shapely.Polygon(ring))
    assert area.area == pytest.approx(floor().difference(obstacles()).area)


def test_obstacle_map_is_in_the_estimates_frame(ax, flat):
    draw_obstacle_map(ax, flat)
    assert_allclose(artist(ax, "obstacle-points").get_offsets(), flat.obstacles.position)


@pytest.mark.parametrize(("draw", "length"), [(draw_obstacle_map, 5.0), (draw_cleaning_run, 5.0)])
def test_scale_bar_is_as_long_as_it_says_and_hides_nothing(ax, flat, draw, length):
    draw(ax, flat)
    png_bytes(ax.figure, dpi=40)
    cells = ax.findobj(lambda a: a.get_gid() == "scale-bar")
    assert len(cells) == 10
    left = min(cell.get_x() for cell in cells)
    right = max(cell.get_x() + cell.get_width() for cell in cells)
    top = max(cell.get_y() + cell.get_height() for cell in cells)
    assert right - left == pytest.approx(length)
    assert any(text.get_text() == "5 m" for text in ax.texts)
    assert top < flat.nodes.true_pose[:, 1].min()
    assert ax.get_aspect() == 1.0


def test_cones_have_the_radii_of_the_paper(ax):
    camera = FisheyeCamera()
    draw_lintel_search(ax, fisheye_image(camera), camera)
    png_bytes(ax.figure, dpi=40)
    cones = ax.findobj(lambda a: a.get_gid() == "cone")
    radii = sorted(cone.get_radius() for cone in cones)
    assert radii == pytest.approx([22.0, 46.0], abs=1.0)  # 18 and 38 degrees
    assert {cone.get_center() for cone in cones} == {(232.0, 232.0)}


def test_edge_pixels_are_where_the_method_found_them(ax):
    camera, parameters = FisheyeCamera(), LintelParameters()
    image = fisheye_image(camera, seed=1)
    view = search_lintel(1, image, camera)
    search = LintelSearch.of(camera, parameters)
    theta, s, _ = edge_pixels(image, search, parameters.min_intensity)
    assert len(view.pixels) == len(theta) > 50
    assert_array_equal(view.theta, theta)
    offset = view.pixels[:, ::-1] + 0.5 - np.array(camera.disc_centre[::-1])
    again = offset[:, 0] * np.cos(theta) + offset[:, 1] * np.sin(theta)
    assert_allclose(again, s, atol=1e-9)
    draw_edge_pixels(ax, image, camera, pixels=view.pixels, theta=view.theta)
    squares = artist(ax, "edge-pixels")
    corners = np.array([path.vertices.min(axis=0) for path in squares.get_paths()])
    assert_allclose(corners, view.pixels[:, ::-1])
    assert len(np.unique(squares.get_facecolor(), axis=0)) > 1


@pytest.mark.parametrize("angle", [0.0, 0.8, 2.0])
def test_the_marked_maximum_is_the_line_in_the_image(ax, angle):
    camera = FisheyeCamera()
    rows, columns = np.indices(camera.image_size) + 0.5
    along = np.cos(angle) * (columns - 232.0) + np.sin(angle) * (rows - 232.0)
    image = cv2.GaussianBlur(np.where(along > 10.0, 200, 60).astype(np.uint8), (0, 0), 0.8)
    view = search_lintel(0, image, camera)
    draw_lintel_histogram(
        ax,
        view.histogram,
        directions=view.directions,
        offsets=view.offsets,
        offset_limit=view.offset_limit,
    )
    (s,), (theta,) = artist(ax, "maximum").get_data()
    assert s == pytest.approx(10.0, abs=2.8)
    difference = (theta - np.degrees(angle) + 90.0) % 180.0 - 90.0
    assert abs(difference) < 11.0
    assert artist(ax, "histogram").get_array().max() == view.histogram.max()


def test_panorama_axes_are_azimuth_and_elevation(ax):
    draw_panorama(ax, np.zeros((48, 288), np.uint8), "node 3")
    assert artist(ax, "panorama").get_extent() == [0, 360, 0, 75]


def test_roc_marks_youdens_j():
    rate = np.array([0.0, 0.1, 0.4, 1.0])
    curve = RocCurve("length", rate, np.array([0.0, 0.6, 0.8, 1.0]), 0.8)
    assert curve.youden == (1, pytest.approx(0.5))
    ax = new_figure().subplots()
    draw_roc(ax, [curve])
    x, y = artist(ax, "youden").get_data()
    assert_allclose([x, y], [[0.1, 0.1], [0.1, 0.6]])
    assert "AUC 0.80, J 0.50" in ax.get_legend().get_texts()[0].get_text()
    draw_roc(new_figure().subplots(), [])


def test_passage_width_joins_the_closest_points(ax):
    points = np.array([[0.0, 0.5], [0.1, -0.4], [0.3, 0.9]])
    draw_passage_width(
        ax, [[-0.1, 0.0], [0.1, 0.0]], obstacles=points, closest=points[:2], strip=(-0.22, 0.27)
    )
    assert_allclose(np.transpose(artist(ax, "width").get_data()), points[:2])
    sides = ax.findobj(lambda a: a.get_gid() == "search-area")
    assert_allclose([side.get_xdata() for side in sides], [[-0.22] * 2, [0.27] * 2])
    assert f"L = {np.hypot(0.1, 0.9):.2f} m" in [text.get_text() for text in ax.texts]
    draw_passage_width(
        new_figure().subplots(),
        [[0, 0], [0, 1]],
        obstacles=np.empty((0, 2)),
        closest=None,
        strip=(-1, 1),
    )


def test_the_passage_shown_is_the_width_that_the_method_measures(flat):
    edges = flat.edges[flat.ground_truth.edge_is_border].astype(np.int64)
    widths = passageway_widths(flat, edges)
    measured = np.sort(widths[widths < 5.0])
    view = measure_passage(flat)
    assert view.width == measured[len(measured) // 2]
    assert np.linalg.norm(view.closest[1] - view.closest[0]) == pytest.approx(view.width)
    assert (view.closest[:, None] == view.obstacles[None]).all(axis=2).any(axis=1).all()
    ends = (flat.nodes.position[edges] == view.ends).all(axis=(1, 2))
    assert ends.sum() == 1 and widths[ends] == view.width
    assert measure_passage(flat, flat.edges[:5]) is None  # none of them crosses a border


def test_charts_of_the_experiments(ax):
    draw_impurity_bars(ax, {"default": 3.0, "uniform": 13.0}, {"uniform": 12.91})
    assert sorted(p.get_height() for p in ax.patches) == [3.0, 12.91, 13.0]
    other = new_figure().subplots()
    draw_impurity_surface(other, [-3, -1, 1], [-5, -3], [[0.2, 0.1, 0.3], [0.04, 0.2, 0.5]])
    assert artist(other, "best").get_data() == ([-3], [-3])
    third = new_figure().subplots()
    draw_room_counts(third, ["a", "a", "b"], [600, 650, 2000], [3, 3, 9])
    assert [t.get_text() for t in third.get_legend().get_texts()] == ["a", "b"]
    for axes in (ax, other, third):
        png_bytes(axes.figure, dpi=40)


def test_the_same_figure_gives_the_same_bytes_and_no_global_figure(flat):
    def draw():
        figure = new_figure()
        draw_rooms(figure.subplots(), flat.nodes, flat.ground_truth.room, outlines=obstacles())
        return png_bytes(figure, dpi=60)

    first = draw()
    assert first == draw()
    assert cv2.imdecode(np.frombuffer(first, np.uint8), cv2.IMREAD_COLOR) is not None
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or not pyplot.get_fignums()


def legend_of(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_one_legend_names_what_the_panels_show(flat, real_flat):
    figure = new_figure()
    draw_obstacle_map(figure.add_subplot(1, 2, 1), real_flat)
    draw_graph(figure.add_subplot(1, 2, 2), real_flat)
    add_map_legend(figure)
    assert legend_of(figure)[:3] == ["obstacle point", "edge", "room border"]
    truth = np.asarray(flat.ground_truth.room)
    for room, wrong in ((truth, False), (np.where(np.arange(len(truth)) == 5, 99, truth), True)):
        figure = new_figure()
        draw_rooms(figure.add_subplot(), flat.nodes, room, truth=truth)
        add_map_legend(figure)
        assert ("node in a wrong room" in legend_of(figure)) == wrong
        assert "node in the colour of its room" in legend_of(figure)


def test_nodes_of_a_tiny_map_are_not_cut_off(ax):
    centres = np.array([[1.0, 1.0], [1.1, 1.0]])
    draw_circles(ax, centres, 0.13)
    finish_plan(ax)
    assert ax.get_xlim()[0] < 1.0 - 0.065
    assert ax.get_xlim()[1] > 1.1 + 0.065
    assert ax.get_ylim()[1] > 1.0 + 0.065
