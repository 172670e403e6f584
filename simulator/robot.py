"""The robot: size, settings, diff-drive kinematics and wheel odometry (§2, §2.1).

What the paper says: radius about 15 cm, height about 10 cm, two separately
driven wheels; nodes about 10 cm apart on lanes about 30 cm apart; the position
estimate is locally consistent and drifts globally. What it leaves open, and is
therefore a setting here: speed, turning, odometry noise, how near two nodes
must be to be joined, when a lane or a part ends.

Each wheel turns by what was commanded times (1 + slip); the encoders report
the commanded travel. So a constant slip bends the true track while the
estimate stays straight: the drift of a real wheel odometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.trigonometry import sine_cosine

__all__ = ["RobotSpec", "WheelSlip", "arc", "roll", "wheel_slip", "wrap"]

Floats = NDArray[np.float64]


_LARGEST = 0.3
"""The robot looks for obstacles on its grid so far around a place, m (`GridMap.clearance`)."""

_POSITIVE = (
    "radius",
    "height",
    "wheel_base",
    "castor",
    "speed",
    "turn_rate",
    "time_step",
    "slip_memory",
    "correction_period",
    "node_spacing",
)


@dataclass(frozen=True)
class RobotSpec:
    """Body, motion and strategy settings; SI units, rad.

    Attributes
    ----------
    radius, height : float
        Of the body, m (§2); a radius of at most 0.3.
    wheel_base, castor : float
        Distance between the wheels, and of the castor ahead of their axle, m.
    speed, turn_rate : float
        m/s and rad/s. Speed and laser rate together decide how many obstacle
        points fall within ε_τ of a node (Appendix A).
    time_step : float
        s; one step moves the body by 2 cm at most.
    slip_bias, slip_noise, slip_memory : float
        Standard deviation of each wheel's constant slip in a run and of its
        slowly varying slip (share of the travel), and the distance, m, over
        which the latter is correlated.
    correction_period, correction_radius : float
        How often, s, and to nodes how near, m, the position is corrected.
    correction_nodes : int
        The image is related to that many of the nearest nodes.
    correction_gain : float
        Share of the measured difference that is taken over, 0..1.
    correction_position_noise, correction_heading_noise : float
        Error of one relation of two images, m and rad.
    lane_spacing, node_spacing : float
        m (§2.2: about 0.30 and 0.10).
    edge_radius : float
        Nodes of different lanes at most this far apart are adjacent, m: two
        body radii plus a thin wall, so that nodes on either side of a wall are
        not joined, and well above the 0.316 m of the diagonal neighbour, which
        gives the tight diagonals of Fig. 4.
    edge_clearance : float
        A straight line is direct travel if no known obstacle is nearer to it, m: the
        radius but for what the map may be wrong by.
    cover_radius : float
        A position is covered if a node is this near, m.
    overlap_radius : float
        A lane ends where an older node is this near to what lies ahead, m.
    squeeze_spacing : float
        A last lane beside an obstacle is set this close to its neighbour, m.
    minimum_lane : float
        A meandering lane is not begun where less length is free, m.
    piercing_width : float
        A passage with less room for the robot's *centre* is narrow: it is
        entered by a piercing lane, m. 0.35 is a passage of 0.65 m.
    piercing_opening : float
        A piercing lane ends when the centre has so much room to either side, m.
    frontier_area, frontier_depth : float
        What is uncovered is worth a new part from this area, m², and from this
        depth beyond ``cover_radius``, m.
    visit_radius : float
        Passing a node this near counts as a revisit, m.
    caution, last_caution : float
        The centre is planned this much nearer to known obstacles than the
        radius, m: the map may place them a little too near. When nothing is
        left to cover, the last attempts are made with the second margin; the
        bumper has the last word.
    align_to_walls : bool
        Turn the first lane to the direction of the walls seen from the base.
    time_limit : float
        s of simulated time after which the run is given up as faulty.
    """

    radius: float = 0.15
    height: float = 0.10
    wheel_base: float = 0.22
    castor: float = 0.10
    speed: float = 0.16
    turn_rate: float = 1.2
    time_step: float = 0.125
    slip_bias: float = 0.0005
    slip_noise: float = 0.0025
    slip_memory: float = 0.5
    correction_period: float = 0.5
    correction_radius: float = 0.5
    correction_nodes: int = 4
    correction_gain: float = 0.3
    correction_position_noise: float = 0.02
    correction_heading_noise: float = 0.015
    lane_spacing: float = 0.30
    node_spacing: float = 0.10
    edge_radius: float = 0.40
    edge_clearance: float = 0.12
    cover_radius: float = 0.20
    overlap_radius: float = 0.20
    squeeze_spacing: float = 0.25
    minimum_lane: float = 0.35
    piercing_width: float = 0.35
    piercing_opening: float = 0.40
    frontier_area: float = 0.03
    frontier_depth: float = 0.05
    visit_radius: float = 0.03
    caution: float = 0.015
    last_caution: float = 0.04
    align_to_walls: bool = True
    time_limit: float = 300000.0

    def __post_init__(self) -> None:
        for setting in fields(self):
            value = getattr(self, setting.name)
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{setting.name}: {value}, expected a finite number >= 0")
        for name in _POSITIVE:
            if getattr(self, name) == 0:
                raise ValueError(f"{name}: 0, expected > 0")
        if self.radius > _LARGEST:
            raise ValueError(f"radius: {self.radius}, expected at most {_LARGEST:g} m")
        if self.correction_gain > 1:
            raise ValueError(f"correction_gain: {self.correction_gain}, expected 0..1")
        if min(self.squeeze_spacing, self.lane_spacing) < self.cover_radius + 0.05 - 1e-9:
            raise ValueError(
                f"squeeze_spacing, lane_spacing: {self.squeeze_spacing}, {self.lane_spacing} m, "
                f"expected at least cover_radius + 0.05 = {self.cover_radius + 0.05:g} m, "
                "so that a new lane covers new floor"
            )
        if self.speed * self.time_step > 0.0201:
            raise ValueError(
                f"speed * time_step: {self.speed * self.time_step:.3f} m, expected at most 0.02 m, "
                "so that contact is found before the body overlaps an obstacle"
            )


@compiled
def wrap(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def arc(pose: Floats, left: float, right: float, wheel_base: float) -> Floats:
    """Pose after the wheels have rolled ``left`` and ``right`` metres.

    The exact arc of a differential drive: the chord of length
    s·sin(δ/2)/(δ/2) points half way between the old and the new heading.

    Parameters
    ----------
    pose : array, shape (3,)
        x m, y m, heading rad.

    Returns
    -------
    array, shape (3,)
    """
    turn = (right - left) / wheel_base
    half = 0.5 * turn
    chord = 0.5 * (left + right) * (sine_cosine(half)[0] / half if abs(half) > 1e-9 else 1.0)
    sine, cosine = sine_cosine(pose[2] + half)
    x, y = pose[0] + chord * cosine, pose[1] + chord * sine
    return np.array([x, y, wrap(pose[2] + turn)])


class WheelSlip(NamedTuple):
    """Slip of both wheels: a constant of the run plus a slowly varying part.

    ``bias``, ``wander`` (2,): shares of the commanded travel, left and right; ``wander``
    changes in place. ``noise`` is its standard deviation, ``memory`` the travel, m, after
    which it is forgotten.
    """

    bias: Floats
    wander: Floats
    noise: float
    memory: float


def wheel_slip(spec: RobotSpec, rng: np.random.Generator) -> WheelSlip:
    """The slip of one run at its beginning."""
    bias = rng.normal(0.0, spec.slip_bias, 2)
    return WheelSlip(bias, np.zeros(2), spec.slip_noise, spec.slip_memory)


@compiled
def roll(
    slip: WheelSlip, left: float, right: float, rng: np.random.Generator
) -> tuple[float, float]:
    """True travel of both wheels, m, for the commanded travel, m."""
    share = max(abs(left), abs(right)) / slip.memory
    # exp(-share) by Padé: the library's differs in the last bit between processors.
    keep = (12.0 - share * (6.0 - share)) / (12.0 + share * (6.0 + share))
    spread = slip.noise * math.sqrt(1.0 - keep * keep)
    for wheel in range(2):
        slip.wander[wheel] = keep * slip.wander[wheel] + spread * rng.standard_normal()
    return (
        left * (1.0 + slip.bias[0] + slip.wander[0]),
        right * (1.0 + slip.bias[1] + slip.wander[1]),
    )
