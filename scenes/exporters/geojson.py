"""An apartment as GeoJSON: the layers that `scenes.importers.geojson` reads."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pydantic import BaseModel
from shapely import Polygon

from scenes.apartment import Apartment, Piece
from scenes.openings import place
from scenes.pieces import KINDS
from scenes.storage import save_text

__all__ = ["apartment_geojson", "piece_outline", "write_geojson"]

GEOMETRY = frozenset({"polygon", "holes", "position", "start", "end", "width"})
"""Fields that the geometry of a feature says."""


def write_geojson(apartment: Apartment, path: str | Path) -> None:
    """Write an apartment as GeoJSON, in metres; one feature a line.

    Raises
    ------
    SceneError
        If the file cannot be written.
    """
    data = apartment_geojson(apartment)
    lines = [json.dumps(feature, ensure_ascii=False) for feature in data.pop("features")]
    head = json.dumps(data, ensure_ascii=False)[:-1]
    save_text(head + ', "features": [\n' + ",\n".join(lines) + "\n]}\n", path)


def apartment_geojson(apartment: Apartment) -> dict[str, Any]:
    """The FeatureCollection of an apartment."""
    own = apartment.model_dump(
        mode="json",
        include={"name", "description", "lighting", "passageway_contrast", "materials"},
    )
    return {"type": "FeatureCollection", "apartment": own, "features": [*_features(apartment)]}


def _features(apartment: Apartment) -> Iterator[dict[str, Any]]:
    for room in apartment.rooms:
        yield _feature("room", Polygon(room.polygon), room)
    for wall in apartment.walls:
        yield _feature("wall", shapely.LineString([wall.start, wall.end]), wall)
    for block in apartment.blocks:
        yield _feature("block", Polygon(block.polygon, block.holes), block)
    for border in apartment.borders:
        yield _feature("border", shapely.LineString(border), None)
    for layer, items in (("door", apartment.passages), ("window", apartment.windows)):
        for item in items:
            yield _feature(layer, _line(apartment, item.position, item.width), item)
    for piece in apartment.furniture:
        yield _feature("furniture", piece_outline(piece), piece)
    for lamp in apartment.lamps:
        yield _feature("lamp", shapely.Point(lamp.position), lamp)
    yield _feature("start", shapely.Point(apartment.start.position), apartment.start)


def piece_outline(piece: Piece) -> Polygon:
    """The rectangle that a piece takes, m."""
    width, depth, _ = piece.size or KINDS[piece.kind].size
    angle = np.radians(piece.rotation_deg)
    c, s = round(float(np.cos(angle)), 15), round(float(np.sin(angle)), 15)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (width / 2, depth / 2)
    return Polygon(corners @ np.array([[c, s], [-s, c]]) + np.array(piece.position))


def _line(apartment: Apartment, position: tuple[float, float], width: float) -> shapely.LineString:
    """The line of an opening along its wall."""
    opening = place(apartment, position, width)
    half = width / 2
    return shapely.LineString(opening.points(np.array([(-half, 0.0), (half, 0.0)])))


def _feature(layer: str, shape: shapely.Geometry, item: BaseModel | None) -> dict[str, Any]:
    fields = {} if item is None else item.model_dump(mode="json", exclude=set(GEOMETRY))
    return {
        "type": "Feature",
        "properties": {"layer": layer, **fields},
        "geometry": _geometry(shape),
    }


def _geometry(shape: shapely.Geometry) -> dict[str, Any]:
    if shape.geom_type == "Point":
        return {"type": "Point", "coordinates": _points(shape)[0]}
    if shape.geom_type == "LineString":
        return {"type": "LineString", "coordinates": _points(shape)}
    # RFC 7946: the outer ring counter-clockwise, holes clockwise.
    turned = shapely.orient_polygons(shape)
    rings: Sequence[shapely.LinearRing] = [turned.exterior, *turned.interiors]
    return {"type": "Polygon", "coordinates": [_points(ring) for ring in rings]}


def _points(shape: shapely.Geometry) -> list[list[float]]:
    rounded: list[list[float]] = np.round(shapely.get_coordinates(shape), 6).tolist()
    return rounded
