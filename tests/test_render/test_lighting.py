"""Windows and lamps."""

from __future__ import annotations

import numpy as np
import pytest
from probe import boxed_room

from render.lighting import lamp_radiance, window_frame
from scenes.apartment import Window


@pytest.mark.parametrize(
    ("position", "middle", "inward"),
    [
        ((0.0, 2.1), (0.0, 2.21), (0.0, -1.0)),
        ((0.0, -2.1), (0.0, -2.21), (0.0, 1.0)),
        ((2.1, 0.5), (2.21, 0.5), (-1.0, 0.0)),
        ((-2.1, 0.5), (-2.21, 0.5), (1.0, 0.0)),
    ],
)
def test_a_window_light_lies_outside_and_faces_the_room(
    position: tuple[float, float], middle: tuple[float, float], inward: tuple[float, float]
) -> None:
    frame = window_frame(boxed_room(position), Window(position=position))
    assert frame is not None
    assert frame[0] == pytest.approx(middle)
    assert frame[1] == pytest.approx(inward)


def test_a_window_between_two_outsides_has_no_light() -> None:
    room = boxed_room((0.0, 2.1))
    wall = room.walls[0].model_copy(update={"start": (8.0, 0.0), "end": (12.0, 0.0)})
    apart = room.model_copy(update={"walls": (*room.walls, wall)})
    assert window_frame(apart, Window(position=(10.0, 0.0))) is None


def test_a_lamps_body_sends_out_its_power() -> None:
    room = boxed_room((0.0, 2.1), "interior")
    area = 0.25
    assert np.pi * area * lamp_radiance(room, 0, area) == pytest.approx(40.0)


def test_lamps_are_off_in_daylight() -> None:
    assert lamp_radiance(boxed_room((0.0, 2.1), "exterior"), 0, 0.25) == 0.0
