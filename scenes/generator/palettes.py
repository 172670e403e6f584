"""Surfaces and light of generated apartments.

§3.1: the environments differ in the materials of walls, ceilings and door
frames, in the light, and (Table 8) in how much the passageways stand out. The
paper judges that contrast by eye; here it is the reflectance of the frame
relative to the wall: nearly equal (low), lighter than a tinted wall (medium),
dark on a light wall (high).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from scenes.apartment import Colour, Frame, Lighting, Material, RoomKind
from scenes.generator.wishes import Contrast, Source

__all__ = ["Palette", "draw_lighting", "draw_palette"]

WET = ("bathroom", "kitchen", "storage")
DRY_FLOORS = (
    "parquet",
    "parquet_dark",
    "parquet_light",
    "planks",
    "planks_grey",
    "oak_planks",
    "walnut_planks",
    "white_planks",
    "laminate",
    "carpet_beige",
    "cork",
)
WET_FLOORS = (
    "tiles_grey",
    "tiles_terracotta",
    "tiles_white",
    "tiles_blue",
    "tiles_beige",
    "tiles_slate",
    "tiles_green",
    "terrazzo",
    "linoleum",
)
WOODS = ("wood", "wood_light", "wood_dark", "wood_oak", "wood_cherry", "lacquer_white")
CLOTHS = (
    "fabric_grey",
    "fabric_beige",
    "fabric_dark",
    "fabric_blue",
    "fabric_green",
    "fabric_red",
    "fabric_brown",
    "fabric_teal",
    "fabric_yellow",
    "linen",
)
COVERS = (*CLOTHS, "fabric_white", "fabric_pink", "denim")
RUGS = ("carpet_red", "carpet_blue", "carpet_beige", "carpet_grey", "carpet_green", "carpet_dark")
FRONTS = ("lacquer_white", "lacquer_white", "wood_light", "wood", "lacquer_red", "lacquer_black")
SOFT_FLOORS = (
    "carpet_grey",
    "carpet_beige",
    "carpet_blue",
    "laminate",
    "planks",
    "oak_planks",
    "pine_planks",
    "parquet_light",
)
MOTIFS: tuple[Literal["stripes", "dots", "sprigs", "ogee"], ...] = (
    "stripes",
    "dots",
    "sprigs",
    "ogee",
)


@dataclass(frozen=True)
class Palette:
    """Own materials, and the names of those of each room kind; the frame of all doorways.

    ``swap`` says which material furniture has in this home instead of a kind's
    default (``slot:name`` for one slot only, else ``name``).
    """

    materials: dict[str, Material]
    floors: dict[RoomKind, str]
    walls: dict[RoomKind, str]
    ceiling: str
    frame: Frame
    window: str
    skirting: str
    swap: dict[str, str]


def draw_palette(
    rng: np.random.Generator, kinds: tuple[RoomKind, ...], contrast: Contrast
) -> Palette:
    """Materials for the room kinds of one apartment."""
    level = {"low": (0.62, 0.82), "medium": (0.42, 0.66), "high": (0.66, 0.84)}[contrast]
    main = _tint(rng, level)
    materials = {"main_wall": Material(pattern="plaster", colour=main, size=0.02, roughness=0.9)}
    walls: dict[RoomKind, str] = {}
    for kind in dict.fromkeys(kinds):
        walls[kind] = "main_wall"
        if kind == "bathroom" or (kind not in ("corridor", "living_room") and rng.random() < 0.5):
            name = f"{kind}_wall"
            colour = _frame(rng, main, "low") if contrast == "low" else _tint(rng, level)
            materials[name] = _wall(rng, kind, colour)
            walls[kind] = name
    bright = float(rng.uniform(0.78, 0.86))
    materials["ceiling"] = Material(pattern="plain", colour=(bright, bright, bright), roughness=0.9)
    materials["frame"] = Material(
        pattern="plain", colour=_frame(rng, main, contrast), roughness=0.5
    )
    widths = {"low": (0.04, 0.06), "medium": (0.06, 0.08), "high": (0.07, 0.1)}[contrast]
    width = round(float(rng.uniform(*widths)), 3)
    return Palette(
        materials=materials,
        floors=_floors(rng, kinds),
        walls=walls,
        ceiling="ceiling",
        frame=Frame(width=width, depth=0.01 if contrast == "low" else 0.02, material="frame"),
        window=str(rng.choice(["window_paint", "frame_wood", "frame_grey"])),
        skirting=str(rng.choice(["skirting", "frame_wood", "frame_paint"])),
        swap=_swaps(rng),
    )


def _swaps(rng: np.random.Generator) -> dict[str, str]:
    """What the furniture of one home is made of."""
    woods = [str(rng.choice(WOODS)) for _ in range(2)]
    cloths = [str(rng.choice(CLOTHS)) for _ in range(3)]
    covers = [str(rng.choice(COVERS)) for _ in range(3)]
    return {
        "wood": woods[0],
        "wood_light": woods[1],
        "fabric_grey": cloths[0],
        "fabric_beige": cloths[1],
        "boxes:fabric_beige": cloths[2],
        "boxes:fabric_red": cloths[2],
        "cover:fabric_blue": covers[0],
        "cover:fabric_green": covers[1],
        "cover:fabric_red": covers[2],
        "carpet_red": str(rng.choice(RUGS)),
        "fronts:lacquer_white": str(rng.choice(FRONTS)),
        "worktop:stone": str(rng.choice(["stone", "wood", "wood_light"])),
    }


def draw_lighting(rng: np.random.Generator, source: Source) -> Lighting:
    """Sun and sky; at night (``interior``) hardly any of either."""
    day = {"interior": 0.0, "mixed": 0.5, "exterior": 1.0}[source]
    return Lighting(
        source=source,
        sun_elevation_deg=round(float(rng.uniform(22.0, 55.0)), 1),
        sun_azimuth_deg=round(float(rng.uniform(90.0, 270.0)), 1),
        sun_strength=round(day * float(rng.uniform(2.0, 4.0)), 2),
        sky_strength=round(max(0.02, day * float(rng.uniform(0.8, 1.3))), 2),
    )


def _tint(rng: np.random.Generator, level: tuple[float, float]) -> Colour:
    """Draw a pale colour of about that reflectance."""
    base = float(rng.uniform(*level))
    red, green, blue = np.clip(base + rng.uniform(-0.07, 0.07, 3), 0.05, 0.88)
    return round(float(red), 3), round(float(green), 3), round(float(blue), 3)


def _wall(rng: np.random.Generator, kind: RoomKind, colour: Colour) -> Material:
    if kind == "bathroom":
        size = float(rng.choice([0.15, 0.2, 0.3]))
        return Material(pattern="tiles", colour=colour, size=size, roughness=0.3)
    if kind in ("bedroom", "living_room", "office") and rng.random() < 0.4:
        return _wallpaper(rng, colour)
    return Material(pattern="plaster", colour=colour, size=0.02, roughness=0.9)


def _wallpaper(rng: np.random.Generator, colour: Colour) -> Material:
    """A faint motif, so that the wall's reflectance stays what the contrast asks."""
    shade = float(rng.uniform(0.75, 0.92))
    red, green, blue = (round(shade * value, 3) for value in colour)
    return Material(
        pattern="wallpaper",
        motif=MOTIFS[int(rng.integers(len(MOTIFS)))],
        colour=colour,
        second_colour=(red, green, blue),
        size=round(float(rng.uniform(0.08, 0.3)), 2),
        roughness=0.9,
        seed=int(rng.integers(1000)),
    )


def _frame(rng: np.random.Generator, wall: Colour, contrast: Contrast) -> Colour:
    """Frame colour whose reflectance differs from the wall's as the contrast asks."""
    if contrast == "low":
        shade = float(rng.uniform(0.96, 1.04))
        red, green, blue = (round(min(0.9, shade * value), 3) for value in wall)
        return red, green, blue
    if contrast == "medium":
        white = round(float(rng.uniform(0.8, 0.88)), 3)
        return white, white, round(white - 0.02, 3)
    dark = float(rng.uniform(0.05, 0.16))
    return round(dark, 3), round(0.7 * dark, 3), round(0.5 * dark, 3)


def _floors(rng: np.random.Generator, kinds: tuple[RoomKind, ...]) -> dict[RoomKind, str]:
    """One floor for hub and living room, others by what the room is for."""
    main = str(rng.choice(DRY_FLOORS))
    floors: dict[RoomKind, str] = {}
    for kind in dict.fromkeys(kinds):
        choices = WET_FLOORS if kind in WET else SOFT_FLOORS
        floors[kind] = main if kind in ("corridor", "living_room") else str(rng.choice(choices))
    return floors
