"""Small hand-made plans: apartments without furniture files, and bare obstacles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from scenes.apartment import Apartment, Block, Passage, Piece, Room, Start, Wall


def outline(corners, thickness=0.12):
    """Walls around a polygon of clear floor, by its corners."""
    floor = shapely.Polygon(corners)
    ring = np.asarray(floor.buffer(thickness / 2, join_style="mitre").exterior.coords)
    return tuple(Wall(start=tuple(a), end=tuple(b), thickness=thickness) for a, b in pairwise(ring))


def box_room(width=2.4, height=1.8, start=(0.6, 0.6), heading_deg=0.0, furniture=()):
    """One rectangular room."""
    corners = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
    return Apartment(
        name="box",
        rooms=(Room(name="room", polygon=corners),),
        walls=outline(corners),
        furniture=furniture,
        start=Start(position=start, heading_deg=heading_deg),
    )


def l_shape(start=(0.5, 0.5), heading_deg=90.0):
    """One L-shaped room."""
    corners = ((0.0, 0.0), (2.6, 0.0), (2.6, 1.2), (1.2, 1.2), (1.2, 2.4), (0.0, 2.4))
    return Apartment(
        name="ell",
        rooms=(Room(name="room", polygon=corners),),
        walls=outline(corners),
        start=Start(position=start, heading_deg=heading_deg),
    )


def two_rooms(door=0.85, start=(0.6, 0.7), heading_deg=0.0, threshold=None):
    """Two rooms side by side, joined by one doorway."""
    width, depth, wall = 2.0, 2.2, 0.12
    left = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
    right = tuple((x + width + wall, y) for x, y in left)
    whole = ((0.0, 0.0), (2 * width + wall, 0.0), (2 * width + wall, depth), (0.0, depth))
    middle = width + wall / 2
    return Apartment(
        name="two",
        rooms=(Room(name="left", polygon=left), Room(name="right", polygon=right)),
        walls=(
            *outline(whole),
            Wall(start=(middle, 0.0), end=(middle, depth), thickness=wall),
        ),
        passages=(Passage(position=(middle, 1.2), width=door, threshold=threshold),),
        start=Start(position=start, heading_deg=heading_deg),
    )


def chair(position):
    """A piece that stands on four legs."""
    return Piece(kind="chair", position=position)


def slits(width, shelves=3):
    """A room parted by shelves; beside them a slit of ``width`` m and one of 0.8 m."""
    side, depth = 3.0, 1.5
    corners = ((0.0, 0.0), (side, 0.0), (side, depth * (shelves + 1)), (0.0, depth * (shelves + 1)))
    blocks = []
    for middle in depth * np.arange(1, shelves + 1):
        low, high = float(middle) - 0.05, float(middle) + 0.05
        footprint = ((width, low), (side - 0.8, low), (side - 0.8, high), (width, high))
        blocks.append(Block(polygon=footprint, top=1.0, material="white_paint"))
    return Apartment(
        name="slits",
        rooms=(Room(name="room", polygon=corners),),
        walls=outline(corners),
        blocks=tuple(blocks),
        start=Start(position=(1.5, 0.6), heading_deg=0.0),
    )
