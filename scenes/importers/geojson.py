"""Floor plans as GeoJSON: one feature per element, its ``layer`` says what it is.

Coordinates are metres in a flat frame (x right, y up), not degrees. The layers:

===========  =======================================  =======================================
layer        geometry                                 properties (all optional)
===========  =======================================  =======================================
room         Polygon: clear floor                     name, kind, ceiling_height, floor, walls,
                                                      ceiling, skirting
wall         LineString: centre line; Polygon:        thickness
             footprint
door         LineString: along the wall; Polygon:     width (Point only), lintel_height, frame,
             thin outline; Point: the middle          closed, threshold
window       as door                                  width (Point only), sill_height,
                                                      head_height, frame
furniture    Polygon: outline; Point: the middle      kind (required), rotation_deg, size,
                                                      elevation, materials
block        Polygon                                  bottom, top, material
border       LineString                               –
lamp         Point                                    kind, height, radius, power, temperature
start        Point                                    heading_deg
===========  =======================================  =======================================

Properties are the fields of `scenes.apartment` of the same name. A member
``apartment`` of the collection may hold name, description, lighting,
passageway_contrast and own materials. `scenes.exporters.geojson` writes all this;
what else the GeoJSON of a map has (one with a member ``map``) is passed over.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError
from shapely import Polygon

from scenes.apartment import Block, Lamp, Passage, Piece, Point, Room, Start, Wall, Window
from scenes.errors import SceneError
from scenes.faults import shape_fault, value_fault
from scenes.importers import Imported, first_of
from scenes.importers.drawing import PlanDrawing, PlanFixture, PlanOpening, PlanRoom, long_axis
from scenes.importers.plan import PlanOptions
from scenes.importers.plan_file import built, check_extent, check_scale
from scenes.importers.reading import read_json
from scenes.pieces import KINDS

__all__ = ["read_geojson"]

Floats = NDArray[np.float64]

FORMAT = "a GeoJSON FeatureCollection"
FAR = 400.0
"""Plans farther from the origin are moved there, m."""
DEGREES = ("crs84", "epsg::4326", "epsg:4326")
LAYERS = ("room", "wall", "door", "window", "furniture", "block", "border", "lamp", "start")
OWN = ("description", "lighting", "passageway_contrast", "materials")
OF_MAPS: dict[str, tuple[str, ...]] = {"room": ("room", "nodes", "area"), "drawn_border": ()}
"""What `roomseg export` writes of a map beside floor and borders, by layer."""


def read_geojson(
    path: str | Path,
    *,
    scale: float | None = None,
    name: str | None = None,
    start: Point | None = None,
    ceiling_height: float = 2.5,
    furnish: bool = True,
    add_doors: bool = False,
) -> Imported:
    """Read a floor plan from GeoJSON; the layers are in the module's docstring.

    Parameters
    ----------
    path : path
    scale : float, optional
        Metres per unit of the coordinates; 1 if absent.
    name : str, optional
        Of the apartment; the file's own, or the file's stem, if absent.
    start, ceiling_height, furnish, add_doors
        `PlanOptions`, for what the file does not say.

    Raises
    ------
    SceneError
        One line: the file, the feature, its value, what would be right.
    """
    check_scale(path, scale)
    data = read_json(path, FORMAT)
    if not isinstance(data, dict) or not isinstance(data.get("features"), list):
        raise SceneError(f"{path}: no list of features; expected {FORMAT}")
    _refuse_degrees(path, data.get("crs"))
    own = data.get("apartment") or {}
    if not isinstance(own, dict):
        raise SceneError(f"{path}: apartment: {own!r:.60}; expected an object")
    _refuse_no_layers(path, data["features"])
    reader = _Layers(path, 1.0 if scale is None else scale, OF_MAPS if "map" in data else {})
    rooms = [*_room_shapes(data["features"], reader.scale)]
    check_extent(path, rooms, scale)
    if rooms:
        reader.move(shapely.total_bounds(rooms))
    for index, feature in enumerate(data["features"]):
        reader.add(index, feature)
    drawing = reader.drawing({key: own[key] for key in OWN if key in own})
    options = PlanOptions(ceiling_height, furnish=furnish, add_doors=add_doors, start=start)
    return built(path, drawing, name or own.get("name"), options)


def _room_shapes(features: list[Any], scale: float) -> Iterator[shapely.Geometry]:
    """Outlines of the rooms as far as they can be read; what is wrong is found later."""
    for feature in features:
        try:
            if feature["properties"]["layer"] == "room":
                geometry = feature["geometry"]
                yield _geometry(geometry["type"], geometry["coordinates"], scale)
        except (TypeError, ValueError, LookupError, shapely.errors.ShapelyError):
            continue


def _refuse_no_layers(path: str | Path, features: list[Any]) -> None:
    """Refuse a file of another program, in which nothing says what it is."""
    found = [item.get("properties") for item in features if isinstance(item, dict)]
    if found and not any(isinstance(item, dict) and "layer" in item for item in found):
        raise SceneError(
            f"{path}: no feature has a property 'layer'; expected one in each, that says what it "
            f"is: {', '.join(LAYERS)}"
        )


def _refuse_degrees(path: str | Path, crs: object) -> None:
    text = str(crs).lower()
    if any(system in text for system in DEGREES):
        raise SceneError(
            f"{path}: crs: degrees of longitude and latitude; expected coordinates in metres "
            f"(project the layers, or draw without a coordinate system)"
        )


@dataclass
class _Layers:
    """The elements of a drawing, filled feature by feature."""

    path: str | Path
    scale: float
    passed_over: Mapping[str, tuple[str, ...]]
    shift: tuple[float, float] = (0.0, 0.0)
    rooms: list[PlanRoom] = field(default_factory=list)
    walls: list[Wall] = field(default_factory=list)
    wall_shapes: list[Polygon] = field(default_factory=list)
    openings: list[PlanOpening] = field(default_factory=list)
    fixtures: list[PlanFixture] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    borders: list[Any] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)
    start: Start | None = None
    notes: list[str] = field(default_factory=list)
    unknown: dict[str, list[str]] = field(default_factory=dict)

    def move(self, bounds: Floats) -> None:
        """Bring a plan in the coordinates of a country to the origin."""
        if np.isfinite(bounds).all() and np.abs(bounds).max() > FAR:
            self.shift = (-float(np.floor(bounds[0])), -float(np.floor(bounds[1])))
            x, y = self.shift
            self.notes.append(f"all coordinates: moved by ({x:.0f}, {y:.0f}) m to the origin")

    def add(self, index: int, feature: object) -> None:
        """Take over one feature."""
        label = f"features[{index}]"
        if not isinstance(feature, dict):
            raise SceneError(f"{self.path}: {label}: {feature!r:.60}; expected a feature")
        properties = feature.get("properties") or {}
        layer = properties.get("layer") if isinstance(properties, dict) else None
        makers: dict[object, Callable[..., None]] = {
            "room": self._room,
            "wall": self._wall,
            "door": partial(self._opening, Passage),
            "window": partial(self._opening, Window),
            "furniture": self._furniture,
            "block": self._block,
            "border": self._border,
            "lamp": self._lamp,
            "start": self._start,
        }
        if not isinstance(layer, str) or layer not in makers:
            told = "no property 'layer'" if layer is None else f"layer {layer!r:.40}"
            if layer != "drawn_border" or layer not in self.passed_over:
                self.unknown.setdefault(told, []).append(label)
            return
        label = f"{label} ({layer})"
        idle = ("layer", *self.passed_over.get(layer, ()))
        fields = {key: value for key, value in properties.items() if key not in idle}
        for part in self._parts(label, feature.get("geometry")):
            makers[layer](label, part, fields)

    def drawing(self, own: Mapping[str, Any]) -> PlanDrawing:
        """All of it."""
        for told, labels in self.unknown.items():
            known = ", ".join(LAYERS)
            self.notes.append(f"{first_of(labels)}: {told}; expected one of {known}; left out")
        fields: dict[str, Any] = dict(own)
        fields["lamps"] = tuple(self.lamps)
        if self.start is not None:
            fields["start"] = self.start
        return PlanDrawing(
            tuple(self.rooms),
            tuple(self.walls),
            tuple(self.wall_shapes),
            tuple(self.openings),
            tuple(self.fixtures),
            tuple(self.blocks),
            tuple(self.borders),
            fields,
            tuple(self.notes),
        )

    def _parts(self, label: str, geometry: object) -> Iterator[shapely.Geometry]:
        """Simple geometries of a feature, in metres."""
        known = ("Point", "LineString", "Polygon", "MultiPoint", "MultiLineString", "MultiPolygon")
        kind = geometry.get("type") if isinstance(geometry, dict) else geometry
        if not isinstance(geometry, dict) or kind not in known:
            raise SceneError(
                f"{self.path}: {label}: geometry {kind!r:.40}; expected one of {', '.join(known)}"
            )
        try:
            shape = _geometry(str(kind), geometry.get("coordinates"), self.scale)
        except (TypeError, ValueError, LookupError, shapely.errors.ShapelyError) as error:
            reason = str(error).splitlines()[0] if str(error) else "no coordinates"
            raise SceneError(
                f"{self.path}: {label}: coordinates: {reason}; expected those of a {kind}"
            ) from None
        if shape.is_empty:
            raise SceneError(f"{self.path}: {label}: no coordinates; expected those of a {kind}")
        yield from shapely.get_parts(shapely.transform(shape, lambda xy: xy + self.shift))

    def _need(self, label: str, part: shapely.Geometry, *kinds: str) -> None:
        if part.geom_type not in kinds:
            raise SceneError(
                f"{self.path}: {label}: a {part.geom_type}; expected a {' or '.join(kinds)}"
            )

    def _need_simple(self, label: str, part: Polygon) -> None:
        if not part.is_valid:
            raise SceneError(
                f"{self.path}: {label}: {shape_fault(part)}; expected a simple polygon"
            )

    def _make(self, label: str, model: type[BaseModel], fields: Mapping[str, Any]) -> Any:
        """An object of a model; unknown fields become notes, bad values an error."""
        unknown = [key for key in fields if key not in model.model_fields]
        if unknown:
            names = ", ".join(repr(key) for key in unknown)
            self.notes.append(f"{label}: unknown properties {names}; left out")
        known = {k: v for k, v in fields.items() if k in model.model_fields and v is not None}
        known |= {k: None for k, v in fields.items() if v is None and _nullable(model, k)}
        try:
            return model(**known)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
            where = ".".join(str(item) for item in fault["loc"]) or "properties"
            raise SceneError(
                f"{self.path}: {label}: {where}: {fault['input']!r:.40}; {value_fault(fault)}"
            ) from None

    def _room(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "Polygon")
        self._need_simple(label, part)
        named = str(fields.pop("name", None) or fields.get("kind") or "room")
        stand_in = {"name": "room", "polygon": ((0, 0), (1, 0), (0, 1))}
        room = self._make(label, Room, {**fields, **stand_in})
        given = {key for key in fields if key in Room.model_fields and key != "kind"}
        rest = {key: getattr(room, key) for key in given}
        shape = Polygon(part.exterior)
        self.rooms.append(PlanRoom(f"{label} {named!r}", named, room.kind, shape, rest))
        for hole in part.interiors:
            self.blocks.append(self._make(label, Block, {"polygon": _corners(hole)}))

    def _wall(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "LineString", "Polygon")
        if part.geom_type == "Polygon":
            self._need_simple(label, part)
            self.wall_shapes.append(part)
            return
        points = shapely.get_coordinates(part).tolist()
        for a, b in itertools.pairwise(points):
            if np.hypot(*np.subtract(a, b)) > 1e-3:
                self.walls.append(self._make(label, Wall, {**fields, "start": a, "end": b}))

    def _opening(
        self,
        model: type[Passage | Window],
        label: str,
        part: shapely.Geometry,
        fields: dict[str, Any],
    ) -> None:
        item = self._make(label, model, {**fields, "position": (0.0, 0.0)})
        if part.geom_type == "Point":
            line = self._across_point(part, item.width)
        else:
            line = long_axis(part)
        given = set(fields) & set(model.model_fields) - {"width"}
        rest = {key: getattr(item, key) for key in given}
        start, end = (tuple(point) for point in line.tolist())
        kind: Literal["door", "window"] = "door" if model is Passage else "window"
        self.openings.append(PlanOpening(label, kind, start, end, "closed", rest))

    def _across_point(self, point: shapely.Point, width: float) -> Floats:
        """A line of that width along the nearest wall or room side drawn so far."""
        sides = [np.array([(wall.start, wall.end) for wall in self.walls]).reshape(-1, 2, 2)]
        for room in self.rooms:
            ring = shapely.get_coordinates(room.shape.exterior)
            sides.append(np.stack([ring[:-1], ring[1:]], axis=1))
        every = np.concatenate(sides)
        if not len(every):
            raise SceneError(
                f"{self.path}: a door or window at ({point.x:g}, {point.y:g}) comes before all "
                f"rooms and walls; expected them first, or a LineString"
            )
        side = every[int(np.argmin(shapely.distance(shapely.linestrings(every), point)))]
        along = (side[1] - side[0]) / np.hypot(*(side[1] - side[0]))
        middle = np.array([point.x, point.y])
        line: Floats = np.array([middle - width / 2 * along, middle + width / 2 * along])
        return line

    def _furniture(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "Polygon", "Point")
        kind = fields.get("kind")
        if not isinstance(kind, str) or kind not in KINDS:
            self.notes.append(f"{label}: {kind!r:.40} is no kind of furniture; left out")
            return
        piece = None
        if part.geom_type == "Point" or {"rotation_deg", "size"} <= set(fields):
            middle = part if part.geom_type == "Point" else part.exterior.centroid
            spot = (round(middle.x, 6), round(middle.y, 6))
            piece = self._make(label, Piece, {**fields, "position": spot})
        self.fixtures.append(PlanFixture(f"{label} {kind!r}", kind, part, piece))

    def _block(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "Polygon")
        self._need_simple(label, part)
        holes = tuple(_corners(ring) for ring in part.interiors)
        shape = {"polygon": _corners(part.exterior), "holes": holes}
        self.blocks.append(self._make(label, Block, {**fields, **shape}))

    def _border(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "LineString")
        points = [tuple(point) for point in shapely.get_coordinates(part).tolist()]
        self.borders.extend(itertools.pairwise(points))

    def _lamp(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "Point")
        self.lamps.append(self._make(label, Lamp, {**fields, "position": (part.x, part.y)}))

    def _start(self, label: str, part: shapely.Geometry, fields: dict[str, Any]) -> None:
        self._need(label, part, "Point")
        if self.start is not None:
            self.notes.append(f"{label}: there is a start already; left out")
            return
        self.start = self._make(label, Start, {**fields, "position": (part.x, part.y)})


def _nullable(model: type[BaseModel], key: str) -> bool:
    return key in model.model_fields and "None" in str(model.model_fields[key].annotation)


def _corners(ring: shapely.LinearRing) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in shapely.get_coordinates(ring)[:-1])


def _geometry(kind: str, coordinates: Any, scale: float) -> shapely.Geometry:
    """A geometry from GeoJSON coordinates; heights are dropped."""

    def points(values: Any) -> Floats:
        array = np.array([value[:2] for value in values], dtype=float).reshape(-1, 2)
        if not np.isfinite(array).all():
            raise ValueError("not finite")
        return array * scale

    def polygon(rings: Any) -> Polygon:
        return Polygon(points(rings[0]), [points(ring) for ring in rings[1:]])

    if kind == "Point":
        return shapely.Point(points([coordinates])[0])
    if kind == "LineString":
        return shapely.LineString(points(coordinates))
    if kind == "Polygon":
        return polygon(coordinates)
    if kind == "MultiPoint":
        return shapely.MultiPoint(points(coordinates))
    if kind == "MultiLineString":
        return shapely.MultiLineString([points(line) for line in coordinates])
    return shapely.MultiPolygon([polygon(rings) for rings in coordinates])
