"""Making Blender shader nodes with few words."""

from __future__ import annotations

from typing import Any

from scenes.apartment import Colour

__all__ = ["Socket", "Tree", "add_math", "add_node", "blend", "rgba"]

Socket = Any
Tree = Any


def add_node(tree: Tree, kind: str, **inputs: Any) -> Any:
    """A new node with its inputs set to values or linked from other sockets."""
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        _set(tree, node.inputs[name.replace("_", " ")], value)
    return node


def add_math(tree: Tree, operation: str, *values: Any) -> Socket:
    """A sum, product, comparison, ... of sockets and numbers."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, values, strict=False):
        _set(tree, socket, value)
    return node.outputs[0]


def blend(tree: Tree, factor: Socket, low: Any, high: Any) -> Socket:
    """Linear blend of two colours (values or sockets)."""
    node = tree.nodes.new("ShaderNodeMix")
    node.data_type = "RGBA"
    tree.links.new(factor, node.inputs["Factor"])
    for socket, value in ((node.inputs[6], low), (node.inputs[7], high)):
        _set(tree, socket, value if hasattr(value, "node") else rgba(value))
    return node.outputs[2]


def rgba(colour: Colour) -> tuple[float, float, float, float]:
    """An opaque colour."""
    return (*colour, 1.0)


def _set(tree: Tree, socket: Socket, value: Any) -> None:
    if hasattr(value, "node"):
        tree.links.new(value, socket)
    else:
        socket.default_value = value
