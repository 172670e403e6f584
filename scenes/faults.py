"""What libraries say is wrong with a value or a shape, in words for people who write files."""

from __future__ import annotations

import re
from typing import Any

import shapely
from pydantic_core import ErrorDetails

__all__ = ["shape_fault", "value_fault"]

_SHAPES = {
    "Self-intersection": "crosses itself",
    "Ring Self-intersection": "touches itself",
    "Hole lies outside shell": "has a hole outside of it",
    "Holes are nested": "has a hole in a hole",
    "Interior is disconnected": "is cut in two by its holes",
}
_TYPES = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dict_type": "an object with fields",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "model_attributes_type": "an object with fields",
    "model_type": "an object with fields",
    "string_type": "a text",
    "tuple_type": "a list",
}
_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}
_NAME = r"^[A-Za-z0-9]"


def shape_fault(shape: shapely.Geometry) -> str:
    """What is wrong with a polygon that is not valid, and where: ``crosses itself at (2, 1.5)``."""
    reason = shapely.is_valid_reason(shape)
    found = re.fullmatch(r"(.*)\[(\S+) (\S+)\]", reason)
    if found is None:
        return f"is no area: {reason}"
    what = _SHAPES.get(found[1], f"is no area: {found[1].lower()}")
    return f"{what} at ({float(found[2]):.3g}, {float(found[3]):.3g})"


def value_fault(fault: ErrorDetails) -> str:
    """What would be right instead of a value that a model refuses: ``expected a number``."""
    kind, context = fault["type"], fault.get("ctx", {})
    if kind in _TYPES:
        return f"expected {_TYPES[kind]}"
    if kind in _BOUNDS:
        word, key = _BOUNDS[kind]
        return f"expected {word} {context[key]:g}"
    if kind in ("too_short", "too_long"):
        return f"expected {_count(kind, context)}"
    if kind == "literal_error":
        return f"expected {context['expected']}"
    if kind == "string_pattern_mismatch" and str(context["pattern"]).startswith(_NAME):
        return "expected letters, digits, '_', '.', '-', at most 64, a letter or digit first"
    return " ".join(fault["msg"].split())


def _count(kind: str, context: dict[str, Any]) -> str:
    """How many items a list should have, and how many it has."""
    short = kind == "too_short"
    limit = context["min_length" if short else "max_length"]
    return f"{'at least' if short else 'at most'} {limit}, not {context['actual_length']}"
