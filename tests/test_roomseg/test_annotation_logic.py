"""Drawing, cutting, identities, corrections: the annotation without a page (§3.1.1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components, dijkstra
from test_ground_truth import rows_map

from dataset.borders import crosses_border
from dataset.errors import RoomsegError
from roomseg.annotation import correction
from roomseg.annotation.carrying import carried_to_map
from roomseg.annotation.cut import CuttableMap
from roomseg.annotation.drawing import Border, Drawing, Room, ranges_of
from roomseg.annotation.history import History
from roomseg.annotation.identity import identified, room_of_nodes
from roomseg.annotation.pointer import border_at, line_at, pressed
from roomseg.annotation.suggestion import dividing_lines, suggested_lines
from roomseg.spectral import adjacency

CORRIDOR = replace(rows_map((), 1), ground_truth=None)
"""Four lanes 0.3 m apart along x = 0 .. 3.9 m."""
FLAT = cleaned_flat()
# The machine may be busy; how long an example takes says nothing about it.
PATIENT = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
coordinates = st.floats(-0.5, 4.5, allow_nan=False)
lines = st.tuples(coordinates, coordinates, coordinates, coordinates).filter(
    lambda line: np.hypot(line[2] - line[0], line[3] - line[1]) > 0.05
)


def drawn(
    canvas: CuttableMap, *segments: tuple[float, float, float, float], count: int | None = None
) -> Drawing:
    drawing = Drawing().with_borders(segments)
    cut = canvas.cut(drawing)
    return identified(drawing, canvas.rooms_at_once(cut, count or cut.proposed_count))


# Drawing


@pytest.mark.parametrize(
    "line",
    [
        (0.0, 0.0, 0.0, 0.01),
        (0.0, 0.0, np.nan, 1.0),
        (0.0, 0.0, np.inf, 1.0),
        (0.0, 0.0, 1e9, 1.0),
        (0.0, 0.0, 1.0),
    ],
)
def test_lines_that_make_no_sense_are_refused(line: tuple[float, ...]) -> None:
    with pytest.raises(RoomsegError, match="border: "):
        Drawing().with_borders([line])


def test_numbers_of_borders_are_never_used_again() -> None:
    drawing = Drawing().with_borders([(0, 0, 1, 0), (0, 1, 1, 1)]).without([2])
    assert [b.id for b in drawing.with_borders([(0, 2, 1, 2)]).borders] == [1, 3]
    assert drawing.moved(1, (0, 0, 2, 0)).border(1).ends == (0, 0, 2, 0)
    with pytest.raises(RoomsegError, match="border 2: there is none"):
        drawing.moved(2, (0, 0, 2, 0))


@settings(PATIENT)
@given(st.sets(st.integers(0, 40), max_size=20))
def test_ranges_of_nodes_are_these_nodes(nodes: set[int]) -> None:
    ascending = np.array(sorted(nodes), dtype=np.int64)
    room = Room(1, "", ranges_of(ascending))
    assert room.indices().tolist() == ascending.tolist()
    assert room.size == len(nodes)


@pytest.mark.parametrize("name", ["x" * 61, "a\x00b", "\u202eabc"])
def test_names_that_cannot_be_printed_are_refused(name: str) -> None:
    drawing = Drawing(rooms=(Room(1, "", ((0, 3),)),))
    with pytest.raises(RoomsegError, match="room name"):
        drawing.renamed(1, name)


def test_two_rooms_have_two_names() -> None:
    drawing = Drawing(rooms=(Room(1, "hall", ((0, 3),)), Room(2, "", ((4, 5),))))
    with pytest.raises(RoomsegError, match="'hall' is that of another room"):
        drawing.renamed(2, " hall ")
    assert drawing.renamed(2, "<b>bath</b>").room(2).name == "<b>bath</b>"
    assert drawing.renamed(1, "").room(1).title == "room 1"


# Undo


@settings(PATIENT)
@given(st.lists(st.sampled_from(["draw", "undo", "redo"]), max_size=30))
def test_undo_and_redo_are_those_of_a_list_with_a_mark(steps: list[str]) -> None:
    history, states, at = History(Drawing()), [Drawing()], 0
    for number, step in enumerate(steps):
        if step == "draw":
            new = Drawing(next_room=number + 2)
            history, states, at = history.then(new), [*states[: at + 1], new], at + 1
        elif step == "undo":
            history, at = history.undone(), max(0, at - 1)
        else:
            history, at = history.redone(), min(len(states) - 1, at + 1)
        assert history.present == states[at]


# Cutting


@settings(PATIENT, max_examples=60)
@given(st.lists(lines, min_size=1, max_size=5))
def test_crossed_edges_and_pieces(segments: list[tuple[float, float, float, float]]) -> None:
    """Against `dataset.crosses_border` and plain connected components."""
    canvas = CuttableMap(CORRIDOR)
    drawing = Drawing().with_borders(segments)
    cut = canvas.cut(drawing)
    expected = crosses_border(CORRIDOR.nodes.position, CORRIDOR.edges, drawing.segments)
    assert (cut.edge_is_border == expected).all()
    inner = canvas.edges[~expected]
    n = len(canvas.position)
    piece = connected_components(adjacency(n, inner, np.ones(len(inner))), directed=False)[1]
    assert len(set(zip(piece, cut.pieces.piece, strict=True))) == len(set(piece))
    for leak in cut.leaks:
        border = drawing.border(leak.border)
        steps = np.stack([leak.nodes[:-1], leak.nodes[1:]], axis=1)
        allowed = {tuple(sorted(edge)) for edge in inner.tolist()}
        assert all(tuple(sorted(step)) in allowed for step in steps.tolist())
        ends = np.sort(leak.nodes[[0, -1]])[None]
        assert crosses_border(canvas.position, ends, np.array(border.ends).reshape(1, 2, 2)).all()


def test_a_line_through_the_corridor_separates() -> None:
    canvas = CuttableMap(CORRIDOR)
    cut = canvas.cut(Drawing().with_borders([(1.95, -0.2, 1.95, 1.1)]))
    assert cut.edge_is_border.sum() == 4
    assert cut.proposed_count == 2 and not cut.leaks and not cut.idle


def test_a_line_that_is_too_short_leaks_where_it_ends() -> None:
    """It crosses three of four lanes; the way round it leads through the fourth."""
    canvas = CuttableMap(CORRIDOR)
    cut = canvas.cut(Drawing().with_borders([(1.95, -0.2, 1.95, 0.7)]))
    (leak,) = cut.leaks
    assert cut.proposed_count == 1
    assert leak.length == pytest.approx(0.7)
    assert canvas.position[leak.nodes][:, 1].max() == pytest.approx(0.9)
    graph = adjacency(160, canvas.edges[~cut.edge_is_border], canvas.lengths[~cut.edge_is_border])
    assert leak.length == pytest.approx(dijkstra(graph, indices=leak.nodes[0])[leak.nodes[-1]])


def test_three_lines_in_a_doorway_leave_strips_and_two_rooms() -> None:
    canvas = CuttableMap(CORRIDOR)
    drawing = drawn(canvas, *((x, -0.2, x, 1.1) for x in (1.15, 1.25, 1.35)))
    assert canvas.cut(drawing).proposed_count == 2
    assert [room.size for room in drawing.active_rooms] in ([48, 112], [52, 108], [56, 104])


def test_a_line_beside_the_map_is_told() -> None:
    cut = CuttableMap(CORRIDOR).cut(Drawing().with_borders([(0, 5, 1, 5)]))
    assert cut.idle == (1,) and not cut.leaks


def test_rooms_at_once_are_those_of_the_clustering() -> None:
    borders = carried_to_map(FLAT.nodes, FLAT.ground_truth.borders)
    canvas = CuttableMap(FLAT)
    drawing = Drawing().with_borders(borders.reshape(-1, 4))
    cut = canvas.cut(drawing)
    assert cut.proposed_count == 3 and not cut.leaks
    at_once, clustered = canvas.rooms_at_once(cut, 3), canvas.confirmed(drawing, cut, 3)
    pieces = cut.pieces
    in_room = ~pieces.is_strip[pieces.piece]
    assert (at_once[in_room] == clustered[in_room]).all()


# Carrying


@settings(PATIENT)
@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_borders_are_carried_by_a_rigid_motion(angle: float, x: float, y: float) -> None:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    nodes = replace(FLAT.nodes, position=FLAT.nodes.true_pose[:, :2] @ turn.T + (x, y))
    borders = FLAT.ground_truth.borders
    assert np.allclose(carried_to_map(nodes, borders), borders @ turn.T + (x, y))


def test_carried_borders_cross_the_same_edges_of_a_bent_map() -> None:
    borders = carried_to_map(FLAT.nodes, FLAT.ground_truth.borders)
    crossed = crosses_border(FLAT.nodes.position, FLAT.edges, borders)
    assert (crossed != FLAT.ground_truth.edge_is_border).mean() < 0.005


# Identities


@settings(PATIENT)
@given(st.lists(st.integers(0, 4), min_size=5, max_size=40), st.permutations(range(5)))
def test_identities_do_not_depend_on_the_numbers_of_clusters(
    label: list[int], order: list[int]
) -> None:
    first = np.unique(label, return_inverse=True)[1]
    drawing = identified(Drawing(), first)
    renumbered = np.unique(np.array(order)[label], return_inverse=True)[1]
    again = identified(drawing, renumbered)
    assert again == drawing
    number = room_of_nodes(again, len(label))
    assert (number > 0).all()
    assert len(set(zip(number, first, strict=True))) == len(set(first))


def test_a_moved_border_keeps_names() -> None:
    canvas = CuttableMap(CORRIDOR)
    drawing = drawn(canvas, (0.95, -0.2, 0.95, 1.1)).renamed(2, "hall")
    for x in (1.95, 2.95, 3.55):
        moved = drawing.moved(1, (x, -0.2, x, 1.1))
        drawing = identified(moved, canvas.rooms_at_once(canvas.cut(moved), 2))
    assert [(r.title, r.size) for r in drawing.active_rooms] == [("room 1", 144), ("hall", 16)]


def test_a_room_that_was_gone_for_a_moment_returns_with_its_name() -> None:
    canvas = CuttableMap(CORRIDOR)
    drawing = drawn(canvas, (1.15, -0.2, 1.15, 1.1)).renamed(1, "bath")
    leaking = drawing.moved(1, (1.15, -0.2, 1.15, 0.7))
    leaking = identified(leaking, canvas.rooms_at_once(canvas.cut(leaking), 1))
    assert [room.title for room in leaking.active_rooms] == ["room 2"]
    mended = leaking.moved(1, (1.25, -0.2, 1.25, 1.1))
    mended = identified(mended, canvas.rooms_at_once(canvas.cut(mended), 2))
    assert [(r.title, r.size) for r in mended.active_rooms] == [("bath", 52), ("room 2", 108)]


# Corrections


def test_splitting_and_merging_keep_identities() -> None:
    canvas = CuttableMap(FLAT)
    borders = carried_to_map(FLAT.nodes, FLAT.ground_truth.borders).reshape(-1, 4)
    drawing = drawn(canvas, *borders.tolist())
    largest = max(drawing.active_rooms, key=lambda room: room.size)
    drawing = drawing.renamed(largest.id, "living")
    split = correction.split(canvas, drawing, largest.id)
    cut = canvas.cut(split)
    assert len(split.borders) == len(borders) + 1 and not cut.leaks
    split = identified(split, canvas.rooms_at_once(cut, cut.proposed_count))
    assert cut.proposed_count == 4
    new = ({r.id for r in split.active_rooms} - {r.id for r in drawing.active_rooms}).pop()
    assert split.room(largest.id).name == "living"
    assert split.room(largest.id).size >= split.room(new).size
    merged = correction.merged(canvas, split, cut, new, largest.id)
    cut = canvas.cut(merged)
    merged = identified(merged, canvas.rooms_at_once(cut, cut.proposed_count))
    assert [(r.id, r.name, r.size) for r in merged.active_rooms] == [
        (r.id, r.name, r.size) for r in drawing.active_rooms
    ]


def test_a_room_with_a_loop_is_split_at_two_places() -> None:
    """Two lanes on either side of a bed, joined at its head and its foot."""
    position = CORRIDOR.nodes.position + np.where(np.arange(160) < 80, 0.0, 1.2)[:, None] * [0, 1]
    ends = position[CORRIDOR.edges]
    beside = (ends[..., 0] > 0.35).all(axis=1) & (ends[..., 0] < 3.55).all(axis=1)
    kept = ~(beside & (np.abs(np.diff(ends[..., 1], axis=1)[:, 0]) > 1.0))
    nodes = replace(CORRIDOR.nodes, position=position)
    canvas = CuttableMap(replace(CORRIDOR, nodes=nodes, edges=CORRIDOR.edges[kept]))
    drawing = identified(Drawing(), np.zeros(160, np.int64))
    split = correction.split(canvas, drawing, 1)
    cut = canvas.cut(split)
    assert len(split.borders) == 2 and not cut.leaks
    assert cut.proposed_count == 2


def test_of_a_line_that_parts_other_rooms_too_only_a_part_goes() -> None:
    """A long line along the corridor; another across it makes four rooms."""
    canvas = CuttableMap(CORRIDOR)
    drawing = drawn(canvas, (1.95, -0.2, 1.95, 1.1), (-0.2, 0.45, 4.1, 0.45), count=4)
    number = room_of_nodes(drawing, 160)
    merged = correction.merged(canvas, drawing, canvas.cut(drawing), number[0], number[80])
    cut = canvas.cut(merged)
    labels = canvas.rooms_at_once(cut, 3)
    x, y = canvas.position.T
    assert len(drawing.active_rooms) == 4
    assert len(merged.borders) == 2 and not cut.leaks
    assert len(set(labels[x < 1.95])) == 1
    assert len(set(labels[(x > 1.95) & (y < 0.45)])) == 1
    assert len(set(labels[(x > 1.95) & (y > 0.45)])) == 1


def test_rooms_that_do_not_touch_cannot_be_merged() -> None:
    canvas = CuttableMap(CORRIDOR)
    drawing = drawn(canvas, (0.95, -0.2, 0.95, 1.1), (2.95, -0.2, 2.95, 1.1))
    with pytest.raises(RoomsegError, match="room 1 and room 3: no border parts them"):
        correction.merged(canvas, drawing, canvas.cut(drawing), 1, 3)
    with pytest.raises(RoomsegError, match="expected two rooms"):
        correction.merged(canvas, drawing, canvas.cut(drawing), 1, 1)
    with pytest.raises(RoomsegError, match="room 9: there is none"):
        correction.split(canvas, drawing, 9)


# Suggestions


def test_a_perfect_classifier_suggests_the_borders() -> None:
    canvas = CuttableMap(FLAT)
    marked = FLAT.ground_truth.edge_is_border[canvas.graph.kept]
    suggestions = suggested_lines(canvas, marked, 60.0, 3, seed=0)
    cut = canvas.cut(Drawing().with_borders(suggestions.reshape(-1, 4)))
    assert len(suggestions) == 2 and not cut.leaks
    labels = canvas.rooms_at_once(cut, 3)
    rooms = FLAT.ground_truth.room
    assert len(set(labels)) == 3
    agreeing = sum(np.bincount(rooms[labels == label]).max() for label in range(3))
    assert agreeing / len(rooms) > 0.97


@pytest.mark.parametrize("rooms", [5, 8, 12])
def test_lines_that_part_nothing_are_not_suggested(rooms: int) -> None:
    canvas = CuttableMap(FLAT)
    marked = FLAT.ground_truth.edge_is_border[canvas.graph.kept]
    suggestions = suggested_lines(canvas, marked, 60.0, rooms, seed=0)
    cut = canvas.cut(Drawing().with_borders(suggestions.reshape(-1, 4)))
    ends = cut.pieces.piece[canvas.edges[cut.edge]]
    parted = ends[:, 0] != ends[:, 1]
    assert len(suggestions) >= 2
    assert all(parted[cut.border == line].mean() >= 0.5 for line in range(len(suggestions)))


def test_a_single_node_cannot_be_divided() -> None:
    none = np.zeros((0, 2, 2))
    assert len(dividing_lines(CuttableMap(CORRIDOR), np.array([5]), none, 0)) == 0


# The mouse


BORDERS = (Border(4, (0.0, 0.0, 1.0, 0.0)), Border(7, (0.0, 2.0, 1.0, 2.0)))


def test_a_drag_takes_an_end_a_border_or_draws() -> None:
    assert pressed(BORDERS, 0.98, 2.03, 0.1).to(3.0, 3.03) == pytest.approx((0, 2, 3.02, 3.0))
    assert pressed(BORDERS, 0.5, 0.05, 0.1).to(0.6, 0.25) == pytest.approx((0.1, 0.2, 1.1, 0.2))
    new = pressed(BORDERS, 0.5, 1.0, 0.1)
    assert new.border is None and new.to(2.0, 1.5) == (0.5, 1.0, 2.0, 1.5)
    assert pressed((), 0.5, 1.0, 0.1).border is None


def test_a_click_takes_the_nearest_line_within_reach() -> None:
    assert border_at(BORDERS, 0.5, 1.2, 0.9).id == 7
    assert border_at(BORDERS, 0.5, 1.2, 0.1) is None
    assert line_at(np.zeros((0, 2, 2)), 0.0, 0.0, 9.0) is None
