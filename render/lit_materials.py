"""Materials of any make whose matte part shines with baked light.

In a material's node tree, and in the groups within, every shader that scatters light
like paper is replaced by one that shines: the colour that it had, whatever nodes make
it, times the baked light. All other shaders, and what mixes them, stay as they are and
are traced: glass, mirrors, glow, what is translucent or has a glow below its surface.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from render.nodes import Socket, Tree, add_math, add_node
from render.scene_evaluation import glows
from render.shading import MATTE_ROUGHNESS

__all__ = ["BACK", "FRONT", "is_matte", "lit_copy", "plain_material"]

FRONT, BACK = "baked front", "baked back"
"""Attributes of a mesh's corners: where in the picture of baked light each side is."""
ABSENT = ("Transmission Weight", "Subsurface Weight", "Coat Weight", "Sheen Weight")
"""What a Principled surface must not have to be understood."""
ROUGH_GLOSS = 0.05
"""Share of light that rough gloss scatters; the rest reaches what is below."""
PLAIN = 0.8
"""Reflectance of what has no material."""


def is_matte(material: Any) -> bool:
    """Whether part of a material is matte, and baked light can stand for it.

    What glows is left alone: it is a lamp, and rays are aimed at it.
    """
    return not glows(material) and any(True for _ in _matte_nodes(material))


def plain_material(bpy: Any) -> Any:
    """What Cycles takes for a surface without a material."""
    made = bpy.data.materials.new("plain")
    if made.node_tree is None:
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader = add_node(tree, "ShaderNodeBsdfDiffuse", Color=(PLAIN, PLAIN, PLAIN, 1.0))
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def lit_copy(material: Any, light: Any) -> Any:
    """A copy of a material whose matte part shines with the image ``light``."""
    made = material.copy()
    made.cycles.emission_sampling = "NONE"
    _copy_groups(made.node_tree)
    for tree, node in list(_matte_nodes(made)):
        if node.type == "BSDF_DIFFUSE":
            glow = _glow(tree, _value(node, "Color"), light)
            shown = add_node(tree, "ShaderNodeEmission", Color=glow).outputs[0]
        else:
            shown = _lit_principled(tree, node, light)
        for link in list(node.outputs[0].links):
            tree.links.new(shown, link.to_socket)
    return made


def _copy_groups(tree: Tree) -> None:
    """Give the groups in a tree node trees of their own."""
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            _copy_groups(node.node_tree)


def _matte_nodes(material: Any) -> Iterator[tuple[Tree, Any]]:
    """The shaders that are understood, and the trees that they are in."""
    for tree in _trees(material.node_tree):
        for node in tree.nodes:
            matte = node.type == "BSDF_DIFFUSE" or (
                node.type == "BSDF_PRINCIPLED" and _is_understood(node)
            )
            if matte and node.outputs[0].is_linked:
                yield tree, node


def _trees(tree: Any, seen: set[str] | None = None) -> Iterator[Tree]:
    """A node tree, and those of the groups in it."""
    seen = set() if seen is None else seen
    if tree is None:
        return
    yield tree
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree and node.node_tree.name not in seen:
            seen.add(node.node_tree.name)
            yield from _trees(node.node_tree, seen)


def _is_understood(node: Any) -> bool:
    """Whether a Principled surface is a matte one with gloss, or a mixture of that and metal."""
    metallic = node.inputs["Metallic"]
    pure_metal = not metallic.is_linked and metallic.default_value >= 1.0
    return not pure_metal and not any(
        node.inputs[name].is_linked or node.inputs[name].default_value > 0.0 for name in ABSENT
    )


def _lit_principled(tree: Tree, node: Any, light: Any) -> Socket:
    """A Principled surface with baked light instead of its matte part."""
    made = _lit_dielectric(tree, node, light)
    metallic = _value(node, "Metallic")
    if _is_set(metallic, above=0.0):
        metal = _copy(tree, node)
        _set(tree, metal.inputs["Metallic"], 1.0)
        _set(tree, metal.inputs["Alpha"], 1.0)
        made = _mixed(tree, metallic, made, metal.outputs[0])
    alpha = _value(node, "Alpha")
    if hasattr(alpha, "node") or alpha < 1.0:
        clear = tree.nodes.new("ShaderNodeBsdfTransparent")
        made = _mixed(tree, alpha, clear.outputs[0], made)
    return made


def _lit_dielectric(tree: Tree, node: Any, light: Any) -> Socket:
    """Its part that is no metal: a coat of gloss over what shines; one glow where it is rough.

    Principled lets a coat, not the specular layer, dim what shines below.
    """
    colour, rough = _value(node, "Base Color"), _value(node, "Roughness")
    gloss = add_math(tree, "MULTIPLY", _value(node, "Specular IOR Level"), 2.0)
    if not hasattr(rough, "node") and rough >= MATTE_ROUGHNESS:
        share = add_math(tree, "MULTIPLY", gloss, ROUGH_GLOSS)
        dimmed = _scaled(tree, colour, add_math(tree, "SUBTRACT", 1.0, share))
        whole = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(dimmed, whole.inputs[0])
        tree.links.new(share, whole.inputs[1])
        return add_node(
            tree, "ShaderNodeEmission", Color=_glow(tree, whole.outputs[0], light)
        ).outputs[0]
    shader = add_node(
        tree,
        "ShaderNodeBsdfPrincipled",
        Base_Color=(0.0, 0.0, 0.0, 1.0),
        Specular_IOR_Level=0.0,
        Coat_Weight=add_math(tree, "MINIMUM", gloss, 1.0),
        Coat_Roughness=rough,
        Coat_IOR=_value(node, "IOR"),
        Emission_Color=_glow(tree, colour, light),
        Emission_Strength=1.0,
    )
    normal = _value(node, "Normal")
    if hasattr(normal, "node"):
        tree.links.new(normal, shader.inputs["Coat Normal"])
    return shader.outputs[0]


def _glow(tree: Tree, colour: Any, light: Any) -> Socket:
    """A colour times the light baked on the side that is looked at."""
    where = tree.nodes.new("ShaderNodeMix")
    where.data_type = "VECTOR"
    behind = tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
    tree.links.new(behind, where.inputs["Factor"])
    for name, socket in ((FRONT, where.inputs[4]), (BACK, where.inputs[5])):
        corner = tree.nodes.new("ShaderNodeAttribute")
        corner.attribute_name = name
        tree.links.new(corner.outputs["Vector"], socket)
    texel = add_node(tree, "ShaderNodeTexImage", Vector=where.outputs[1])
    texel.image = light
    texel.extension = "EXTEND"
    product = tree.nodes.new("ShaderNodeVectorMath")
    product.operation = "MULTIPLY"
    _set(tree, product.inputs[0], colour)
    tree.links.new(texel.outputs["Color"], product.inputs[1])
    return product.outputs[0]


def _value(node: Any, name: str) -> Any:
    """What goes into an input: a socket or a value."""
    socket = node.inputs[name]
    if socket.is_linked:
        return socket.links[0].from_socket
    return socket.default_value if hasattr(socket, "default_value") else None


def _is_set(value: Any, above: float) -> bool:
    return hasattr(value, "node") or value > above


def _set(tree: Tree, socket: Any, value: Any) -> None:
    """Link a socket from another one, or give it a value of its own."""
    if hasattr(value, "node"):
        tree.links.new(value, socket)
        return
    for link in list(socket.links):
        tree.links.remove(link)
    is_number = isinstance(value, float | int)
    vector = socket.type == "VECTOR" and not is_number
    socket.default_value = tuple(value)[:3] if vector else value


def _scaled(tree: Tree, colour: Any, factor: Socket) -> Socket:
    made = tree.nodes.new("ShaderNodeVectorMath")
    made.operation = "SCALE"
    _set(tree, made.inputs[0], colour)
    tree.links.new(factor, made.inputs["Scale"])
    return made.outputs[0]


def _mixed(tree: Tree, factor: Any, first: Socket, second: Socket) -> Socket:
    """A share ``factor`` of the second shader, the rest of the first."""
    made = tree.nodes.new("ShaderNodeMixShader")
    _set(tree, made.inputs[0], factor)
    tree.links.new(first, made.inputs[1])
    tree.links.new(second, made.inputs[2])
    return made.outputs[0]


def _copy(tree: Tree, node: Any) -> Any:
    """Another Principled surface with the same inputs."""
    made = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for socket in made.inputs:
        if socket.enabled and socket.name in node.inputs:
            value = _value(node, socket.name)
            if value is not None:
                _set(tree, socket, value)
    return made
