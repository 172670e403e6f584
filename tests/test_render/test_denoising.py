"""What no receiver covered is continued from its own chart."""

from __future__ import annotations

import numpy as np
import pytest

from render.denoising import continued

BOXES = np.array([[0, 0, 6, 5], [0, 5, 6, 5], [6, 0, 2, 10]], dtype=np.int32)


@pytest.fixture
def patchy() -> tuple[np.ndarray, np.ndarray]:
    """Red left, green right, both with holes; nothing covered below."""
    picture = np.zeros((8, 10, 3), dtype=np.float32)
    picture[:6, :5, 0] = np.arange(1.0, 6.0)
    picture[:6, 5:, 1] = 7.0
    covered = np.zeros((8, 10), dtype=bool)
    covered[1:4, 1:4] = covered[2:4, 6:9] = True
    picture[~covered] = 100.0
    return picture, covered


def test_the_nearest_covered_texel_of_the_same_chart_goes_on(patchy) -> None:
    made = continued(*patchy, BOXES)
    expected = np.broadcast_to([2.0, 2.0, 3.0, 4.0, 4.0], (6, 5))
    np.testing.assert_array_equal(made[:6, :5, 0], expected)
    np.testing.assert_array_equal(made[:6, 5:, 1], 7.0)
    assert not made[:6, :5, 1].any()
    assert not made[6:].any()


def test_noise_goes_on_as_noise(patchy) -> None:
    picture, covered = patchy
    made = continued(picture, covered, BOXES, np.random.default_rng(1))
    np.testing.assert_array_equal(made[covered], picture[covered])
    assert set(np.unique(made[:6, :5, 0])) == {2.0, 3.0, 4.0}
    assert (made[:6, :5, 0] != [2.0, 2.0, 3.0, 4.0, 4.0])[~covered[:6, :5]].any()
    again = continued(picture, covered, BOXES, np.random.default_rng(1))
    np.testing.assert_array_equal(made, again)
