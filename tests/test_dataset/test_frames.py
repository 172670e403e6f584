"""Radiance in float16, and as HDF5 stores it."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from sample_maps import images_of, two_rooms

from dataset import FisheyeCamera, FormatError, FrameJournal, MapFile, Radiance, discard_frames
from dataset.frames import pack_radiance, unpack_radiance
from dataset.journal import journal_path
from dataset.validation import problems

IMAGES = images_of(two_rooms(), seed=7)
SIZE = FisheyeCamera().resized(16).image_size


def light_of(node: int) -> np.ndarray:
    """Seven decades around a level of the node's own."""
    rng = np.random.default_rng(node)
    return (10.0 ** rng.uniform(-7.0, 0.0, SIZE) * 30.0 ** (node - 4)).astype(np.float32)


def render(path, nodes, keep: bool = True) -> None:
    with FrameJournal(path, keep_radiance=keep) as journal:
        for node in nodes:
            if node not in journal.done:
                journal.append(node, IMAGES[node], 1.0 + node, Radiance.of(light_of(node)))
        journal.pack()


@pytest.mark.parametrize("scale", [1e-30, 1e-17, 1.0, 65504.0, 1e30])
def test_any_brightness_keeps_eleven_bits(scale: float) -> None:
    light = (scale * np.geomspace(1e-7, 1.0, 256)).astype(np.float32).reshape(SIZE)
    back = Radiance.of(light).light
    assert back.dtype == np.float32
    np.testing.assert_allclose(back, light, rtol=2.0**-11)


def test_rounding_twice_is_rounding_once() -> None:
    light = np.random.default_rng(0).lognormal(0.0, 3.0, SIZE).astype(np.float32)
    once = Radiance.of(light).light
    np.testing.assert_array_equal(Radiance.of(once).light, once)


def test_darkness_and_what_is_not_finite() -> None:
    assert not Radiance.of(np.zeros(SIZE, np.float32)).light.any()
    for value in (np.nan, np.inf):
        with pytest.raises(ValueError, match="not finite"):
            Radiance.of(np.full(SIZE, value, np.float32))


def test_packing_and_unpacking() -> None:
    radiance = Radiance.of(light_of(3))
    data = pack_radiance(radiance, SIZE)
    back = unpack_radiance(data, radiance.exponent, SIZE)
    np.testing.assert_array_equal(back.light, radiance.light)
    with pytest.raises(FormatError, match="images/radiance: shape"):
        pack_radiance(radiance, (4, 4))


def test_radiance_is_kept_beside_the_images(map_path) -> None:
    render(map_path, range(8))
    with MapFile(map_path) as file:
        assert file.keeps_radiance
        for node in range(8):
            np.testing.assert_array_equal(file.radiance(node), Radiance.of(light_of(node)).light)
            np.testing.assert_array_equal(file.image(node), IMAGES[node])
    # h5py's own filters read what we packed.
    with h5py.File(map_path) as file:
        stored = file["images/radiance"]
        assert stored.chunks == (1, *SIZE)
        exponent = int(file["images/radiance_exponent"][5])
        light = stored[5].astype(float) * 2.0**exponent
        np.testing.assert_allclose(light, light_of(5), rtol=1e-3)
    assert list(problems(map_path)) == []


def test_in_pieces_and_through_the_journal_gives_the_same_bytes(map_path) -> None:
    empty = map_path.read_bytes()
    render(map_path, range(8))
    whole = map_path.read_bytes()
    map_path.write_bytes(empty)
    render(map_path, [6, 1])
    with FrameJournal(map_path) as journal:  # goes on to keep it without being asked
        assert journal.keeps_radiance
        journal.append(3, IMAGES[3], 4.0, Radiance.of(light_of(3)))
    with journal_path(map_path).open("ab") as stream:
        stream.write(b"torn")
    render(map_path, range(8), keep=False)
    assert map_path.read_bytes() == whole
    discard_frames(map_path)
    with MapFile(map_path) as file:
        assert not file.keeps_radiance


def test_images_with_and_without_radiance_do_not_mix(map_path) -> None:
    with FrameJournal(map_path) as journal:
        journal.append(0, IMAGES[0], 1.0)
    with pytest.raises(FormatError, match="frames: holds frames without radiance: go on without"):
        FrameJournal(map_path, keep_radiance=True)
    with FrameJournal(map_path) as journal:
        journal.pack()
        assert not journal.keeps_radiance
    with pytest.raises(FormatError, match=r"flat-run1\.h5: holds frames without radiance"):
        FrameJournal(map_path, keep_radiance=True)
    with MapFile(map_path) as file, pytest.raises(FormatError, match="render --hdr"):
        file.radiance(0)


def test_a_frame_without_its_radiance_is_refused(map_path) -> None:
    with (
        FrameJournal(map_path, keep_radiance=True) as journal,
        pytest.raises(FormatError, match="keeps radiance, but node 2 has none"),
    ):
        journal.append(2, IMAGES[2], 1.0)


def test_damaged_radiance_is_told(map_path) -> None:
    render(map_path, range(8))
    with h5py.File(map_path, "r+") as file:
        file["images/radiance"][4, 0, 0] = np.inf
        del file["images/radiance_exponent"]
    assert list(problems(map_path)) == [
        "/images/radiance_exponent: expected 8 whole numbers",
        "/images/radiance: that of node 4 is damaged",
    ]
