"""What all pages have in common: a view, a panel beside it, nothing loaded from anywhere.

A page is one file with everything in it: it needs nothing but a browser, asks no
server, and can be mailed. Names come from files, so whatever becomes HTML is escaped.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import cv2
import numpy as np
import shapely
from bokeh.embed import file_html
from bokeh.layouts import column, row
from bokeh.models import (
    CheckboxGroup,
    ColumnDataSource,
    CustomJS,
    DataRange1d,
    DataTable,
    Div,
    InlineStyleSheet,
    NumberFormatter,
    PanTool,
    PrintfTickFormatter,
    ResetTool,
    SaveTool,
    StringFormatter,
    TableColumn,
    WheelZoomTool,
)
from bokeh.plotting import figure
from bokeh.resources import INLINE
from numpy.typing import NDArray

from roomseg.figures.style import room_colours

__all__ = [
    "FEATURE_TITLES",
    "PALETTE",
    "WIDTH",
    "areas",
    "chart",
    "fact_list",
    "heading",
    "jpeg_url",
    "layer_switch",
    "page",
    "plan_figure",
    "png_url",
    "table",
    "text",
    "view_figure",
]

WIDTH = 340
"""Of the panel, px."""
ROW_HEIGHT = 24
STYLE = """
:host { font-family: system-ui, sans-serif; font-size: 13px; line-height: 1.4; color: #222 }
h1 { font-size: 17px; margin: 0; overflow-wrap: anywhere } h2 { font-size: 13px; margin: 6px 0 0 0 }
p { margin: 2px 0; overflow-wrap: anywhere } .quiet { color: #666 }
dl { display: grid; grid-template-columns: auto 1fr; gap: 2px 10px; margin: 4px 0 }
dt { color: #666 } dd { margin: 0; overflow-wrap: anywhere }
img { display: block; margin-top: 4px; max-width: 100%; border-radius: 3px }
"""
PANEL = {
    "background": "#F4F4F2",
    "padding": "8px 12px",
    "overflow-y": "auto",
    "overflow-x": "hidden",
}

TWO_COLUMNS = """
.bk-input-group { columns: 2; display: block } label { display: flex; align-items: center }
"""
SWATCH = "content: ''; width: 10px; height: 10px; border-radius: 2px; margin-left: 6px"
SWITCH = """
renderers.forEach((own, index) => {
  for (const item of own) item.visible = layers.active.includes(index)
})
"""

FEATURE_TITLES = {
    "length": "edge length, m",
    "passageway_width": "passageway width, m",
    "passageway": "passageway by its lintel, px",
    "d_c": "panorama difference d_c",
    "d_s": "signature difference d_s",
}
"""What the edge features are, with their units."""
PALETTE = tuple(
    f"#{r:02x}{g:02x}{b:02x}" for r, g, b in (room_colours(27) * 255).round().astype(int)
)
"""Colours of rooms, over and over again."""


def page(title: str, view: Any, *panel: Any) -> str:
    """Lay out a page: the view fills it, the panel beside it has its own scroll bar."""
    side = column(*panel, width=WIDTH + 40, sizing_mode="stretch_height", styles=PANEL)
    return str(file_html(row(view, side, sizing_mode="stretch_both"), INLINE, title))


def text(html: str = "", name: str | None = None, width: int = WIDTH - 20) -> Div:
    """HTML in the pages' type; what comes from a file has to be escaped before."""
    return Div(text=html, name=name, width=width, stylesheets=[InlineStyleSheet(css=STYLE)])


def heading(title: str, about: str = "") -> Div:
    """What the page is of."""
    return text(f"<h1>{escape(title)}</h1><p class='quiet'>{escape(about)}</p>")


def fact_list(facts: Sequence[tuple[str, str]]) -> Div:
    """Names and what they are, one below the other."""
    lines = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts)
    return text(f"<dl>{lines}</dl>")


def layer_switch(
    renderers: Mapping[str, Sequence[Any]], shown: Sequence[str], *, coloured: bool = False
) -> CheckboxGroup:
    """Boxes that switch layers on and off.

    Parameters
    ----------
    renderers : mapping of str to sequence
        What shows a layer, by its name.
    shown : sequence of str
        The layers that are on at first.
    coloured : bool
        Whether the colour of a layer stands behind its name.
    """
    style = STYLE + TWO_COLUMNS + (_swatches(renderers) if coloured else "")
    switch = CheckboxGroup(
        labels=[*renderers],
        active=[index for index, name in enumerate(renderers) if name in shown],
        name="layers",
        stylesheets=[InlineStyleSheet(css=style)],
        width=WIDTH - 20,
    )
    for name, own in renderers.items():
        for item in own:
            item.visible = name in shown
    arguments = {"layers": switch, "renderers": [list(own) for own in renderers.values()]}
    switch.js_on_change("active", CustomJS(args=arguments, code=SWITCH))
    return switch


def _swatches(renderers: Mapping[str, Sequence[Any]]) -> str:
    """CSS: behind each layer's name its colour, if it has a single one."""
    rules = []
    for index, own in enumerate(renderers.values(), 1):
        looks = [getattr(own[0].glyph, f"{part}_color", None) for part in ("line", "fill")]
        # What is no colour is nothing, or the name of a column.
        for colour in [look for look in looks if str(look).startswith("#")][:1]:
            rules.append(f"label:nth-of-type({index})::after {{ {SWATCH}; background: {colour} }}")
    return "\n".join(rules)


def view_figure(**options: Any) -> Any:
    """An empty figure that fills the view, moved with the mouse and zoomed with its wheel."""
    plot = figure(
        sizing_mode="stretch_both",
        min_height=300,
        min_width=320,
        min_border_left=48,
        tools=[],
        toolbar_location="above",
        **options,
    )
    wheel, drag = WheelZoomTool(zoom_on_axis=False), PanTool()
    plot.add_tools(drag, wheel, ResetTool(), SaveTool())
    plot.toolbar.active_scroll, plot.toolbar.active_drag = wheel, drag
    _plain(plot)
    return plot


def plan_figure() -> Any:
    """An empty plan, m."""
    spans = {f"{axis}_range": DataRange1d(range_padding=0.04) for axis in "xy"}
    plot = view_figure(match_aspect=True, **spans)
    for axis in plot.axis:
        axis.formatter = PrintfTickFormatter(format="%g m")
    return plot


def chart(title: str, x: str, y: str, height: int = 150, width: int = WIDTH - 20) -> Any:
    """A small diagram for the panel."""
    plot = figure(
        title=title,
        height=height,
        width=width,
        tools=[],
        toolbar_location=None,
        x_axis_label=x,
        y_axis_label=y,
    )
    _plain(plot)
    return plot


def _plain(plot: Any) -> None:
    plot.toolbar.logo = None
    plot.grid.grid_line_color = None
    plot.background_fill_color = "#FBFBFA"
    plot.outline_line_color = "#DDDDDD"
    for axis in plot.axis:
        axis.axis_line_color = axis.major_tick_line_color = "#BBBBBB"
        axis.minor_tick_line_color = None
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = "#666666"


def table(
    columns: Mapping[str, tuple[str, int]],
    source: ColumnDataSource,
    height: int | None = None,
    digits: str = "0[.]0",
) -> DataTable:
    """A table that is sorted by a click on a column's head.

    Parameters
    ----------
    columns : mapping of field to (title, width in px)
    source : ColumnDataSource
        Rows that are selected are so in everything that shows the source.
    height : int, optional
        px; all rows if absent, but no more than twelve.
    digits : str
        How numbers are written (Numbro's format).
    """
    made = [
        TableColumn(
            field=name, title=title, width=width, formatter=_formatter(source, name, digits)
        )
        for name, (title, width) in columns.items()
    ]
    rows = len(next(iter(source.data.values()), ()))
    return DataTable(
        source=source,
        columns=made,
        editable=False,
        index_position=None,
        reorderable=False,
        width=WIDTH - 10,
        height=height or ROW_HEIGHT * (min(rows, 12) + 1) + 16,
        row_height=ROW_HEIGHT,
        autosize_mode="none",
    )


def _formatter(source: ColumnDataSource, name: str, digits: str) -> Any:
    values = source.data[name]
    if all(isinstance(value, str) for value in values):
        return StringFormatter()
    return NumberFormatter(format=digits, text_align="right", nan_format="")


def areas(*shapes: Any) -> dict[str, list[Any]]:
    """Shapely areas as columns of Bokeh's ``multi_polygons``, holes left out; m."""
    xs: list[Any] = []
    ys: list[Any] = []
    for shape in shapes:
        parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
        rings = [
            [shapely.get_coordinates(ring).round(3) for ring in (part.exterior, *part.interiors)]
            for part in parts
        ]
        xs.append([[ring[:, 0].tolist() for ring in part] for part in rings])
        ys.append([[ring[:, 1].tolist() for ring in part] for part in rings])
    return {"xs": xs, "ys": ys}


def jpeg_url(image: NDArray[np.uint8], longest: int) -> str:
    """A picture as a data URL, no larger than so many px."""
    scale = min(1.0, longest / max(image.shape))
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    packed = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 70])[1]
    return "data:image/jpeg;base64," + base64.b64encode(packed.tobytes()).decode()


def png_url(png: bytes) -> str:
    """A PNG file as a data URL."""
    return "data:image/png;base64," + base64.b64encode(png).decode()
