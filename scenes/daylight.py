"""Sun and sky at a time of day: the angles and strengths that `Lighting` wants.

The sun's place follows from latitude, day and solar time (declination by the cosine
of the year, good to half a degree); +y is north. Its light is dimmed by the air it
passes, 0.7^(m^0.678) after Meinel for the air mass m of Kasten and Young. The sky
has `Lighting`'s usual strength when the sun is 35° high and follows the sun's height;
below the horizon it falls by a factor of 10 for every 3°, as in civil twilight, and the
sun is gone.
"""

from __future__ import annotations

import math

from scenes.apartment import Lighting

__all__ = ["daylight", "sun_angles"]

TILT_DEG = 23.44
"""Tilt of the earth's axis."""
SOLSTICE = 355
"""Day of the year on which the sun stands lowest."""
USUAL_HEIGHT_DEG = 35.0
"""Height of the sun at which sun and sky have their usual strengths."""
TWILIGHT_DEG = 3.0
"""Every so much below the horizon the sky is ten times darker."""


def sun_angles(hour: float, day_of_year: int, latitude_deg: float) -> tuple[float, float]:
    """Elevation and azimuth of the sun, degrees, the azimuth counter-clockwise from +x (east).

    Parameters
    ----------
    hour : float
        Solar time, 0..24; the sun is in the south at 12.
    day_of_year : int
        1..366.
    latitude_deg : float
        North is positive.
    """
    year = 2.0 * math.pi * (day_of_year - SOLSTICE) / 365.25
    declination = math.radians(-TILT_DEG * math.cos(year))
    latitude, turn = math.radians(latitude_deg), math.radians(15.0 * (hour - 12.0))
    east = -math.cos(declination) * math.sin(turn)
    north = math.cos(latitude) * math.sin(declination)
    north -= math.sin(latitude) * math.cos(declination) * math.cos(turn)
    up = math.sin(latitude) * math.sin(declination)
    up += math.cos(latitude) * math.cos(declination) * math.cos(turn)
    elevation = math.degrees(math.asin(max(-1.0, min(1.0, up))))
    return elevation, math.degrees(math.atan2(north, east))


def daylight(
    hour: float, *, day_of_year: int = 80, latitude_deg: float = 50.0, base: Lighting | None = None
) -> Lighting:
    """The light at a time of day; ``base`` says the rest and what is usual (default: `Lighting`).

    Parameters
    ----------
    hour, day_of_year, latitude_deg
        As `sun_angles`; by default an equinox in central Europe.
    base : Lighting, optional
        Its source is kept, its strengths are those of a sun at 35°.
    """
    base = base or Lighting()
    elevation, azimuth = sun_angles(hour, day_of_year, latitude_deg)
    sun = _transmission(elevation) / _transmission(USUAL_HEIGHT_DEG)
    sky = _sky(elevation) / _sky(USUAL_HEIGHT_DEG)
    return base.model_copy(
        update={
            "sun_elevation_deg": round(elevation, 1),
            "sun_azimuth_deg": round(azimuth, 1),
            "sun_strength": round(min(100.0, base.sun_strength * sun), 3),
            "sky_strength": round(min(100.0, base.sky_strength * sky), 4),
        }
    )


def _transmission(elevation_deg: float) -> float:
    """Share of the sun's light that passes the air; 0 below the horizon."""
    if elevation_deg <= 0.0:
        return 0.0
    slant = 0.50572 * (elevation_deg + 6.07995) ** -1.6364
    mass = 1.0 / (math.sin(math.radians(elevation_deg)) + slant)
    return float(0.7 ** (mass**0.678))


def _sky(elevation_deg: float) -> float:
    """Brightness of the sky: with the sun's height by day, falling off in twilight."""
    horizon = 0.05
    if elevation_deg <= 0.0:
        return float(horizon * 10.0 ** (elevation_deg / TWILIGHT_DEG))
    return horizon + math.sin(math.radians(elevation_deg))
