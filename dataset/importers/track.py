"""A driven track as nodes of a topo-metric map: one every 10 cm, with lane and part (§2.1).

The paper's robot knows its lanes, others tell only where they drove. So:

* A node is made wherever the robot has come 10 cm from the last one, unless an older
  node is there already; then that one is visited again.
* Straight stretches (the track simplified by 6 cm) of at least 40 cm are lanes. Bends
  between them, such as the step from one lane to the next, belong to the lane before; bends of
  more than 60 cm in all (along a wall, around a leg) are lanes of their own, of 1 m at most.
* A lane that follows a parallel one beside it is the next of its part; any other
  begins a new part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from dataset.topomap import Nodes, Visits

__all__ = ["NODE_SPACING", "Drive", "Track", "drive_of"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NODE_SPACING = 0.10
"""m."""
SAME_PLACE = 0.095
"""A node this near is visited again, m: less than the spacing."""
STRAIGHTNESS = 0.06
"""A stretch is straight if the track is within so much of a line, m."""
SHORTEST_LANE = 0.40
LONGEST_BEND = 0.60
LONGEST_CURVE = 1.0
PARALLEL = np.radians(20.0)
FARTHEST_LANE = 0.50
"""Lanes of a part follow each other at most this far apart, m."""
DENSE = 0.01
"""The track is looked at every so often, m."""


@dataclass(frozen=True)
class Track:
    """Where a robot was: in order, in pieces that do not join.

    time (t,) s, ascending; position (t, 2) m and heading (t,) rad in the robot's own
    frame; stroke (t,) the number of the piece.
    """

    time: Floats
    position: Floats
    heading: Floats
    stroke: Integers


@dataclass(frozen=True)
class Drive:
    """The nodes of a track.

    Attributes
    ----------
    nodes : Nodes
    visits : Visits
    driven : array, shape (d, 2)
        Pairs of nodes that were visited one after the other.
    """

    nodes: Nodes
    visits: Visits
    driven: Integers


def drive_of(track: Track) -> Drive:
    """Make nodes of a track; see the module's text.

    Parameters
    ----------
    track : Track
        With at least one point.

    Returns
    -------
    Drive
        Nodes in order of creation, visits in order of time.
    """
    points = _samples(track)
    stretch = _lanes(points)
    node = _places(points.position)
    first = np.unique(node, return_index=True)[1]
    part, lane = _parts(points.position[first], stretch[first])
    nodes = Nodes(
        points.position[first],
        points.heading[first],
        part.astype(np.int32),
        lane.astype(np.int32),
    )
    follows = (np.diff(points.stroke) == 0) & (np.diff(node) != 0)
    pairs = np.sort(np.stack([node[:-1], node[1:]], axis=1)[follows], axis=1)
    return Drive(nodes, Visits(node.astype(np.int32), points.time), np.unique(pairs, axis=0))


def _samples(track: Track) -> Track:
    """The track where it is a node's spacing from the sample before."""
    dense = _dense(track)
    kept = []
    last = np.array([np.inf, np.inf])
    stroke = -1
    for k, (point, piece) in enumerate(zip(dense.position, dense.stroke.tolist(), strict=True)):
        dx, dy = point - last
        if piece != stroke or dx * dx + dy * dy >= (NODE_SPACING - 1e-9) ** 2:
            kept.append(k)
            last, stroke = point, piece
    return Track(dense.time[kept], dense.position[kept], dense.heading[kept], dense.stroke[kept])


def _dense(track: Track) -> Track:
    """The track with points in between, so that none is far from the next."""
    step = np.hypot(*np.diff(track.position, axis=0).T)
    joined = np.diff(track.stroke) == 0
    counts = np.where(joined, np.ceil(step / DENSE), 1).astype(np.int64)
    counts = np.maximum(counts, 1)
    at = np.concatenate([[0], np.cumsum(counts)])
    places = np.arange(at[-1] + 1)
    index = np.searchsorted(at, places, side="right") - 1
    x, y = (np.interp(places, at, column) for column in track.position.T)
    heading = np.interp(places, at, np.unwrap(track.heading))
    # Between pieces there is nothing in between: one step leads from the last to the first.
    position = np.stack([x, y], axis=1)
    return Track(np.interp(places, at, track.time), position, heading, track.stroke[index])


def _lanes(points: Track) -> Integers:
    """Running number of each sample's lane, negative for a lane that is no straight one."""
    lane = np.zeros(len(points.time), dtype=np.int64)
    number = 0
    for first, last in _strokes(points.stroke):
        corners = _corners(points.position[first:last]) + first
        for begin, end, straight in _runs(points.position, corners):
            number += 1
            lane[begin:end] = number if straight else -number
    return lane


def _strokes(stroke: Integers) -> Iterator[tuple[int, int]]:
    cuts = np.flatnonzero(np.diff(stroke)) + 1
    yield from zip([0, *cuts.tolist()], [*cuts.tolist(), len(stroke)], strict=True)


def _corners(position: Floats) -> Integers:
    """Where a piece of the track bends: indices, its first and last point included."""
    if len(position) < 3:
        return np.array([0, len(position) - 1])
    # The index travels as the third coordinate.
    line = shapely.linestrings(np.column_stack([position, np.arange(len(position))]))
    simple = shapely.simplify(line, STRAIGHTNESS, preserve_topology=False)
    corners: Integers = shapely.get_coordinates(simple, include_z=True)[:, 2].astype(np.int64)
    return corners


def _runs(position: Floats, corners: Integers) -> list[tuple[int, int, bool]]:
    """Lanes of a piece as (first, one past the last, whether straight) of its samples."""
    lengths = np.hypot(*np.diff(position[corners], axis=0).T)
    runs: list[tuple[int, int, bool]] = []
    bends: list[int] = []
    stretches = list(zip(corners[:-1].tolist(), corners[1:].tolist(), strict=True))
    for k, (begin, end) in enumerate(stretches):
        if lengths[k] < SHORTEST_LANE:
            bends.append(k)
            continue
        begin = _with_bends(runs, [stretches[j] for j in bends], lengths[bends], begin)  # noqa: PLW2901
        bends = []
        runs.append((begin, end, True))
    _with_bends(runs, [stretches[j] for j in bends], lengths[bends], int(corners[-1]))
    if runs:
        begin, _, straight = runs[-1]
        return [*runs[:-1], (begin, int(corners[-1]) + 1, straight)]
    return [(int(corners[0]), int(corners[-1]) + 1, False)]


def _with_bends(
    runs: list[tuple[int, int, bool]], bends: list[tuple[int, int]], lengths: Floats, begin: int
) -> int:
    """Give bends to the lane before, or make lanes of them; where the next lane begins."""
    if not bends:
        return begin
    if lengths.sum() <= LONGEST_BEND:
        if not runs:
            return bends[0][0]
        first, _, straight = runs[-1]
        runs[-1] = (first, begin, straight)
        return begin
    # Equal lanes, none longer than a curve may be.
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    share = np.minimum(along[:-1] // LONGEST_CURVE, along[-1] // LONGEST_CURVE)
    for number in np.unique(share):
        some = [bend for bend, own in zip(bends, share, strict=True) if own == number]
        runs.append((some[0][0], some[-1][1], False))
    return begin


def _places(position: Floats) -> Integers:
    """Node of each sample: an older one that is near, or a new one."""
    cells: dict[tuple[int, int], list[int]] = {}
    node = np.empty(len(position), dtype=np.int64)
    where: list[tuple[float, float]] = []
    for k, (x, y) in enumerate(position.tolist()):
        i, j = int(x // SAME_PLACE), int(y // SAME_PLACE)
        near = [n for a in (-1, 0, 1) for b in (-1, 0, 1) for n in cells.get((i + a, j + b), ())]
        gaps = [((where[n][0] - x) ** 2 + (where[n][1] - y) ** 2, n) for n in near]
        gap, nearest = min(gaps, default=(np.inf, -1))
        if gap < SAME_PLACE**2:
            node[k] = nearest
            continue
        node[k] = len(where)
        cells.setdefault((i, j), []).append(len(where))
        where.append((x, y))
    return node


def _parts(position: Floats, stretch: Integers) -> tuple[Integers, Integers]:
    """Part and lane of each node, both from 0, of the running numbers of lanes."""
    part, lane = np.zeros(len(stretch), np.int64), np.zeros(len(stretch), np.int64)
    before: Floats | None = None
    at = (-1, 0)
    for number in sorted(set(stretch.tolist()), key=abs):
        members = np.flatnonzero(stretch == number)
        here = position[members] if number > 0 and len(members) > 2 else None
        follows = before is not None and here is not None and _beside(before, here)
        at = (at[0], at[1] + 1) if follows else (at[0] + 1, 0)
        part[members], lane[members] = at
        before = here
    return part, lane


def _beside(first: Floats, second: Floats) -> bool:
    """Whether two straight lanes are parallel, overlap, and lie next to each other."""
    one, other = _direction(first), _direction(second)
    if abs(one @ other) < np.cos(PARALLEL):
        return False
    along, across = first @ one, np.array([-one[1], one[0]])
    also = second @ one
    apart = abs(np.median(second @ across) - np.median(first @ across))
    overlap = min(along.max(), also.max()) - max(along.min(), also.min())
    return bool(SAME_PLACE <= apart <= FARTHEST_LANE and overlap > 0.0)


def _direction(points: Floats) -> Floats:
    """The direction in which points lie along a line, a unit vector."""
    axis: Floats = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    return axis
