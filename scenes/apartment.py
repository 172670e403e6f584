"""What an apartment is: the one description that simulator and renderer read.

SI units; x right, y up; angles in files are degrees and say so (``_deg``),
because people write these files. Room polygons are the clear floor between
the wall faces; walls are centre lines with a thickness; passages and windows
are cut into the wall on whose centre line their middle lies. Blocks are solids
of free shape: columns, ceiling steps, traced walls. Everything solid becomes
vertical prisms in `scenes.solids`, so that the 2D obstacles of the simulator are
by construction what the 3D pieces occupy near the floor.

The JSON Schema is generated from these models (``Apartment.model_json_schema()``).
What the types cannot say (overlaps, doorways off every wall) is checked in
`scenes.checks`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "DRIVEN_OVER",
    "Apartment",
    "Block",
    "Frame",
    "Lamp",
    "Lighting",
    "Material",
    "Passage",
    "Piece",
    "Room",
    "SceneFile",
    "Skirting",
    "Start",
    "Threshold",
    "Wall",
    "Window",
]

DRIVEN_OVER = 0.01
"""What lies on the floor and is no higher is driven over, m: rugs, cables, thresholds."""

Metres = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Length = Annotated[float, Field(gt=0.0, le=1000.0)]
Point = tuple[Metres, Metres]
Unit = Annotated[float, Field(ge=0.0, le=1.0)]
Colour = tuple[Unit, Unit, Unit]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]

RoomKind = Literal[
    "bathroom", "bedroom", "corridor", "kitchen", "living_room", "office", "storage", "other"
]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Material(_Model):
    """A procedural surface: a pattern of two colours at true scale."""

    pattern: Literal[
        "plain",
        "plaster",
        "wallpaper",
        "parquet",
        "planks",
        "tiles",
        "carpet",
        "wood",
        "fabric",
        "metal",
        "glass",
    ] = "plain"
    colour: Colour = (0.8, 0.8, 0.8)
    second_colour: Colour | None = None
    """Grout, grain or weave; a darker shade of ``colour`` if absent."""
    size: Length = 0.2
    """Size of one repeat (tile, board, weave, motif), m."""
    roughness: Unit = 0.7
    motif: Literal["stripes", "dots", "sprigs", "ogee"] = "stripes"
    """What is printed on a wallpaper in the second colour."""
    seed: Annotated[int, Field(ge=0, lt=2**32)] = 0
    """Moves the pattern by some metres: other boards, grain and mottling; 0: not at all."""


class Skirting(_Model):
    """Boards along the feet of a room's walls, interrupted by its passages."""

    height: Annotated[float, Field(gt=0.0, le=0.5)] = 0.07
    depth: Annotated[float, Field(gt=0.0, le=0.05)] = 0.012
    material: Name = "frame_paint"


class Room(_Model):
    """A room: clear floor polygon between the wall faces, m."""

    name: Name
    kind: RoomKind = "other"
    polygon: tuple[Point, ...] = Field(min_length=3)
    ceiling_height: Length = 2.5
    floor: Name = "parquet"
    walls: Name = "white_plaster"
    ceiling: Name = "white_paint"
    skirting: Skirting | None = None


class Wall(_Model):
    """A straight wall along its centre line, floor to ceiling."""

    start: Point
    end: Point
    thickness: Length = 0.12


class Block(_Model):
    """A solid of free shape: an upright prism between two heights, m.

    ``top`` ``None``: through the ceiling. ``material`` ``None``: the ``walls``
    surface of whichever room a face looks into. A block from the floor through
    the ceiling without a material is masonry: it closes rooms as a wall does,
    takes its footprint from their floor, and openings cut it. A block that
    begins above the floor and goes through the ceiling is a step of the ceiling.
    """

    polygon: tuple[Point, ...] = Field(min_length=3)
    holes: tuple[Annotated[tuple[Point, ...], Field(min_length=3)], ...] = ()
    bottom: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    top: Length | None = None
    material: Name | None = None

    @property
    def is_masonry(self) -> bool:
        """Whether it is a piece of wall."""
        return self.bottom == 0.0 and self.top is None and self.material is None


class SceneFile(_Model):
    """A 3D scene that is rendered instead of the solids; they are its obstacles only.

    ``file`` is a Blender file in the folder of the apartment's or the map's own
    file; ``sha256`` of its bytes tells whether it is still the same.
    """

    file: Name
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Frame(_Model):
    """A door frame (jambs and, under a lintel, the head).

    ``width`` is the visible casing around the opening, ``depth`` how far it
    stands out from the wall face on either side, m.
    """

    width: Length = 0.07
    depth: Length = 0.02
    material: Name = "frame_paint"


class Threshold(_Model):
    """A sill or a strip that lies across a passage, low enough to be driven over.

    ``height`` above the floor; ``depth`` along the way through, in the middle of the
    wall, m.
    """

    height: Annotated[float, Field(gt=0.0, le=DRIVEN_OVER)] = 0.006
    depth: Annotated[float, Field(gt=0.0, le=0.5)] = 0.04
    material: Name = "metal"


class Passage(_Model):
    """A doorway or an open passage: a gap in the wall that joins two rooms.

    ``width`` is the clear width between the jambs. ``lintel_height`` is the
    clear height; ``None``: open up to the ceiling. Doors are always open and
    their leaves not modelled (§3.1). ``closed`` passages (the entrance door)
    are filled by a door leaf and join nothing. A ``threshold`` tilts the robot that
    drives over it.
    """

    position: Point
    width: Length = 0.8
    lintel_height: Length | None = 2.0
    frame: Frame | None = None
    threshold: Threshold | None = None
    closed: bool = False


class Window(_Model):
    """An opening to the outside with a frame around it."""

    position: Point
    width: Length = 1.2
    sill_height: Annotated[float, Field(ge=0.0, le=10.0)] = 0.9
    head_height: Length = 2.1
    frame: Name = "window_paint"


class Piece(_Model):
    """A piece of furniture or fitting, made of prisms by `scenes.pieces`.

    ``position`` is the middle of the footprint; at ``rotation_deg`` 0 the back
    of the piece is towards +y. ``size`` is (width, depth, height), m; the
    kind's default if absent, as is ``elevation``, of its underside above the floor,
    m: 0 but for what hangs. ``materials`` replaces slots of the kind.
    """

    kind: Name
    position: Point
    rotation_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    elevation: Annotated[float, Field(ge=0.0, le=10.0)] | None = None
    size: tuple[Length, Length, Length] | None = None
    materials: dict[str, Name] = Field(default_factory=dict)


class Lamp(_Model):
    """A lamp: a glowing body with a power and a colour temperature, K.

    ``power`` is in watts as on the box of an incandescent bulb, 13.4 lm each (60 W:
    806 lm). ``height`` is the underside of the body above the floor, m; ``None``: that
    of the kind, ceiling lamps flush with the ceiling.
    """

    kind: Literal["ceiling", "pendant", "floor", "table"] = "ceiling"
    position: Point
    height: Length | None = None
    radius: Length = 0.15
    power: Length = 40.0
    temperature: Annotated[float, Field(ge=1000.0, le=20000.0)] = 3000.0


class Lighting(_Model):
    """Which light falls in: lamps, sun and sky, or both (Table 8)."""

    source: Literal["interior", "exterior", "mixed"] = "exterior"
    sun_elevation_deg: Annotated[float, Field(ge=-90.0, le=90.0)] = 35.0
    sun_azimuth_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 200.0
    sun_strength: Annotated[float, Field(ge=0.0, le=100.0)] = 3.0
    """Irradiance of the sun, W/m²."""
    sky_strength: Annotated[float, Field(ge=0.0, le=100.0)] = 1.0


class Start(_Model):
    """Where the base station stands and the run begins."""

    position: Point
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0


class Apartment(_Model):
    """One apartment; see the module docstring for conventions."""

    format: Literal["roomseg-apartment"] = "roomseg-apartment"
    format_version: Literal[1] = 1
    name: Name
    description: str = ""
    rooms: tuple[Room, ...] = Field(min_length=1)
    walls: tuple[Wall, ...] = ()
    blocks: tuple[Block, ...] = ()
    borders: tuple[tuple[Point, Point], ...] = ()
    """Borders between rooms that no wall parts: segments, m."""
    passages: tuple[Passage, ...] = ()
    windows: tuple[Window, ...] = ()
    furniture: tuple[Piece, ...] = ()
    lamps: tuple[Lamp, ...] = ()
    materials: dict[Name, Material] = Field(default_factory=dict)
    """Own materials; they come before the built-in ones of `scenes.materials`."""
    lighting: Lighting = Field(default_factory=Lighting)
    passageway_contrast: Literal["low", "medium", "high"] = "medium"
    scene_file: SceneFile | None = None
    start: Start
