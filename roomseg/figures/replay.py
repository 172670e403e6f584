"""A cleaning run as moving pictures: the true plan beside the robot's own map.

On the left, in the scene's frame: the plan, the floor that the body has passed, the
true track, the robot with its beams. On the right, in the frame of the estimate: the
obstacle points so far, the lanes and the estimate. So the drift shows as the
difference of both. Pictures are drawn with OpenCV upon what is already there: a frame
costs what is new in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from dataset.errors import FormatError
from dataset.topomap import Obstacles, Path, TopoMap
from roomseg.figures.plans import Plan, plan_rings

__all__ = ["COLOURS", "replay_frames"]

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
Colour = tuple[int, int, int]

MARGIN = 0.3
"""Around what is drawn, m."""
SPOT_TIME = 0.6
"""A beam is shown for so long after its measurement, s."""
CAPTION = 26
"""Height of the line of text over the pictures, px."""

# Blue, green, red.
WHITE: Colour = (255, 255, 255)
INK: Colour = (50, 50, 50)
COVERED: Colour = (214, 232, 200)
TRACK: Colour = (150, 150, 150)
LANE: Colour = (160, 90, 40)
POINT: Colour = (170, 120, 60)
BEAM: Colour = (60, 60, 220)
ROBOT: Colour = (40, 140, 240)
BETWEEN: Colour = (225, 225, 225)
COLOURS = (WHITE, INK, COVERED, TRACK, LANE, POINT, BEAM, ROBOT, BETWEEN)
"""All of them, for formats with a palette."""


@dataclass(frozen=True)
class _View:
    """Metres to pixels of one picture: the corner (x, y) m at the lower left, px per m."""

    low: Floats
    scale: float
    size: tuple[int, int]

    def pixels(self, points: Floats) -> NDArray[np.int32]:
        """Columns and rows of points (n, 2) m."""
        column = (points[:, 0] - self.low[0]) * self.scale
        row = self.size[0] - (points[:, 1] - self.low[1]) * self.scale
        return np.asarray(np.round(np.stack([column, row], axis=1)), dtype=np.int32)


def replay_frames(
    topomap: TopoMap,
    outlines: Plan | None = None,
    *,
    speed: float = 60.0,
    rate: float = 25.0,
    height: int = 540,
) -> Iterator[Image]:
    """Draw a cleaning run as a film.

    Parameters
    ----------
    topomap : TopoMap
        With its driven path.
    outlines : Plan, optional
        What stands near the floor, scene frame.
    speed : float
        Simulated seconds in one second of the film.
    rate : float
        Pictures per second of the film.
    height : int
        Of the film, px; even. Its width follows from the plan.

    Yields
    ------
    array, shape (height, width, 3)
        8 bit; blue, green, red.

    Raises
    ------
    FormatError
        If the map has no driven path.
    """
    path = topomap.path
    if path is None or len(path.time) == 0:
        raise FormatError(
            f"{topomap.environment}: /path: missing, only driven maps can be replayed"
        )
    views = _views(path, outlines, height - CAPTION)
    truth, own = (np.full((*view.size, 3), 255, np.uint8) for view in views)
    track = np.zeros(views[0].size, np.uint8)
    walls = [] if outlines is None else [views[0].pixels(ring) for ring in plan_rings(outlines)]
    end = path.time[-1]
    shown = 0
    for time in np.append(np.arange(0.0, end, speed / rate), end):
        row = int(np.searchsorted(path.time, time, side="right"))
        part = slice(max(shown - 1, 0), row)
        _add_coverage(truth, track, views[0], path.true_pose[part, :2], topomap.robot_radius)
        _add_lanes(own, views[1], path, part)
        before = path.time[part.start] if shown else -1.0
        _add_points(own, views[1], topomap, before, time)
        shown = row
        left, right = np.where(track[..., None] > 0, TRACK, truth).astype(np.uint8), own.copy()
        if walls:
            cv2.fillPoly(left, walls, INK, cv2.LINE_AA)
        _draw_robot(left, views[0], path.true_pose[row - 1], topomap.robot_radius)
        _draw_beams(right, views[1], path.estimate[row - 1], topomap.obstacles, time)
        _draw_robot(right, views[1], path.estimate[row - 1], topomap.robot_radius)
        yield _captioned(np.hstack([left, right]), time, int(path.lane[row - 1]))


def _views(path: Path, outlines: Plan | None, height: int) -> tuple[_View, _View]:
    """One scale for both pictures."""
    shapes = [path.true_pose[:, :2], path.estimate[:, :2]]
    if outlines is not None:
        shapes += plan_rings(outlines)
    points = np.concatenate(shapes)
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    scale = height / (high[1] - low[1])
    # Video encoders want even sides.
    view = _View(low, scale, (height, 2 * int(np.ceil((high[0] - low[0]) * scale / 2))))
    return view, view


def _add_coverage(image: Image, mask: Image, view: _View, track: Floats, radius: float) -> None:
    """The floor that the body has passed, and its track on a mask of its own."""
    line = view.pixels(track)
    width = max(1, round(2 * radius * view.scale))
    cv2.polylines(image, [line], False, COVERED, width, cv2.LINE_AA)
    cv2.polylines(mask, [line], False, 255, 1)


def _add_lanes(image: Image, view: _View, path: Path, part: slice) -> None:
    """The estimated way; lanes dark."""
    line, lane = view.pixels(path.estimate[part, :2]), path.lane[part]
    for k in range(1, len(line)):
        colour = LANE if lane[k] >= 0 else BETWEEN
        cv2.line(image, line[k - 1].tolist(), line[k].tolist(), colour, 1, cv2.LINE_AA)


def _add_points(image: Image, view: _View, topomap: TopoMap, before: float, now: float) -> None:
    """The obstacle points that have come in."""
    time = topomap.obstacles.time
    new = (time > before) & (time <= now)
    for column, row in view.pixels(topomap.obstacles.position[new]).tolist():
        cv2.circle(image, (column, row), 1, POINT, -1, cv2.LINE_AA)


def _draw_beams(image: Image, view: _View, pose: Floats, obstacles: Obstacles, time: float) -> None:
    """From the robot to the spots that it has just seen."""
    recent = (obstacles.time > time - SPOT_TIME) & (obstacles.time <= time)
    here = view.pixels(pose[None, :2])[0].tolist()
    for spot in view.pixels(obstacles.position[recent]).tolist():
        cv2.line(image, here, spot, BEAM, 1, cv2.LINE_AA)


def _draw_robot(image: Image, view: _View, pose: Floats, radius: float) -> None:
    """The body and its heading."""
    nose = pose[:2] + radius * np.array([np.cos(pose[2]), np.sin(pose[2])])
    here, ahead = view.pixels(np.stack([pose[:2], nose])).tolist()
    cv2.circle(image, here, max(2, round(radius * view.scale)), ROBOT, -1, cv2.LINE_AA)
    cv2.line(image, here, ahead, WHITE, 2, cv2.LINE_AA)


def _captioned(image: Image, time: float, lane: int) -> Image:
    """A line of text over both pictures."""
    strip = np.full((CAPTION, image.shape[1], 3), 255, np.uint8)
    text = f"{int(time) // 60:3d}:{int(time) % 60:02d}   " + (
        f"lane {lane}" if lane >= 0 else "between lanes"
    )
    middle = image.shape[1] // 2
    for x, words in ((8, f"truth   {text}"), (middle + 8, "the robot's own map")):
        cv2.putText(strip, words, (x, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.45, INK, 1, cv2.LINE_AA)
    return np.vstack([strip, image])
