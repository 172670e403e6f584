"""A trained model as one self-contained page: where it sees borders, and what it is made of.

Two features span a plane on which all others are as border edges have them; the colour
tells on which side of the classifier's boundary an edge there lies, and how far from it.
"""

from __future__ import annotations

from dataclasses import asdict
from itertools import combinations
from typing import Any

import numpy as np
from bokeh.layouts import column, row
from bokeh.models import ColorBar, ColumnDataSource, CustomJS, LinearColorMapper, Range1d, Select
from bokeh.plotting.contour import contour_data
from matplotlib.colors import LinearSegmentedColormap, to_hex
from numpy.typing import NDArray

from roomseg.browser.shell import (
    FEATURE_TITLES,
    chart,
    fact_list,
    heading,
    page,
    table,
    text,
    view_figure,
)
from roomseg.classifier import BorderModel, TrainingMap
from roomseg.figures.style import BORDER_EDGE_GREEN, INK
from roomseg.room_count import NodeCountRegression

__all__ = ["model_page"]

Floats = NDArray[np.float64]

SIDE = 80
"""Of a plane's picture, px."""
COLOURS = ("#B7BEC6", "#FFFFFF", BORDER_EDGE_GREEN)
"""No border, the boundary, a border."""
NO_BORDER = "#6B7480"
MANY = 2000
"""Of more points those of no border are drawn smaller."""
FEWEST_MAPS = 4
"""With fewer the three coefficients of Eq. 23 are not determined."""
CHOOSE = """
const plane = planes[Number(select.value)]
picture.data = {...plane.picture}
boundary.data = {...plane.boundary}
vectors.data = {...vectors.data, x: columns[plane.x], y: columns[plane.y]}
plot.x_range.setv({start: plane.picture.x[0], end: plane.picture.x[0] + plane.picture.dw[0]})
plot.y_range.setv({start: plane.picture.y[0], end: plane.picture.y[0] + plane.picture.dh[0]})
for (const range of [plot.x_range, plot.y_range])
  range.setv({reset_start: range.start, reset_end: range.end})
plot.below[0].axis_label = titles[plane.x]
plot.left[0].axis_label = titles[plane.y]
"""


def model_page(model: BorderModel, name: str) -> str:
    """Make the page of a model.

    Parameters
    ----------
    model : BorderModel
    name : str
        Of its file.
    """
    return page(
        name,
        _planes(model),
        heading(name, "room-border classifier, a support vector machine (§2.3)"),
        fact_list(_facts(model)),
        text("<h2>Features</h2><p class='quiet'>with mean and spread of the training edges</p>"),
        _features(model),
        *_trained_on(model.trained_on),
        *_room_count(model.trained_on),
    )


def _facts(model: BorderModel) -> list[tuple[str, str]]:
    p = model.parameters
    facts = [
        ("C, γ", f"{p.C:g}, {p.gamma:g}"),
        ("w", f"{p.class_weight:g}: so many times a border edge counts"),
        ("ρ", f"{p.rho:g}: so many times less it weighs in the graph"),
        ("points", f"{len(model.points)} that hold the boundary"),
    ]
    edges = sum(item.edges for item in model.trained_on)
    if edges:
        found = sum(item.border_edges for item in model.trained_on)
        places = len({item.environment for item in model.trained_on})
        facts.append(("trained on", f"{edges} edges, {found} of them border edges"))
        facts.append(("from", f"{len(model.trained_on)} maps of {places} places"))
    else:
        facts.append(("trained on", "the file does not tell"))
    return facts


def _features(model: BorderModel) -> Any:
    source = ColumnDataSource(
        {
            "feature": [FEATURE_TITLES.get(name, name) for name in model.names],
            "mean": [float(value) for value in model.mean],
            "spread": [float(value) for value in model.spread],
        },
        name="features",
    )
    columns = {"feature": ("feature", 196), "mean": ("mean", 62), "spread": ("spread", 62)}
    return table(columns, source, digits="0.00")


def _trained_on(maps: tuple[TrainingMap, ...]) -> list[Any]:
    if not maps:
        return []
    columns = {
        "environment": ("place", 80),
        "run": ("run", 50),
        "nodes": ("nodes", 50),
        "rooms": ("rooms", 45),
        "edges": ("edges", 50),
        "border_edges": ("border", 45),
    }
    rows = [asdict(item) for item in maps]
    source = ColumnDataSource({key: [line[key] for line in rows] for key in columns}, name="maps")
    return [text("<h2>Maps</h2>"), table(columns, source)]


def _room_count(maps: tuple[TrainingMap, ...]) -> list[Any]:
    """Rooms by nodes of the training maps, and what Eq. 23 makes of them."""
    if not maps:
        return []
    nodes = np.array([item.nodes for item in maps])
    rooms = np.array([item.rooms for item in maps])
    plot = chart("", "nodes of a map", "rooms", height=170)
    plot.scatter(nodes, rooms, size=6, color=BORDER_EDGE_GREEN)
    told = "of the training maps"
    if len(np.unique(nodes)) >= FEWEST_MAPS:
        fit = NodeCountRegression.fit(nodes.tolist(), rooms.tolist())
        n = np.linspace(nodes.min(), nodes.max(), 100)
        plot.line(n, fit.a * np.sqrt(n) + fit.b * n + fit.c, color=INK)
        told = f"m = {fit.a:.3g} √n {fit.b:+.3g} n {fit.c:+.3g} fits the training maps (Eq. 23)"
    return [text(f"<h2>How many rooms</h2><p class='quiet'>{told}</p>"), plot]


def _planes(model: BorderModel) -> Any:
    """The view: a plane of two features with the model's points, and a menu of planes."""
    vectors = model.mean + model.spread * model.points
    is_border = model.decision_function(vectors) > 0.0
    usual = vectors[is_border if is_border.any() else slice(None)].mean(axis=0)
    pairs = combinations(range(len(model.names)), 2)
    planes = [_plane(model, vectors, usual, *pair) for pair in pairs]
    if not planes:
        return text("<p class='quiet'>A single feature spans no plane.</p>")
    titles = [FEATURE_TITLES.get(name, name) for name in model.names]
    picture, boundary = ColumnDataSource(planes[0]["picture"]), ColumnDataSource()
    boundary.data = planes[0]["boundary"]
    shown = ColumnDataSource(
        {
            "x": vectors[:, 0],
            "y": vectors[:, 1],
            "colour": np.where(is_border, BORDER_EDGE_GREEN, NO_BORDER).tolist(),
            "size": np.where(is_border, 7, 6 if len(vectors) < MANY else 4),
            "kind": np.where(is_border, "a border edge", "another edge").tolist(),
        },
        name="points",
    )
    plot = _plane_figure(picture, boundary, shown, planes, (titles[0], titles[1]))
    options = [
        (str(index), f"{titles[plane['y']]} by {titles[plane['x']]}")
        for index, plane in enumerate(planes)
    ]
    select = Select(options=options, value="0", width=440, name="plane")
    arguments = {
        "select": select,
        "planes": planes,
        "picture": picture,
        "boundary": boundary,
        "vectors": shown,
        "columns": [*np.ascontiguousarray(vectors.T)],
        "titles": titles,
        "plot": plot,
    }
    select.js_on_change("value", CustomJS(args=arguments, code=CHOOSE))
    hint = "Points: training edges that hold the boundary. "
    if len(model.names) > 2:
        hint += "Other features: the mean of the green ones."
    about = text(f"<p class='quiet'>{hint}</p>", width=380)
    return column(row(select, about, height=44), plot, sizing_mode="stretch_both")


def _plane(model: BorderModel, vectors: Floats, usual: Floats, x: int, y: int) -> dict[str, Any]:
    """Decision values in the plane of two features, and where they are 0."""
    spans = [_span(vectors[:, index]) for index in (x, y)]
    (x0, x1), (y0, y1) = spans
    a, b = np.meshgrid(np.linspace(x0, x1, SIDE), np.linspace(y0, y1, SIDE))
    edges = np.tile(usual, (SIDE * SIDE, 1))
    edges[:, x], edges[:, y] = a.ravel(), b.ravel()
    value = model.decision_function(edges).reshape(SIDE, SIDE)
    line = contour_data(a, b, value, levels=[0.0], want_fill=False).line_data
    assert line is not None
    return {
        "x": x,
        "y": y,
        "picture": {
            "image": [value.astype(np.float32)],
            "x": [x0],
            "y": [y0],
            "dw": [x1 - x0],
            "dh": [y1 - y0],
        },
        "boundary": {"xs": line.xs, "ys": line.ys},
    }


def _span(values: Floats) -> tuple[float, float]:
    """Where most values lie, and a bit."""
    low, high = np.percentile(values, [1.0, 99.0])
    more = 0.08 * (high - low) or 1.0
    return float(low - more), float(high + more)


def _plane_figure(
    picture: ColumnDataSource,
    boundary: ColumnDataSource,
    vectors: ColumnDataSource,
    planes: list[dict[str, Any]],
    titles: tuple[str, str],
) -> Any:
    data = planes[0]["picture"]
    (x0, dw), (y0, dh) = ((data[a][0], data[d][0]) for a, d in (("x", "dw"), ("y", "dh")))
    plot = view_figure(
        x_axis_label=titles[0],
        y_axis_label=titles[1],
        x_range=Range1d(x0, x0 + dw),
        y_range=Range1d(y0, y0 + dh),
    )
    most = max(float(np.abs(plane["picture"]["image"][0]).max()) for plane in planes)
    blend = LinearSegmentedColormap.from_list("sides", COLOURS)(np.linspace(0.0, 1.0, 256))
    mapper = LinearColorMapper(palette=[to_hex(c) for c in blend], low=-most, high=most)
    plot.image("image", "x", "y", "dw", "dh", source=picture, color_mapper=mapper)
    plot.multi_line("xs", "ys", source=boundary, color=INK, line_width=2)
    plot.scatter(
        "x",
        "y",
        source=vectors,
        size="size",
        fill_color="colour",
        line_color="white",
        line_width=0.7,
        fill_alpha=0.8,
        legend_group="kind",
    )
    plot.legend.background_fill_alpha = 0.85
    bar = ColorBar(color_mapper=mapper, width=10, title="border, above 0", title_standoff=8)
    plot.add_layout(bar, "right")
    return plot
