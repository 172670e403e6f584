"""Figures of the floor plan alone: outlines, floor space, the cleaning run (Figs. 3, 16, 17).

Plans arrive as shapely geometries or as sequences of (k, 2) point arrays, so
that nothing here knows what an apartment is.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import shapely
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

from dataset.topomap import Nodes, Path, TopoMap
from roomseg.figures.style import (
    EDGE_RED,
    FLOOR_GREY,
    INK,
    OBSTACLE_BLUE,
    TRAVEL_GREY,
    finish_plan,
)

__all__ = [
    "Frame",
    "Plan",
    "draw_circles",
    "draw_cleaning_run",
    "draw_floor",
    "draw_obstacle_map",
    "draw_obstacle_points",
    "draw_outlines",
    "lane_tracks",
    "node_positions",
    "plan_rings",
]

Floats = NDArray[np.float64]
Frame = Literal["scene", "map"]
Plan = Any
"""A shapely geometry of areas, or an iterable of (k, 2) arrays of outline points, m."""


def plan_rings(plan: Plan) -> list[Floats]:
    """Return the closed outlines of a plan, arrays (k, 2), m; holes come as own rings."""
    if isinstance(plan, shapely.Geometry):
        parts = shapely.get_parts(plan)
        areas = parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]
        return [shapely.get_coordinates(ring) for ring in shapely.get_rings(areas)]
    return [_closed(np.asarray(points, dtype=float)) for points in plan]


def _closed(points: Floats) -> Floats:
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(f"outline: shape {points.shape}, expected (k >= 2, 2)")
    return points if np.array_equal(points[0], points[-1]) else np.vstack([points, points[:1]])


def node_positions(nodes: Nodes, frame: Frame | None = None) -> Floats:
    """Where to draw the nodes, (n, 2) m: true positions if known, else estimates (Fig. 22)."""
    true_pose = nodes.true_pose
    if frame == "map" or (frame is None and true_pose is None):
        return nodes.position
    if true_pose is None:
        raise ValueError("frame: scene, but the map has no true poses; expected map")
    return true_pose[:, :2]


def draw_circles(ax: Any, centres: Floats, diameter: float) -> Any:
    """Add circles of that diameter, m, as one collection, and return it to be styled."""
    size = np.full(len(centres), diameter)
    circles = EllipseCollection(
        size,
        size,
        np.zeros(len(centres)),
        units="xy",
        offsets=centres,
        offset_transform=ax.transData,
    )
    ax.add_collection(circles)
    ax.autoscale_view()
    return circles


def draw_outlines(ax: Any, plan: Plan, linewidth: float = 0.6, alpha: float = 1.0) -> None:
    """Draw obstacle outlines in blue, as in Figs. 3 and 22."""
    lines = LineCollection(
        plan_rings(plan),
        colors=OBSTACLE_BLUE,
        linewidths=linewidth,
        alpha=alpha,
        gid="obstacle-outlines",
        zorder=2,
    )
    ax.add_collection(lines)
    ax.autoscale_view()


def draw_floor(
    ax: Any,
    floor: Plan,
    obstacles: Plan | None = None,
    *,
    title: str | None = None,
    bar: float | None = None,
) -> None:
    """Draw the unoccupied floor space, ``floor`` less ``obstacles`` (Fig. 17)."""
    rings = plan_rings(_as_area(floor).difference(_as_area(obstacles)))
    if rings:
        path = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
        ax.add_patch(
            PathPatch(path, facecolor=FLOOR_GREY, edgecolor=INK, linewidth=0.7, gid="floor")
        )
    finish_plan(ax, title, bar)


def _as_area(plan: Plan | None) -> Any:
    if plan is None:
        return shapely.MultiPolygon()
    if isinstance(plan, shapely.Geometry):
        return plan
    return shapely.union_all([shapely.Polygon(ring) for ring in plan_rings(plan)])


def lane_tracks(path: Path, frame: Frame = "scene") -> tuple[list[Floats], list[Floats]]:
    """Split the driven path at the changes of its lane state.

    Returns
    -------
    lanes, travels : lists of arrays, shape (k, 2)
        Tracks along lanes, in driving order, and the movements between them;
        a movement begins where the lane before it ended. m.
    """
    points = (path.true_pose if frame == "scene" else path.estimate)[:, :2]
    if not len(points):
        return [], []
    cuts = np.flatnonzero(np.diff(path.lane)) + 1
    starts, ends = np.r_[0, cuts], np.r_[cuts, len(points)]
    lanes, travels = [], []
    for start, end in zip(starts, ends, strict=True):
        if path.lane[start] < 0:
            travels.append(points[max(start - 1, 0) : end + 1])
        else:
            lanes.append(points[start:end])
            if start and path.lane[start - 1] >= 0:
                travels.append(points[start - 1 : start + 1])
    return lanes, [track for track in travels if len(track) > 1]


def _node_lanes(topomap: TopoMap) -> list[Floats]:
    """Lanes from the nodes, in order of creation, for maps without a path."""
    position, nodes = topomap.nodes.position, topomap.nodes
    keys = np.stack([nodes.part, nodes.lane], axis=1)
    _, first, lane = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return [position[lane.ravel() == index] for index in np.argsort(first)]


def draw_cleaning_run(
    ax: Any,
    topomap: TopoMap,
    outlines: Plan | None = None,
    *,
    base_station: tuple[float, float] | None = None,
    title: str | None = None,
    bar: float | None = None,
) -> None:
    """Draw lanes in red with circle and arrowhead, the way between them grey (Fig. 3).

    Drawn in the scene frame; without a path or true poses, the lanes are those
    of the nodes in the robot's estimate. ``base_station`` (x, y), m, defaults
    to where the path begins.
    """
    if outlines is not None:
        draw_outlines(ax, outlines)
    if topomap.path is not None:
        lanes, travels = lane_tracks(topomap.path)
        if base_station is None and len(topomap.path.true_pose):
            base_station = tuple(topomap.path.true_pose[0, :2])
    else:
        lanes, travels = _node_lanes(topomap), []
    ax.add_collection(
        LineCollection(
            travels,
            colors=TRAVEL_GREY,
            linewidths=0.5,
            gid="travels",
            zorder=1,
        )
    )
    _draw_lanes(ax, lanes, topomap.robot_radius)
    if base_station is not None:
        _draw_base_station(ax, base_station, topomap.robot_radius)
    ax.autoscale_view()
    finish_plan(ax, title, bar)


def _draw_lanes(ax: Any, lanes: list[Floats], robot_radius: float) -> None:
    """Lane lines, start circles and arrowheads, sized in metres to suit any scale."""
    size = 0.4 * robot_radius
    style: dict[str, Any] = {
        "facecolors": EDGE_RED,
        "edgecolors": EDGE_RED,
        "linewidths": 0.3,
        "zorder": 4,
    }
    ax.add_collection(LineCollection(lanes, colors=EDGE_RED, linewidths=0.9, gid="lanes", zorder=3))
    starts = np.array([lane[0] for lane in lanes]).reshape(-1, 2)
    circles = draw_circles(ax, starts, 2.0 * size)
    circles.set(gid="lane-starts", **style)
    heads = [_arrowhead(lane, 2.2 * size) for lane in lanes if len(lane) > 1]
    ax.add_collection(PolyCollection(heads, gid="lane-arrows", **style))


def _arrowhead(lane: Floats, size: float) -> Floats:
    """Triangle with its tip at the lane's end, pointing along its last 10 cm, m."""
    tip = lane[-1]
    far = np.flatnonzero(np.linalg.norm(lane - tip, axis=1) >= 0.1)
    along = tip - lane[far[-1] if len(far) else 0]
    length = float(np.hypot(*along))
    along = along / length if length > 0.0 else np.array([1.0, 0.0])
    across = np.array([-along[1], along[0]])
    base = tip - size * along
    return np.stack([tip, base + 0.5 * size * across, base - 0.5 * size * across])


def _draw_base_station(ax: Any, position: tuple[float, float], radius: float) -> None:
    corner = (position[0] - radius, position[1] - radius)
    ax.add_patch(
        Rectangle(
            corner,
            2 * radius,
            2 * radius,
            facecolor="#F0C419",
            edgecolor=INK,
            linewidth=0.8,
            gid="base-station",
            zorder=5,
        )
    )


def draw_obstacle_points(ax: Any, points: Floats, size: float = 0.04) -> None:
    """Draw laser points (k, 2) as small black rings, diameter ``size`` m (Figs. 16 and 25)."""
    rings = draw_circles(ax, points, size)
    rings.set(facecolor="none", edgecolor=INK, linewidth=0.3, gid="obstacle-points", zorder=2)


def draw_obstacle_map(
    ax: Any, topomap: TopoMap, *, title: str | None = None, bar: float | None = None
) -> None:
    """Draw obstacle points as the robot believes them, drift and all (Fig. 16)."""
    draw_obstacle_points(ax, topomap.obstacles.position)
    finish_plan(ax, title, bar)
