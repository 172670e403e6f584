"""Names on a plan, legible on whatever lies below."""

from __future__ import annotations

from typing import Any

from bokeh.models import ColumnDataSource

__all__ = ["draw_names"]


def draw_names(plot: Any, source: ColumnDataSource, column: str, **style: Any) -> Any:
    """Write a column of ``source`` at its ``x`` and ``y``; returns the renderer."""
    usual = {"text_font_size": "13px", "text_font_style": "bold", "background_fill_alpha": 0.8}
    return plot.text(
        "x",
        "y",
        text=column,
        source=source,
        text_align="center",
        text_baseline="middle",
        background_fill_color="white",
        padding=3,
        border_radius=4,
        **(usual | style),
    )
