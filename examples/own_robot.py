"""A map of your own robot: from its log to annotated and found rooms, without a camera.

The log is CSV: time s, x m, y m, heading rad, and the eight ranges of the beams in m
(empty where nothing is seen). Without ``--log`` a small one is made up: two rooms and a
doorway. Change `BEARINGS`, `RADIUS` and the borders that you draw; for a Valetudo map or a
ROS bag, `roomseg import` does the first half.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from dataset import GroundTruth, Obstacles, TopoMap, crosses_border, write_map, write_rooms
from dataset.importers.edges import adjacent_pairs, connected_drive
from dataset.importers.track import Track, drive_of
from roomseg.ground_truth import label_rooms
from roomseg.metrics import impurity
from roomseg.preprocessing import preprocess
from roomseg.segmentation import segment

RADIUS = 0.17
BEARINGS = np.arange(8) * np.pi / 4
BORDERS = np.array([[[2.05, 0.6], [2.05, 1.4]]])  # x0, y0, x1, y1 in m: across the doorway
ROOMS = 2


def map_of(log: np.ndarray) -> TopoMap:
    """Nodes, lanes, edges and obstacle points of a log, shape (t, 4 + beams)."""
    time, pose, ranges = log[:, 0], log[:, 1:4], log[:, 4:]
    angle = pose[:, 2:] + BEARINGS
    ends = pose[:, None, :2] + ranges[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    row, beam = np.nonzero(np.isfinite(ranges))
    points = Obstacles(ends[row, beam], time[row], beam.astype(np.uint8))
    drive = drive_of(Track(time, pose[:, :2], pose[:, 2], np.zeros(len(time), np.int64)))
    drive, edges, notes = connected_drive(drive, adjacent_pairs(drive, points.position))
    print(*notes, sep="\n", end="\n" if notes else "")
    return TopoMap(
        environment="my flat",
        run="monday",
        seed=0,
        created="2026-01-05T09:00:00Z",
        software="own_robot.py",
        nodes=drive.nodes,
        edges=edges.astype(np.int32),
        visits=drive.visits,
        obstacles=points,
        robot_radius=RADIUS,
    )


def made_up_log() -> np.ndarray:
    """Lanes through two rooms of 2 m x 2 m, beside each other, with a doorway of 0.8 m."""
    corners = []
    for left in (0.2, 2.3):
        for k, y in enumerate(np.arange(0.2, 1.9, 0.3)):
            corners += [(left, y), (left + 1.6, y)][:: -1 if k % 2 else 1]
        corners.append((2.05, 1.0))
    corners.append((2.3, 0.8))
    way = np.array(corners)
    step = np.hypot(*np.diff(way, axis=0).T)
    time = np.concatenate([[0.0], np.cumsum(step)]) / 0.2
    at = np.arange(0.0, time[-1], 0.5)
    x, y = (np.interp(at, time, column) for column in way.T)
    ahead = np.arctan2(*np.diff(way, axis=0).T[::-1])
    heading = ahead[np.searchsorted(time, at, side="right").clip(1, len(ahead)) - 1]
    places = np.stack([x, y], axis=1)
    ranges = np.array([ranges_at(*row) for row in zip(places, heading, strict=True)])
    return np.column_stack([at, places, heading, ranges])


def ranges_at(place: np.ndarray, heading: float) -> np.ndarray:
    """What beams of 1 m see of the walls, in steps of 1 cm."""
    reach = np.arange(0.0, 1.0, 0.01)
    angle = heading + BEARINGS[:, None]
    x = place[0] + reach * np.cos(angle)
    y = place[1] + reach * np.sin(angle)
    rooms = (x > 0) & (x < 4.1) & (y > 0) & (y < 2) & (np.abs(x - 2.05) > 0.05)
    free = rooms | ((np.abs(x - 2.05) <= 0.05) & (np.abs(y - 1.0) < 0.4))
    return np.where(free.all(axis=1), np.nan, reach[free.argmin(axis=1)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--log", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("monday.h5"))
    arguments = parser.parse_args()
    log = made_up_log()
    if arguments.log is not None:
        log = np.genfromtxt(arguments.log, delimiter=",", ndmin=2)
    topomap = map_of(log)
    crossed = crosses_border(topomap.nodes.position, topomap.edges, BORDERS)
    truth = GroundTruth(BORDERS, "map", crossed, room_count=ROOMS)
    topomap = label_rooms(topomap.with_ground_truth(truth))
    write_map(arguments.output, topomap)
    found = segment(preprocess(topomap), None, ROOMS, np.random.default_rng(0), 1.0)
    write_rooms(arguments.output, found, model="equal weights", rooms=ROOMS)
    room = topomap.ground_truth.room
    print(
        f"{arguments.output}: {len(topomap.nodes)} nodes, {int(crossed.sum())} border edges, "
        f"impurity {100 * impurity(found, room):.2f} %"
    )


if __name__ == "__main__":
    main()
