"""The built-in surfaces: procedural patterns at true scale (§3.1, Table 8).

Environments differ in the materials of walls, ceilings and door frames (§3.1).
Colours are linear reflectances in [0, 1]; the camera is monochrome, so that
their luminance matters most. An apartment's own materials come first.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from scenes.apartment import Apartment, Colour, Material
from scenes.errors import SceneError

Motif = Literal["stripes", "dots", "sprigs", "ogee"]

__all__ = ["BUILT_IN", "LAMP_PREFIX", "mean_colour", "resolve"]

LAMP_PREFIX = "lamp:"
"""Glowing bodies have the material ``lamp:INDEX`` of ``apartment.lamps[INDEX]``."""
SECOND_SHARE = {
    "plaster": 0.5,
    "wallpaper": 0.3,
    "parquet": 0.25,
    "planks": 0.25,
    "tiles": 0.04,
    "carpet": 0.5,
    "wood": 0.5,
    "fabric": 0.5,
}
"""About which share of a pattern is in its second colour, as `render.patterns` draws it."""


def _plain(colour: Colour, roughness: float = 0.6) -> Material:
    return Material(pattern="plain", colour=colour, roughness=roughness)


def _plaster(colour: Colour) -> Material:
    return Material(pattern="plaster", colour=colour, size=0.02, roughness=0.9)


def _parquet(colour: Colour, second: Colour) -> Material:
    return Material(pattern="parquet", colour=colour, second_colour=second, size=0.4, roughness=0.4)


def _planks(colour: Colour, second: Colour) -> Material:
    return Material(pattern="planks", colour=colour, second_colour=second, size=0.15, roughness=0.4)


def _tiles(colour: Colour, second: Colour, size: float) -> Material:
    return Material(pattern="tiles", colour=colour, second_colour=second, size=size, roughness=0.25)


def _carpet(colour: Colour) -> Material:
    return Material(pattern="carpet", colour=colour, size=0.01, roughness=1.0)


def _wood(colour: Colour, second: Colour) -> Material:
    return Material(pattern="wood", colour=colour, second_colour=second, size=0.1, roughness=0.45)


def _fabric(colour: Colour) -> Material:
    return Material(pattern="fabric", colour=colour, size=0.008, roughness=1.0)


def _speckled(colour: Colour, second: Colour, size: float) -> Material:
    """Mottling in two colours: terrazzo, granite, cork, marble."""
    return Material(
        pattern="plaster", colour=colour, second_colour=second, size=size, roughness=0.3
    )


def _wallpaper(motif: Motif, size: float, colour: Colour, second: Colour) -> Material:
    return Material(
        pattern="wallpaper",
        motif=motif,
        size=size,
        colour=colour,
        second_colour=second,
        roughness=0.85,
    )


def _metal(colour: Colour, roughness: float) -> Material:
    return Material(pattern="metal", colour=colour, size=0.05, roughness=roughness)


BUILT_IN: Mapping[str, Material] = MappingProxyType(
    {
        # floors
        "parquet": _parquet((0.42, 0.26, 0.13), (0.30, 0.17, 0.08)),
        "parquet_dark": _parquet((0.17, 0.09, 0.05), (0.10, 0.05, 0.03)),
        "planks": _planks((0.46, 0.31, 0.18), (0.36, 0.22, 0.12)),
        "planks_grey": _planks((0.34, 0.32, 0.29), (0.25, 0.23, 0.21)),
        "laminate": _planks((0.55, 0.42, 0.28), (0.45, 0.33, 0.20)),
        "tiles_white": _tiles((0.80, 0.80, 0.79), (0.50, 0.50, 0.49), 0.20),
        "tiles_grey": _tiles((0.38, 0.38, 0.38), (0.22, 0.22, 0.22), 0.30),
        "tiles_terracotta": _tiles((0.42, 0.17, 0.09), (0.30, 0.25, 0.20), 0.30),
        "tiles_blue": _tiles((0.20, 0.33, 0.48), (0.60, 0.60, 0.60), 0.15),
        "carpet_beige": _carpet((0.52, 0.44, 0.33)),
        "carpet_blue": _carpet((0.09, 0.13, 0.24)),
        "carpet_grey": _carpet((0.24, 0.24, 0.25)),
        "carpet_red": _carpet((0.30, 0.06, 0.05)),
        "linoleum": _plain((0.36, 0.38, 0.34), 0.35),
        "concrete": _plaster((0.42, 0.41, 0.40)),
        "parquet_light": _parquet((0.58, 0.44, 0.28), (0.48, 0.34, 0.20)),
        "oak_planks": _planks((0.44, 0.32, 0.19), (0.34, 0.23, 0.13)),
        "pine_planks": _planks((0.60, 0.42, 0.22), (0.50, 0.32, 0.15)),
        "walnut_planks": _planks((0.16, 0.09, 0.05), (0.10, 0.055, 0.03)),
        "white_planks": _planks((0.66, 0.63, 0.58), (0.56, 0.53, 0.48)),
        "tiles_beige": _tiles((0.56, 0.48, 0.37), (0.40, 0.35, 0.28), 0.33),
        "tiles_black": _tiles((0.04, 0.04, 0.045), (0.15, 0.15, 0.15), 0.30),
        "tiles_slate": _tiles((0.12, 0.13, 0.14), (0.22, 0.22, 0.22), 0.60),
        "tiles_green": _tiles((0.16, 0.30, 0.22), (0.55, 0.55, 0.52), 0.10),
        "mosaic_white": _tiles((0.76, 0.78, 0.78), (0.42, 0.42, 0.42), 0.05),
        "mosaic_blue": _tiles((0.12, 0.26, 0.38), (0.55, 0.56, 0.56), 0.05),
        "terrazzo": _speckled((0.72, 0.70, 0.66), (0.30, 0.27, 0.24), 0.015),
        "cork": _speckled((0.46, 0.30, 0.16), (0.30, 0.18, 0.09), 0.01),
        "carpet_green": _carpet((0.10, 0.17, 0.09)),
        "carpet_dark": _carpet((0.07, 0.07, 0.075)),
        # walls and ceilings
        "white_plaster": _plaster((0.80, 0.80, 0.78)),
        "cream_plaster": _plaster((0.76, 0.70, 0.56)),
        "yellow_plaster": _plaster((0.72, 0.58, 0.28)),
        "green_plaster": _plaster((0.42, 0.55, 0.38)),
        "blue_plaster": _plaster((0.36, 0.48, 0.62)),
        "red_plaster": _plaster((0.50, 0.20, 0.16)),
        "grey_plaster": _plaster((0.46, 0.46, 0.46)),
        "pink_plaster": _plaster((0.72, 0.52, 0.47)),
        "ochre_plaster": _plaster((0.56, 0.36, 0.14)),
        "dark_plaster": _plaster((0.10, 0.13, 0.17)),
        "striped_wallpaper": _wallpaper("stripes", 0.16, (0.70, 0.68, 0.60), (0.42, 0.48, 0.38)),
        "grey_striped_wallpaper": _wallpaper("stripes", 0.10, (0.62, 0.62, 0.62), (0.4, 0.4, 0.42)),
        "dotted_wallpaper": _wallpaper("dots", 0.20, (0.52, 0.62, 0.72), (0.80, 0.80, 0.78)),
        "floral_wallpaper": _wallpaper("sprigs", 0.25, (0.75, 0.71, 0.63), (0.45, 0.17, 0.17)),
        "green_floral_wallpaper": _wallpaper("sprigs", 0.18, (0.62, 0.66, 0.52), (0.2, 0.32, 0.16)),
        "golden_wallpaper": _wallpaper("ogee", 0.40, (0.55, 0.44, 0.24), (0.72, 0.62, 0.40)),
        "blue_wallpaper": _wallpaper("ogee", 0.32, (0.16, 0.24, 0.36), (0.40, 0.47, 0.55)),
        "facade": _plaster((0.60, 0.58, 0.54)),
        "brick": Material(
            pattern="tiles",
            colour=(0.38, 0.14, 0.09),
            second_colour=(0.50, 0.48, 0.44),
            size=0.12,
            roughness=0.9,
        ),
        "wood_panels": _planks((0.38, 0.24, 0.13), (0.28, 0.16, 0.08)),
        "white_paint": _plain((0.82, 0.82, 0.81), 0.8),
        "grey_paint": _plain((0.45, 0.45, 0.45), 0.8),
        "cream_paint": _plain((0.78, 0.73, 0.62), 0.8),
        "blue_paint": _plain((0.55, 0.64, 0.72), 0.8),
        "ceiling_boards": _planks((0.58, 0.42, 0.25), (0.48, 0.33, 0.18)),
        "white_boards": _planks((0.78, 0.78, 0.76), (0.68, 0.68, 0.66)),
        # joinery
        "frame_paint": _plain((0.78, 0.78, 0.76), 0.4),
        "frame_grey": _plain((0.38, 0.38, 0.38), 0.4),
        "frame_dark": _plain((0.08, 0.07, 0.06), 0.4),
        "frame_wood": _wood((0.30, 0.16, 0.07), (0.20, 0.10, 0.04)),
        "frame_oak": _wood((0.46, 0.32, 0.18), (0.36, 0.23, 0.12)),
        "frame_walnut": _wood((0.13, 0.07, 0.04), (0.08, 0.04, 0.02)),
        "frame_green": _plain((0.14, 0.22, 0.15), 0.4),
        "frame_blue": _plain((0.12, 0.19, 0.30), 0.4),
        "frame_red": _plain((0.32, 0.06, 0.05), 0.4),
        "frame_black": _plain((0.03, 0.03, 0.03), 0.4),
        "frame_metal": _metal((0.56, 0.56, 0.57), 0.35),
        "door_paint": _plain((0.74, 0.74, 0.72), 0.4),
        "door_wood": _wood((0.36, 0.20, 0.09), (0.26, 0.13, 0.06)),
        "window_paint": _plain((0.84, 0.84, 0.84), 0.3),
        "skirting": _plain((0.80, 0.80, 0.78), 0.4),
        # furniture
        "wood_light": _wood((0.56, 0.40, 0.23), (0.46, 0.31, 0.17)),
        "wood": _wood((0.36, 0.21, 0.10), (0.27, 0.15, 0.07)),
        "wood_dark": _wood((0.12, 0.06, 0.03), (0.07, 0.03, 0.02)),
        "wood_oak": _wood((0.44, 0.31, 0.18), (0.34, 0.22, 0.12)),
        "wood_cherry": _wood((0.30, 0.12, 0.06), (0.22, 0.08, 0.04)),
        "painted_white": _plain((0.76, 0.75, 0.72), 0.45),
        "painted_sage": _plain((0.34, 0.42, 0.32), 0.45),
        "painted_blue": _plain((0.12, 0.20, 0.32), 0.45),
        "painted_yellow": _plain((0.66, 0.48, 0.14), 0.45),
        "painted_black": _plain((0.035, 0.035, 0.035), 0.45),
        "lacquer_white": _plain((0.82, 0.82, 0.82), 0.25),
        "lacquer_black": _plain((0.03, 0.03, 0.03), 0.25),
        "lacquer_red": _plain((0.45, 0.05, 0.04), 0.25),
        "stone": _plain((0.26, 0.25, 0.24), 0.3),
        "granite": _speckled((0.30, 0.29, 0.28), (0.06, 0.06, 0.06), 0.006),
        "marble": _speckled((0.80, 0.80, 0.79), (0.52, 0.53, 0.54), 0.25),
        "slate": _speckled((0.11, 0.12, 0.13), (0.07, 0.075, 0.08), 0.1),
        "worktop_oak": _parquet((0.46, 0.31, 0.17), (0.36, 0.23, 0.12)),
        "worktop_white": _plain((0.74, 0.74, 0.73), 0.3),
        "metal": _metal((0.62, 0.62, 0.63), 0.3),
        "metal_dark": _metal((0.12, 0.12, 0.13), 0.4),
        "ceramic": _plain((0.86, 0.86, 0.86), 0.1),
        "glass_dark": _plain((0.02, 0.02, 0.02), 0.05),
        "plastic_white": _plain((0.78, 0.78, 0.78), 0.4),
        "plastic_black": _plain((0.03, 0.03, 0.03), 0.4),
        "fabric_white": _fabric((0.78, 0.77, 0.74)),
        "fabric_beige": _fabric((0.55, 0.47, 0.36)),
        "fabric_grey": _fabric((0.28, 0.28, 0.29)),
        "fabric_dark": _fabric((0.06, 0.06, 0.07)),
        "fabric_blue": _fabric((0.08, 0.14, 0.30)),
        "fabric_red": _fabric((0.38, 0.06, 0.05)),
        "fabric_green": _fabric((0.12, 0.24, 0.10)),
        "fabric_yellow": _fabric((0.60, 0.42, 0.08)),
        "fabric_brown": _fabric((0.18, 0.11, 0.06)),
        "fabric_teal": _fabric((0.05, 0.22, 0.22)),
        "fabric_pink": _fabric((0.55, 0.28, 0.28)),
        "linen": _fabric((0.60, 0.56, 0.48)),
        "denim": _fabric((0.10, 0.15, 0.24)),
        "leather": _plain((0.10, 0.05, 0.03), 0.4),
        "leaves": _fabric((0.06, 0.19, 0.04)),
        "soil": _carpet((0.06, 0.04, 0.03)),
        "paper": _plain((0.62, 0.52, 0.40), 0.8),
        "cardboard": _plain((0.38, 0.27, 0.16), 0.9),
        "wicker": _fabric((0.36, 0.25, 0.13)),
        "coir": _carpet((0.22, 0.14, 0.07)),
        "rubber": _plain((0.03, 0.03, 0.03), 0.8),
        "enamel_white": _plain((0.85, 0.85, 0.85), 0.2),
        "stone_light": _plain((0.55, 0.53, 0.49), 0.5),
        "chrome": _metal((0.70, 0.71, 0.72), 0.08),
        "brass": _metal((0.62, 0.45, 0.18), 0.25),
        "iron": _metal((0.05, 0.05, 0.05), 0.55),
        "copper": _metal((0.64, 0.35, 0.22), 0.3),
        "mirror": _metal((0.86, 0.87, 0.86), 0.02),
        "glass": Material(pattern="glass", colour=(0.94, 0.96, 0.95), roughness=0.0),
        "glass_green": Material(pattern="glass", colour=(0.72, 0.86, 0.78), roughness=0.0),
        "glass_frosted": Material(pattern="glass", colour=(0.90, 0.92, 0.92), roughness=0.4),
        "plastic_red": _plain((0.50, 0.05, 0.04), 0.4),
        "plastic_yellow": _plain((0.65, 0.45, 0.05), 0.4),
        "plastic_blue": _plain((0.05, 0.15, 0.45), 0.4),
    }
)


def resolve(apartment: Apartment, name: str) -> Material:
    """The material called ``name``: the apartment's own, else the built-in one.

    ``lamp:INDEX`` is a white plain body; its glow is that of the lamp.

    Raises
    ------
    SceneError
        If neither has it.
    """
    if name in apartment.materials:
        return apartment.materials[name]
    if name in BUILT_IN:
        return BUILT_IN[name]
    index = name.removeprefix(LAMP_PREFIX)
    if index != name and index.isdecimal() and int(index) < len(apartment.lamps):
        return Material(colour=(1.0, 1.0, 1.0))
    raise SceneError(f"{apartment.name}: material {name!r} is neither its own nor built in")


def mean_colour(material: Material) -> Colour:
    """Mean colour of a pattern, linear."""
    second = material.second_colour
    if second is None:
        return material.colour
    share = SECOND_SHARE.get(material.pattern, 0.0)
    red, green, blue = (
        (1.0 - share) * a + share * b for a, b in zip(material.colour, second, strict=True)
    )
    return (red, green, blue)
