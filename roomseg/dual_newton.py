"""Solving a C-SVM (Eqs. 12-14) by a semismooth Newton method.

The hinge loss C max(0, s), s = 1 - y (f + b), is smoothed by what an augmented
Lagrangian of its dual makes of it: with multipliers α and a width δ,

    p = min(max(α + s C / δ, 0), C)

is both the loss's slope and the next multiplier. Only rows with 0 < p < C, the band, have
curvature: that is a few hundred of tens of thousands. So a Newton step solves a small
system, whatever the number of bounded support vectors, and a step along it is exact.
The multipliers become the solution of the dual; since their change is divided by C / δ,
the Karush-Kuhn-Tucker conditions are met to within δ after the first pass, and to
any accuracy after some more.

Where f lives is left to a `Space`: functions that a low-rank factor of the kernel spans,
or all that the kernel spans. Rows that are far from the band are left out of the Newton
steps; afterwards all rows are looked at, and if one should have moved, it goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from typing import Protocol, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

__all__ = [
    "Direction",
    "DualPoint",
    "Space",
    "kkt_violations",
    "newton_target",
    "relative_gap",
    "solve",
]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

WIDTHS = (0.3, 0.03, 0.003, 0.0003)
PASSES = 12
"""Changes of the multipliers at most; three or four are usual."""
ROUNDS, STEPS = 40, 200
"""Looks at all rows, and Newton steps, at most, for one set of multipliers."""
REACH = 0.1
"""Rows farther than this from a later band are left out of its first steps."""
FARTHEST = 1e6
"""A step's change of f; b alone has no bound if the active rows cannot balance the others."""
RIDGE = 1e-9
"""Keeps b determined where no row is in the band."""


@dataclass(frozen=True)
class DualPoint:
    """A point of the dual, and how good it is.

    Attributes
    ----------
    alpha : array, shape (n,)
    bias : float
        b.
    violation : float
        The largest violation of a Karush-Kuhn-Tucker condition: how far a row's
        y (f + b) is on the wrong side of 1 for its α. libsvm stops at 1e-3.
    gap : float
        Primal less dual objective, over the primal one.
    steps : int
        Newton steps taken.
    """

    alpha: Floats
    bias: float
    violation: float
    gap: float
    steps: int


@dataclass(frozen=True)
class Direction:
    """Where a Newton step leads: f + t values, b + t bias.

    ``slope`` and ``curvature`` are those of |w|² / 2 and of the rows left out along it;
    ``multipliers`` are those of the active rows at t = 1, and ``coefficients`` are the
    space's own.
    """

    values: Floats
    bias: float
    slope: float
    curvature: float
    multipliers: Floats
    coefficients: Floats


class Space(Protocol):
    """Functions f of the rows, and how to move among them."""

    @property
    def values(self) -> Floats:
        """Values f of every row, shape (n,)."""

    def restrict(self, active: Integers, p: Floats) -> Floats:
        """Move only these rows from now on; their f, shape (a,). p: all rows' slopes."""

    def direction(self, p: Floats, band: Integers, pull: Floats, pushed: Floats) -> Direction:
        """Newton direction, see `newton_target`.

        Parameters
        ----------
        p : array, shape (a,)
            Slopes of the active rows' losses.
        band : array, shape (m,)
            Which of them have curvature.
        pull, pushed : arrays, shape (m,)
            Their curvature C / δ, and α δ / C + 1 - y b.
        """

    def move(self, direction: Direction, t: float) -> None:
        """Go t along it."""

    def release(self) -> None:
        """Bring f of all rows up to date."""

    def assign(self, alpha: Floats) -> None:
        """Make f = Σ α y K, of all rows; ``alpha`` differs in active rows only."""


def newton_target(
    kernel: Floats, y: Floats, weight: Floats, pushed: Floats, balance: float
) -> tuple[Floats, float]:
    """Solve for the band's multipliers β and for the change of b, here b.

    β / weight + y (K (y β)) + y b = pushed, and Σ y β + balance = `RIDGE` b.

    Parameters
    ----------
    kernel : array, shape (m, m)
        Is overwritten.
    y, weight, pushed : arrays, shape (m,)
    balance : float
        Σ y p of all other rows.

    Returns
    -------
    beta : array, shape (m,)
    bias : float
    """
    kernel *= y[:, None] * y
    kernel[np.diag_indices(len(y))] += 1.0 / weight
    sides = np.stack([pushed, y], axis=1)
    if len(y):
        factor = linalg.cho_factor(kernel, overwrite_a=True, check_finite=False)
        sides = linalg.cho_solve(factor, sides, check_finite=False)
    # Without a band b is undetermined: any step to the right side will do, its length is sought.
    ridge = RIDGE if len(y) else max(abs(balance), RIDGE)
    bias = float((balance + y @ sides[:, 0]) / (y @ sides[:, 1] + ridge))
    return sides[:, 0] - bias * sides[:, 1], bias


def _compiled(function: Function) -> Function:
    """Compile with numba on first use; the machine code is kept for the next run."""
    return cast(Function, numba.njit(cache=True)(function))


@_compiled
def _project(alpha: Floats, pull: Floats, cost: Floats, margin: Floats) -> Floats:
    """Slope p of each row; margin = y (f + b)."""
    p = np.empty(len(alpha))
    for i in range(len(alpha)):
        p[i] = min(max(alpha[i] + pull[i] * (1.0 - margin[i]), 0.0), cost[i])
    return p


@_compiled
def _derivatives(
    alpha: Floats, pull: Floats, cost: Floats, margin: Floats, change: Floats, t: float
) -> tuple[float, float]:
    """First and second derivative of the smoothed losses at margin + t change."""
    first, second = 0.0, 0.0
    for i in range(len(alpha)):
        u = alpha[i] + pull[i] * (1.0 - margin[i] - t * change[i])
        if u >= cost[i]:
            first -= cost[i] * change[i]
        elif u > 0.0:
            first -= u * change[i]
            second += pull[i] * change[i] ** 2
    return first, second


def solve(
    space: Space,
    y: Floats,
    cost: Floats,
    start: DualPoint,
    tolerance: float,
    widths: Sequence[float] = WIDTHS,
    reach: float = REACH,
) -> DualPoint:
    """Find the multipliers of a C-SVM.

    Parameters
    ----------
    space : Space
        With f of the start.
    y : array, shape (n,)
        1 or -1.
    cost : array, shape (n,)
        The upper bound C of each row's multiplier.
    start : DualPoint
        Its ``alpha`` lies between 0 and ``cost``.
    tolerance : float
        For `DualPoint.violation`.
    widths : sequence of float
        δ, in turn; the last one is used until the tolerance is met.
    reach : float
        From the second width on, rows farther from the band are left out of the first steps.

    Returns
    -------
    DualPoint
        Its ``violation`` may be above the tolerance if that was not reached.
    """
    alpha, bias, steps, violation, far = start.alpha, start.bias, 0, np.inf, np.inf
    for width in chain(widths, repeat(widths[-1], PASSES)):
        alpha, bias, taken = _smoothed(space, y, cost, alpha, bias, width, far, tolerance)
        far = max(reach, 3.0 * width)
        steps += taken
        margin = y * (space.values + bias)
        violation = float(kkt_violations(alpha, cost, margin).max(initial=0.0))
        if violation <= tolerance:
            break
    return DualPoint(
        alpha, bias, violation, relative_gap(space.values, y, cost, alpha, bias), steps
    )


def _smoothed(
    space: Space,
    y: Floats,
    cost: Floats,
    alpha: Floats,
    bias: float,
    width: float,
    reach: float,
    tolerance: float,
) -> tuple[Floats, float, int]:
    """Minimise the objective smoothed with a width: next α, b, and the steps taken."""
    pull, steps = cost / width, 0
    p = _project(alpha, pull, cost, y * (space.values + bias))
    for _ in range(ROUNDS):
        if not ((p > 0.0) & (p < cost)).any():
            reach = np.inf
        place = alpha / pull + 1.0 - y * (space.values + bias)
        active = np.flatnonzero((place > -reach) & (place < width + reach))
        rows = _Rows(alpha[active], pull[active], cost[active], y[active])
        f, moved, found = space.restrict(active, p), 0.0, None
        while found is None and moved < 0.999 * reach and steps < STEPS:
            f, bias, last, found = _newton_step(space, rows, f, bias, reach - moved, tolerance)
            steps, moved = steps + 1, moved + last
        if found is None:
            space.release()
            p, reach = _project(alpha, pull, cost, y * (space.values + bias)), 4.0 * reach
            continue
        p[active] = found
        space.assign(p)
        following = _project(alpha, pull, cost, y * (space.values + bias))
        if not np.delete(following != p, active).any():
            break
        elsewhere = np.ones(len(y), bool)
        elsewhere[active] = False
        p = np.where(elsewhere, following, p)
    return p, bias, steps


@dataclass(frozen=True)
class _Rows:
    """What the smoothed loss of the active rows is made of; all of shape (a,)."""

    alpha: Floats
    pull: Floats
    cost: Floats
    y: Floats

    def project(self, f: Floats) -> Floats:
        """p; f with b."""
        p: Floats = _project(self.alpha, self.pull, self.cost, self.y * f)
        return p

    def piece(self, p: Floats) -> NDArray[np.int8]:
        """Whether p is at its lower bound (-1), at its upper one (1), or between (0)."""
        return (p >= self.cost).astype(np.int8) - (p <= 0.0)


def _newton_step(
    space: Space, rows: _Rows, f: Floats, bias: float, most: float, tolerance: float
) -> tuple[Floats, float, float, Floats | None]:
    """One Newton step with line search: f and b after it, how far f went; p at a minimum.

    f goes no farther than ``most``: the rows that are left out are settled only so far.
    The objective is piecewise quadratic, so a whole step within one piece ends in its minimum.
    There p is the direction's: computed from f, its rounding errors would be C / δ times f's.
    """
    p = rows.project(f + bias)
    piece = rows.piece(p)
    band = np.flatnonzero(piece == 0)
    pull = rows.pull[band]
    pushed = rows.alpha[band] / pull + 1.0 - rows.y[band] * bias
    direction = space.direction(p, band, pull, pushed)
    change = rows.y * (direction.values + direction.bias)
    speed = float(np.abs(change).max(initial=0.0))
    t = _step_length(rows, rows.y * (f + bias), change, direction)
    t = min(t, min(most, FARTHEST) / speed) if speed > 0.0 else t
    space.move(direction, t)
    f, bias = f + t * direction.values, bias + t * direction.bias
    stays = (rows.piece(rows.project(f + bias)) == piece).all()
    found = len(band) > 0 and ((t == 1.0 and stays) or t * speed <= 1e-3 * tolerance)
    return f, bias, t * speed, np.clip(direction.multipliers, 0.0, rows.cost) if found else None


def _step_length(rows: _Rows, margin: Floats, change: Floats, direction: Direction) -> float:
    """Where the convex, piecewise quadratic objective is least along a direction."""
    t, low, high = 1.0, 0.0, np.inf
    for _ in range(100):
        first, second = _derivatives(rows.alpha, rows.pull, rows.cost, margin, change, t)
        first += direction.slope + t * direction.curvature
        second += direction.curvature
        low, high = (low, t) if first > 0.0 else (t, high)
        best = t - first / second if second > 0.0 else np.inf
        if not low <= best <= high:
            best = 0.5 * (low + high) if np.isfinite(high) else 2.0 * t
        if abs(best - t) <= 1e-3 * t:
            return 1.0 if abs(best - 1.0) <= 1e-3 else best
        t = best
    return t


def kkt_violations(alpha: Floats, cost: Floats, margin: Floats) -> Floats:
    """How much each row violates the Karush-Kuhn-Tucker conditions; margin = y (f + b)."""
    lacking = 1.0 - margin
    wrong = np.where(alpha > 0.0, np.maximum(-lacking, 0.0), 0.0)
    return np.maximum(wrong, np.where(alpha < cost, np.maximum(lacking, 0.0), 0.0))


def relative_gap(f: Floats, y: Floats, cost: Floats, alpha: Floats, bias: float) -> float:
    """Relative duality gap; f = Σ α y K."""
    square = float((alpha * y) @ f)
    primal = 0.5 * square + float(cost @ np.maximum(0.0, 1.0 - y * (f + bias)))
    dual = float(alpha.sum()) - 0.5 * square - bias * float(alpha @ y)
    return (primal - dual) / primal if primal > 0.0 else 0.0
