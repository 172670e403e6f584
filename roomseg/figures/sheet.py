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
IMAGES = 3
"""At most, of a place."""
FEWEST = 3
"""Columns of places, so that the charts have room."""
HUES = ("#0072B2", "#D55E00", "#882255")
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
        At least one. The last one has the scale bar.
    charts : sequence of Chart
        At least one; all of the same splits.
    """
    hues = dict(zip(charts[0].values, HUES, strict=False))
    half = _half([place.plan for place in places])
    columns = max(FEWEST, math.ceil(math.sqrt(1.3 * len(places))))
    rows = math.ceil(len(places) / columns)
    heights = (CELL * half[1] / half[0], STRIP if any(place.images for place in places) else 0.0)
    height = (sum(heights) + TITLE) * rows
    figure = new_figure(CELL * columns, CHART + height + TITLE)
    figure.suptitle(title, fontsize=11, color=INK)
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[CHART, height])[:, 0]
    _draw_charts(above, charts, hues)
    cells = below.subfigures(rows, columns, squeeze=False)
    for cell, place in zip(cells.flat, places, strict=False):
        plan = _draw_place(cell, place, heights, hues.get(place.split, INK))
        _frame(plan, place.plan, half)
    x, y = plan.get_xlim()[0], plan.get_ylim()[0]
    scale_bar(plan, (x, y), scale_bar_length(2.0 * half[0]), 0.03 * half[0])
    return figure


def _half(plans: Sequence[HomePlan]) -> tuple[float, float]:
    """Half of width and height, m, of a rectangle that every plan fits into."""
    bounds = np.array([_bounds(plan) for plan in plans])
    width, height = (bounds[:, 2:] - bounds[:, :2]).max(axis=0)
    # Room for the scale bar below.
    return 0.53 * float(width), 0.58 * float(height)


def _bounds(plan: HomePlan) -> Any:
    return shapely.total_bounds([plan.walls, *(room.floor for room in plan.rooms)])


def _draw_charts(figure: Any, charts: Sequence[Chart], hues: Mapping[str, str]) -> None:
    """Histograms in a row; a legend if there are several splits."""
    axes = figure.subplots(1, len(charts), squeeze=False)[0]
    for ax, chart in zip(axes, charts, strict=True):
        _draw_chart(ax, chart, hues)
    handles, labels = axes[0].get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(
            handles, labels, loc="outside upper right", ncols=3, fontsize=7, frameon=False
        )


def _draw_chart(ax: Any, chart: Chart, hues: Mapping[str, str]) -> None:
    """A histogram, the splits on top of each other."""
    used = {split: values for split, values in chart.values.items() if len(values)}
    ax.set_xlabel(chart.label, fontsize=7, color=INK)
    ax.tick_params(labelsize=6.5, colors=INK)
    ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    ax.spines[["top", "right"]].set_visible(False)
    if not used:
        return
    bins, ticks = _bins(np.concatenate([*used.values()]))
    colours = [hues[split] for split in used]
    ax.hist([*used.values()], bins=bins, stacked=True, color=colours, label=[*used], rwidth=0.9)
    if ticks is not None:
        ax.set_xticks(ticks)


def _bins(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Bins of a histogram, and where to write numbers if each bin is of one number."""
    low, high = float(values.min()), float(values.max())
    if low == high or (high - low < 20 and np.all(values == np.round(values))):
        return np.arange(low - 0.5, high + 1.0), np.arange(low, high + 0.5, 1 + (high - low) // 8)
    return np.linspace(low, high, 13), None


def _draw_place(cell: Any, place: SheetPlace, heights: tuple[float, float], hue: str) -> Any:
    """The plan with its title, the images in a row below; returns the plan's axes."""
    if not heights[1]:
        plan = cell.add_subplot()
    else:
        above, below = cell.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        plan = above.add_subplot()
        # A margin, so that it shows whose images they are.
        widths = [0.15, *[1.0] * IMAGES, 0.15]
        grid = below.add_gridspec(1, IMAGES + 2, width_ratios=widths, wspace=0.02)
        for column, image in enumerate(place.images[:IMAGES], 1):
            ax = below.add_subplot(grid[0, column])
            ax.set_axis_off()
            ax.imshow(image, cmap="gray", vmin=0, vmax=255)
    draw_home_plan(plan, place.plan)
    plan.set_title(place.title, fontsize=7, color=hue)
    return plan


def _frame(ax: Any, plan: HomePlan, half: tuple[float, float]) -> None:
    """Show the plan in the middle of a rectangle."""
    x0, y0, x1, y1 = _bounds(plan)
    x, y = (x0 + x1) / 2.0, (y0 + y1) / 2.0
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set_xlim(x - half[0], x + half[0])
    ax.set_ylim(y - half[1], y + half[1])
