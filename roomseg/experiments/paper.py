"""The paper's numbers, table by table, and the ranges within which we call ours alike.

A range around a statistic of the maps asks whether the simulated world is like the paper's; a
feature that tells borders far better than the paper's is outside, too. A range of a quality asks
whether ours is as good or better.
"""

from __future__ import annotations

from math import inf

__all__ = [
    "BEST_PARAMETERS",
    "CLASS_RATIO",
    "ENVIRONMENTS",
    "FINEST_SEARCH",
    "FULL_SEARCH",
    "IMPURITY",
    "MAPS_RIGHT",
    "NOVEL_MAPS_RIGHT",
    "ROOM_COUNT",
    "SINGLE_FEATURES",
    "TABLE_1",
    "VARIANTS",
    "WIDTH",
    "WRONG_BORDERS_IN_NEW_RUNS",
]

Band = tuple[float, float]

TABLE_1: dict[str, tuple[float, Band | None]] = {
    "P(short)": (0.498, (0.45, 0.55)),
    "P(border)": (0.026, (0.020, 0.033)),
    "P(border | short)": (0.008, (0.004, 0.014)),
    "P(border | long)": (0.043, (0.033, 0.055)),
}
CLASS_RATIO = (38.0, (30.0, 50.0))
"""Within-room edges for each border edge (§2.3.2)."""

WIDTH = {
    "missing": (0.47, (0.37, 0.57)),
    "largest": (4.4, (3.5, 5.0)),
    "border_given_narrow": (0.005, (0.0, 0.015)),
}
"""Edges without L, the largest L in m, P(border | L < 0.5 m) (§2.2.2)."""

SINGLE_FEATURES: dict[str, tuple[float, Band, float]] = {
    "length": (0.71, (0.65, 0.77), 0.35),
    "passageway_width": (0.78, (0.70, 0.86), 0.56),
    "passageway": (0.87, (0.80, 0.94), 0.61),
    "d_c": (0.77, (0.69, 0.85), 0.40),
    "d_s": (0.66, (0.58, 0.74), 0.29),
}
"""Area under the ROC curve, accepted range, Youden's J (Table 3)."""

BEST_PARAMETERS: tuple[float, float, float, float] = (-3.0, -3.0, 40.0, 60.0)
"""log₂ C, log₂ γ, w, ρ (Table 6)."""

FULL_SEARCH = (
    (-3, -3, 40, 60, 3.13, 1.04),
    (-3, -3, 40, 80, 3.15, 1.12),
    (-3, -3, 40, 100, 3.55, 1.12),
    (-3, -3, 40, 120, 3.55, 1.12),
    (3, -11, 60, 60, 3.72, 1.30),
    (9, -13, 60, 60, 3.73, 1.37),
    (7, -13, 60, 60, 3.74, 1.30),
    (5, -11, 60, 60, 3.74, 1.37),
    (9, -13, 40, 60, 3.75, 1.63),
    (9, -13, 40, 80, 3.76, 1.63),
)
"""Rows of Table 5: log₂ C, log₂ γ, w, ρ, mean and median impurity × 100."""

FINEST_SEARCH = (
    (-3.0, -3.0, 40, 60, 3.13, 1.04),
    (-3.0, -3.0, 40, 70, 3.13, 1.04),
    (-3.0, -3.0, 40, 50, 3.19, 1.37),
    (-2.0, -3.5, 40, 50, 3.35, 1.65),
    (-2.5, -3.5, 40, 60, 3.50, 1.04),
)
"""Rows of Table 6, as those of Table 5."""

IMPURITY = ((3.13, (-inf, 3.13)), (1.04, (-inf, 1.04)))
"""Mean and median impurity × 100 with all features (Table 6), and what would be as good."""

MAPS_RIGHT = {"sim1": 0, "sim2": 3, "sim3": 3, "sim5": 3, "real1": 5, "real2": 4, "real3": 3}
"""Maps that are nearly identical to the ground truth (§3.2, §4.1); of Sim4's it is not said."""

ROOM_COUNT = {
    "Map-node regression": (0.68, 0.42, 0.90),
    "Eigenvalue gap": (0.77, 0.45, 0.81),
}
"""Mean |e|, share of maps with e = 0, with |e| ≤ 1 (Table 7)."""

ENVIRONMENTS: dict[str, tuple[int, float, int]] = {
    "sim1": (3, 2806, 9),
    "sim2": (3, 1988, 9),
    "sim3": (3, 787, 5),
    "sim4": (3, 783, 5),
    "sim5": (3, 1688, 7),
    "real1": (5, 656, 3),
    "real2": (8, 760, 4),
    "real3": (3, 649, 2),
}
"""Maps, mean number of map nodes, rooms of each environment (Table 8)."""

VARIANTS: dict[str, tuple[float | None, float | None, float | None, float | None, float, float]] = {
    "default": (-3, -3, 40, 60, 3.13, 1.04),
    "uniform": (None, None, None, None, 12.91, 15.46),
    "no-camera": (-1, -3, 40, 5, 10.87, 9.67),
    "no-pano": (5, -13, 40, 100, 3.76, 1.07),
    "no-ceiling": (15, -13, 40, 60, 3.89, 1.37),
    "no-obst": (-5, -3, 40, 80, 3.69, 1.21),
}
"""Rows of Table 10, as those of Table 5."""

WRONG_BORDERS_IN_NEW_RUNS = {"sim1": 1, "sim2": 0, "sim3": 0, "sim4": 1, "sim5": 0}
"""Room borders that were placed wrong in the new runs (§3.4)."""

NOVEL_MAPS_RIGHT = (2, 5)
"""Maps of the additional place without a missed border, and how many there were (§3.4)."""
