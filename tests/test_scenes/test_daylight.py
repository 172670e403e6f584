"""Sun and sky by the hour, against the almanac."""

from __future__ import annotations

import pytest

from scenes.apartment import Lighting
from scenes.daylight import daylight, sun_angles

SOUTH, EAST, WEST = -90.0, 0.0, 180.0


@pytest.mark.parametrize(
    "hour, day, latitude, elevation, azimuth",
    [
        (12, 80, 50.0, 40.0, SOUTH),  # equinox: 90° less the latitude
        (12, 172, 50.0, 63.4, SOUTH),  # solstices: 23.4° more and less
        (12, 355, 50.0, 16.6, SOUTH),
        (6, 80, 50.0, 0.0, EAST),
        (18, 80, 50.0, 0.0, WEST),
        (12, 172, -30.0, 36.6, 90.0),  # in the south the sun is in the north
    ],
)
def test_sun_stands_where_the_almanac_says(hour, day, latitude, elevation, azimuth):
    found = sun_angles(hour, day, latitude)
    assert found[0] == pytest.approx(elevation, abs=0.5)
    assert (found[1] - azimuth + 180) % 360 - 180 == pytest.approx(0.0, abs=0.7)


@pytest.mark.parametrize("latitude, longest", [(0.0, 12.0), (40.0, 14.84), (50.0, 16.15)])
def test_midsummers_day_is_as_long_as_the_sunrise_equation_says(latitude, longest):
    for hour in (12.0 - longest / 2, 12.0 + longest / 2):
        assert sun_angles(hour, 172, latitude)[0] == pytest.approx(0.0, abs=0.1)


def test_light_rises_to_noon_and_is_gone_at_night():
    hours = [3, 5, 6.2, 8, 10, 12]
    lights = [daylight(hour) for hour in hours]
    skies = [light.sky_strength for light in lights]
    assert skies == sorted(skies) and skies[0] < 1e-3 * skies[-1]
    suns = [light.sun_strength for light in lights]
    assert suns[:2] == [0.0, 0.0] and suns[2:] == sorted(suns[2:])


def test_base_says_what_is_usual():
    base = Lighting(source="mixed", sun_strength=1.0, sky_strength=2.0)
    at = daylight(12, day_of_year=64, latitude_deg=48.0, base=base)
    assert at.sun_elevation_deg == pytest.approx(35.0, abs=0.3)
    assert (at.source, at.sun_strength, at.sky_strength) == (
        "mixed",
        pytest.approx(1.0, abs=0.02),
        pytest.approx(2.0, abs=0.06),
    )
