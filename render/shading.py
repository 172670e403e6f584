"""Procedural Blender materials at true scale, from `scenes.apartment.Material`.

Every pattern is drawn in the mesh's UV coordinates, which are metres on the
surface (`render.blender.surface_coordinates`), so that a 20 cm tile measures 20 cm
on the floor and on a slanted wall alike.

Chosen here: a pixel of the 464-pixel disc covers 1.7 cm of a ceiling 2.4 m away.
Relief of plaster is far below that and would only be noise, so plaster is a faint
mottling of its colour; the larger relief of tiles is in their grout. What is
rough is a plain diffuse surface, which needs fewer samples than a glossy one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenes.apartment import Colour, Material

__all__ = ["build_glow", "build_material"]

MATTE_ROUGHNESS = 0.65
"""Surfaces at least this rough are purely diffuse."""

_Socket = Any
_Tree = Any


def _node(tree: _Tree, kind: str, **inputs: Any) -> Any:
    """A new node with its inputs set to values or linked from other sockets."""
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        socket = node.inputs[name.replace("_", " ")]
        if hasattr(value, "node"):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def _rgba(colour: Colour) -> tuple[float, float, float, float]:
    return (*colour, 1.0)


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


def _blend(tree: _Tree, factor: _Socket, low: Any, high: Any) -> _Socket:
    """Linear blend of two colours (values or sockets)."""
    node = tree.nodes.new("ShaderNodeMix")
    node.data_type = "RGBA"
    tree.links.new(factor, node.inputs["Factor"])
    for socket, value in ((node.inputs[6], low), (node.inputs[7], high)):
        if hasattr(value, "node"):
            tree.links.new(value, socket)
        else:
            socket.default_value = _rgba(value)
    return node.outputs[2]


def _stretched(tree: _Tree, scale: tuple[float, float]) -> _Socket:
    """Surface coordinates (m), scaled along u and v."""
    uv = tree.nodes.new("ShaderNodeUVMap")
    mapping = _node(tree, "ShaderNodeMapping", Vector=uv.outputs["UV"])
    mapping.inputs["Scale"].default_value = (*scale, 1.0)
    return mapping.outputs["Vector"]


def _noise(tree: _Tree, scale: tuple[float, float], detail: float = 1.0) -> _Socket:
    """Smooth noise in 0..1 with ``scale`` repeats per metre along u and v."""
    node = _node(tree, "ShaderNodeTexNoise", Scale=1.0, Detail=detail)
    node.noise_dimensions = "2D"
    tree.links.new(_stretched(tree, scale), node.inputs["Vector"])
    return node.outputs[0]


def _bricks(
    tree: _Tree,
    *,
    tones: tuple[Colour, Colour],
    joint: Colour,
    size: tuple[float, float],
    gap: float,
) -> Any:
    """Brick pattern: bricks of ``size`` m in two tones, with joints of ``gap`` m between them."""
    uv = tree.nodes.new("ShaderNodeUVMap").outputs["UV"]
    return _node(
        tree,
        "ShaderNodeTexBrick",
        Vector=uv,
        Color1=_rgba(tones[0]),
        Color2=_rgba(tones[1]),
        Mortar=_rgba(joint),
        Scale=1.0,
        Mortar_Size=gap / 2.0,
        Mortar_Smooth=0.1,
        Bias=0.0,
        Brick_Width=size[0],
        Row_Height=size[1],
    )


def _plain(tree: _Tree, material: Material) -> _Socket:
    node = tree.nodes.new("ShaderNodeRGB")
    node.outputs[0].default_value = _rgba(material.colour)
    return node.outputs[0]


def _plaster(tree: _Tree, material: Material) -> _Socket:
    repeats = 1.0 / material.size
    noise = _noise(tree, (repeats, repeats), detail=2.0)
    return _blend(tree, noise, _second(material, 0.94), material.colour)


def _boards(tree: _Tree, material: Material, length: float, width: float) -> _Socket:
    """Boards of ``length`` x ``width`` m, each with its own tone and grain."""
    dark = _second(material, 0.7)
    bricks = _bricks(
        tree,
        tones=(material.colour, _between(material.colour, dark)),
        joint=_darker(dark, 0.4),
        size=(length, width),
        gap=min(0.003, 0.05 * width),
    )
    bricks.offset = 0.37
    bricks.offset_frequency = 2
    grain = _noise(tree, (3.0, 40.0), detail=1.0)
    shade = _node(tree, "ShaderNodeMapRange", Value=grain, To_Min=0.82, To_Max=1.12).outputs[0]
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "SCALE"
    tree.links.new(bricks.outputs["Color"], node.inputs[0])
    tree.links.new(shade, node.inputs["Scale"])
    return node.outputs[0]


def _parquet(tree: _Tree, material: Material) -> _Socket:
    """Staves: ``size`` is their length, since that is what repeats to the eye."""
    return _boards(tree, material, material.size, material.size / 6.0)


def _planks(tree: _Tree, material: Material) -> _Socket:
    """Boards: ``size`` is their width; they are ten times as long."""
    return _boards(tree, material, 10.0 * material.size, material.size)


def _tiles(tree: _Tree, material: Material) -> _Socket:
    shade = _darker(material.colour, 0.96)
    grout = _second(material, 0.6)
    size = material.size
    bricks = _bricks(
        tree,
        tones=(material.colour, shade),
        joint=grout,
        size=(size, size),
        gap=max(0.003, 0.02 * size),
    )
    bricks.offset = 0.0
    return bricks.outputs["Color"]


def _carpet(tree: _Tree, material: Material) -> _Socket:
    repeats = 4.0 / material.size
    noise = _noise(tree, (repeats, repeats), detail=3.0)
    return _blend(tree, noise, _second(material, 0.6), material.colour)


def _wood(tree: _Tree, material: Material) -> _Socket:
    repeats = 1.0 / material.size
    grain = _noise(tree, (repeats, 12.0 * repeats), detail=2.0)
    return _blend(tree, grain, _second(material, 0.65), material.colour)


def _fabric(tree: _Tree, material: Material) -> _Socket:
    repeats = 1.0 / material.size
    checker = _node(
        tree,
        "ShaderNodeTexChecker",
        Vector=_stretched(tree, (repeats, repeats)),
        Scale=1.0,
        Color1=_rgba(material.colour),
        Color2=_rgba(_second(material, 0.85)),
    )
    return checker.outputs["Color"]


_PATTERNS: dict[str, Callable[[_Tree, Material], _Socket]] = {
    "plain": _plain,
    "plaster": _plaster,
    "wallpaper": _fabric,
    "parquet": _parquet,
    "planks": _planks,
    "tiles": _tiles,
    "carpet": _carpet,
    "wood": _wood,
    "fabric": _fabric,
    "metal": _plain,
    "glass": _plain,
}


def build_material(bpy: Any, name: str, material: Material) -> Any:
    """Blender material ``name`` with the pattern, scale and gloss of ``material``.

    Parameters
    ----------
    bpy : module
    name : str
    material : Material

    Returns
    -------
    bpy.types.Material
    """
    made, tree = _empty(bpy, name)
    colour = _PATTERNS[material.pattern](tree, material)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(_surface(tree, material, colour), output.inputs["Surface"])
    return made


def build_glow(bpy: Any, name: str, temperature: float, radiance: float) -> Any:
    """Material of a lamp's body: ``radiance`` W/m²/sr, coloured as a black body (K)."""
    made, tree = _empty(bpy, name)
    colour = _node(tree, "ShaderNodeBlackbody", Temperature=temperature).outputs["Color"]
    shader = _node(tree, "ShaderNodeEmission", Color=colour, Strength=radiance)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def _empty(bpy: Any, name: str) -> tuple[Any, _Tree]:
    """A new Blender material and its empty node tree."""
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    made.node_tree.nodes.clear()
    return made, made.node_tree


def _surface(tree: _Tree, material: Material, colour: _Socket) -> _Socket:
    """Diffuse shader for what is rough, Principled for what shines."""
    metal = material.pattern == "metal"
    if material.roughness >= MATTE_ROUGHNESS and not metal:
        return _node(tree, "ShaderNodeBsdfDiffuse", Color=colour).outputs["BSDF"]
    shader = _node(
        tree,
        "ShaderNodeBsdfPrincipled",
        Base_Color=colour,
        Roughness=material.roughness,
        Metallic=1.0 if metal else 0.0,
    )
    return shader.outputs["BSDF"]
