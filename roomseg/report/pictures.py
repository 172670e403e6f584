"""The pictures of a report: figures and images as PNG, each with a caption and its text.

The alternative text says what is to be seen, for readers who cannot see it.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomseg.figures import (
    RocCurve,
    draw_cleaning_run,
    draw_edge_pixels,
    draw_floor,
    draw_graph,
    draw_impurity_bars,
    draw_lintel_histogram,
    draw_lintel_search,
    draw_obstacle_map,
    draw_passage_width,
    draw_roc,
    draw_rooms,
    new_figure,
    png_bytes,
)
from roomseg.figures.graphs import wrong_nodes
from roomseg.figures.plans import node_positions, plan_rings
from roomseg.report.contents import LintelView, MapResult, PassageView, Place, Report, Snapshot
from roomseg.report.views import measure_passage

__all__ = [
    "Picture",
    "draw_passage",
    "lintel_picture",
    "place_pictures",
    "result_pictures",
    "room_pictures",
    "snapshot_pictures",
]

_PLAN_WIDTH = 4.8
"""Inches; small, so that numbers and lines can be read on the page, at a high resolution."""


@dataclass(frozen=True)
class Picture:
    """A PNG with what is said about it; ``file`` is a name made from its content."""

    file: str
    png: bytes
    width: int
    height: int
    title: str
    caption: str
    alt: str

    @classmethod
    def of(cls, png: bytes, stem: str, title: str, caption: str, alt: str) -> Picture:
        """Name the picture and read its size, px, from the PNG header."""
        plain = re.sub(r"[^a-z0-9]+", "-", stem.lower()).strip("-")[:60]
        digest = hashlib.sha256(png).hexdigest()[:12]
        width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
        return cls(f"{plain}-{digest}.png", png, width, height, title, caption, alt)


def _plan_picture(
    place: Place, result: MapResult, draw: Callable[[Any], None], *words: str
) -> Picture:
    """Draw into axes as large as the plan asks for; ``words``: kind, title, caption, alt."""
    points = [node_positions(result.topomap.nodes)]
    if place.outlines is not None:
        points += plan_rings(place.outlines)
    corners = np.vstack(points)
    extent = np.ptp(corners, axis=0) if len(corners) else np.ones(2)
    height = float(np.clip(extent[1] / max(extent[0], 0.1), 0.4, 1.6))
    figure = new_figure(_PLAN_WIDTH, _PLAN_WIDTH * height)
    draw(figure.subplots())
    kind, title, caption, alt = words
    return Picture.of(png_bytes(figure, dpi=230), f"{result.name} {kind}", title, caption, alt)


def place_pictures(place: Place) -> Iterator[Picture]:
    """Yield pictures of the first map: run, floor, graph before and after (Figs. 3-5, 12)."""
    if not place.maps:
        return
    yield from _cleaning_pictures(place, place.maps[0])
    yield from _graph_pictures(place, place.maps[0])
    passage = measure_passage(place.maps[0].topomap, place.maps[0].kept)
    if passage is not None:
        yield _passage_picture(place.maps[0], passage)


def _cleaning_pictures(place: Place, result: MapResult) -> Iterator[Picture]:
    topomap = result.topomap
    yield _plan_picture(
        place,
        result,
        lambda ax: draw_cleaning_run(ax, topomap, place.outlines, base_station=place.base_station),
        "run",
        "Cleaning run",
        "Lanes red from circle to arrowhead, the way between them grey, obstacles blue, "
        "base station yellow.",
        f"Floor plan of {place.name} with the robot's meandering lanes",
    )
    if place.floor is not None:
        yield _plan_picture(
            place,
            result,
            lambda ax: draw_floor(ax, place.floor, place.outlines),
            "floor",
            "Unoccupied floor",
            "The floor that no obstacle stands on; some of it is too narrow for the robot.",
            f"Unoccupied floor space of {place.name}",
        )
    yield _plan_picture(
        place,
        result,
        lambda ax: draw_obstacle_map(ax, topomap),
        "obstacles",
        "What the robot believes",
        "Obstacle points by the robot's own estimate, which drifts: walls are bent and doubled.",
        f"Obstacle points of {result.name} in the robot's estimate",
    )


def _graph_pictures(place: Place, result: MapResult) -> Iterator[Picture]:
    topomap = result.topomap
    yield _plan_picture(
        place,
        result,
        lambda ax: draw_graph(ax, topomap, outlines=place.outlines),
        "graph",
        "Map graph",
        f"All {len(topomap.edges):,} edges between adjacent nodes; true room borders dashed.",
        f"Map graph of {result.name} with {len(topomap.edges)} edges and the room borders",
    )
    if result.kept is None:
        return
    marked = 0 if result.border is None else int(np.sum(result.border))
    said = "" if result.border is None else f"; {marked:,} classified as border, green"
    yield _plan_picture(
        place,
        result,
        lambda ax: draw_graph(
            ax, topomap, edges=result.kept, is_border=result.border, outlines=place.outlines
        ),
        "kept graph",
        "Preprocessed graph" if result.border is None else "Classified edges",
        f"The {len(result.kept):,} edges kept by Algorithm 1{said}.",
        f"Preprocessed graph of {result.name}, {len(result.kept)} edges, {marked} marked as border",
    )


def draw_passage(ax: Any, view: PassageView, title: str | None = None) -> None:
    """Draw how a passageway's width was measured, the edge upright (Fig. 7)."""
    middle, (x, y) = view.ends.mean(axis=0), view.ends[1] - view.ends[0]
    upright = np.array([[y, x], [-x, y]]) / np.hypot(x, y)
    ends, obstacles, closest = (
        (points - middle) @ upright for points in (view.ends, view.obstacles, view.closest)
    )
    near = obstacles[np.abs(obstacles[:, 1]) < view.strip[1] + 0.4]
    draw_passage_width(ax, ends, obstacles=near, closest=closest, strip=view.strip, title=title)


def _passage_picture(result: MapResult, view: PassageView) -> Picture:
    figure = new_figure(_PLAN_WIDTH, 0.7 * _PLAN_WIDTH)
    draw_passage(figure.subplots(), view)
    return Picture.of(
        png_bytes(figure, dpi=230),
        f"{result.name} passage",
        "A passageway's width",
        "At one border edge (blue): nearby obstacle points, the search area, and the closest "
        "points on either side.",
        f"Obstacle points around an edge of {result.name} and the width of {view.width:.2f} m",
    )


def lintel_picture(place: Place, view: LintelView) -> Picture:
    """Show the lintel search at one node: image, edge pixels, histogram (Fig. 8)."""
    figure = new_figure(11.0, 3.5)
    axes = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.25))
    draw_lintel_search(axes[0], view.image, view.camera, "camera image")
    draw_edge_pixels(
        axes[1], view.image, view.camera, pixels=view.pixels, theta=view.theta, title="above"
    )
    draw_lintel_histogram(
        axes[2],
        view.histogram,
        directions=view.directions,
        offsets=view.offsets,
        offset_limit=view.offset_limit,
        title="edge histogram",
    )
    return Picture.of(
        png_bytes(figure),
        f"{place.name} lintel",
        f"Lintel search at node {view.node}",
        "Search cone solid, offset cone dashed; edge pixels in the hue of their direction; "
        "the highest bin is the lintel, or what looks like one.",
        f"Camera image at node {view.node}, its {len(view.pixels)} edge pixels and their "
        f"histogram with a maximum of {int(np.max(view.histogram, initial=0))}",
    )


def room_pictures(place: Place, result: MapResult) -> Iterator[Picture]:
    """Yield the true rooms and those found, side by side on the page (Figs. 22 and 27)."""
    topomap = result.topomap
    truth = None if topomap.ground_truth is None else topomap.ground_truth.room
    panels = [
        ("Ground truth", "truth", truth, None),
        ("With the classifier", "rooms", result.room, result.impurity),
        ("Uniform weights", "uniform", result.uniform_room, result.uniform_impurity),
    ]
    for title, kind, room, impurity in panels:
        if room is not None:
            yield _room_picture(place, result, room, (title, kind, impurity))


def _room_picture(
    place: Place,
    result: MapResult,
    room: NDArray[Any],
    panel: tuple[str, str, float | None],
) -> Picture:
    title, kind, impurity = panel
    ground_truth = result.topomap.ground_truth
    truth = None if kind == "truth" or ground_truth is None else ground_truth.room
    count = len(np.unique(room))
    caption = f"{count} rooms"
    if impurity is not None:
        caption += f", impurity {100.0 * impurity:.2f} %"
    if truth is not None:
        wrong = int(wrong_nodes(room, truth).sum())
        caption += f", {wrong:,} nodes in a wrong room (ringed)" if wrong else ", no node wrong"
    return _plan_picture(
        place,
        result,
        lambda ax: draw_rooms(
            ax,
            result.topomap.nodes,
            room,
            truth=truth,
            points=result.topomap.obstacles.position,
            outlines=place.outlines,
        ),
        kind,
        title,
        f"{caption}.",
        f"{title} of {result.name}: nodes coloured by room, {caption}",
    )


def snapshot_pictures(place: Place, snapshot: Snapshot) -> Iterator[Picture]:
    """Yield a camera image and its panorama (Figs. 20 and 21), pixel by pixel."""
    where = f"node {snapshot.node}"
    yield Picture.of(
        _grey_png(snapshot.image),
        f"{place.name} {where} camera",
        where.capitalize(),
        "",
        f"Fisheye image looking up from {where} of {place.name}",
    )
    if snapshot.panorama is not None:
        yield Picture.of(
            _grey_png(snapshot.panorama),
            f"{place.name} {where} panorama",
            where.capitalize(),
            "",
            f"Unfolded panorama at {where} of {place.name}",
        )


def _grey_png(image: NDArray[np.uint8]) -> bytes:
    done, data = cv2.imencode(".png", np.ascontiguousarray(image, dtype=np.uint8))
    if not done:
        raise ValueError(f"image: shape {image.shape}, expected (h, w)")
    return data.tobytes()


def result_pictures(report: Report) -> Iterator[Picture]:
    """Yield the charts over all maps: ROC curves and impurity by variant (Figs. 11 and 26)."""
    for kind, curves in (
        ("without images", report.roc_without_images),
        ("with images", report.roc_with_images),
    ):
        if curves:
            yield _roc_picture(kind, curves)
    if report.impurity_by_variant:
        yield _variant_picture(report)


def _roc_picture(kind: str, curves: tuple[RocCurve, ...]) -> Picture:
    figure = new_figure(4.4, 4.4)
    draw_roc(figure.subplots(), curves)
    return Picture.of(
        png_bytes(figure, dpi=200),
        f"roc {kind}",
        f"How well one feature tells border edges, {kind}",
        "Solid: ROC curve. Dashed: Youden's J. Diagonal: chance.",
        "ROC curves: " + ", ".join(f"{curve.name} AUC {curve.area:.2f}" for curve in curves),
    )


def _variant_picture(report: Report) -> Picture:
    ours = {name: 100.0 * value for name, value, _ in report.impurity_by_variant}
    paper = {
        name: 100.0 * theirs for name, _, theirs in report.impurity_by_variant if theirs is not None
    }
    figure = new_figure(5.4, 3.3)
    draw_impurity_bars(figure.subplots(), ours, paper or None)
    return Picture.of(
        png_bytes(figure, dpi=200),
        "impurity",
        "What each kind of feature is worth",
        "Mean impurity with all features, and with some of them left out.",
        "Mean impurity: " + ", ".join(f"{name} {value:.1f}" for name, value in ours.items()),
    )
