"""A folder as one self-contained page: a small picture and some figures of each file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from bokeh.layouts import row
from bokeh.models import ColumnDataSource, CustomJS, Div, InlineStyleSheet
from bokeh.palettes import Colorblind
from numpy.typing import NDArray

from roomseg.browser.shell import STYLE, chart, fact_list, heading, page, png_url, table, text
from roomseg.figures.sheet import Chart

__all__ = ["FolderItem", "folder_page"]

CARD = 216
"""px; width of a card."""
CARD_STYLE = """
:host { background: white; border: 1px solid #DDDDDA; border-radius: 6px; padding: 8px;
box-sizing: border-box; font-size: 12px } h3 { font-size: 13px; margin: 0; overflow-wrap: anywhere }
img { margin: 0 auto 6px auto }
"""
GRID = {"flex-wrap": "wrap", "overflow-y": "auto", "align-content": "flex-start", "padding": "6px"}
CHOOSE = """
const chosen = files.selected.indices
cards.forEach((card, index) => card.visible = !chosen.length || chosen.includes(index))
"""
BINS = 12
FEWEST = 3
"""Values of a diagram."""
FEW_VALUES = 15
"""Whole numbers of a span up to this have a bar each."""


@dataclass(frozen=True)
class FolderItem:
    """A file of the folder.

    Attributes
    ----------
    name : str
        With its way from the folder.
    kind : str
        What it is.
    rooms : int or None
        How many it has.
    facts : tuple of str
        What stands below its name, line by line.
    picture : bytes
        PNG; empty if there is none.
    """

    name: str
    kind: str
    rooms: int | None
    facts: tuple[str, ...]
    picture: bytes = b""


def folder_page(
    name: str,
    items: Sequence[FolderItem],
    charts: Sequence[Chart] = (),
    facts: Sequence[tuple[str, str]] = (),
    unread: Sequence[str] = (),
) -> str:
    """Make the page of a folder.

    Parameters
    ----------
    name : str
        Of the folder.
    items : sequence of FolderItem
        At least one.
    charts : sequence of Chart
        How figures spread over the files; those with few values are left out.
    facts : sequence of (name, value)
        What to tell of all of them.
    unread : sequence of str
        Why other files are not shown, one line each.
    """
    cards = [_card(item) for item in items]
    files = ColumnDataSource(
        {
            "name": [item.name for item in items],
            "kind": [item.kind for item in items],
            "rooms": [np.nan if item.rooms is None else float(item.rooms) for item in items],
        },
        name="files",
    )
    arguments = {"files": files, "cards": cards}
    files.selected.js_on_change("indices", CustomJS(args=arguments, code=CHOOSE))
    lines = "".join(f"<p class='quiet'>{escape(line)}</p>" for line in unread)
    return page(
        name,
        row(*cards, sizing_mode="stretch_both", styles=GRID),
        heading(name),
        fact_list(facts),
        text(
            "<h2>Files</h2><p class='quiet'>A click on a file shows it alone (with Ctrl or Shift "
            "several, with Ctrl again all); one on a column's head sorts.</p>"
        ),
        table({"name": ("file", 200), "kind": ("kind", 75), "rooms": ("rooms", 45)}, files),
        *(_histogram(item) for item in charts if _size(item) >= FEWEST),
        *([text(f"<h2>Not shown</h2>{lines}")] if unread else []),
    )


def _card(item: FolderItem) -> Div:
    picture = f'<img src="{png_url(item.picture)}">' if item.picture else ""
    lines = "<br>".join(escape(line) for line in item.facts)
    html = f"{picture}<h3>{escape(item.name)}</h3><span class='quiet'>{lines}</span>"
    style = [InlineStyleSheet(css=STYLE + CARD_STYLE)]
    return Div(text=html, width=CARD, margin=6, stylesheets=style)


def _size(of: Chart) -> int:
    return sum(len(own) for own in of.values.values())


def _histogram(of: Chart) -> Any:
    """Bars, those of several groups on top of each other."""
    plot = chart("", of.label, "", height=130)
    values = {group: np.asarray(own, float) for group, own in of.values.items() if len(own)}
    edges = _bins(np.concatenate([*values.values()]))
    below = np.zeros(len(edges) - 1)
    for (group, own), colour in zip(values.items(), Colorblind[8], strict=False):
        above = below + np.histogram(own, edges)[0]
        look = {"fill_color": colour, "line_color": "white"}
        if len(values) > 1:
            look["legend_label"] = group
        plot.quad(left=edges[:-1], right=edges[1:], bottom=below, top=above, **look)
        below = above
    plot.y_range.start = 0
    plot.yaxis.ticker.desired_num_ticks = 3
    plot.yaxis.ticker.min_interval = 1
    return plot


def _bins(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of the bars; a bar for each number if these are few whole ones."""
    low, high = float(values.min()), float(values.max())
    whole = bool(np.all(values == np.round(values)))
    if low == high or (whole and high - low <= FEW_VALUES):
        return np.arange(low - 0.5, high + 1.0)
    return np.linspace(low, high, BINS + 1)
