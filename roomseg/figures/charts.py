"""Charts of the experiments, and the passageway width of one edge (Figs. 7, 11, 13, 15, 26)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from roomseg.figures.plans import draw_circles
from roomseg.figures.style import EDGE_RED, INK, OBSTACLE_BLUE, TRAVEL_GREY, finish_plan

__all__ = [
    "RocCurve",
    "draw_border_share",
    "draw_impurity_bars",
    "draw_impurity_surface",
    "draw_lines",
    "draw_passage_width",
    "draw_roc",
    "draw_room_counts",
]

_SERIES = ("#0072B2", "#D5481E", "#008F68", "#AA4499", "#B58900", "#56B4E9", "#555555", "#332288")


@dataclass(frozen=True)
class RocCurve:
    """Receiver operating characteristic of one edge feature (§2.2.5).

    false_positive and true_positive (k,) are rates in [0, 1], both increasing;
    area is the area under the curve.
    """

    name: str
    false_positive: NDArray[np.float64]
    true_positive: NDArray[np.float64]
    area: float

    @property
    def youden(self) -> tuple[int, float]:
        """Index and value of Youden's J, the greatest height above the diagonal."""
        height = np.asarray(self.true_positive) - np.asarray(self.false_positive)
        index = int(np.argmax(height))
        return index, float(height[index])


def _quiet_axes(ax: Any) -> None:
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_linewidth(0.6)
    ax.tick_params(labelsize=8, length=2.5, width=0.6, colors=INK)


def draw_roc(ax: Any, curves: Sequence[RocCurve], title: str | None = None) -> None:
    """Draw ROC curves with the height J of each dashed and chance dashed black (Fig. 11)."""
    ax.plot([0, 1], [0, 1], color=INK, linestyle=(0, (4, 3)), linewidth=0.9, gid="chance")
    for index, curve in enumerate(curves):
        colour = _SERIES[index % len(_SERIES)]
        at, height = curve.youden
        x = float(curve.false_positive[at])
        ax.plot(
            curve.false_positive,
            curve.true_positive,
            color=colour,
            linewidth=1.6,
            label=f"{curve.name}  (AUC {curve.area:.2f}, J {height:.2f})",
            gid="roc",
        )
        ax.plot([x, x], [x, x + height], color=colour, ls=(0, (3, 2)), lw=1.1, gid="youden")
    ax.set_xlabel("false positive rate", fontsize=9)
    ax.set_ylabel("true positive rate", fontsize=9)
    ax.set_xlim(-0.01, 1.01)
    ax.set_ylim(-0.01, 1.01)
    ax.set_aspect("equal")
    _quiet_axes(ax)
    if curves:
        ax.legend(loc="lower right", fontsize=7.5, frameon=True, framealpha=0.9, edgecolor="none")
    if title:
        ax.set_title(title, fontsize=9.5, color=INK)


def draw_passage_width(
    ax: Any,
    edge: ArrayLike,
    *,
    obstacles: ArrayLike,
    closest: ArrayLike | None,
    strip: tuple[float, float],
    title: str | None = None,
) -> None:
    """Show how the passageway width L of one edge comes about (Fig. 7).

    Parameters
    ----------
    edge : array, shape (2, 2)
        Positions of its two nodes, m.
    obstacles : array, shape (k, 2)
        Local obstacle points, m.
    closest : array, shape (2, 2), or None
        The obstacle points nearest to the edge on either side, m; their
        distance is L. None: not enough obstacle data.
    strip : tuple of float
        Where the search area begins and ends along the edge, from its middle, m.
    """
    ends, points = np.asarray(edge, dtype=float), np.asarray(obstacles, dtype=float).reshape(-1, 2)
    middle = ends.mean(axis=0)
    along = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-9)
    across = np.array([-along[1], along[0]])
    reach = np.abs((points - middle) @ across).max(initial=0.5) + 0.1
    for limit in strip:
        line = middle + limit * along + np.outer([-reach, reach], across)
        ax.plot(*line.T, color=TRAVEL_GREY, ls=(0, (4, 3)), lw=1.0, gid="search-area")
    ax.scatter(*points.T, s=7, facecolors="none", edgecolors=INK, linewidths=0.5, gid="points")
    ax.plot(*ends.T, "-o", color=OBSTACLE_BLUE, lw=2.0, ms=6, gid="edge", zorder=4)
    if closest is not None:
        _draw_width(ax, np.asarray(closest, dtype=float), middle, along)
    length = float(np.hypot(*(ends[1] - ends[0])))
    _name(ax, f"l = {length:.2f} m", middle - 0.25 * length * along, (9, -3), OBSTACLE_BLUE)
    finish_plan(ax, title)


def _draw_width(
    ax: Any, pair: NDArray[np.float64], middle: NDArray[np.float64], along: NDArray[np.float64]
) -> None:
    width = float(np.hypot(*(pair[1] - pair[0])))
    ax.plot(*pair.T, color=EDGE_RED, lw=1.6, gid="width", zorder=3)
    rings = draw_circles(ax, pair, 0.05)
    rings.set(facecolor="none", edgecolor=EDGE_RED, linewidth=1.8, gid="closest", zorder=5)
    for point in pair:
        foot = middle + np.dot(point - middle, along) * along
        ax.plot(*np.stack([point, foot]).T, color=INK, ls=":", lw=1.0, zorder=2)
    # Beside the edge, which is about halfway.
    quarter = 0.78 * pair[0] + 0.22 * pair[1]
    _name(ax, f"L = {width:.2f} m", quarter, (0, 8), EDGE_RED)


def _name(
    ax: Any, text: str, place: NDArray[np.float64], shift: tuple[int, int], colour: str
) -> None:
    """Write beside a place, ``shift`` pt from it."""
    ax.annotate(
        text,
        place,
        xytext=shift,
        textcoords="offset points",
        color=colour,
        fontsize=10,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
        zorder=6,
    )


def draw_impurity_bars(
    ax: Any,
    ours: Mapping[str, float],
    paper: Mapping[str, float] | None = None,
    title: str | None = None,
) -> None:
    """Draw the mean impurity × 100 of each variant beside the paper's (Fig. 26)."""
    place = np.arange(len(ours))
    width = 0.38 if paper else 0.6
    shift = width / 2 if paper else 0.0
    bars = ax.bar(place - shift, list(ours.values()), width, color=OBSTACLE_BLUE, label="here")
    ax.bar_label(bars, fmt="%.1f", fontsize=7, padding=1)
    if paper:
        theirs = [paper.get(name, np.nan) for name in ours]
        known = np.isfinite(theirs)
        others = ax.bar(
            (place + shift)[known],
            np.asarray(theirs)[known],
            width,
            color="#C9CDD2",
            edgecolor=TRAVEL_GREY,
            linewidth=0.6,
            label="paper",
        )
        ax.bar_label(others, fmt="%.1f", fontsize=7, padding=1)
        ax.legend(fontsize=8, frameon=False)
    ax.set_xticks(place, list(ours), fontsize=8, rotation=20 if len(ours) > 4 else 0)
    ax.set_ylabel("mean impurity × 100", fontsize=8)
    _quiet_axes(ax)
    if title:
        ax.set_title(title, fontsize=9.5, color=INK)


def draw_impurity_surface(
    ax: Any,
    log2_c: ArrayLike,
    log2_gamma: ArrayLike,
    impurity: ArrayLike,
    *,
    limit: float = 0.15,
    other: tuple[float, float] | None = None,
    title: str | None = None,
) -> None:
    """Draw the mean impurity over the search grid of C and gamma (Figs. 13 and 14).

    Parameters
    ----------
    log2_c, log2_gamma : array, shape (a,), (b,)
        Evenly spaced grid values.
    impurity : array, shape (b, a)
        Mean impurity, 0 to 1; values above ``limit`` share the darkest colour.
    other : tuple of float, optional
        Somebody else's choice, log2 of C and gamma, marked by a cross.
    """
    c, gamma = np.asarray(log2_c, dtype=float), np.asarray(log2_gamma, dtype=float)
    values = 100.0 * np.asarray(impurity, dtype=float)
    half_c = 0.5 * (c[1] - c[0]) if len(c) > 1 else 0.5
    half_gamma = 0.5 * (gamma[1] - gamma[0]) if len(gamma) > 1 else 0.5
    picture = ax.imshow(
        values,
        origin="lower",
        extent=(c[0] - half_c, c[-1] + half_c, gamma[0] - half_gamma, gamma[-1] + half_gamma),
        cmap="YlOrBr",
        vmin=0.0,
        vmax=100.0 * limit,
        aspect="auto",
        gid="surface",
    )
    row, column = np.unravel_index(np.nanargmin(values), values.shape)
    ax.plot(c[column], gamma[row], "o", ms=10, mfc="none", mec=OBSTACLE_BLUE, mew=2, gid="best")
    if other is not None and c[0] <= other[0] <= c[-1] and gamma[0] <= other[1] <= gamma[-1]:
        ax.plot(*other, "x", ms=7, mec=INK, mew=1.6, gid="other")
    ax.set_xlabel("log₂ C", fontsize=9)
    ax.set_ylabel("log₂ γ", fontsize=9)
    _quiet_axes(ax)
    bar = ax.figure.colorbar(picture, ax=ax, extend="max", fraction=0.05, pad=0.02)
    bar.set_label("mean impurity × 100", fontsize=8)
    bar.ax.tick_params(labelsize=7, length=2)
    if title:
        ax.set_title(title, fontsize=9.5, color=INK)


def draw_room_counts(
    ax: Any, environment: Sequence[str], nodes: ArrayLike, rooms: ArrayLike
) -> None:
    """Draw the number of rooms over that of nodes, one mark per map (Fig. 15)."""
    n, m, names = np.asarray(nodes), np.asarray(rooms), np.asarray(environment)
    markers = "os^Dv<>pP*X"
    for index, name in enumerate(dict.fromkeys(environment)):
        inside = names == name
        ax.scatter(
            n[inside],
            m[inside],
            s=34,
            marker=markers[index % len(markers)],
            facecolors="none",
            edgecolors=_SERIES[index % len(_SERIES)],
            linewidths=1.3,
            label=name,
            gid="maps",
        )
    ax.set_xlabel("map nodes n", fontsize=9)
    ax.set_ylabel("rooms m", fontsize=9)
    ax.set_xlim(0, 1.06 * n.max(initial=1))
    ax.set_ylim(0, 1.08 * m.max(initial=1))
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    _quiet_axes(ax)
    ax.legend(fontsize=7.5, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))


def draw_border_share(
    ax: Any,
    values: NDArray[np.float64],
    is_border: NDArray[np.bool_],
    bins: NDArray[np.float64],
    *,
    name: str,
    mark: float,
) -> None:
    """Draw how many edges there are in each bin of a feature, and which share are borders.

    ``mark`` is a threshold, drawn dotted; bins of fewer than 20 edges have no share.
    """
    count, _ = np.histogram(values, bins)
    border, _ = np.histogram(values[is_border], bins)
    middle, width = (bins[1:] + bins[:-1]) / 2, np.diff(bins)
    ax.bar(middle, count, 0.92 * width, color="#C9CDD2", gid="edges")
    ax.set_xlabel(name, fontsize=9)
    ax.set_ylabel("edges", fontsize=9)
    _quiet_axes(ax)
    other = ax.twinx()
    enough = count >= 20
    share = 100.0 * border / np.maximum(count, 1)
    other.plot(middle[enough], share[enough], "-o", color=EDGE_RED, ms=3.5, lw=1.4, gid="share")
    other.set_ylim(bottom=0)
    other.set_ylabel("border edges, %", fontsize=9, color=EDGE_RED)
    other.spines[["top", "left"]].set_visible(False)
    other.tick_params(labelsize=8, length=2.5, width=0.6, colors=EDGE_RED)
    ax.axvline(mark, color=INK, ls=":", lw=1.0)


def draw_lines(
    ax: Any, x: Sequence[float], lines: Mapping[str, Sequence[float]], names: tuple[str, str]
) -> None:
    """Draw one line with marks for each name; ``names`` are those of the axes."""
    markers = "os^Dv<>p"
    for index, (label, values) in enumerate(lines.items()):
        colour, marker = _SERIES[index % len(_SERIES)], markers[index % len(markers)]
        ax.plot(x, values, marker=marker, ms=4, lw=1.3, color=colour, label=label, gid="line")
    ax.set_xlabel(names[0], fontsize=9)
    ax.set_ylabel(names[1], fontsize=9)
    _quiet_axes(ax)
    ax.legend(fontsize=7.5, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
