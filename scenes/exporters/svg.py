"""An apartment as an SVG plan to scale: one unit is one millimetre on paper.

Groups have ids (``rooms``, ``walls``, ``doors``, ``windows``, ``furniture`` …) and
elements a ``data-name`` or ``data-kind``, so that a drawing program can pick them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree as ET

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Apartment, Passage, Room, Window
from scenes.openings import Opening, lining_of, place
from scenes.pieces import piece_parts
from scenes.solids import (
    LEAF,
    block_footprint,
    building_region,
    cutter,
    masonry_region,
    polygons,
    wall_region,
)
from scenes.storage import save_text

__all__ = ["apartment_svg", "write_svg"]

Floats = NDArray[np.float64]

SCALES = (50, 100, 200, 500)
"""Scales 1:n; the first at which the plan fits on the paper is taken."""
PAPER = 400.0
"""The longer side of a plan, mm (A3)."""
MARGIN = 8.0
FOOT = 12.0
"""Room for the scale bar under the plan, mm."""
TEXT, SMALLEST_TEXT = 3.2, 1.3
"""Height of the letters in rooms, mm."""
LETTER = 0.58
"""Width of a letter, as a share of its height."""
EYES = 1.0
"""What hangs higher is dashed, m."""

COLOURS: Mapping[str, str] = MappingProxyType(
    {
        "bathroom": "#d7eaf6",
        "bedroom": "#f3e6d8",
        "corridor": "#f0f0f0",
        "kitchen": "#fdeccb",
        "living_room": "#e4f1da",
        "office": "#dfe3f6",
        "storage": "#e6e4d8",
        "other": "#f7f7f7",
    }
)
STYLE = """
.room { stroke: none; }
.wall { fill: #333; stroke: none; fill-rule: evenodd; }
.leaf { fill: #a5763f; stroke: none; }
.lintel, .border, .above { fill: none; stroke: #777; stroke-width: .18; stroke-dasharray: 1.2 .8; }
.border { stroke: #2468b4; }
.frame { fill: #8a8a8a; stroke: none; }
.threshold { fill: #c4c4c4; stroke: none; }
.glass { fill: #fff; stroke: #2468b4; stroke-width: .18; }
.piece { fill: #fff; fill-opacity: .55; stroke: #555; stroke-width: .2; stroke-linejoin: round; }
.hung { fill: none; stroke: #555; stroke-width: .18; stroke-dasharray: .9 .6; }
.lamp { fill: #ffe680; fill-opacity: .6; stroke: #a08000; stroke-width: .18; }
.start { fill: #b03030; stroke: none; }
.block { fill: #999; stroke: #555; stroke-width: .18; }
text { font-family: Helvetica, Arial, sans-serif; fill: #222; text-anchor: middle; }
#labels text { paint-order: stroke; stroke: #fff; stroke-width: .6; stroke-opacity: .8; }
.scale { fill: none; stroke: #222; stroke-width: .25; }
"""


class _Frame:
    """From metres, y up, to millimetres on paper, y down."""

    def __init__(self, bounds: tuple[float, float, float, float]) -> None:
        west, south, east, north = bounds
        longer = max(east - west, north - south) * 1000.0
        fitting = [scale for scale in SCALES if longer / scale <= PAPER - 2 * MARGIN]
        self.scale = fitting[0] if fitting else SCALES[-1]
        self.corner = np.array([west, north])
        self.factor = 1000.0 / self.scale
        self.width = (east - west) * self.factor + 2 * MARGIN
        self.height = (north - south) * self.factor + 2 * MARGIN + FOOT

    def points(self, metres: Floats) -> Floats:
        """Points (n, 2) on paper, mm."""
        shifted = (np.asarray(metres, dtype=float).reshape(-1, 2) - self.corner) * (1.0, -1.0)
        paper: Floats = shifted * self.factor + MARGIN
        return paper

    def path(self, shape: shapely.Geometry) -> str:
        """Path data of a shape."""
        if shape.geom_type == "Polygon":
            rings = [shape.exterior, *shape.interiors]
            return " ".join(self._line(ring.coords[:-1]) + " Z" for ring in rings)
        if shape.geom_type == "LineString":
            return self._line(shape.coords)
        return " ".join(self.path(part) for part in shapely.get_parts(shape))

    def _line(self, coordinates: object) -> str:
        points = self.points(np.array(coordinates))
        return "M " + " L ".join(f"{_mm(x)},{_mm(y)}" for x, y in points)


def write_svg(apartment: Apartment, path: str | Path) -> None:
    """Write the plan of an apartment as SVG, the same bytes for the same apartment.

    Raises
    ------
    SceneError
        If the file cannot be written.
    """
    save_text(apartment_svg(apartment), path)


def apartment_svg(apartment: Apartment) -> str:
    """The SVG text of an apartment's plan."""
    frame = _Frame(building_region(apartment).bounds)
    width, height = _mm(frame.width), _mm(frame.height)
    attributes = {
        "xmlns": "http://www.w3.org/2000/svg",
        "width": f"{width}mm",
        "height": f"{height}mm",
        "viewBox": f"0 0 {width} {height}",
    }
    root = ET.Element("svg", attributes)
    ET.SubElement(root, "title").text = apartment.name
    ET.SubElement(
        root, "desc"
    ).text = f"Plan 1:{frame.scale}; one unit is 1 mm on paper, {frame.scale} mm in the apartment."
    ET.SubElement(root, "style").text = STYLE
    _rect(root, (0.0, 0.0, frame.width, frame.height), {"fill": "#fff"})
    _rooms(_group(root, "rooms"), apartment, frame)
    _furniture(_group(root, "furniture"), apartment, frame)
    _walls(root, apartment, frame)
    _openings(root, apartment, frame)
    _borders_and_blocks(root, apartment, frame)
    _lamps_and_start(root, apartment, frame)
    _labels(_group(root, "labels"), apartment, frame)
    _scale_bar(_group(root, "scale"), frame)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _mm(value: float) -> str:
    """A number with two decimals at most."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _group(root: ET.Element, name: str) -> ET.Element:
    return ET.SubElement(root, "g", id=name)


def _rect(
    parent: ET.Element, box: tuple[float, float, float, float], attributes: dict[str, str]
) -> None:
    """A rectangle (x, y, width, height), mm."""
    sides = dict(zip(("x", "y", "width", "height"), map(_mm, box), strict=True))
    ET.SubElement(parent, "rect", sides | attributes)


def _path(parent: ET.Element, frame: _Frame, shape: shapely.Geometry, kind: str) -> ET.Element:
    return ET.SubElement(parent, "path", {"class": kind, "d": frame.path(shape)})


def _rooms(group: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    for room in apartment.rooms:
        item = _path(group, frame, Polygon(room.polygon), "room")
        item.set("fill", COLOURS[room.kind])
        item.set("data-name", room.name)
        item.set("data-kind", room.kind)


def _walls(root: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    group = _group(root, "walls")
    cuts = [cutter(place(apartment, p.position, p.width), lining_of(p)) for p in apartment.passages]
    cuts += [cutter(place(apartment, w.position, w.width)) for w in apartment.windows]
    for part in polygons(wall_region(apartment).difference(shapely.union_all(cuts)), 1e-4):
        _path(group, frame, part, "wall")


def _openings(root: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    doors, windows = _group(root, "doors"), _group(root, "windows")
    for passage in apartment.passages:
        opening = place(apartment, passage.position, passage.width)
        for shape, kind in _door(passage, opening):
            _path(doors, frame, shape, kind)
    for window in apartment.windows:
        opening = place(apartment, window.position, window.width)
        for shape in _window(window, opening):
            _path(windows, frame, shape, "glass")


def _door(passage: Passage, opening: Opening) -> Iterator[tuple[shapely.Geometry, str]]:
    """Jambs, a threshold, a lintel over the opening, or a closed leaf."""
    half, face = opening.width / 2, opening.thickness / 2
    lining = lining_of(passage)
    if passage.frame is not None:
        deep = face + passage.frame.depth
        for a, b in ((-half - lining, -half), (half, half + lining)):
            yield opening.rectangle((a, b), (-deep, deep)), "frame"
    if passage.threshold is not None:
        yield opening.strip(passage.threshold.depth), "threshold"
    if passage.closed:
        yield opening.strip(LEAF), "leaf"
    elif passage.lintel_height is not None:
        for side in (-face, face):
            ends = opening.points(np.array([(-half, side), (half, side)]))
            yield shapely.LineString(ends), "lintel"


def _window(window: Window, opening: Opening) -> Iterator[Polygon]:
    half, face = window.width / 2, opening.thickness / 2
    yield opening.rectangle((-half, half), (-face, face))
    yield opening.rectangle((-half, half), (-0.02, 0.02))


def _borders_and_blocks(root: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    group = _group(root, "blocks")
    for block in apartment.blocks:
        if not block.is_masonry:
            kind = "above" if block.bottom > EYES else "block"
            _path(group, frame, block_footprint(block), kind)
    group = _group(root, "borders")
    for border in apartment.borders:
        _path(group, frame, shapely.LineString(border), "border")


def _furniture(group: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    """Outlines, what lies or stands low first."""
    drawn = [(piece, piece_parts(piece)) for piece in apartment.furniture]
    drawn.sort(key=lambda item: max(part.top for part in item[1]))
    for piece, parts in drawn:
        outline = shapely.union_all([part.footprint for part in parts])
        kind = "hung" if min(part.bottom for part in parts) > EYES else "piece"
        item = _path(group, frame, _edges(outline), kind)
        item.set("data-kind", piece.kind)
        ET.SubElement(item, "title").text = piece.kind.replace("_", " ")


def _edges(outline: shapely.Geometry) -> shapely.Geometry:
    """An outline without the seams between its parts."""
    return outline.buffer(2e-3, join_style="mitre").buffer(-2e-3, join_style="mitre")


def _lamps_and_start(root: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    group = _group(root, "lamps")
    for lamp in apartment.lamps:
        x, y = frame.points(np.array(lamp.position))[0]
        radius = _mm(max(lamp.radius * frame.factor, 0.8))
        item = ET.SubElement(group, "circle", {"class": "lamp", "cx": _mm(x), "cy": _mm(y)})
        item.set("r", radius)
        item.set("data-kind", lamp.kind)
    angle = np.radians(apartment.start.heading_deg + np.array([0.0, 140.0, 220.0]))
    reach = 0.15 * np.column_stack([np.cos(angle), np.sin(angle)])
    arrow = Polygon(np.array(apartment.start.position) + reach)
    item = _path(_group(root, "start"), frame, arrow, "start")
    ET.SubElement(item, "title").text = "start"


def _labels(group: ET.Element, apartment: Apartment, frame: _Frame) -> None:
    """Name and area in the widest free place of each room, upright if the room is narrow."""
    masonry = masonry_region(apartment)
    parts = [part.footprint for piece in apartment.furniture for part in piece_parts(piece)]
    lamps = [shapely.Point(lamp.position).buffer(lamp.radius) for lamp in apartment.lamps]
    start = shapely.Point(apartment.start.position).buffer(0.15)
    taken = shapely.union_all([*parts, *lamps, start])
    for room in apartment.rooms:
        floor = Polygon(room.polygon).difference(masonry)
        free = polygons(floor.difference(taken), 0.05) or polygons(floor)
        circles = [shapely.maximum_inscribed_circle(part, tolerance=0.02) for part in free]
        widest = max(circles, key=lambda circle: float(circle.length))
        _label(group, frame, room, floor, shapely.get_coordinates(widest)[0])


def _label(
    group: ET.Element, frame: _Frame, room: Room, floor: shapely.Geometry, spot: Floats
) -> None:
    lines = (room.name.replace("_", " "), f"{floor.area:.1f} m²")
    letters = max(len(line) for line in lines) * LETTER
    sizes = []
    for axis in ((1.0, 0.0), (0.0, 1.0)):
        ray = np.multiply(axis, 100.0)
        line = shapely.LineString([spot - ray, spot + ray]).intersection(floor)
        part = min(shapely.get_parts(line), key=lambda part: part.distance(shapely.Point(spot)))
        west, south, east, north = part.bounds
        # The text is centred: the nearer wall decides.
        half = min(east - spot[0], spot[0] - west) + min(north - spot[1], spot[1] - south)
        sizes.append(1.9 * float(half) * frame.factor / letters)
    upright = sizes[0] < SMALLEST_TEXT * 1.5 and sizes[1] > sizes[0]
    size = max(min(TEXT, sizes[1] if upright else sizes[0]), SMALLEST_TEXT)
    px, py = (float(value) for value in frame.points(spot)[0])
    attributes = {"font-size": _mm(size), "data-name": room.name}
    attributes["transform"] = f"translate({_mm(px)} {_mm(py)})" + " rotate(-90)" * upright
    text = ET.SubElement(group, "text", attributes)
    for line_text, shift in zip(lines, (-0.15, 1.0), strict=True):
        span = ET.SubElement(text, "tspan", x="0", y=_mm(shift * size))
        span.text = line_text


def _scale_bar(group: ET.Element, frame: _Frame) -> None:
    """A bar of whole metres and the scale, under the plan."""
    metres = 1 if frame.width < 120.0 else 2
    length = metres * frame.factor
    y = frame.height - MARGIN
    for index in range(2):
        x = MARGIN + index * length / 2
        attributes = {"class": "scale", "style": f"fill: {'#fff' if index else '#222'}"}
        _rect(group, (x, y, length / 2, 1.2), attributes)
    for value, x in ((0, MARGIN), (metres, MARGIN + length)):
        _caption(group, x, y - 1.0, f"{value} m" if value else "0")
    _caption(group, MARGIN + length + 14.0, y + 1.2, f"1:{frame.scale}")


def _caption(group: ET.Element, x: float, y: float, text: str) -> None:
    item = ET.SubElement(group, "text", {"x": _mm(x), "y": _mm(y), "font-size": "2.6"})
    item.text = text
