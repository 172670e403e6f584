"""Lintel detection on images of lintels at known places."""

from __future__ import annotations

import numpy as np
import pytest

from dataset.camera import SIMULATED_CAMERA, FisheyeCamera
from dataset.topomap import Nodes
from roomseg.passageway import (
    LintelParameters,
    LintelSearch,
    bin_orientations,
    edge_pixels,
    lintel_histograms,
    orientation_maxima,
    passageway_feature,
)

PAPER = LintelParameters()
SEARCH = LintelSearch.of(SIMULATED_CAMERA, PAPER)


def line_image(theta: float, s: float, camera: FisheyeCamera = SIMULATED_CAMERA) -> np.ndarray:
    """A smooth step from 60 to 180 across the image line with this normal and offset."""
    rows, columns = np.indices(camera.image_size) + 0.5
    x, y = columns - camera.disc_centre[1], rows - camera.disc_centre[0]
    across = x * np.cos(theta) + y * np.sin(theta) - s
    return np.rint(120 + 60 * np.tanh(across)).astype(np.uint8)


def view(
    pose: tuple[float, float, float], lintel_x: float, camera: FisheyeCamera = SIMULATED_CAMERA
) -> np.ndarray:
    """What a robot at this pose sees: a ceiling 1.9 m above the lens, dark beyond x = lintel_x."""
    rows, columns = np.indices(camera.image_size) + 0.5
    azimuth, zenith = camera.unproject(np.stack([rows, columns], axis=-1))
    reach = 1.9 * np.tan(np.minimum(zenith, 1.4))
    x = pose[0] + reach * np.cos(azimuth + pose[2])
    return np.rint(120 - 60 * np.tanh((x - lintel_x) / 0.01)).astype(np.uint8)


def test_angles_of_the_paper() -> None:
    assert np.degrees(PAPER.search_angle) == pytest.approx(38, abs=0.5)
    radius = np.hypot(SEARCH.column, SEARCH.row).max()
    assert radius == pytest.approx(PAPER.search_angle / 2 * 464 / np.radians(190), abs=0.5)
    assert SEARCH.max_offset == 23.0
    assert len(SEARCH.column) == pytest.approx(np.pi * radius**2, rel=0.02)


def test_everything_scales_with_the_disc() -> None:
    half = LintelSearch.of(SIMULATED_CAMERA.resized(232), PAPER)
    assert half.max_offset == pytest.approx(11.5)
    assert len(half.column) == pytest.approx(len(SEARCH.column) / 4, rel=0.03)
    real = FisheyeCamera(np.radians(185), 450, (512, 640), (256, 320))
    assert LintelSearch.of(real, PAPER).max_offset == pytest.approx(22.9, abs=0.05)


@pytest.mark.parametrize("theta", np.radians([10, 45, 95, 160]))
@pytest.mark.parametrize("s", [-15.0, 0.0, 6.5, 20.0])
def test_pixels_of_a_line_have_its_orientation_and_offset(theta: float, s: float) -> None:
    angles, offsets, _ = edge_pixels(line_image(theta, s), SEARCH, 400)
    assert len(angles) > 100
    assert angles == pytest.approx(np.full(len(angles), theta), abs=0.06)
    assert np.mean(offsets) == pytest.approx(s, abs=0.3)


@pytest.mark.parametrize("theta", np.radians([10, 45, 95, 160]))
@pytest.mark.parametrize("s", [-15.0, 0.0, 6.5, 20.0])
def test_highest_bin_is_that_of_the_line(theta: float, s: float) -> None:
    angles, offsets, _ = edge_pixels(line_image(theta, s), SEARCH, PAPER.min_intensity)
    histograms = lintel_histograms(angles, offsets, SEARCH.max_offset, PAPER)
    shift, shift_s, i, j = np.unravel_index(histograms.argmax(), histograms.shape)
    delta_s = 2 * 23.0 / 17
    bin_theta = (i + (0.0 if shift else 0.5)) * np.pi / 18
    bin_s = (j - 9 + (0.0 if shift_s else 0.5)) * delta_s
    assert abs(bin_theta - theta) <= np.pi / 36 + 0.01
    assert abs(bin_s - s) <= delta_s / 2 + 0.5
    assert bin_orientations(PAPER)[shift, i] == pytest.approx(bin_theta)


def test_inverted_image_gives_the_same() -> None:
    image = line_image(0.4, 5.0)
    direct = orientation_maxima(image, SEARCH, PAPER)
    assert (orientation_maxima(255 - image, SEARCH, PAPER) == direct).all()


def test_histograms_pixel_by_pixel() -> None:
    """Eqs. 2-5 as loops, with the flip of s where θ wraps."""
    rng = np.random.default_rng(3)
    theta, s = rng.uniform(0, np.pi, 500), rng.uniform(-23, 23, 500)
    expected = np.zeros((2, 2, 18, 19), dtype=int)
    delta_theta, delta_s = np.pi / 18, 46 / 17
    for angle, offset in zip(theta, s, strict=True):
        turned = angle + delta_theta / 2
        wraps = int(turned / np.pi)
        i_shifted = int((turned - wraps * np.pi) / delta_theta)
        offset_shifted = -offset if wraps else offset
        for row, i, o in ((0, int(angle / delta_theta), offset), (1, i_shifted, offset_shifted)):
            expected[row, 0, i, int(np.floor(o / delta_s)) + 9] += 1
            expected[row, 1, i, int(np.floor(o / delta_s + 0.5)) + 9] += 1
    assert (lintel_histograms(theta, s, 23.0, PAPER) == expected).all()
    assert (expected.sum(axis=(2, 3)) == 500).all()


@pytest.mark.parametrize("bins", [(18, 17), (36, 33), (10, 8)])
def test_every_pixel_has_a_bin(bins: tuple[int, int]) -> None:
    parameters = LintelParameters(orientation_bins=bins[0], offset_bins=bins[1])
    s = np.array([-1, 1, -1, 1]) * np.nextafter(23.0, 0)
    theta = np.array([0.0, 0.0, np.nextafter(np.pi, 0), np.nextafter(np.pi, 0)])
    assert (lintel_histograms(theta, s, 23.0, parameters).sum(axis=(2, 3)) == 4).all()


def test_a_line_along_the_wrap_is_one_bin() -> None:
    """θ scatters around 0 ≡ π; the letter of Eqs. 3-4 would halve the highest bin."""
    rng = np.random.default_rng(0)
    axis = rng.normal(0.0, 0.02, 400)
    theta, s = axis % np.pi, np.where(axis < 0, -10.0, 10.0)
    assert lintel_histograms(theta, s, 23.0, PAPER).max() == 400


def test_plain_and_weak_images_have_no_edges() -> None:
    plain = np.full((464, 464), 128, np.uint8)
    assert orientation_maxima(plain, SEARCH, PAPER).max() == 0
    assert orientation_maxima(plain, SEARCH, LintelParameters(min_intensity=0)).max() == 0
    weak = (100 + line_image(0.3, 4.0) // 30).astype(np.uint8)
    assert orientation_maxima(weak, SEARCH, PAPER).max() == 0


def doorway(headings: np.ndarray, camera: FisheyeCamera = SIMULATED_CAMERA):
    """Five nodes around a lintel at x = 0; edges across it, along it, and away from it."""
    position = np.array([[-0.1, 0.0], [0.1, 0.0], [-0.1, 0.15], [-1.4, 0.0], [-1.3, 0.0]])
    nodes = Nodes(position, headings, np.zeros(5), np.zeros(5))
    search = LintelSearch.of(camera, PAPER)
    maxima = np.stack(
        [
            orientation_maxima(view((*place, heading), 0.0, camera), search, PAPER)
            for place, heading in zip(position, headings, strict=True)
        ]
    )
    edges = np.array([[0, 1], [0, 2], [3, 4], [1, 2]])
    return maxima, nodes, edges


@pytest.mark.parametrize("seed", range(6))
def test_only_edges_across_the_lintel_see_it(seed: int) -> None:
    """Whatever the headings: the mirrored image and the map frame fit together."""
    headings = np.random.default_rng(seed).uniform(-np.pi, np.pi, 5)
    across, along, away, diagonal = passageway_feature(*doorway(headings), PAPER)
    assert across > 100
    assert along < across / 10
    assert away == 0
    assert diagonal > 100  # 37° off the normal, within ε


def test_half_the_disc_sees_fewer_pixels() -> None:
    headings = np.array([0.3, 1.7, -2.0, 0.0, 0.0])
    full = passageway_feature(*doorway(headings), PAPER)
    half = passageway_feature(*doorway(headings, SIMULATED_CAMERA.resized(232)), PAPER)
    assert full[0] / 8 < half[0] < full[0] / 2
    assert half[1] < half[0] / 5


def test_orientations_are_axes() -> None:
    """β = 170° and Θ = 5° are 15° apart (Eq. 6, wrapped)."""
    maxima = np.zeros((2, 2, 18), dtype=int)
    maxima[:, 0, 0] = 7  # Θ = 5°
    beta = np.radians(170)
    nodes = Nodes([[0, 0], [np.cos(beta), np.sin(beta)]], np.zeros(2), np.zeros(2), np.zeros(2))
    edge = np.array([[0, 1]])
    for tolerance, expected in ((10, 0), (16, 7), (90, 7)):
        parameters = LintelParameters(tolerance=np.radians(tolerance))
        assert passageway_feature(maxima, nodes, edge, parameters) == [expected]


def test_tolerance_of_90_degrees_admits_all() -> None:
    maxima = np.random.default_rng(1).integers(0, 50, (2, 2, 18))
    nodes = Nodes([[0, 0], [1, 2]], [0.3, -1.0], np.zeros(2), np.zeros(2))
    parameters = LintelParameters(tolerance=np.pi / 2)
    weaker = maxima.max(axis=(1, 2)).min()
    assert passageway_feature(maxima, nodes, np.array([[0, 1]]), parameters) == [weaker]


@pytest.mark.parametrize(
    "camera",
    [
        FisheyeCamera(np.radians(160), 390.7, (512, 640), (256.0, 320.0)),
        FisheyeCamera(np.radians(220), 537.3, (512, 640), (241.5, 371.5)),
        FisheyeCamera(np.radians(190), 464.0, (300, 280), (130.0, 150.0)),
    ],
    ids=["160 degrees", "off the middle", "cropped"],
)
def test_a_lintel_is_found_alike_wherever_the_disc_lies(camera: FisheyeCamera) -> None:
    """All have the simulated camera's scale, 464 px for 190°, so the same histogram."""
    search = LintelSearch.of(camera, PAPER)
    assert search.max_offset == pytest.approx(23.0, abs=0.01)
    assert len(search.column) == pytest.approx(len(SEARCH.column), rel=0.01)
    pose = (0.0, 0.0, 0.4)
    here = orientation_maxima(view(pose, 0.12, camera), search, PAPER)
    plain = orientation_maxima(view(pose, 0.12), SEARCH, PAPER)
    assert here.max() == pytest.approx(plain.max(), rel=0.1)
    found = bin_orientations(PAPER).ravel()[here.argmax()]
    assert np.degrees(found) == pytest.approx(180.0 - np.degrees(0.4), abs=6.0)
