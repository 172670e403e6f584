"""Procedural Blender materials at true scale, from `scenes.apartment.Material`.

What is rough is a plain diffuse surface, which needs fewer samples than a glossy one.

Panes of glass are thin: what is seen through them is not displaced. They are
therefore transparent with a mirror image on top (Fresnel), not refracting: light
from a lamp or window then passes straight on, and needs no caustics, which would
never be found by the few paths of a frame. Only the faces that look at the light's
origin count; the far side of the pane lets all through, so that a closed pane
reflects and tints once.
"""

from __future__ import annotations

from typing import Any

from render.nodes import Socket, Tree, add_node
from render.patterns import pattern_colour
from scenes.apartment import Material

__all__ = ["ATLAS", "MATTE_ROUGHNESS", "build_glow", "build_material"]

MATTE_ROUGHNESS = 0.65
"""Surfaces at least this rough are purely diffuse."""
GLASS_INDEX = 1.5
GLOSS_INDEX = 1.5
"""Of Principled surfaces."""
ATLAS = "atlas"
"""The UV layer of baked light."""
CLEAR_ROUGHNESS = 0.05
"""Glass that is rougher scatters what passes through it."""
WHITE = (1.0, 1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0, 1.0)


def build_material(
    bpy: Any, name: str, material: Material, light: Any = None, pixel: float = 0.0
) -> Any:
    """Blender material ``name`` with the pattern, scale and gloss of ``material``.

    Parameters
    ----------
    bpy : module
    name : str
    material : Material
    light : bpy.types.Image, optional
        Baked light (`render.baking`), in the UV layer `ATLAS`: what is matte then shines
        by itself, and only gloss is left to trace.
    pixel : float
        What a pixel of the camera sees, rad: finer joints are smoothed; 0: as they are.

    Returns
    -------
    bpy.types.Material
    """
    made, tree = _empty(bpy, name)
    colour = pattern_colour(tree, material, pixel)
    if light is None:
        surface = _surface(tree, material, colour)
    else:
        made.cycles.emission_sampling = "NONE"
        surface = _lit_surface(tree, material, colour, _reflected(tree, colour, light))
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(surface, output.inputs["Surface"])
    return made


def build_glow(bpy: Any, name: str, temperature: float, radiance: float) -> Any:
    """Material of a lamp's body: ``radiance`` W/m²/sr, coloured as a black body (K)."""
    made, tree = _empty(bpy, name)
    colour = add_node(tree, "ShaderNodeBlackbody", Temperature=temperature).outputs["Color"]
    shader = add_node(tree, "ShaderNodeEmission", Color=colour, Strength=radiance)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def _empty(bpy: Any, name: str) -> tuple[Any, Tree]:
    """A new Blender material and its empty node tree."""
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    made.node_tree.nodes.clear()
    return made, made.node_tree


def _surface(tree: Tree, material: Material, colour: Socket) -> Socket:
    """Diffuse shader for what is rough, Principled for what shines, a pane for glass."""
    if material.pattern == "glass":
        return _pane(tree, material.roughness, colour)
    metal = material.pattern == "metal"
    if material.roughness >= MATTE_ROUGHNESS and not metal:
        return add_node(tree, "ShaderNodeBsdfDiffuse", Color=colour).outputs["BSDF"]
    shader = add_node(
        tree,
        "ShaderNodeBsdfPrincipled",
        Base_Color=colour,
        Roughness=material.roughness,
        Metallic=1.0 if metal else 0.0,
    )
    return shader.outputs["BSDF"]


def _reflected(tree: Tree, colour: Socket, light: Any) -> Socket:
    """Colour times the light baked at each point."""
    where = add_node(tree, "ShaderNodeUVMap")
    where.uv_map = ATLAS
    texel = add_node(tree, "ShaderNodeTexImage", Vector=where.outputs["UV"])
    texel.image = light
    texel.extension = "EXTEND"
    product = tree.nodes.new("ShaderNodeVectorMath")
    product.operation = "MULTIPLY"
    tree.links.new(colour, product.inputs[0])
    tree.links.new(texel.outputs["Color"], product.inputs[1])
    return product.outputs[0]


def _lit_surface(tree: Tree, material: Material, colour: Socket, glow: Socket) -> Socket:
    """As `_surface`, but matte light ``glow`` is not traced.

    Principled lets a coat, not the specular layer, dim what shines below: the gloss of
    a surface is therefore its coat, which is the same lobe.
    """
    if material.pattern == "glass":
        return _pane(tree, material.roughness, colour, glow)
    if material.pattern == "metal":
        return _surface(tree, material, colour)
    if material.roughness >= MATTE_ROUGHNESS:
        return add_node(tree, "ShaderNodeEmission", Color=glow).outputs[0]
    shader = add_node(
        tree,
        "ShaderNodeBsdfPrincipled",
        Base_Color=BLACK,
        Specular_IOR_Level=0.0,
        Coat_Weight=1.0,
        Coat_Roughness=material.roughness,
        Coat_IOR=GLOSS_INDEX,
        Emission_Color=glow,
        Emission_Strength=1.0,
    )
    return shader.outputs["BSDF"]


def _pane(tree: Tree, roughness: float, colour: Socket, glow: Socket | None = None) -> Socket:
    """Transparent with a Fresnel reflection; frosted where it is rough."""
    through = add_node(tree, "ShaderNodeBsdfTransparent", Color=colour).outputs["BSDF"]
    if roughness > CLEAR_ROUGHNESS:
        if glow is None:
            scattered = add_node(tree, "ShaderNodeBsdfTranslucent", Color=colour).outputs["BSDF"]
        else:
            scattered = add_node(tree, "ShaderNodeEmission", Color=glow).outputs[0]
        through = _mix(tree, min(1.0, 2.0 * roughness), through, scattered)
    mirror = add_node(tree, "ShaderNodeBsdfAnisotropic", Color=WHITE, Roughness=roughness)
    fresnel = add_node(tree, "ShaderNodeFresnel", IOR=GLASS_INDEX).outputs[0]
    front = _mix(tree, fresnel, through, mirror.outputs["BSDF"])
    behind = add_node(tree, "ShaderNodeBsdfTransparent", Color=WHITE).outputs["BSDF"]
    far_side = tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
    return _mix(tree, far_side, front, behind)


def _mix(tree: Tree, factor: Any, first: Socket, second: Socket) -> Socket:
    """A share ``factor`` of the second shader, the rest of the first."""
    node = add_node(tree, "ShaderNodeMixShader", Fac=factor)
    tree.links.new(first, node.inputs[1])
    tree.links.new(second, node.inputs[2])
    return node.outputs[0]
