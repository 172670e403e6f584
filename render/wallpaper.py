"""The motifs of wallpapers: which share of the second colour lies where.

All are drawn in a square that repeats: one unit of the coordinates is one repeat.
Dots, sprigs and leaves come twice in it, the second time half a repeat further
along both ways, as papers are printed (a half drop).
"""

from __future__ import annotations

from collections.abc import Callable

from render.nodes import Socket, Tree, add_math, add_node

__all__ = ["motif_share"]

DOT = 0.16
"""Radius of a dot, in repeats."""
PETAL = (0.15, 0.09)
"""Mean radius of a sprig's outline, and how far its petals go in and out, in repeats."""
TRELLIS = (0.25, 0.21, 0.035)
"""Mean place, swing and half width of the lines of an ogee, in repeats."""
LEAF = (0.11, 0.2)
"""Half axes of the leaf within an ogee, in repeats."""


def motif_share(tree: Tree, uv: Socket, motif: str) -> Socket:
    """Share (0 or 1) of the second colour at coordinates in repeats."""
    split = add_node(tree, "ShaderNodeSeparateXYZ", Vector=uv)
    return _MOTIFS[motif](tree, split.outputs["X"], split.outputs["Y"])


def _offset(tree: Tree, value: Socket, shift: float) -> Socket:
    """Signed distance to the middle of the repeat, -0.5..0.5, of a value that is shifted first."""
    return add_math(
        tree, "SUBTRACT", add_math(tree, "FRACT", add_math(tree, "ADD", value, shift)), 0.5
    )


def _length(tree: Tree, x: Socket, y: Socket) -> Socket:
    squares = [add_math(tree, "MULTIPLY", value, value) for value in (x, y)]
    return add_math(tree, "SQRT", add_math(tree, "ADD", *squares))


def _half_drop(
    tree: Tree, u: Socket, v: Socket, draw: Callable[[Tree, Socket, Socket], Socket]
) -> Socket:
    """What is drawn about the middle of a repeat, and again half a repeat further."""
    both = [draw(tree, _offset(tree, u, shift), _offset(tree, v, shift)) for shift in (0.0, 0.5)]
    return add_math(tree, "MAXIMUM", *both)


def _stripes(tree: Tree, u: Socket, v: Socket) -> Socket:
    """A broad stripe and, in the middle of the gap, a narrow one."""
    del v  # they run upwards
    x = add_math(tree, "ABSOLUTE", _offset(tree, u, 0.0))
    narrow = add_math(tree, "LESS_THAN", x, 0.03)
    return add_math(tree, "MAXIMUM", narrow, add_math(tree, "GREATER_THAN", x, 0.28))


def _dots(tree: Tree, u: Socket, v: Socket) -> Socket:
    return _half_drop(tree, u, v, lambda t, x, y: add_math(t, "LESS_THAN", _length(t, x, y), DOT))


def _sprigs(tree: Tree, u: Socket, v: Socket) -> Socket:
    """Flowers of five petals."""
    return _half_drop(tree, u, v, _flower)


def _flower(tree: Tree, x: Socket, y: Socket) -> Socket:
    turns = add_math(tree, "MULTIPLY", add_math(tree, "ARCTAN2", x, y), 5.0)
    wave = add_math(tree, "MULTIPLY", add_math(tree, "COSINE", turns), PETAL[1])
    edge = add_math(tree, "ADD", wave, PETAL[0])
    radius = _length(tree, x, y)
    petals = add_math(tree, "LESS_THAN", radius, edge)
    return add_math(tree, "MULTIPLY", petals, add_math(tree, "GREATER_THAN", radius, 0.04))


def _ogee(tree: Tree, u: Socket, v: Socket) -> Socket:
    """A net of S-shaped lines with a leaf in every mesh."""
    x = add_math(tree, "ABSOLUTE", _offset(tree, u, 0.0))
    wave = add_math(tree, "COSINE", add_math(tree, "MULTIPLY", v, 6.283185307179586))
    line = add_math(tree, "ADD", add_math(tree, "MULTIPLY", wave, TRELLIS[1]), TRELLIS[0])
    away = add_math(tree, "ABSOLUTE", add_math(tree, "SUBTRACT", x, line))
    net = add_math(tree, "LESS_THAN", away, TRELLIS[2])
    # The meshes lie about (0.5, 0) and (0, 0.5).
    leaves = _half_drop(tree, u, add_math(tree, "ADD", v, 0.5), _leaf)
    return add_math(tree, "MAXIMUM", net, leaves)


def _leaf(tree: Tree, x: Socket, y: Socket) -> Socket:
    scaled = [add_math(tree, "DIVIDE", x, LEAF[0]), add_math(tree, "DIVIDE", y, LEAF[1])]
    return add_math(tree, "LESS_THAN", _length(tree, *scaled), 1.0)


_MOTIFS: dict[str, Callable[[Tree, Socket, Socket], Socket]] = {
    "stripes": _stripes,
    "dots": _dots,
    "sprigs": _sprigs,
    "ogee": _ogee,
}
