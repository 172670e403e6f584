"""A cleaning run as a Rerun recording: everything on one timeline, and how to look at it.

What grows (path, covered floor, nodes, edges, obstacle points) is recorded piece by
piece, each at its time; the views show all pieces up to the cursor. What changes
(robot, beams) is recorded as it is at its time.
"""

from __future__ import annotations

import hashlib
import importlib
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import cv2
import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from dataset.errors import RoomsegError
from dataset.topomap import Path, TopoMap
from roomseg.figures.plans import Plan, plan_rings
from roomseg.figures.style import (
    BORDER_EDGE_GREEN,
    EDGE_RED,
    INK,
    OBSTACLE_BLUE,
    TRAVEL_GREY,
    room_colours,
    scale_bar_length,
)

__all__ = ["recording_bytes"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TIMELINE = "time"
PIECE = 4.0
"""What grows does so in pieces of this many s."""
POSE_PERIOD = 0.5
"""Of the robot, s."""
BEAM_TIME = 0.6
"""A beam is shown for so long after its measurement, s."""
JPEG_QUALITY = 85
COVERED, GREEN = "#CFE8DA", "#2E9E6B"
ROBOT, BEAM = "#E69F00", "#CC3311"
PAPER = (255, 255, 255)
MARGIN = 0.8
"""Around the plan, m."""

ORDER = ("covered", "travels", "edges", "points", "walls", "furniture", "lanes", "nodes", "borders")
"""From below to above; the robot and its beams are above all."""


def recording_bytes(
    topomap: TopoMap,
    plans: Mapping[str, Plan] | None = None,
    covered: tuple[Floats, Floats] | None = None,
    images: Iterable[tuple[int, NDArray[np.uint8]]] = (),
) -> bytes:
    """Make the content of an ``.rrd`` file of a run.

    Parameters
    ----------
    topomap : TopoMap
        Without a driven path the robot is where it visits nodes.
    plans : mapping, optional
        ``walls`` and ``furniture``, scene frame.
    covered : pair of arrays, shape (m,), optional
        Times, s, and the covered share of the floor then, 0..1.
    images : iterable of (int, array), optional
        Nodes and their camera images, 8 bit grey.

    Raises
    ------
    RoomsegError
        If the package ``rerun-sdk`` is not installed.
    """
    rr = _rerun()
    with warnings.catch_warnings():
        # What it cannot record it would leave out with a warning.
        warnings.simplefilter("error", rr.error_utils.RerunWarning)
        return _record(rr, topomap, plans or {}, covered, images)


def _record(
    rr: Any,
    topomap: TopoMap,
    plans: Mapping[str, Plan],
    covered: tuple[Floats, Floats] | None,
    images: Iterable[tuple[int, NDArray[np.uint8]]],
) -> bytes:
    name = f"{topomap.environment} {topomap.run}"
    identity = f"{name} {topomap.seed} {topomap.created}"
    stream = rr.RecordingStream(
        "roomseg", recording_id=hashlib.sha256(identity.encode()).hexdigest()[:32]
    )
    storage = stream.binary_stream()
    stream.send_recording_name(name)
    recorder = _Recorder(rr, stream, topomap)
    points = [
        topomap.nodes.position,
        *(ring for plan in plans.values() for ring in plan_rings(plan)),
    ]
    recorder.add_sheets(np.concatenate(points))
    # What is seen first comes first: viewers show what has arrived.
    if topomap.nodes.true_pose is not None:
        recorder.add_scene(plans)
    if covered is not None:
        recorder.add_curve("run/covered", covered[0], 100.0 * covered[1], "covered, %", GREEN)
    recorder.add_map()
    if topomap.path is not None and len(topomap.path.time):
        recorder.add_path(topomap.path)
    has_images = recorder.add_images(images)
    stream.send_blueprint(_blueprint(topomap, has_images, covered is not None))
    content = storage.read()
    assert isinstance(content, bytes)
    return content


def _rerun() -> Any:
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        raise RoomsegError(
            f"a Rerun recording needs the package rerun-sdk ({error}): pip install 'roomseg[rerun]'"
        ) from None


def _packed(rgb: Any) -> NDArray[np.uint32]:
    """Colours (..., 3) in 0..1 as the numbers 0xRRGGBBAA, opaque."""
    parts = np.round(255.0 * np.asarray(rgb, dtype=float)).astype(np.uint32)
    packed: NDArray[np.uint32] = parts @ np.array([1 << 24, 1 << 16, 1 << 8], np.uint32) | 0xFF
    return packed


def _colour(name: str) -> int:
    return int(_packed(to_rgb(name)))


class _Recorder:
    """Writes one run into a stream."""

    def __init__(self, rr: Any, stream: Any, topomap: TopoMap) -> None:
        self.rr, self.stream, self.topomap = rr, stream, topomap
        nodes = topomap.nodes
        visits = topomap.visits
        created = np.full(len(nodes), np.inf)
        np.minimum.at(created, visits.node, visits.time)
        # What a real robot's log says no time of is there from the beginning.
        self.created = np.where(np.isinf(created), 0.0, created)
        self.part_colours = _packed(room_colours(int(nodes.part.max(initial=0)) + 1))

    def add_sheets(self, points: Floats) -> None:
        """What both plans are drawn on: a frame around all the points, and a scale bar."""
        rr = self.rr
        low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
        frame = [low, (high[0], low[1]), high, (low[0], high[1]), low]
        length = scale_bar_length(high[0] - low[0])
        bar = low + 0.6 * MARGIN + [(0.0, 0.0), (length, 0.0)]
        for name in ("map", "scene"):
            # Plans have y up, the viewer's pictures down.
            flip = rr.Transform3D(mat3x3=[[1, 0, 0], [0, -1, 0], [0, 0, 1]])
            self.stream.log(name, flip, static=True)
            look: dict[str, Any] = {"radii": -1.0, "colors": _colour(TRAVEL_GREY)}
            self._style(f"{name}/sheet", rr.LineStrips2D, strips=[frame], **look)
            look |= {"radii": -2.0, "labels": f"{length:g} m"}
            self._style(f"{name}/scale", rr.LineStrips2D, strips=[bar], **look)

    def add_map(self) -> None:
        """The robot's own map: nodes and edges as they are made, points as they are seen."""
        rr, topomap = self.rr, self.topomap
        nodes, seen = topomap.nodes, topomap.obstacles
        order = np.argsort(self.created, kind="stable")
        colour = self.part_colours[nodes.part[order]]
        columns = rr.Points2D.columns(positions=nodes.position[order], colors=colour)
        self._send("map/nodes", self.created[order], columns)
        self._style("map/nodes", rr.Points2D, radii=0.05)
        made = self.created[topomap.edges].max(axis=1, initial=0.0)
        order = np.argsort(made, kind="stable")
        times, counts = np.unique(made, return_counts=True)
        strips = rr.LineStrips2D.columns(strips=list(nodes.position[topomap.edges[order]]))
        self._send("map/edges", times, strips.partition(counts))
        self._style("map/edges", rr.LineStrips2D, colors=_colour(EDGE_RED), radii=-0.4)
        order = np.argsort(seen.time, kind="stable")
        ends, counts = _by_piece(seen.time[order])
        points = rr.Points2D.columns(positions=seen.position[order])
        self._send("map/points", ends, points.partition(counts))
        self._style("map/points", rr.Points2D, colors=_colour(OBSTACLE_BLUE), radii=0.02)
        if topomap.path is None or not len(topomap.path.time):
            visits = topomap.visits
            pose = np.column_stack([nodes.position, nodes.heading])[visits.node]
            self._add_robot("map", visits.time, pose)
            self._add_beams(visits.time, pose)

    def add_path(self, path: Path) -> None:
        """The way, true and estimated, the robot on it, its beams, and how far it is off."""
        sampled = np.arange(0.0, path.time[-1], POSE_PERIOD)
        rows = np.append(np.searchsorted(path.time, sampled), len(path.time) - 1)
        self._add_beams(path.time, path.estimate)
        parts = self._lane_parts(path)
        for frame, pose in (("map", path.estimate), ("scene", path.true_pose)):
            self._add_robot(frame, path.time[rows], pose[rows])
            self._add_way(frame, path, pose[:, :2], parts)
        off = np.hypot(*(path.estimate - path.true_pose)[rows, :2].T)
        self.add_curve("run/drift", path.time[rows], 100.0 * off, "off by, cm", EDGE_RED)
        self._add_log(path, parts)

    def add_scene(self, plans: Mapping[str, Plan]) -> None:
        """What does not change: the plan and the room borders."""
        rr, truth = self.rr, self.topomap.ground_truth
        for name, plan in plans.items():
            colour = _colour(INK if name == "walls" else OBSTACLE_BLUE)
            self._style(f"scene/{name}", rr.LineStrips2D, strips=plan_rings(plan), colors=colour)
        if truth is not None and truth.frame == "scene":
            self._style(
                "scene/borders",
                rr.LineStrips2D,
                strips=list(truth.borders),
                colors=_colour(BORDER_EDGE_GREEN),
            )

    def add_curve(self, entity: str, time: Floats, value: Floats, name: str, colour: str) -> None:
        """A figure over time."""
        rr = self.rr
        self._send(entity, time, rr.Scalars.columns(scalars=value))
        line = rr.SeriesLines(names=name, colors=_colour(colour), widths=2.0)
        self.stream.log(entity, line, static=True)

    def add_images(self, images: Iterable[tuple[int, NDArray[np.uint8]]]) -> bool:
        """Camera images at the creation of their nodes; whether there are any."""
        entity = "camera"
        found = False
        for node, image in images:
            quality = (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY)
            jpeg = cv2.imencode(".jpg", image, quality)[1].tobytes()
            self.stream.set_time(TIMELINE, duration=float(self.created[node]))
            self.stream.log(entity, self.rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
            found = True
        return found

    def _add_way(self, frame: str, path: Path, track: Floats, parts: Ints) -> None:
        """Lanes in the colour of their part, the way between them grey, the covered floor."""
        rr = self.rr
        starts = _piece_starts(path)
        ends = np.append(starts[1:], len(track))
        strips = [track[max(a - 1, 0) : b] for a, b in zip(starts, ends, strict=True)]
        time, lane = path.time[ends - 1], path.lane[starts]
        known = parts[starts] >= 0
        colour = np.where(known, self.part_colours[parts[starts]], _colour(TRAVEL_GREY))
        for name, chosen in (("lanes", lane >= 0), ("travels", lane < 0)):
            entity, index = f"{frame}/{name}", np.flatnonzero(chosen)
            lines = [strips[i] for i in index]
            columns = rr.LineStrips2D.columns(strips=lines, colors=colour[index])
            self._send(entity, time[index], columns)
            self._style(entity, rr.LineStrips2D, radii=-1.0 if name == "lanes" else -0.4)
        if frame == "scene":
            self._send("scene/covered", time, rr.LineStrips2D.columns(strips=strips))
            style = {"colors": _colour(COVERED), "radii": self.topomap.robot_radius}
            self._style("scene/covered", rr.LineStrips2D, **style)

    def _add_robot(self, frame: str, time: Floats, pose: Floats) -> None:
        """The body and its heading."""
        rr, radius = self.rr, self.topomap.robot_radius
        entity = f"{frame}/robot"
        self._send(f"{entity}/body", time, rr.Points2D.columns(positions=pose[:, :2]))
        self._style(f"{entity}/body", rr.Points2D, colors=_colour(ROBOT), radii=radius)
        ahead = 2.0 * radius * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
        arrows = rr.Arrows2D.columns(origins=pose[:, :2], vectors=ahead)
        self._send(f"{entity}/heading", time, arrows)
        self._style(f"{entity}/heading", rr.Arrows2D, colors=_colour(INK))

    def _add_beams(self, time: Floats, pose: Floats) -> None:
        """From the robot to what it sees just now; nothing where it sees nothing."""
        rr, seen = self.rr, self.topomap.obstacles
        if not len(seen.time) or not len(time):
            return
        order = np.argsort(seen.time, kind="stable")
        when, counts = np.unique(seen.time, return_counts=True)
        row = np.minimum(np.searchsorted(time, seen.time[order]), len(time) - 1)
        strips = list(np.stack([pose[row, :2], seen.position[order]], axis=1))
        gone = when[np.diff(when, append=np.inf) > BEAM_TIME] + BEAM_TIME
        times = np.concatenate([when, gone])
        lengths = np.concatenate([counts, np.zeros(len(gone), dtype=counts.dtype)])
        by_time = np.argsort(times, kind="stable")
        columns = rr.LineStrips2D.columns(strips=strips).partition(lengths[by_time])
        self._send("map/beams", times[by_time], columns)
        self._style("map/beams", rr.LineStrips2D, colors=_colour(BEAM), radii=-0.6)

    def _lane_parts(self, path: Path) -> Ints:
        """Part of the lane driven at each moment, (t,): that of the nodes made on it; else -1."""
        node_lane = path.lane[
            np.minimum(np.searchsorted(path.time, self.created), len(path.time) - 1)
        ]
        part_of = np.full(int(path.lane.max(initial=-1)) + 2, -1)
        part_of[node_lane[node_lane >= 0]] = self.topomap.nodes.part[node_lane >= 0]
        return np.asarray(part_of[path.lane], dtype=np.int64)

    def _add_log(self, path: Path, parts: Ints) -> None:
        """What the robot is about, whenever that changes."""
        rows = np.flatnonzero(np.diff(path.lane, prepend=-2))
        said = [
            "between lanes"
            if path.lane[row] < 0
            else f"lane {path.lane[row]}" + (f", part {parts[row]}" if parts[row] >= 0 else "")
            for row in rows
        ]
        self._send("run/log", path.time[rows], self.rr.TextLog.columns(text=said))

    def _send(self, entity: str, time: Floats, columns: Any) -> None:
        if len(time):
            stamps = np.round(1e9 * time).astype("timedelta64[ns]")
            index = self.rr.TimeColumn(TIMELINE, duration=stamps)
            self.stream.send_columns(entity, [index], columns)

    def _style(self, entity: str, kind: Any, **fields: Any) -> None:
        """What holds at all times."""
        name = entity.split("/")[1]
        order = float(ORDER.index(name)) if name in ORDER else float(len(ORDER))
        self.stream.log(entity, kind.from_fields(**fields, draw_order=order), static=True)


def _piece_starts(path: Path) -> Ints:
    """First rows of the pieces of a path: no longer than `PIECE`, of one lane each."""
    changes = np.diff(path.lane) != 0
    changes |= np.diff(np.floor(path.time / PIECE)) != 0
    starts: Ints = np.append(0, np.flatnonzero(changes) + 1)
    return starts


def _by_piece(time: Floats) -> tuple[Floats, Ints]:
    """Group ascending times: the last of each `PIECE`, and how many there are in it."""
    _, counts = np.unique(np.floor(time / PIECE), return_counts=True)
    return time[np.cumsum(counts) - 1], counts


def _blueprint(topomap: TopoMap, has_images: bool, has_coverage: bool) -> Any:
    """How the viewer opens: truth beside the robot's own map, images, curves and log."""
    rrb = importlib.import_module("rerun.blueprint")
    has_path = topomap.path is not None and len(topomap.path.time) > 0
    plans = [_plan_view(rrb, "map", "the robot's own map")]
    if topomap.nodes.true_pose is not None:
        plans.insert(0, _plan_view(rrb, "scene", "truth"))
    if has_images:
        plans.append(rrb.Spatial2DView(origin="/camera", name="camera"))
    rows = [rrb.Horizontal(*plans)]
    curves = [("covered", "covered floor, %")] if has_coverage else []
    curves += [("drift", "estimate off by, cm")] if has_path else []
    below = [rrb.TimeSeriesView(origin=f"/run/{name}", name=title) for name, title in curves]
    if has_path:
        below.append(rrb.TextLogView(origin="/run/log", name="lanes"))
    if below:
        rows.append(rrb.Horizontal(*below))
    shares = [3.0, 1.0][: len(rows)]
    return rrb.Blueprint(rrb.Vertical(*rows, row_shares=shares), collapse_panels=True)


def _plan_view(rrb: Any, frame: str, title: str) -> Any:
    """A view of a plan that shows all that has come up to the cursor."""
    until_now = rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rrb.TimeRangeBoundary.infinite(),
        # Its own `cursor_relative()` needs NumPy 2 to be written.
        end=rrb.TimeRangeBoundary(0, "cursor_relative"),
    )
    growing = ("covered", "travels", "edges", "points", "lanes", "nodes")
    return rrb.Spatial2DView(
        # From above the frame, whose y axis is turned over.
        origin="/",
        contents=[f"/{frame}/**"],
        name=title,
        background=PAPER,
        overrides={f"/{frame}/{name}": until_now for name in growing},
    )
