"""Floor plans of the CubiCasa5k data set: SVG whose groups say by class what they are.

Coordinates are pixels of a drawing, y down, without a scale. What is read:

- ``Space Bedroom``, ``Space LivingRoom`` …: rooms; their outline is the group's first
  polygon. ``Outdoor``, ``Balcony``, ``Garage``, ``StairWell`` … are no rooms for a robot.
- ``Wall`` and ``Column``: footprints. ``Door`` and ``Window``: thin outlines, in a
  wall's group or beside it.
- ``FixedFurniture Toilet`` …: the polygon of its ``BoundaryPolygon``, or the box around
  all that is drawn of it.
- ``transform`` of any group. Everything else (labels, dimensions, panels) is no part
  of the plan; railings and stairs are left out, and said so.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

import numpy as np
import shapely
from defusedxml import DefusedXmlException, ElementTree
from numpy.typing import NDArray
from shapely import Polygon

from scenes.apartment import Point, RoomKind
from scenes.errors import SceneError
from scenes.faults import shape_fault
from scenes.importers import Imported
from scenes.importers.drawing import PlanDrawing, PlanFixture, PlanOpening, PlanRoom, long_axis
from scenes.importers.plan import PlanOptions
from scenes.importers.plan_file import ask_for_scale, built, check_extent, check_scale
from scenes.importers.reading import read_text

__all__ = ["read_cubicasa"]

Floats = NDArray[np.float64]

FORMAT = "a CubiCasa5k SVG"
FARTHEST = 1e6
"""Coordinates of a drawing are at most this large, pixels."""
DOOR_WIDTH = 0.8
"""At the right scale half of the doors are narrower, m."""

SPACES: dict[str, RoomKind] = {
    "Bath": "bathroom",
    "Bedroom": "bedroom",
    "Closet": "storage",
    "Corridor": "corridor",
    "Den": "office",
    "Dining": "living_room",
    "DraughtLobby": "corridor",
    "DressingRoom": "storage",
    "EatingArea": "living_room",
    "Entry": "corridor",
    "Hall": "corridor",
    "HallWay": "corridor",
    "Kitchen": "kitchen",
    "Library": "office",
    "LivingRoom": "living_room",
    "Lounge": "living_room",
    "Office": "office",
    "Pantry": "storage",
    "Sauna": "bathroom",
    "Storage": "storage",
    "TechnicalRoom": "storage",
    "Utility": "storage",
}
OUTSIDE = frozenset(
    {
        "Balcony",
        "Below150cm",
        "CarPort",
        "Elevator",
        "Garage",
        "Garbage",
        "OpenToBelow",
        "Outdoor",
        "Skylights",
        "StairWell",
        "SwimmingPool",
        "Terrace",
    }
)
"""Spaces that are no rooms for a robot."""
FIXTURES = {
    "BaseCabinet": "kitchen_counter",
    "Bathtub": "bath",
    "BathtubRound": "bath",
    "Closet": "wardrobe",
    "CoatCloset": "wardrobe",
    "CoatRack": "coat_rack",
    "CornerSink": "basin",
    "CounterTop": "kitchen_counter",
    "Dishwasher": "dishwasher",
    "DoubleSink": "basin",
    "DoubleSinkRight": "basin",
    "Fireplace": "fireplace",
    "FireplaceCorner": "fireplace",
    "GasStove": "cooker",
    "IntegratedStove": "cooker",
    "Jacuzzi": "bath",
    "Refrigerator": "fridge",
    "RoundSink": "basin",
    "Shower": "shower_tray",
    "ShowerCab": "shower_cabin",
    "ShowerPlatform": "shower_tray",
    "SideSink": "basin",
    "Sink": "basin",
    "Toilet": "toilet",
    "TumbleDryer": "washing_machine",
    "WallCabinet": "wall_cupboard",
    "WashingMachine": "washing_machine",
}
HUNG = frozenset({"wall_cupboard"})
"""Kinds that hang on walls: drawings show them, but not at what height."""
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def read_cubicasa(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    ceiling_height: float = 2.5,
    furnish: bool = True,
    add_doors: bool = False,
) -> Imported:
    """Read a floor plan of CubiCasa5k; the module's docstring says how.

    Parameters
    ----------
    path : path
    scale : float
        Metres per pixel.
    name : str, optional
        Of the apartment; the file's stem if absent.
    start, ceiling_height, furnish, add_doors
        `PlanOptions`.

    Raises
    ------
    SceneError
        One line: the file, the element, its value, what would be right. Without a
        scale it says at which half of the doors would be narrower than 0.80 m.
    """
    check_scale(path, scale)
    groups = _Groups(path)
    root = _root(path)
    groups.walk(root, np.eye(3))
    if not groups.spaces:
        _refuse_own(path, root)
        raise SceneError(f"{path}: no group of class 'Space'; expected {FORMAT}")
    if scale is None:
        doors = [
            float(np.hypot(*np.diff(long_axis(shape), axis=0)[0]))
            for _, kind, shape in groups.openings
            if kind == "Door"
        ]
        raise ask_for_scale(path, doors, DOOR_WIDTH)
    drawing = _drawing(groups, scale)
    check_extent(path, [room.shape for room in drawing.rooms], scale)
    options = PlanOptions(ceiling_height, furnish=furnish, add_doors=add_doors, start=start)
    return built(path, drawing, name, options)


def _refuse_own(path: str | Path, root: Element) -> None:
    """Refuse the plans that `scenes.exporters.svg` draws."""
    ids = {group.get("id") for group in root if _tag(group) == "g"}
    if {"rooms", "furniture", "labels", "scale"} <= ids:
        raise SceneError(
            f"{path}: a plan that `roomseg export` drew; SVG plans are for looking at only; "
            f"expected a .geojson of it, which can be read back"
        )


def _root(path: str | Path) -> Element:
    """The SVG element; entities are refused, nothing outside the file is read."""
    try:
        root: Element = ElementTree.fromstring(read_text(path, FORMAT).encode())
    except DefusedXmlException:
        raise SceneError(
            f"{path}: declares entities; expected {FORMAT} without any (save it as plain SVG)"
        ) from None
    except ParseError as error:
        raise SceneError(f"{path}: not XML: {error}; expected {FORMAT}") from None
    except (ValueError, RecursionError, LookupError):
        raise SceneError(f"{path}: no readable XML; expected {FORMAT}") from None
    if _tag(root) != "svg":
        raise SceneError(f"{path}: a {_tag(root)!r:.40} document; expected {FORMAT}")
    return root


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


@dataclass
class _Groups:
    """What the groups of a file are: label, type, polygon in pixels."""

    path: str | Path
    spaces: list[tuple[str, str, Polygon]] = field(default_factory=list)
    walls: list[Polygon] = field(default_factory=list)
    openings: list[tuple[str, str, Polygon]] = field(default_factory=list)
    fixtures: list[tuple[str, str, Polygon]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)

    def walk(self, element: Element, above: Floats) -> None:
        """Take over a group and the groups in it."""
        stack = [(element, above)]
        while stack:
            group, outer = stack.pop()
            inner = outer @ self._transform(group)
            if self._take(group, inner):
                stack.extend((child, inner) for child in reversed(group) if _tag(child) == "g")

    def _take(self, group: Element, matrix: Floats) -> bool:
        """Take over one group; whether its inner groups are to be looked at."""
        words = [*group.get("class", "").split(), ""]
        first = group.get("id", "") if group.get("id") in _BY_ID else words[0]
        if first not in ("Space", "Column", "FixedFurniture", *_BY_ID):
            return True
        kind = next((word for word in words[1:] if word != "ElectricalAppliance"), "")[:40]
        self.counts[first] = self.counts.get(first, 0) + 1
        label = f"{first}{' ' + kind if kind else ''} {self.counts[first]}"
        if first in _UNUSED:
            self.notes.append(f"{label}: not used; left out")
            return False
        shape = self._shape(label, first, group, matrix)
        if shape is None:
            self.notes.append(f"{label}: has no polygon; left out")
        elif first == "Space":
            self.spaces.append((label, kind, shape))
        elif first in ("Wall", "Column"):
            self.walls.append(shape)
        elif first == "FixedFurniture":
            self.fixtures.append((label, kind, shape))
        else:
            self.openings.append((label, first, shape))
        return first == "Wall"

    def _shape(self, label: str, first: str, group: Element, matrix: Floats) -> Polygon | None:
        """The outline of a group, y up."""
        if first == "FixedFurniture":
            points = self._fixture(label, group, matrix)
        else:
            outline = next(_outlines(group), None)
            points = None if outline is None else self._points(label, outline, matrix)
        if points is None:
            return None
        shape = Polygon(points * (1.0, -1.0))
        if first == "Space" and not shape.is_valid:
            fault = shape_fault(Polygon(points))
            raise SceneError(f"{self.path}: {label}: {fault}; expected a simple polygon")
        if not shape.is_valid:
            shape = shape.convex_hull
            self.notes.append(f"{label}: its outline crosses itself; the hull around it is used")
        return shape if shape.geom_type == "Polygon" and shape.area > 0.0 else None

    def _fixture(self, label: str, group: Element, matrix: Floats) -> Floats | None:
        """Corners of a fixture: its boundary, or the box around all its outlines."""
        inner = [(child, matrix @ self._transform(child)) for child in group if _tag(child) == "g"]
        for child, own in inner:
            outline = next(_outlines(child), None)
            if outline is not None and "BoundaryPolygon" in child.get("class", "").split():
                return self._points(label, outline, own)
        drawn = [
            self._points(label, outline, own)
            for child, own in [(group, matrix), *inner]
            for outline in _outlines(child)
        ]
        if not drawn:
            return None
        (x0, y0), (x1, y1) = np.min(np.concatenate(drawn), 0), np.max(np.concatenate(drawn), 0)
        return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])

    def _points(self, label: str, outline: str, matrix: Floats) -> Floats:
        """Points (n, 2) of an outline after its transform, y down."""
        numbers = [float(text) for text in NUMBER.findall(outline)]
        if len(numbers) < 6 or len(numbers) % 2 or not np.isfinite(numbers).all():
            raise SceneError(
                f"{self.path}: {label}: points {outline!r:.40}; expected at least three x,y"
            )
        points = np.column_stack([np.reshape(numbers, (-1, 2)), np.ones(len(numbers) // 2)])
        with np.errstate(over="ignore", invalid="ignore"):
            moved: Floats = (points @ matrix.T)[:, :2]
        if not (np.abs(moved) <= FARTHEST).all():
            raise SceneError(
                f"{self.path}: {label}: points {outline!r:.40}; expected pixels within "
                f"{FARTHEST:g} of the origin"
            )
        return moved

    def _transform(self, group: Element) -> Floats:
        """The matrix (3, 3) of a group's ``transform``."""
        matrix = np.eye(3)
        text = group.get("transform", "")
        for name, inside in re.findall(r"(\w+)\s*\(([^)]*)\)", text):
            values = [float(number) for number in NUMBER.findall(inside)]
            step = _matrix(name, values)
            if step is None:
                raise SceneError(
                    f"{self.path}: transform {text!r:.60}; expected matrix, translate, scale "
                    f"or rotate with their numbers"
                )
            matrix = matrix @ step
        return matrix


_UNUSED = ("Railing", "Stairs")
_BY_ID = ("Wall", "Door", "Window", *_UNUSED)
"""Groups that say by their id, too, what they are."""


def _outlines(group: Element) -> Iterator[str]:
    """Points of the polygons right in a group, rectangles as polygons."""
    for child in group:
        if _tag(child) == "polygon":
            yield child.get("points", "")
        elif _tag(child) == "rect":
            try:
                x, y, w, h = (float(child.get(key, "0")) for key in ("x", "y", "width", "height"))
            except ValueError:
                continue
            yield f"{x},{y} {x + w},{y} {x + w},{y + h} {x},{y + h}"


def _matrix(name: str, values: list[float]) -> Floats | None:
    """One step of a transform; None if it is none."""
    count = len(values)
    if name == "matrix" and count == 6:
        a, b, c, d, e, f = values
        return np.array([(a, c, e), (b, d, f), (0.0, 0.0, 1.0)])
    if name == "translate" and count in (1, 2):
        return np.array([(1, 0, values[0]), (0, 1, (values[1:] or [0.0])[0]), (0, 0, 1.0)])
    if name == "scale" and count in (1, 2):
        return np.diag([values[0], values[-1], 1.0])
    if name == "rotate" and count in (1, 3):
        c, s = np.cos(np.radians(values[0])), np.sin(np.radians(values[0]))
        x, y = values[1:] or (0.0, 0.0)
        shift = np.array([x - c * x + s * y, y - s * x - c * y])
        return np.array([(c, -s, shift[0]), (s, c, shift[1]), (0.0, 0.0, 1.0)])
    return None


def _drawing(groups: _Groups, scale: float) -> PlanDrawing:
    """The drawing in metres, its corner at the origin."""
    outlines = [shape for _, _, shape in groups.spaces] + groups.walls
    corner = shapely.total_bounds(outlines)[:2]

    def metres(shape: Polygon) -> Polygon:
        return shapely.transform(shape, lambda xy: (xy - corner) * scale)

    notes = list(groups.notes)
    rooms = []
    for label, kind, shape in groups.spaces:
        if kind in OUTSIDE:
            notes.append(f"{label}: no room for a robot; left out")
        else:
            name = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind or "room").lower()
            rooms.append(PlanRoom(label, name, SPACES.get(kind, "other"), metres(shape)))
    openings = []
    for label, kind, shape in groups.openings:
        start, end = (tuple(p) for p in np.round(long_axis(metres(shape)), 4).tolist())
        openings.append(PlanOpening(label, "window" if kind == "Window" else "door", start, end))
    shapes = [metres(shape) for shape in (*groups.walls, *(s for _, _, s in groups.openings))]
    fixtures = []
    for label, kind, shape in groups.fixtures:
        if kind in FIXTURES and FIXTURES[kind] not in HUNG:
            fixtures.append(PlanFixture(label, _kind(kind, metres(shape), rooms), metres(shape)))
        else:
            notes.append(f"{label}: no kind of furniture for it; left out")
    return PlanDrawing(
        tuple(rooms),
        wall_shapes=tuple(shapes),
        openings=tuple(openings),
        fixtures=tuple(fixtures),
        notes=tuple(notes),
    )


def _kind(drawn: str, shape: Polygon, rooms: list[PlanRoom]) -> str:
    """The kind of piece; a sink in a kitchen is no wash basin."""
    kind = FIXTURES[drawn]
    home = next((room for room in rooms if room.shape.intersects(shape.centroid)), None)
    in_kitchen = home is not None and home.kind in ("kitchen", "living_room")
    return "kitchen_sink" if kind == "basin" and in_kitchen else kind
