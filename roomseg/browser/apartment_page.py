"""An apartment as one self-contained page: its plan in layers, and its rooms."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import shapely
from bokeh.models import ColumnDataSource, CustomJS, HoverTool, TapTool
from matplotlib.colors import to_hex

from roomseg.browser.labels import draw_names
from roomseg.browser.map_layers import line_columns
from roomseg.browser.shell import (
    PALETTE,
    areas,
    fact_list,
    heading,
    layer_switch,
    page,
    plan_figure,
    table,
    text,
)
from roomseg.figures.labels import Label, place_label
from roomseg.figures.plan import FRAME, GAP, GROUPS, LEAF, SOLID, START, HomePlan, Symbol, tint
from roomseg.figures.style import BORDER_EDGE_GREEN, INK

__all__ = ["apartment_page"]

START_SIZE = 0.16
"""m; half the side of the base station's square."""
INCHES = 0.9
"""What 1 m measures on a screen, about."""
HIDDEN = ("overhead",)
"""Layers that are off at first."""
HINT = "<p class='quiet'>Click on a room, here or in the plan.</p>"
TELL = "div.text = rooms.selected.indices.map((room) => rooms.data.told[room]).join('') || hint"


def apartment_page(
    plan: HomePlan,
    told: Sequence[Sequence[tuple[str, str]]],
    facts: Sequence[tuple[str, str]] = (),
    about: str = "",
) -> str:
    """Make the page of an apartment.

    Parameters
    ----------
    plan : HomePlan
    told : sequence of (name, value) each
        What to tell of each room besides its name and area.
    facts : sequence of (name, value)
        What to tell of the apartment.
    about : str
        Its description.
    """
    plot = plan_figure()
    rooms = _room_source(plan, told)
    layers: dict[str, list[Any]] = {}
    _draw_floors(plot, rooms)
    _draw_furniture(plot, plan.symbols, layers)
    _draw_building(plot, plan, layers)
    _draw_signs(plot, plan, layers)
    layers["room names"] = [_draw_names(plot, rooms)]
    chosen = text(HINT, name="room")
    arguments = {"div": chosen, "rooms": rooms, "hint": HINT}
    rooms.selected.js_on_change("indices", CustomJS(args=arguments, code=TELL))
    return page(
        plan.name,
        plot,
        heading(plan.name, about),
        text("<h2>Layers</h2>"),
        layer_switch(layers, [name for name in layers if name not in HIDDEN]),
        text("<h2>Rooms</h2>"),
        table({"name": ("room", 200), "area": ("m²", 80)}, rooms, digits="0.0"),
        chosen,
        fact_list(facts),
    )


def _room_source(plan: HomePlan, told: Sequence[Sequence[tuple[str, str]]]) -> ColumnDataSource:
    labels = _labels(plan)
    columns = {
        **areas(*(room.floor for room in plan.rooms)),
        "name": [room.name for room in plan.rooms],
        "area": [round(room.area, 2) for room in plan.rooms],
        "colour": [PALETTE[index % len(PALETTE)] for index in range(len(plan.rooms))],
        "x": [label.x for label in labels],
        "y": [label.y for label in labels],
        "angle": [float(np.radians(label.rotation)) for label in labels],
        "title": [f"{room.name}\n{room.area:.1f} m²" for room in plan.rooms],
        "told": [
            _lines([("room", room.name), ("area", f"{room.area:.1f} m²"), *lines])
            for room, lines in zip(plan.rooms, told, strict=True)
        ],
    }
    return ColumnDataSource(columns, name="rooms")


def _labels(plan: HomePlan) -> list[Label]:
    """Where the rooms' names stand: beside the furniture if there is room."""
    taken = shapely.union_all([symbol.shape for symbol in plan.symbols if not symbol.hung])
    return [
        place_label(room.floor, taken, [room.name, f"{room.area:.1f} m²"], INCHES)
        for room in plan.rooms
    ]


def _lines(told: Sequence[tuple[str, str]]) -> str:
    items = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in told)
    return f"<dl>{items}</dl>"


def _draw_floors(plot: Any, rooms: ColumnDataSource) -> None:
    floors = plot.multi_polygons(
        "xs",
        "ys",
        source=rooms,
        fill_color="colour",
        fill_alpha=0.16,
        line_color=None,
        selection_fill_alpha=0.5,
        nonselection_fill_alpha=0.16,
    )
    plot.add_tools(TapTool(renderers=[floors], visible=False))


def _draw_furniture(plot: Any, symbols: Sequence[Symbol], layers: dict[str, list[Any]]) -> None:
    """Seen from above: what is higher covers what is lower; of hung pieces the outline."""
    looks: dict[str, dict[str, Any]] = {
        "furniture": {"fill_color": "fill"},
        "hung furniture": {"fill_color": None, "line_dash": [3, 2]},
    }
    drawn = []
    for name, look in looks.items():
        own = [symbol for symbol in symbols if symbol.hung == (name != "furniture")]
        columns = {
            **areas(*(symbol.shape for symbol in own)),
            "colour": [GROUPS[symbol.group] for symbol in own],
            "fill": [to_hex(tint(GROUPS[symbol.group], 0.32)) for symbol in own],
            "name": [symbol.name for symbol in own],
            "group": [symbol.group for symbol in own],
        }
        if own:
            shapes = plot.multi_polygons(
                "xs", "ys", source=ColumnDataSource(columns, name=name), line_color="colour", **look
            )
            layers[name] = [shapes]
            drawn.append(shapes)
    if drawn:
        tips = [("", "@name (@group)")]
        plot.add_tools(HoverTool(renderers=drawn, tooltips=tips, visible=False))


def _draw_building(plot: Any, plan: HomePlan, layers: dict[str, list[Any]]) -> None:
    """Walls and what belongs to them; dashed what is overhead."""
    doors = plan.doors
    for name, shapes, look in (
        ("walls", [plan.walls], {"fill_color": INK, "line_color": INK}),
        ("walls", plan.solids, {"fill_color": SOLID, "line_color": INK}),
        ("doors", [door.opening for door in doors], {"fill_color": GAP, "line_color": None}),
        ("doors", [d.threshold for d in doors], {"fill_color": FRAME, "line_color": None}),
        ("doors", [door.frame for door in doors], {"fill_color": FRAME, "line_color": INK}),
        ("doors", [door.leaf for door in doors], {"fill_color": LEAF, "line_color": INK}),
        ("windows", [w.opening for w in plan.windows], {"fill_color": "white", "line_color": INK}),
        ("overhead", plan.overhead, {"fill_color": None, "line_color": INK, "line_dash": [4, 2]}),
    ):
        there = [shape for shape in shapes if shape is not None]
        if there:
            columns = ColumnDataSource(areas(*there))
            drawn = plot.multi_polygons("xs", "ys", source=columns, line_width=0.5, **look)
            layers.setdefault(name, []).append(drawn)
    lines: list[tuple[str, Any, dict[str, Any]]] = [
        ("windows", [window.pane for window in plan.windows], {"color": INK}),
        ("overhead", [d.faces for d in doors if d.lintel], {"color": INK, "line_dash": [4, 2]}),
        ("borders", plan.borders, {"color": BORDER_EDGE_GREEN, "line_width": 2}),
    ]
    for name, segments, look in lines:
        if len(segments):
            columns = ColumnDataSource(line_columns(np.array(segments)))
            layers.setdefault(name, []).append(plot.line("x", "y", source=columns, **look))


def _draw_signs(plot: Any, plan: HomePlan, layers: dict[str, list[Any]]) -> None:
    """Lamps, and the base station with an arrow where the robot leaves it."""
    if len(plan.lamps):
        x, y, radius = plan.lamps.T
        look = {"fill_color": "#FFF6D0", "line_color": GROUPS["lamps"], "fill_alpha": 0.7}
        layers["lamps"] = [plot.circle(x, y, radius=radius, **look)]
    x0, y0, heading_ = plan.start
    square = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    arrow = np.array([(2.4, 0.0), (1.3, 0.7), (1.3, -0.7)])
    along = np.array([np.cos(heading_), np.sin(heading_)])
    turned = np.array([along, [-along[1], along[0]]])
    shapes = [
        shapely.Polygon(START_SIZE * corners @ turned + [x0, y0]) for corners in (square, arrow)
    ]
    source = ColumnDataSource({**areas(*shapes), "colour": [START, INK]})
    layers["base station"] = [
        plot.multi_polygons("xs", "ys", source=source, fill_color="colour", line_color=INK)
    ]


def _draw_names(plot: Any, rooms: ColumnDataSource) -> Any:
    names = draw_names(
        plot,
        rooms,
        "title",
        angle="angle",
        text_font_size="12px",
        text_font_style="normal",
        background_fill_alpha=0.75,
    )
    # Only the floor shows which room is selected.
    names.nonselection_glyph = None
    return names
