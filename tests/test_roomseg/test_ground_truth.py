"""Room labels from border edges (§3.1.1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from scipy.sparse.csgraph import connected_components
from sklearn.metrics import adjusted_rand_score

import roomseg.ground_truth
from dataset.errors import FormatError
from dataset.topomap import GroundTruth, Nodes, Obstacles, TopoMap, Visits
from roomseg.ground_truth import known_truth, label_rooms
from roomseg.preprocessing import preprocess
from roomseg.spectral import adjacency


def rows_map(lines: tuple[float, ...], room_count: int, columns: int = 40) -> TopoMap:
    """A corridor of four lanes along x, 0.1 m steps, border lines across it at ``lines``."""
    x, y = np.meshgrid(np.arange(columns) * 0.1, np.arange(4) * 0.3)
    position = np.stack([x.ravel(), y.ravel()], axis=1)
    index = np.arange(4 * columns).reshape(4, columns)
    along = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
    across = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
    edges = np.concatenate([along, across])
    ends = position[edges][:, :, 0]
    crossed = np.zeros(len(edges), dtype=bool)
    for line in lines:
        crossed |= (ends.min(axis=1) < line) & (ends.max(axis=1) > line)
    borders = np.array([[[line, -0.2], [line, 1.1]] for line in lines]).reshape(-1, 2, 2)
    n = len(position)
    return TopoMap(
        environment="corridor",
        run="run1",
        seed=3,
        created="2026-01-01",
        software="test",
        nodes=Nodes(position, np.zeros(n), np.zeros(n), np.repeat(np.arange(4), columns)),
        edges=edges,
        visits=Visits(np.arange(n), np.arange(n) * 1.0),
        obstacles=Obstacles(np.zeros((0, 2)), np.zeros(0), np.zeros(0)),
        ground_truth=GroundTruth(borders, "map", crossed, room_count),
    )


def labels_of(topomap: TopoMap) -> np.ndarray:
    room = label_rooms(topomap).ground_truth.room
    assert room is not None
    return room


def pieces(topomap: TopoMap) -> np.ndarray:
    graph = preprocess(topomap)
    inner = graph.edges[~topomap.ground_truth.edge_is_border[graph.kept]]
    return connected_components(adjacency(graph.node_count, inner, np.ones(len(inner))))[1]


def test_one_line_per_border() -> None:
    topomap = rows_map((0.95, 2.45), 3)
    x = topomap.nodes.position[:, 0]
    assert (labels_of(topomap) == (x > 0.95).astype(int) + (x > 2.45)).all()


def test_strips_between_lines_follow_one_side() -> None:
    """Three lines across one passage: two strips of one column each, two rooms."""
    topomap = rows_map((1.15, 1.25, 1.35), 2)
    room, x = labels_of(topomap), topomap.nodes.position[:, 0]
    assert (room[x < 1.15] == 0).all()
    assert (room[x > 1.35] == 1).all()
    piece = pieces(topomap)
    assert all(len(set(room[piece == p])) == 1 for p in range(4))


def test_no_border_free_edge_joins_two_rooms() -> None:
    topomap = label_rooms(replace(cleaned_flat()))
    truth, graph = topomap.ground_truth, preprocess(topomap)
    inner = graph.edges[~truth.edge_is_border[graph.kept]]
    assert (truth.room[inner[:, 0]] == truth.room[inner[:, 1]]).all()
    assert adjusted_rand_score(truth.room, cleaned_flat().ground_truth.room) > 0.97


def test_small_and_large_rooms() -> None:
    topomap = rows_map((0.25, 0.35, 3.15), 3)
    x = topomap.nodes.position[:, 0]
    room = labels_of(topomap)
    assert set(room[x < 0.25]) == {0}
    assert set(room[(x > 0.35) & (x < 3.15)]) == {1}
    assert set(room[x > 3.15]) == {2}


def test_labels_do_not_depend_on_the_seed() -> None:
    topomap = rows_map((0.95, 1.05, 2.45), 3)
    first, second = (label_rooms(topomap, seed).ground_truth.room for seed in (1, 2))
    assert (first == second).all()


def test_the_rest_of_the_truth_is_kept() -> None:
    topomap = rows_map((0.95,), 2)
    labelled = label_rooms(topomap)
    assert labelled.ground_truth.room.dtype == np.int32
    assert (labelled.ground_truth.borders == topomap.ground_truth.borders).all()
    assert topomap.ground_truth.room is None


def test_one_room() -> None:
    assert (labels_of(rows_map((), 1)) == 0).all()


def test_failed_clustering_is_replaced_by_the_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    topomap = rows_map((0.95, 2.35, 2.45, 2.55), 3)
    x = topomap.nodes.position[:, 0]
    monkeypatch.setattr(
        roomseg.ground_truth, "spectral_clustering", lambda *_: np.arange(len(x)) % 3
    )
    room = labels_of(topomap)
    assert (room[x < 0.95] == 0).all()
    assert (room[(x > 0.95) & (x < 2.35)] == 1).all()
    assert (room[x > 2.55] == 2).all()
    assert set(room[(x > 2.35) & (x < 2.45)]) == {1}
    assert len(set(room[(x > 2.45) & (x < 2.55)])) == 1


def test_a_strip_with_more_nodes_than_a_room_is_no_room() -> None:
    """A deep passage with four columns between its lines beside a room of three."""
    topomap = rows_map((0.95, 1.35, 3.65), 3)
    x = topomap.nodes.position[:, 0]
    room = labels_of(topomap)
    assert set(room[x < 0.95]) == {0}
    assert set(room[(x > 1.35) & (x < 3.65)]) == {1}
    assert set(room[x > 3.65]) == {2}


def test_borders_that_do_not_cut() -> None:
    topomap = rows_map((0.95, 2.45), 4)
    with pytest.raises(
        FormatError, match="corridor/run1: ground_truth/borders cut the map into 3 pieces, expected"
    ):
        label_rooms(topomap)


def test_more_rooms_than_the_count_says() -> None:
    """Three equal parts, but the operator counted two."""
    topomap = rows_map((1.35, 2.65), 2, columns=41)
    with pytest.raises(FormatError, match="into 3 rooms, expected the room_count 2") as caught:
        label_rooms(topomap)
    assert "\n" not in str(caught.value)


def test_impossible_room_count() -> None:
    with pytest.raises(FormatError, match=r"room_count: 999, expected 1\.\.160"):
        label_rooms(rows_map((), 999))


def test_map_without_ground_truth() -> None:
    topomap = replace(rows_map((), 1), ground_truth=None)
    with pytest.raises(FormatError, match="corridor/run1: no ground_truth"):
        known_truth(topomap)
    with pytest.raises(FormatError, match="annotate the map first"):
        label_rooms(topomap)


def test_a_lane_between_two_of_an_older_part_joins_them():
    """Algorithm 1 leaves it the edges to the nearer one only: within a room, the map is cut."""
    topomap = rows_map((1.95,), 2)
    position = topomap.nodes.position.copy()
    second = np.arange(40, 80)
    # In the left room its nodes are nearer to the lane below, in the right to the one above.
    position[second, 1] += np.where(position[second, 0] < 1.95, -0.01, 0.01)
    part = np.repeat([0, 1, 0, 0], 40)
    lane = np.repeat([0, 9, 2, 3], 40)
    nodes = Nodes(position, topomap.nodes.heading, part, lane)
    topomap = replace(topomap, nodes=nodes)
    assert len(np.unique(pieces(topomap))) == 4
    assert labels_of(topomap).tolist() == (position[:, 0] > 1.95).astype(int).tolist()


def test_pieces_of_one_known_room_are_one() -> None:
    """Two parts of the run meet at x = 2.45 without an edge; the border is at x = 1.45."""
    topomap = rows_map((1.45, 2.45), 2)
    x = topomap.nodes.position[:, 0]
    torn = (x[topomap.edges].min(axis=1) < 2.45) & (x[topomap.edges].max(axis=1) > 2.45)
    topomap = replace(
        topomap,
        edges=topomap.edges[~torn],
        ground_truth=replace(
            topomap.ground_truth,
            borders=topomap.ground_truth.borders[:1],
            edge_is_border=topomap.ground_truth.edge_is_border[~torn],
        ),
    )
    # A way round joins them, as the clustering needs one map: over the border twice.
    far = np.array([[0, len(x) - 1]])
    topomap = replace(
        topomap,
        edges=np.concatenate([topomap.edges, far]),
        ground_truth=replace(
            topomap.ground_truth,
            edge_is_border=np.append(topomap.ground_truth.edge_is_border, True),
        ),
    )
    with pytest.raises(FormatError, match="into 3 rooms, expected the room_count 2"):
        label_rooms(topomap)
    inside = np.where(x < 1.45, 0, 1)
    inside[::7] = -1  # some nodes stand in no room
    room = label_rooms(topomap, room_of_node=inside).ground_truth.room
    assert (room == np.where(x < 1.45, 0, 1)).all()
