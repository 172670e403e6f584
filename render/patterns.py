"""The patterns of surfaces, as Blender nodes that end in a colour.

Every pattern is drawn in the mesh's UV coordinates, which are metres on the
surface (`render.blender.surface_coordinates`), so that a 20 cm tile measures 20 cm
on the floor and on a slanted wall alike. A material's ``seed`` moves its pattern by
some metres: other boards lie at the same place, with other tones.

Chosen here: a pixel of the 464-pixel disc covers 1.7 cm of a ceiling 2.4 m away.
Relief of plaster is far below that and would only be noise, so plaster is a faint
mottling of its colour; the larger relief of tiles is in their grout. Joints are finer than
a pixel, too: some samples meet one and most do not, which leaves dots where a camera sees a
faint line. Where few samples are taken, joints are therefore drawn a pixel wide, and as much paler.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from render.nodes import Socket, Tree, add_math, add_node, blend, rgba
from render.wallpaper import motif_share
from scenes.apartment import Colour, Material

__all__ = ["pattern_colour"]

FARTHEST_SHIFT = 50.0
"""How far a seed moves a pattern at most, m."""


def pattern_colour(tree: Tree, material: Material, pixel: float = 0.0) -> Socket:
    """Colour of ``material`` at every point of a surface, for a camera's pixels of so many rad."""
    uv = tree.nodes.new("ShaderNodeUVMap").outputs["UV"]
    if material.seed:
        shift = np.random.default_rng(material.seed).uniform(0.0, FARTHEST_SHIFT, 2)
        mapping = add_node(tree, "ShaderNodeMapping", Vector=uv, Location=(*shift, 0.0))
        uv = mapping.outputs["Vector"]
    if material.pattern in _JOINTED:
        return _JOINTED[material.pattern](tree, uv, material, pixel)
    return _PATTERNS[material.pattern](tree, uv, material)


def _second(material: Material, shade: float) -> Colour:
    """The second colour, or a shade of the first."""
    if material.second_colour is not None:
        return material.second_colour
    return _darker(material.colour, shade)


def _darker(colour: Colour, shade: float) -> Colour:
    red, green, blue = colour
    return (red * shade, green * shade, blue * shade)


def _between(first: Colour, second: Colour) -> Colour:
    red, green, blue = (0.5 * (a + b) for a, b in zip(first, second, strict=True))
    return (red, green, blue)


def _stretched(tree: Tree, uv: Socket, scale: tuple[float, float]) -> Socket:
    """Surface coordinates (m), scaled along u and v."""
    mapping = add_node(tree, "ShaderNodeMapping", Vector=uv, Scale=(*scale, 1.0))
    return mapping.outputs["Vector"]


def _noise(tree: Tree, uv: Socket, scale: tuple[float, float], detail: float = 1.0) -> Socket:
    """Smooth noise in 0..1 with ``scale`` repeats per metre along u and v."""
    node = add_node(tree, "ShaderNodeTexNoise", Scale=1.0, Detail=detail)
    node.noise_dimensions = "2D"
    tree.links.new(_stretched(tree, uv, scale), node.inputs["Vector"])
    return node.outputs[0]


def _bricks(
    tree: Tree,
    uv: Socket,
    *,
    tones: tuple[Colour, Colour],
    joint: Colour,
    size: tuple[float, float],
    gap: float,
    pixel: float,
) -> Any:
    """Brick pattern: bricks of ``size`` m in two tones, with joints of ``gap`` m between them."""
    mortar: Any = rgba(joint)
    half: Any = gap / 2.0
    if pixel > 0.0:
        distance = tree.nodes.new("ShaderNodeCameraData").outputs["View Distance"]
        width = add_math(tree, "MAXIMUM", add_math(tree, "MULTIPLY", distance, pixel), gap)
        half = add_math(tree, "MULTIPLY", width, 0.5)
        mortar = blend(tree, add_math(tree, "DIVIDE", gap, width), _between(*tones), joint)
    return add_node(
        tree,
        "ShaderNodeTexBrick",
        Vector=uv,
        Color1=rgba(tones[0]),
        Color2=rgba(tones[1]),
        Mortar=mortar,
        Scale=1.0,
        Mortar_Size=half,
        Mortar_Smooth=0.1,
        Bias=0.0,
        Brick_Width=size[0],
        Row_Height=size[1],
    )


def _plain(tree: Tree, uv: Socket, material: Material) -> Socket:
    del uv  # the same everywhere
    node = tree.nodes.new("ShaderNodeRGB")
    node.outputs[0].default_value = rgba(material.colour)
    return node.outputs[0]


def _plaster(tree: Tree, uv: Socket, material: Material) -> Socket:
    repeats = 1.0 / material.size
    noise = _noise(tree, uv, (repeats, repeats), detail=2.0)
    return blend(tree, noise, _second(material, 0.94), material.colour)


def _wallpaper(tree: Tree, uv: Socket, material: Material) -> Socket:
    repeats = 1.0 / material.size
    scaled = _stretched(tree, uv, (repeats, repeats))
    share = motif_share(tree, scaled, material.motif)
    return blend(tree, share, material.colour, _second(material, 0.8))


def _boards(
    tree: Tree, uv: Socket, material: Material, size: tuple[float, float], pixel: float
) -> Socket:
    """Boards of ``size`` (length, width), m, each with its own tone and grain."""
    dark = _second(material, 0.7)
    bricks = _bricks(
        tree,
        uv,
        tones=(material.colour, _between(material.colour, dark)),
        joint=_darker(dark, 0.4),
        size=size,
        gap=min(0.003, 0.05 * size[1]),
        pixel=pixel,
    )
    bricks.offset = 0.37
    bricks.offset_frequency = 2
    grain = _noise(tree, uv, (3.0, 40.0), detail=1.0)
    shade = add_node(tree, "ShaderNodeMapRange", Value=grain, To_Min=0.82, To_Max=1.12).outputs[0]
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "SCALE"
    tree.links.new(bricks.outputs["Color"], node.inputs[0])
    tree.links.new(shade, node.inputs["Scale"])
    return node.outputs[0]


def _parquet(tree: Tree, uv: Socket, material: Material, pixel: float) -> Socket:
    """Staves: ``size`` is their length, since that is what repeats to the eye."""
    return _boards(tree, uv, material, (material.size, material.size / 6.0), pixel)


def _planks(tree: Tree, uv: Socket, material: Material, pixel: float) -> Socket:
    """Boards: ``size`` is their width; they are ten times as long."""
    return _boards(tree, uv, material, (10.0 * material.size, material.size), pixel)


def _tiles(tree: Tree, uv: Socket, material: Material, pixel: float) -> Socket:
    size = material.size
    bricks = _bricks(
        tree,
        uv,
        tones=(material.colour, _darker(material.colour, 0.96)),
        joint=_second(material, 0.6),
        size=(size, size),
        gap=max(0.003, 0.02 * size),
        pixel=pixel,
    )
    bricks.offset = 0.0
    return bricks.outputs["Color"]


def _carpet(tree: Tree, uv: Socket, material: Material) -> Socket:
    repeats = 4.0 / material.size
    noise = _noise(tree, uv, (repeats, repeats), detail=3.0)
    return blend(tree, noise, _second(material, 0.6), material.colour)


def _wood(tree: Tree, uv: Socket, material: Material) -> Socket:
    repeats = 1.0 / material.size
    grain = _noise(tree, uv, (repeats, 12.0 * repeats), detail=2.0)
    return blend(tree, grain, _second(material, 0.65), material.colour)


def _fabric(tree: Tree, uv: Socket, material: Material) -> Socket:
    repeats = 1.0 / material.size
    checker = add_node(
        tree,
        "ShaderNodeTexChecker",
        Vector=_stretched(tree, uv, (repeats, repeats)),
        Scale=1.0,
        Color1=rgba(material.colour),
        Color2=rgba(_second(material, 0.85)),
    )
    return checker.outputs["Color"]


_PATTERNS: dict[str, Callable[[Tree, Socket, Material], Socket]] = {
    "plain": _plain,
    "plaster": _plaster,
    "wallpaper": _wallpaper,
    "carpet": _carpet,
    "wood": _wood,
    "fabric": _fabric,
    "metal": _plain,
    "glass": _plain,
}

_JOINTED: dict[str, Callable[[Tree, Socket, Material, float], Socket]] = {
    "parquet": _parquet,
    "planks": _planks,
    "tiles": _tiles,
}
