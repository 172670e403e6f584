"""Eight laser beams seen by the camera: sparse, short, noisy ranges (§2.2.2).

What the paper says: eight diodes on the chassis, found by the camera, detection
up to 1 m, low refresh rate, sparse incorrect measurements. What it leaves open:
bearings (here every 45°, the first ahead), rate, noise, drop-outs and false
ranges. A camera triangulates the spot, so the error grows with the square of
the range. A missing spot cannot be told from a spot out of range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled

__all__ = ["SensorSpec", "cast_beams", "measure"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SensorSpec:
    """Laser settings; SI units.

    Attributes
    ----------
    beams : int
        Evenly spaced bearings, the first one straight ahead.
    maximum_range : float
        From the robot's centre, m.
    period : float
        Time between two measurements, s.
    range_noise, range_noise_quadratic : float
        Standard deviation a + b·range², m.
    dropout, dropout_far : float
        Share of measurements that are missing (dark, shiny or sunlit
        surfaces), right at the robot and at the maximum range; it grows with
        the square of the range, as a spot's brightness falls with it.
    false_rate : float
        Share of measurements with a wrong, uniformly distributed range.
    bumper_noise : float
        Error of the contact's bearing, rad.
    """

    beams: int = 8
    maximum_range: float = 1.0
    period: float = 0.5
    range_noise: float = 0.004
    range_noise_quadratic: float = 0.012
    dropout: float = 0.2
    dropout_far: float = 1.0
    false_rate: float = 0.003
    bumper_noise: float = 0.15

    def __post_init__(self) -> None:
        if not 1 <= self.beams <= 255:
            raise ValueError(f"beams: {self.beams}, expected 1..255")
        for name in ("maximum_range", "period"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name}: {getattr(self, name)}, expected > 0")
        for name in ("dropout", "dropout_far", "false_rate"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name}: {getattr(self, name)}, expected 0..1")
        for name in ("range_noise", "range_noise_quadratic", "bumper_noise"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name}: {getattr(self, name)}, expected >= 0")

    def bearings(self) -> Floats:
        """Beam bearings from the robot's heading, rad, shape (beams,)."""
        return np.arange(self.beams) * (2.0 * np.pi / self.beams)


@compiled
def cast_beams(origin: Floats, angles: Floats, walls: Floats) -> Floats:
    """Distance to the nearest wall along each beam.

    Solves origin + t d = a + u (b - a) for every beam and wall; a hit has
    t >= 0 and 0 <= u <= 1. Beams parallel to a wall do not hit it: its end
    points belong to other walls too.

    Parameters
    ----------
    origin : array, shape (2,)
        m.
    angles : array, shape (n,)
        Absolute beam directions, rad.
    walls : array, shape (w, 2, 2)
        End points, m.

    Returns
    -------
    array, shape (n,)
        m; ``inf`` where nothing is hit.
    """
    ranges = np.full(len(angles), np.inf)
    for k in range(len(angles)):
        beam_x, beam_y = math.cos(angles[k]), math.sin(angles[k])
        for w in range(len(walls)):
            along_x = walls[w, 1, 0] - walls[w, 0, 0]
            along_y = walls[w, 1, 1] - walls[w, 0, 1]
            determinant = beam_x * along_y - beam_y * along_x
            if determinant != 0.0:
                off_x, off_y = walls[w, 0, 0] - origin[0], walls[w, 0, 1] - origin[1]
                t = (off_x * along_y - off_y * along_x) / determinant
                u = (off_x * beam_y - off_y * beam_x) / determinant
                if t >= 0.0 and -1e-12 <= u <= 1.0 + 1e-12:
                    ranges[k] = min(ranges[k], t)
    return ranges


def measure(true_range: Floats, spec: SensorSpec, rng: np.random.Generator) -> Floats:
    """What the camera makes of the beams: noise, drop-outs, false ranges.

    Parameters
    ----------
    true_range : array, shape (beams,)
        m; ``inf`` or beyond the maximum range: nothing to see.

    Returns
    -------
    array, shape (beams,)
        Measured range, m; ``nan`` where no spot was found.
    """
    n = len(true_range)
    noise = rng.standard_normal(n)
    chance = rng.random((2, n))
    wrong = rng.uniform(0.15, 1.0, n) * spec.maximum_range
    near = np.minimum(true_range, spec.maximum_range)
    measured = near + noise * (spec.range_noise + spec.range_noise_quadratic * near**2)
    missing = spec.dropout + (spec.dropout_far - spec.dropout) * (near / spec.maximum_range) ** 2
    seen = (true_range <= spec.maximum_range) & (chance[0] >= missing)
    measured = np.where(seen & (measured <= spec.maximum_range), measured, np.nan)
    return np.where(chance[1] < spec.false_rate, wrong, measured)
