"""A dataset on one sheet: plans of its places with some images, and how its figures spread."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from roomseg.figures.plan import HomePlan, draw_home_plan
from roomseg.figures.style import INK, new_figure, scale_bar, scale_bar_length

__all__ = ["Chart", "SheetPlace", "dataset_sheet"]

CELL = 2.4
"""Side of a plan's place on the sheet, inches."""
TITLE = 0.35
STRIP = 0.8
"""Height of the images below it."""
CHART = 1.7
FEWEST = 3
"""Columns of places, so that the charts have room."""
HUES = ("#0072B2", "#E69F00", "#882255")
"""Of the splits."""


@dataclass(frozen=True)
class SheetPlace:
    """A place: its plan, what stands above and of which split it is, and its images, uint8."""

    title: str
    split: str
    plan: HomePlan
    images: tuple[NDArray[np.uint8], ...] = ()


@dataclass(frozen=True)
class Chart:
    """How a figure spreads: what it is called, and its values by split."""

    label: str
    values: Mapping[str, Sequence[float]]


def dataset_sheet(title: str, places: Sequence[SheetPlace], charts: Sequence[Chart]) -> Figure:
    """Draw charts in a row and below them the places, all at the same scale.

    Parameters
    ----------
    title : str
    places : sequence of SheetPlace
        At least one.
    charts : sequence of Chart
        At least one; all of the same splits.
    """
    splits = [*charts[0].values]
    hues = dict(zip(splits, HUES, strict=False))
    columns = max(FEWEST, math.ceil(math.sqrt(1.3 * len(places))))
    rows = math.ceil(len(places) / columns)
    strip = STRIP if any(place.images for place in places) else 0.0
    height = CELL + TITLE + strip
    figure = new_figure(CELL * columns, CHART + height * rows + TITLE)
    figure.suptitle(title, fontsize=11, color=INK)
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[CHART, height * rows])[
        :, 0
    ]
    for ax, chart in zip(above.subplots(1, len(charts), squeeze=False)[0], charts, strict=True):
        _draw_chart(ax, chart, hues)
    above.axes[0].legend(fontsize=6.5, frameon=False)
    cells = below.subfigures(rows, columns, squeeze=False)
    half = _half(places)
    for cell, place in zip(cells.flat, places, strict=False):
        _draw_place(cell, place, half, strip, hues.get(place.split, INK))
    return figure


def _half(places: Sequence[SheetPlace]) -> float:
    """Half of the side of the square that the largest plan needs, m."""
    bounds = [_bounds(place.plan) for place in places]
    return 0.54 * max(float(max(x1 - x0, y1 - y0)) for x0, y0, x1, y1 in bounds)


def _bounds(plan: HomePlan) -> Any:
    return shapely.total_bounds([plan.walls, *(room.floor for room in plan.rooms)])


def _draw_chart(ax: Any, chart: Chart, hues: Mapping[str, str]) -> None:
    """A histogram, the splits on top of each other."""
    used = {split: values for split, values in chart.values.items() if len(values)}
    everything = np.concatenate([*used.values()]) if used else np.zeros(1)
    whole = bool(np.all(everything == np.round(everything))) and np.ptp(everything) < 20
    low, high = float(everything.min()), float(everything.max())
    bins = np.arange(low - 0.5, high + 1.0) if whole else np.linspace(low, high or 1.0, 13)
    if not whole and low == high:
        bins = np.array([low - 0.5, high + 0.5])
    ax.hist(
        [*used.values()],
        bins=bins,
        stacked=True,
        color=[hues[split] for split in used],
        label=[*used],
        rwidth=0.9,
    )
    ax.set_xlabel(chart.label, fontsize=7, color=INK)
    ax.tick_params(labelsize=6.5, colors=INK)
    ax.xaxis.set_major_locator(MaxNLocator(5, integer=whole))
    ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    ax.spines[["top", "right"]].set_visible(False)


def _draw_place(cell: Any, place: SheetPlace, half: float, strip: float, hue: str) -> None:
    """The plan with its title, the images in a row below."""
    if not strip:
        _draw_plan(cell.add_subplot(), place, half, hue)
        return
    grid = cell.add_gridspec(2, 3, height_ratios=[CELL, strip])
    _draw_plan(cell.add_subplot(grid[0, :]), place, half, hue)
    for column in range(3):
        ax = cell.add_subplot(grid[1, column])
        ax.set_axis_off()
        if column < len(place.images):
            ax.imshow(place.images[column], cmap="gray", vmin=0, vmax=255)


def _draw_plan(ax: Any, place: SheetPlace, half: float, hue: str) -> None:
    ax.set_aspect("equal")
    ax.set_axis_off()
    draw_home_plan(ax, place.plan)
    x0, y0, x1, y1 = _bounds(place.plan)
    x, y = (x0 + x1) / 2.0, (y0 + y1) / 2.0
    ax.set_xlim(x - half, x + half)
    ax.set_ylim(y - half, y + half)
    ax.set_title(place.title, fontsize=7, color=hue)
    length = scale_bar_length(2.0 * half)
    scale_bar(ax, (x - half, y - half), length, 0.012 * half)
