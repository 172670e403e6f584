"""Many plans on one sheet, all at the same scale."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely
from matplotlib.figure import Figure

from roomseg.figures.plan import HomePlan, draw_home_plan
from roomseg.figures.style import INK, new_figure

__all__ = ["plan_sheet"]

CELL = 2.2
"""Side of a plan's place on the sheet, inches."""


def plan_sheet(plans: Sequence[HomePlan], titles: Sequence[str]) -> Figure:
    """Draw plans in rows from the upper left, each with its title above.

    Parameters
    ----------
    plans : sequence of HomePlan
        At least one.
    titles : sequence of str
        As many.
    """
    bounds = [shapely.total_bounds([p.walls, *(room.floor for room in p.rooms)]) for p in plans]
    half = 0.52 * max(max(x1 - x0, y1 - y0) for x0, y0, x1, y1 in bounds)
    columns = math.ceil(math.sqrt(1.4 * len(plans)))
    rows = math.ceil(len(plans) / columns)
    figure = new_figure(CELL * columns, (CELL + 0.25) * rows)
    for index, (plan, title, box) in enumerate(zip(plans, titles, bounds, strict=True), 1):
        ax = figure.add_subplot(rows, columns, index, aspect="equal")
        ax.set_axis_off()
        x, y = (box[:2] + box[2:]) / 2.0
        draw_home_plan(ax, plan)
        ax.set_xlim(x - half, x + half)
        ax.set_ylim(y - half, y + half)
        ax.set_title(title, fontsize=7, color=INK)
    return figure
