"""Equations of the paper on numbers small enough for pencil and paper."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.camera import FisheyeCamera
from dataset.topomap import Nodes
from roomseg.panorama import PanoramaParameters, compass_distances, signature_distances, signatures
from roomseg.passageway import (
    LintelParameters,
    LintelSearch,
    edge_pixels,
    lintel_histograms,
    passageway_feature,
)
from roomseg.room_count import EigenvalueGap, eigenvalue_gaps


@pytest.mark.parametrize("upside_down", [False, True])
def test_eq_1_a_step_and_its_negative_have_one_direction(upside_down):
    """Grey 10 above and 50 below row 232: g_y = ±40 · 16, whose direction is 90° for both."""
    camera = FisheyeCamera()
    image = np.full(camera.image_size, 10, np.uint8)
    image[232:] = 50
    image = np.flipud(image) if upside_down else image
    search = LintelSearch.of(camera, LintelParameters())
    theta, s, index = edge_pixels(np.ascontiguousarray(image), search, 40 * 16.0)
    np.testing.assert_allclose(theta, np.pi / 2)
    # The two rows beside the step, half a pixel from the centre of the disc at row 232.
    assert sorted(set(np.round(s, 9))) == [-0.5, 0.5]
    assert set(search.pixels[index][:, 0]) == {231, 232}
    assert len(edge_pixels(np.ascontiguousarray(image), search, 40 * 16.0 + 1)[0]) == 0


def test_eqs_2_to_5_one_pixel_in_four_histograms():
    """N_θ = 4 bins of 45°, N_s = 5 bins of 2 px for s_max = 5; θ = 170°, s = 1.5 px."""
    parameters = LintelParameters(orientation_bins=4, offset_bins=5)
    histograms = lintel_histograms(np.radians([170.0]), np.array([1.5]), 5.0, parameters)
    assert histograms.sum(axis=(2, 3)).tolist() == [[1, 1], [1, 1]]
    zero = 3  # index of the offset bin j = 0: the first is -ceil(5 / 2)
    assert histograms[0, 0, 3, zero + 0] == 1  # i = floor(170 / 45), j = floor(1.5 / 2)
    assert histograms[0, 1, 3, zero + 1] == 1  # j' = floor(1.5 / 2 + 1 / 2)
    # θ + 22.5° = 192.5°, fmod 180° = 12.5°: i' = 0; the gradient is turned, and s with it.
    assert histograms[1, 0, 0, zero - 1] == 1  # floor(-1.5 / 2)
    assert histograms[1, 1, 0, zero - 1] == 1  # floor(-1.5 / 2 + 1 / 2)


def test_eqs_6_to_8_the_weaker_node_decides_among_bins_across_the_edge():
    """Edge along x, robots heading along x; four bins with middles at 22.5°, 67.5°, …"""
    parameters = LintelParameters(orientation_bins=4, tolerance=np.radians(30.0))
    maxima = np.zeros((2, 2, 4), np.int64)
    maxima[:, 0] = [[5, 99, 99, 7], [11, 99, 99, 6]]  # ± 22.5° are admitted, ± 67.5° are not
    maxima[:, 1] = [[3, 99, 99, 99], [9, 99, 99, 99]]  # shifted: 0° is admitted, 45° is not
    nodes = Nodes([[0.0, 0.0], [0.3, 0.0]], [0.0, 0.0], [0, 0], [0, 1])
    found = passageway_feature(maxima, nodes, np.array([[0, 1]]), parameters)
    assert found.tolist() == [min(max(5, 7, 3), max(11, 6, 9))] == [7.0]
    # The second robot turned by 90° sees the lintel's normal in other bins.
    turned = Nodes([[0.0, 0.0], [0.3, 0.0]], [0.0, np.pi / 2], [0, 0], [0, 1])
    assert passageway_feature(maxima, turned, np.array([[0, 1]]), parameters).tolist() == [7.0]
    maxima[1] = [[1, 2, 4, 1], [1, 1, 1, 1]]
    assert passageway_feature(maxima, turned, np.array([[0, 1]]), parameters).tolist() == [4.0]


def test_eqs_9_and_10_rows_of_four_pixels():
    """(1, 2, 3, 9) against (3, 9, 1, 4): turned by two columns they differ by 2 in one pixel."""
    panoramas = np.array([[[1, 2, 3, 9]], [[3, 9, 1, 4]]], np.uint8)
    by_turn = []
    for turn in range(4):
        difference = np.subtract([1, 2, 3, 9], np.roll([3, 9, 1, 4], -turn))
        by_turn.append(float(np.sqrt((difference**2).sum())))
    assert by_turn[0] == pytest.approx(np.sqrt(4 + 49 + 4 + 25))
    assert compass_distances(panoramas, np.array([[0, 1]]))[0] == pytest.approx(min(by_turn)) == 2.0


def test_eq_11_a_wave_has_one_coefficient():
    """8 rows, 24 columns: constant 100 against 100 ± 10 as a cosine of three waves."""
    parameters = PanoramaParameters(width=24, height=8, segments=4, coefficients=6)
    wave = np.rint(100 + 10 * np.cos(3 * 2 * np.pi * np.arange(24) / 24)).astype(np.uint8)
    panoramas = np.stack([np.full((8, 24), 100, np.uint8), np.tile(wave, (8, 1))])
    found = signatures(panoramas, parameters).reshape(2, 4, 6)
    np.testing.assert_allclose(found[0], np.tile([2400, 0, 0, 0, 0, 0], (4, 1)), atol=1e-9)
    # The sum of cos² over 24 columns is 12, rounding of grey levels aside.
    np.testing.assert_allclose(found[1, :, 3], 120.0, rtol=0.02)
    distance = signature_distances(panoramas, np.array([[0, 1]]), parameters)
    assert distance[0] == pytest.approx(np.linalg.norm(found[0] - found[1]))
    assert distance[0] == pytest.approx(2 * 120.0, rel=0.02)  # the root of four segments


def test_eqs_24_to_26_by_hand():
    """Gaps .1, .1, .7, .2; with a = 10, b = -5 the class is 1 from a gap of 1/2 on."""
    values = np.array([0.0, 0.1, 0.2, 0.9, 1.1])
    np.testing.assert_allclose(eigenvalue_gaps(values), [0.1, 0.1, 0.7, 0.2])
    assert EigenvalueGap(10.0, -5.0).predict(values) == 3
    assert EigenvalueGap(10.0, -1.0).predict(values) == 1  # 10 · 0.1 - 1 = 0: y = ⌊1/2 + 1/2⌋
    assert EigenvalueGap(10.0, -1.5).predict(values) == 3
