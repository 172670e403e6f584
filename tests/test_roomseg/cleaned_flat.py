"""A flat of three rooms and the map of its cleaning, built without the simulator.

Every room is covered by meandering lanes 0.30 m apart with nodes every 0.10 m;
a piercing lane joins the corridor to each room through its doorway.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import shapely
from scipy.spatial import cKDTree

from dataset.camera import FisheyeCamera
from dataset.topomap import GroundTruth, Nodes, Obstacles, Path, TopoMap, Visits
from roomseg.features import EdgeFeatures
from roomseg.labelled_map import LabelledMap
from roomseg.preprocessing import preprocess

ROOMS = ((0.0, 1.6, 4.0, 4.6), (4.12, 1.6, 7.4, 4.6), (0.0, 0.0, 7.4, 1.48))
DOORS = ((1.6, 1.46, 2.4, 1.62), (5.2, 1.46, 6.0, 1.62))
FURNITURE = (
    (0.0, 3.2, 1.0, 4.6),
    (2.2, 3.9, 3.0, 4.3),
    (6.6, 2.4, 7.4, 4.2),
    (3.2, 0.0, 4.0, 0.35),
)
RADIUS = 0.15


def floor() -> shapely.Geometry:
    return shapely.union_all([shapely.box(*corner) for corner in ROOMS + DOORS])


def obstacles() -> shapely.Geometry:
    shell = shapely.box(-0.12, -0.12, 7.52, 4.72)
    furniture = shapely.union_all([shapely.box(*corner) for corner in FURNITURE])
    return shell.difference(floor()).union(furniture)


def lanes() -> list[tuple[int, int, np.ndarray]]:
    """(part, lane, points) of every lane, in driving order."""
    free = floor().difference(obstacles()).buffer(-RADIUS - 0.01)
    result = []
    for part, (left, bottom, right, top) in enumerate(ROOMS):
        lane = 0
        for y in np.arange(bottom + 0.17, top - 0.16, 0.3):
            x = np.arange(left + 0.17, right - 0.16, 0.1)
            points = np.stack([x, np.full_like(x, y)], axis=1)
            inside = shapely.contains_xy(free, points)
            for piece in np.split(points, np.flatnonzero(~inside)):
                run = piece[shapely.contains_xy(free, piece)]
                if len(run) > 1:
                    result.append((part, lane, run[:: -1 if lane % 2 else 1]))
                    lane += 1
    for part, (left, _, right, _) in enumerate(DOORS, start=len(ROOMS)):
        y = np.arange(1.3, 1.81, 0.1)
        result.append((part, 0, np.stack([np.full_like(y, (left + right) / 2), y], axis=1)))
    return result


def drift(points: np.ndarray) -> np.ndarray:
    """A bent map: the estimate of points of the scene."""
    angle = 0.012 * points[:, 0]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack(
        [cos * points[:, 0] - sin * points[:, 1], sin * points[:, 0] + cos * points[:, 1]], axis=1
    )


def driven_path(tracks: list[np.ndarray]) -> Path:
    """All lanes with a straight movement of five samples between any two."""
    points, number = [tracks[0][0] + [0.0, 0.0]], [-1]
    for index, track in enumerate(tracks):
        way = np.linspace(points[-1], track[0], 7)[1:-1]
        points.extend([*way, *track])
        number.extend([-1] * len(way) + [index] * len(track))
    position = np.array(points)
    heading = np.arctan2(*np.gradient(position, axis=0).T[::-1])[:, None]
    return Path(
        np.arange(len(position)) * 0.3,
        np.hstack([position, heading]),
        np.hstack([drift(position), heading]),
        np.array(number),
    )


def laser_points(rng: np.random.Generator) -> np.ndarray:
    outline = obstacles().boundary
    distance = rng.uniform(0.0, outline.length, 1500)
    points = shapely.get_coordinates(shapely.line_interpolate_point(outline, distance))
    inside = (points > -0.1).all(axis=1) & (points < (7.5, 4.7)).all(axis=1)
    return points[inside] + rng.normal(0.0, 0.01, (int(inside.sum()), 2))


def cleaned_flat(name: str = "flat", seed: int = 7, real: bool = False) -> TopoMap:
    """The map; ``real``: as from a physical robot, without true poses and path."""
    rng = np.random.default_rng(seed)
    runs = lanes()
    position = np.vstack([points for _, _, points in runs])
    lengths = [len(points) for _, _, points in runs]
    heading = np.concatenate(
        [np.full(len(p), np.arctan2(*(p[-1] - p[0])[::-1])) for _, _, p in runs]
    )
    nodes = Nodes(
        drift(position) + rng.normal(0.0, 0.004, position.shape),
        heading,
        np.repeat([part for part, _, _ in runs], lengths),
        np.repeat([lane for _, lane, _ in runs], lengths),
        None if real else np.hstack([position, heading[:, None]]),
    )
    pairs = cKDTree(position).query_pairs(0.36, output_type="ndarray")
    segments = shapely.linestrings(position[pairs])
    pairs = pairs[~shapely.intersects(segments, obstacles())]
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    borders = np.array(
        [[[left, y], [right, y]] for left, _, right, _ in DOORS for y in (1.48, 1.54, 1.60)]
    )
    crossed = shapely.intersects(
        shapely.linestrings(position[pairs]), shapely.union_all(shapely.linestrings(borders))
    )
    room = np.select([position[:, 1] < 1.54, position[:, 0] < 4.06], [2, 0], 1)
    if real:
        borders = drift(borders.reshape(-1, 2)).reshape(-1, 2, 2)
    truth = GroundTruth(borders, "map" if real else "scene", crossed, 3, room)
    points = laser_points(rng)
    seen = cKDTree(position).query(points)[1]  # from the nearest node
    points, seen = points[np.argsort(seen)], np.sort(seen)
    return TopoMap(
        environment=name,
        run="run1",
        seed=seed,
        created="2026-01-02T03:04:05+00:00",
        software="roomseg 0.1.0",
        nodes=nodes,
        edges=pairs,
        visits=Visits(np.arange(len(position)), np.arange(len(position)) * 0.3),
        obstacles=Obstacles(drift(points), seen * 0.3, np.zeros(len(points))),
        path=None if real else driven_path([points for _, _, points in runs]),
        ground_truth=truth,
    )


def kept_edges(topomap: TopoMap) -> np.ndarray:
    """Index of the edges shorter than 0.31 m, as if preprocessed."""
    return np.flatnonzero(topomap.edge_lengths() < 0.31)


def fisheye_image(camera: FisheyeCamera | None = None, seed: int = 0) -> np.ndarray:
    """A disc with a bright ceiling, a dark lintel band near the middle and walls around."""
    camera = camera or FisheyeCamera()
    rng = np.random.default_rng(seed)
    zenith = camera.pixel_zenith()
    rows, columns = np.indices(camera.image_size)
    azimuth = np.arctan2(rows - camera.disc_centre[0], columns - camera.disc_centre[1])
    grey = np.where(zenith < 1.0, 190.0, 120.0 + 40.0 * np.sin(5 * azimuth))
    angle = 0.3 + 0.7 * seed
    tilted = np.cos(angle) * (columns - camera.disc_centre[1]) + np.sin(angle) * (
        rows - camera.disc_centre[0]
    )
    grey[(np.abs(tilted - 9.0) < 8.0) & (zenith < 0.9)] = 80.0
    grey = cv2.GaussianBlur(grey, (0, 0), 0.9)
    grey[zenith > camera.field_of_view / 2] = 0.0
    return np.clip(grey + rng.normal(0, 2, grey.shape) * (grey > 0), 0, 255).astype(np.uint8)


def labelled_flat(
    environment: str, seed: int, informative: bool = True, run: str = "run1"
) -> LabelledMap:
    """A flat whose features tell border edges, or tell nothing."""
    topomap = replace(cleaned_flat(environment, seed), run=run)
    graph = preprocess(topomap)
    rng = np.random.default_rng(seed)
    values = rng.normal(0, 1, (len(graph), 2))
    values[:, 0] += 4.0 * informative * topomap.ground_truth.edge_is_border[graph.kept]
    return LabelledMap.of(topomap, EdgeFeatures(graph, values, ("length", "passageway")))
