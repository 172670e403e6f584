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
from roomseg.figures.style import scale_bar_length

__all__ = ["COLOURS", "replay_frames"]

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
Colour = tuple[int, int, int]

MARGIN = 0.3
"""Around what is drawn, m."""
SPOT_TIME = 0.6
"""A beam is shown for so long after its measurement, s."""
CAPTION, LEGEND = 26, 24
"""Heights of the lines of text over and under the pictures, px."""
LETTER = 0.42
"""Size of the text, in OpenCV's unit."""

# Blue, green, red.
WHITE: Colour = (255, 255, 255)
INK: Colour = (50, 50, 50)
COVERED: Colour = (214, 232, 200)
TRACK: Colour = (150, 150, 150)
LANE: Colour = (160, 90, 40)
POINT: Colour = (170, 120, 60)
BEAM: Colour = (60, 60, 220)
ROBOT: Colour = (40, 140, 240)
BETWEEN: Colour = (205, 205, 205)
BELIEF: Colour = (153, 68, 170)
COLOURS = (WHITE, INK, COVERED, TRACK, LANE, POINT, BEAM, ROBOT, BETWEEN, BELIEF)
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
    covered: tuple[Floats, Floats] | None = None,
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
    covered : pair of arrays, shape (m,), optional
        Times, s, and the covered share of the floor then, 0..1; told in the caption.

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
    view = _view(path, outlines, height - CAPTION - LEGEND)
    truth, own = (np.full((*view.size, 3), 255, np.uint8) for _ in range(2))
    track = np.zeros(view.size, np.uint8)
    walls = [] if outlines is None else [view.pixels(ring) for ring in plan_rings(outlines)]
    legend = _legend(2 * view.size[1], view.scale)
    end = path.time[-1]
    shown = 0
    for time in np.append(np.arange(0.0, end, speed / rate), end):
        row = int(np.searchsorted(path.time, time, side="right"))
        part = slice(max(shown - 1, 0), row)
        _add_coverage(truth, track, view, path.true_pose[part, :2], topomap.robot_radius)
        _add_lanes(own, view, path, part)
        before = path.time[part.start] if shown else -1.0
        _add_points(own, view, topomap, before, time)
        shown = row
        left, right = np.where(track[..., None] > 0, TRACK, truth).astype(np.uint8), own.copy()
        if walls:
            cv2.fillPoly(left, walls, INK, cv2.LINE_AA)
        now, here = path.estimate[row - 1], path.true_pose[row - 1]
        spots = _recent_spots(topomap.obstacles, time)
        _draw_beams(left, view, here, _carried(spots, now, here))
        _draw_beams(right, view, now, spots)
        _draw_robot(left, view, here, topomap.robot_radius)
        _draw_belief(left, view, now, topomap.robot_radius)
        _draw_robot(right, view, now, topomap.robot_radius)
        said = _captions(path, row - 1, speed, covered)
        yield np.vstack([_caption(said, view.size[1]), np.hstack([left, right]), legend])


def _view(path: Path, outlines: Plan | None, height: int) -> _View:
    """One frame and scale for both pictures."""
    shapes = [path.true_pose[:, :2], path.estimate[:, :2]]
    if outlines is not None:
        shapes += plan_rings(outlines)
    points = np.concatenate(shapes)
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    scale = height / (high[1] - low[1])
    # Video encoders want even sides.
    return _View(low, scale, (height, 2 * int(np.ceil((high[0] - low[0]) * scale / 2))))


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


def _recent_spots(obstacles: Obstacles, time: float) -> Floats:
    """What the beams have just met, (k, 2) m, map frame."""
    recent = (obstacles.time > time - SPOT_TIME) & (obstacles.time <= time)
    return obstacles.position[recent]


def _carried(points: Floats, source: Floats, target: Floats) -> Floats:
    """Points (k, 2) that are seen from one pose, as seen from another."""
    turn = target[2] - source[2]
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    moved: Floats = (points - source[:2]) @ rotation + target[:2]
    return moved


def _draw_beams(image: Image, view: _View, pose: Floats, spots: Floats) -> None:
    """From the robot to the spots that it has just seen."""
    here = view.pixels(pose[None, :2])[0].tolist()
    for spot in view.pixels(spots).tolist():
        cv2.line(image, here, spot, BEAM, 1, cv2.LINE_AA)
        cv2.circle(image, spot, 2, BEAM, -1, cv2.LINE_AA)


def _draw_belief(image: Image, view: _View, pose: Floats, radius: float) -> None:
    """Where the robot takes itself to be, as a ring."""
    here = view.pixels(pose[None, :2])[0].tolist()
    cv2.circle(image, here, max(3, round(radius * view.scale) + 2), BELIEF, 2, cv2.LINE_AA)


def _draw_robot(image: Image, view: _View, pose: Floats, radius: float) -> None:
    """The body and its heading."""
    nose = pose[:2] + radius * np.array([np.cos(pose[2]), np.sin(pose[2])])
    here, ahead = view.pixels(np.stack([pose[:2], nose])).tolist()
    cv2.circle(image, here, max(2, round(radius * view.scale)), ROBOT, -1, cv2.LINE_AA)
    cv2.line(image, here, ahead, WHITE, 2, cv2.LINE_AA)


def _captions(
    path: Path, row: int, speed: float, covered: tuple[Floats, Floats] | None
) -> tuple[str, str]:
    """What stands over the two pictures at a moment of the path."""
    seconds = path.time[row]
    # Over a second: a single step tells the wheels' noise.
    past = min(int(np.searchsorted(path.time, seconds - 1.0)), max(row - 1, 0))
    moved = float(np.hypot(*(path.true_pose[row] - path.true_pose[past])[:2]))
    pace = moved / max(seconds - path.time[past], 1e-9) if row else 0.0
    state = f"lane {path.lane[row]}" if path.lane[row] >= 0 else "between lanes"
    hours, minutes = divmod(int(seconds) // 60, 60)
    truth = f"truth   {hours}:{minutes:02d}:{int(seconds) % 60:02d}  x{speed:g}   {pace:.2f} m/s"
    if covered is not None:
        truth += f"   {100.0 * np.interp(seconds, *covered):.0f} % covered"
    off = 100.0 * float(np.hypot(*(path.estimate[row] - path.true_pose[row])[:2]))
    return truth, f"the robot's own map   {state}   off by {off:.0f} cm"


def _caption(said: tuple[str, str], middle: int) -> Image:
    """A line of text over both pictures."""
    strip = np.full((CAPTION, 2 * middle, 3), 255, np.uint8)
    for x, words in zip((8, middle + 8), said, strict=True):
        _write(strip, words, (x, 18))
    return strip


def _legend(width: int, scale: float) -> Image:
    """What is drawn how, and a scale bar; what does not fit is left out."""
    strip = np.full((LEGEND, width, 3), 255, np.uint8)
    length = scale_bar_length(width / 2.0 / scale)
    right = 8 + round(length * scale)
    cv2.rectangle(strip, (8, 10), (right, 13), INK, -1)
    x = _write(strip, f"{length:g} m", (right + 6, 16)) + 22
    signs = {
        "covered": (COVERED, 10),
        "lane": (LANE, 2),
        "between": (BETWEEN, 2),
        "obstacle point": (POINT, 4),
        "beam": (BEAM, 2),
        "robot": (ROBOT, 10),
        "where it takes itself to be": (BELIEF, 3),
    }
    for words, (colour, thick) in signs.items():
        (wide, _), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, LETTER, 1)
        if x + 22 + wide > width:
            break
        cv2.line(strip, (x, 12), (x + 14, 12), colour, thick)
        x = _write(strip, words, (x + 22, 16)) + 16
    return strip


def _write(image: Image, words: str, corner: tuple[int, int]) -> int:
    """Write at the lower left corner, and return where the text ends, px."""
    cv2.putText(image, words, corner, cv2.FONT_HERSHEY_SIMPLEX, LETTER, INK, 1, cv2.LINE_AA)
    (wide, _), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, LETTER, 1)
    return corner[0] + int(wide)
