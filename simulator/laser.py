"""Laser beams seen by the camera: sparse, short, noisy ranges (§2.2.2).

What the paper says: eight diodes on the chassis, found by the camera, detection
up to 1 m, low refresh rate, sparse incorrect measurements. What it leaves open:
bearings (here every 45°, the first ahead), height, rate, noise, drop-outs and
false ranges.

The camera triangulates the spot, so the error grows with the square of the range;
on a slanted surface the spot is smeared along the beam, which adds with the tangent
of the incidence. The camera's light from a spot goes with the surface's reflectance
(in the lasers' red), the cosine of the incidence, and one over the range squared:
far, dark and grazed surfaces are missed. A missing spot cannot be told from a spot
out of range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.trigonometry import sine_cosine

__all__ = ["Look", "SensorSpec", "Spots", "cast_beams", "measure"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SensorSpec:
    """Settings of the lasers, the bumper and the camera; SI units.

    Attributes
    ----------
    beams : int
        Evenly spaced bearings, the first one straight ahead.
    bearings_deg : tuple of float, optional
        Bearings of the beams instead, degrees counter-clockwise from ahead.
    height : float
        Of the beams above the floor, m: what is lower or hangs higher is not seen.
    maximum_range : float
        From the robot's centre, m; at most 20.
    period : float
        Time between two measurements, s.
    range_noise, range_noise_quadratic : float
        Standard deviation a + b·range² at a surface that is hit squarely, m.
    range_noise_slant : float
        What is added to it for each unit of the incidence's tangent, m.
    dropout : float
        Share of the spots that are missed whatever their brightness (sunlight,
        motion blur).
    least_reflectance : float
        A surface of this reflectance, hit squarely at the maximum range, is just
        too dark to be seen, and so is a brighter one that is hit at a slant. The
        share of missed spots grows evenly with the range squared up to there.
    false_rate : float
        Share of measurements with a wrong, uniformly distributed range.
    bumper_noise : float
        Error of the contact's bearing, rad.
    camera_height : float
        Of the lens above the floor, m; the images are rendered from there.
    """

    beams: int = 8
    bearings_deg: tuple[float, ...] | None = None
    height: float = 0.08
    maximum_range: float = 1.0
    period: float = 0.5
    range_noise: float = 0.003
    range_noise_quadratic: float = 0.012
    range_noise_slant: float = 0.002
    dropout: float = 0.2
    least_reflectance: float = 0.4
    false_rate: float = 0.003
    bumper_noise: float = 0.15
    camera_height: float = 0.10

    def __post_init__(self) -> None:
        if not 1 <= self.beams <= 255:
            raise ValueError(f"beams: {self.beams}, expected 1..255")
        for name in ("maximum_range", "period", "least_reflectance", "camera_height"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: {getattr(self, name)}, expected > 0")
        for name in ("dropout", "false_rate"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name}: {getattr(self, name)}, expected 0..1")
        for name in _NOT_NEGATIVE:
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name}: {getattr(self, name)}, expected >= 0")
        if self.maximum_range > _FARTHEST:
            raise ValueError(
                f"maximum_range: {self.maximum_range}, expected at most {_FARTHEST:g} m"
            )
        if self.bearings_deg is not None:
            self._check_bearings(self.bearings_deg)

    def _check_bearings(self, bearings: tuple[float, ...]) -> None:
        if len(bearings) != self.beams:
            raise ValueError(
                f"bearings_deg: {len(bearings)} bearings, expected beams = {self.beams}"
            )
        if not np.isfinite(bearings).all():
            raise ValueError(f"bearings_deg: {bearings}, expected finite angles")

    def bearings(self) -> Floats:
        """Beam bearings from the robot's heading, rad, shape (beams,)."""
        if self.bearings_deg is not None:
            return np.radians(np.array(self.bearings_deg, dtype=np.float64))
        return np.arange(self.beams) * (2.0 * np.pi / self.beams)

    def look(self) -> Look:
        """The settings that make a measurement."""
        return Look(*(float(getattr(self, name)) for name in Look._fields))


_FARTHEST = 20.0
"""Memory and time grow with the square of the range, m."""

_NOT_NEGATIVE = (
    "height",
    "range_noise",
    "range_noise_quadratic",
    "range_noise_slant",
    "bumper_noise",
)


class Spots(NamedTuple):
    """What the beams hit, shape (n,) each.

    ``range`` m (``inf``: nothing), ``cosine`` of the incidence, ``reflectance`` of the surface.
    """

    range: Floats
    cosine: Floats
    reflectance: Floats


@compiled
def cast_beams(
    origin: Floats, angles: Floats, walls: Floats, reflectance: Floats
) -> tuple[Floats, Floats, Floats]:
    """Distance to the nearest wall along each beam, and how it is hit.

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
    reflectance : array, shape (w,)
        Of the walls, 0..1.

    Returns
    -------
    range, cosine, reflectance : array, shape (n,)
        m; ``inf``, 1 and 1 where nothing is hit.
    """
    ranges, cosine, seen = np.full(len(angles), np.inf), np.ones(len(angles)), np.ones(len(angles))
    for k in range(len(angles)):
        beam_y, beam_x = sine_cosine(angles[k])
        for w in range(len(walls)):
            along_x = walls[w, 1, 0] - walls[w, 0, 0]
            along_y = walls[w, 1, 1] - walls[w, 0, 1]
            determinant = beam_x * along_y - beam_y * along_x
            if determinant != 0.0:
                off_x, off_y = walls[w, 0, 0] - origin[0], walls[w, 0, 1] - origin[1]
                t = (off_x * along_y - off_y * along_x) / determinant
                u = (off_x * beam_y - off_y * beam_x) / determinant
                if 0.0 <= t < ranges[k] and -1e-12 <= u <= 1.0 + 1e-12:
                    ranges[k] = t
                    cosine[k] = abs(determinant) / math.sqrt(along_x * along_x + along_y * along_y)
                    seen[k] = reflectance[w]
    return ranges, cosine, seen


class Look(NamedTuple):
    """The settings of `SensorSpec` that make a measurement."""

    maximum_range: float
    range_noise: float
    range_noise_quadratic: float
    range_noise_slant: float
    dropout: float
    least_reflectance: float
    false_rate: float


@compiled
def measure(spots: Spots, look: Look, rng: np.random.Generator) -> Floats:
    """What the camera makes of the beams: noise, drop-outs, false ranges.

    Parameters
    ----------
    spots : Spots
        Of all beams; a range of ``inf`` or beyond the maximum: nothing to see.

    Returns
    -------
    array, shape (beams,)
        Measured range, m; ``nan`` where no spot was found.
    """
    n = len(spots.range)
    noise, chance = rng.standard_normal(n), rng.random((3, n))
    measured = np.full(n, np.nan)
    for k in range(n):
        true, cosine = spots.range[k], max(spots.cosine[k], 0.05)
        if true <= look.maximum_range:
            spread = look.range_noise + look.range_noise_quadratic * true * true
            spread += look.range_noise_slant * math.sqrt(1.0 / (cosine * cosine) - 1.0)
            # 1 where a spot is as dim as can be: on the least reflectance, squarely, at the limit.
            share = true / look.maximum_range
            dimness = look.least_reflectance * share * share
            dimness /= cosine * max(spots.reflectance[k], 1e-3)
            distance = true + noise[k] * spread
            seen = chance[0, k] < (1.0 - look.dropout) * (1.0 - dimness)
            if seen and distance <= look.maximum_range:
                measured[k] = distance
        if chance[1, k] < look.false_rate:
            measured[k] = (0.15 + 0.85 * chance[2, k]) * look.maximum_range
    return measured
