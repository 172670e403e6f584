"""The journal under crashes: killed at any line, and cut off at every byte."""

from __future__ import annotations

import os
import signal
import sys
import types
from pathlib import Path

import h5py
import numpy as np
import pytest
from sample_maps import CAMERA, assert_same, images_of, two_rooms

import dataset
from dataset import (
    FisheyeCamera,
    FormatError,
    FrameJournal,
    MapFile,
    RoomsegError,
    discard_frames,
    problems,
    read_map,
    write_map,
    write_rooms,
)
from dataset.journal import journal_path

IMAGES = images_of(two_rooms(), seed=7)
PACKAGE = str(Path(dataset.__file__).parent)


def gain_of(node: int) -> float:
    return 0.5 + node


def render(path: Path, nodes=range(8), finished=lambda node: None) -> None:
    """What a renderer does: append what is missing, then pack."""
    with FrameJournal(path) as journal:
        for node in nodes:
            if node not in journal.done:
                journal.append(node, IMAGES[node], gain_of(node))
                finished(node)
        journal.pack()


def assert_holds(path: Path, nodes) -> None:
    with MapFile(path) as file:
        assert np.flatnonzero(file.done).tolist() == sorted(nodes)
        for node in nodes:
            np.testing.assert_array_equal(file.image(node), IMAGES[node])
            assert file.gain(node) == gain_of(node)
    assert list(problems(path)) == []


def files_beside(path: Path) -> list[str]:
    return sorted(item.name for item in path.parent.iterdir())


def test_frames_wait_in_the_journal_until_packed(map_path):
    with FrameJournal(map_path) as journal:
        journal.append(3, IMAGES[3], gain_of(3))
        assert journal.done == {3}
    assert_holds(map_path, [])
    with FrameJournal(map_path) as journal:
        assert journal.done == {3}
        journal.append(1, IMAGES[1], gain_of(1))
        assert journal.pack() == 2
        assert journal.done == {1, 3}
    assert_holds(map_path, [1, 3])
    assert files_beside(map_path) == [map_path.name]


def test_appending_goes_on_after_packing(map_path):
    with FrameJournal(map_path) as journal:
        journal.append(3, IMAGES[3], gain_of(3))
        journal.pack()
        journal.append(0, IMAGES[0], gain_of(0))
        assert journal.pack() == 1
        assert journal.pack() == 0
    assert_holds(map_path, [0, 3])


def test_bytes_do_not_depend_on_order_or_interruptions(tmp_path, topomap):
    orders = ([range(8)], [reversed(range(8))], [[5, 2], [2, 7, 0], range(8)])
    contents = []
    for number, pieces in enumerate(orders):
        path = tmp_path / str(number) / "map.h5"
        path.parent.mkdir()
        write_map(path, topomap)
        for nodes in pieces:
            render(path, nodes)
        assert_holds(path, range(8))
        contents.append(path.read_bytes())
    assert contents[0] == contents[1] == contents[2]


def test_packing_keeps_rooms_and_foreign_images(tmp_path, topomap):
    path = tmp_path / "map.h5"
    images = [image if node < 4 else None for node, image in enumerate(IMAGES)]
    write_map(path, topomap, images, [gain_of(node) for node in range(8)])
    with h5py.File(path, "r+") as file:
        # As another program might store them: shuffled, compressed harder.
        pixels = file["images/pixels"][()]
        del file["images/pixels"]
        file["images"].create_dataset(
            "pixels", data=pixels, chunks=(2, 16, 16), compression=9, shuffle=True
        )
    write_rooms(path, np.zeros(8), model="m", rooms=1)
    render(path)
    assert_holds(path, range(8))
    with MapFile(path) as file:
        assert file.rooms is not None


# ------------------------------------------------------------------ crashes


def run_and_die(work, line: int | None) -> tuple[bool, list[int]]:
    """Run ``work(report)`` in a child that is killed before a line of `dataset` runs.

    ``line`` counts the lines of the package in the order in which they run;
    None: live on. Returns whether the child was killed, and what it reported.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        left = [line]

        def trace(frame: types.FrameType, event: str, argument: object):
            if not frame.f_code.co_filename.startswith(PACKAGE):
                return None
            if event == "line" and left[0] is not None:
                left[0] -= 1
                if left[0] < 0:
                    os.kill(os.getpid(), signal.SIGKILL)
            return trace

        code = 1
        try:
            sys.settrace(trace)
            work(lambda node: os.write(writing, bytes([node])))
            code = 0
        finally:
            sys.settrace(None)
            os._exit(code)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        reported = list(pipe.read())
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return True, reported
    assert os.WEXITSTATUS(status) == 0
    return False, reported


@pytest.mark.parametrize(
    ("already", "first", "step"),
    [
        pytest.param([], 0, 37, id="new"),
        pytest.param([1, 6], 19, 37, id="resumed"),
        pytest.param([], 0, 1, id="new-every-line", marks=pytest.mark.slow),
        pytest.param([1, 6], 0, 1, id="resumed-every-line", marks=pytest.mark.slow),
    ],
)
def test_killed_at_any_line_nothing_is_lost(tmp_path, topomap, already, first, step):
    path = tmp_path / "map.h5"
    write_map(path, topomap)
    render(path, already)
    start = path.read_bytes()
    render(path, [1, 2, 6])
    expected = path.read_bytes()
    line, killed = first, True
    while killed:
        path.write_bytes(start)
        journal_path(path).unlink(missing_ok=True)
        killed, finished = run_and_die(
            lambda report: render(path, [1, 2, 6], finished=report), line
        )
        # The map is whole, and every frame that was reported finished is there.
        assert list(problems(path)) == []
        with FrameJournal(path) as journal:
            assert set(finished) | set(already) <= journal.done
        render(path, [1, 2, 6])
        assert path.read_bytes() == expected
        assert files_beside(path) == ["map.h5"]
        line += step
    assert line > 300


def test_killed_between_rename_and_removal_packs_the_same_again(map_path):
    with FrameJournal(map_path) as journal:
        journal.append(4, IMAGES[4], gain_of(4))
        kept = journal_path(map_path).read_bytes()
        journal.pack()
    packed = map_path.read_bytes()
    journal_path(map_path).write_bytes(kept)
    with FrameJournal(map_path) as journal:
        assert journal.done == {4}
        assert journal.pack() == 1
    assert map_path.read_bytes() == packed


def test_cut_off_at_any_byte_only_the_torn_frame_is_lost(tmp_path, topomap):
    path = tmp_path / "map.h5"
    write_map(path, topomap)
    ends = []
    with FrameJournal(path) as journal:
        for node in (2, 5, 0):
            journal.append(node, IMAGES[node], gain_of(node))
            ends.append(journal_path(path).stat().st_size)
    whole, map_bytes = journal_path(path).read_bytes(), path.read_bytes()
    header = whole.index(b"\n") + 1
    for length in sorted({*range(header, len(whole), 23), *ends, *(end - 1 for end in ends)}):
        path.write_bytes(map_bytes)
        journal_path(path).write_bytes(whole[:length])
        expected = [node for node, end in zip((2, 5, 0), ends, strict=True) if end <= length]
        with FrameJournal(path) as journal:
            assert journal.done == set(expected)
            journal.append(7, IMAGES[7], gain_of(7))
            journal.pack()
        assert_holds(path, [*expected, 7])


@pytest.mark.parametrize("kept", [[], [2], [2, 5]])
def test_a_full_disk_loses_the_frame_in_the_making_only(map_path, kept, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    with FrameJournal(map_path) as journal:
        for node in kept:
            journal.append(node, IMAGES[node], gain_of(node))
        journal._open_stream()
        with monkeypatch.context() as patch:
            patch.setattr("dataset.journal.os.fsync", full)
            with pytest.raises(RoomsegError, match=r"h5\.frames: cannot be written: No space left"):
                journal.append(0, IMAGES[0], gain_of(0))
        assert journal.done == set(kept)
        assert journal_path(map_path).exists() == bool(kept)
        journal.append(1, IMAGES[1], gain_of(1))
    with FrameJournal(map_path) as journal:
        assert journal.done == {*kept, 1}
        journal.pack()
    assert_holds(map_path, [*kept, 1])


def test_damaged_record_is_dropped(map_path):
    with FrameJournal(map_path) as journal:
        for node in (2, 5):
            journal.append(node, IMAGES[node], gain_of(node))
    data = bytearray(journal_path(map_path).read_bytes())
    data[-9] ^= 1
    journal_path(map_path).write_bytes(data)
    with FrameJournal(map_path) as journal:
        assert journal.done == {2}


# ------------------------------------------------------- what is refused


def test_second_writer_is_refused_while_the_first_lives(map_path):
    with FrameJournal(map_path) as journal:
        journal.append(0, IMAGES[0], 1.0)
        for second in (lambda: FrameJournal(map_path), lambda: discard_frames(map_path)):
            with pytest.raises(RoomsegError, match="another process is writing to it"):
                second()
        with pytest.raises(RoomsegError, match="another process is writing to it"):
            write_rooms(map_path, np.zeros(8), model="m", rooms=1)
    FrameJournal(map_path).close()


def test_frames_of_two_cameras_do_not_mix(map_path):
    small = FisheyeCamera().resized(8)
    message = r"holds frames of a 8 px disc in \(8, 8\) px, not 16 px"
    with FrameJournal(map_path, small) as journal:
        journal.append(0, IMAGES[0][:8, :8], 1.0)
    with pytest.raises(FormatError, match=r"flat-run1\.h5\.frames: " + message) as caught:
        FrameJournal(map_path)
    assert "\n" not in str(caught.value)
    with FrameJournal(map_path, small) as journal:
        journal.pack()
    with MapFile(map_path) as file:
        assert file.topomap.camera == small
        np.testing.assert_array_equal(file.image(0), IMAGES[0][:8, :8])
    with pytest.raises(FormatError, match=r"flat-run1\.h5: " + message):
        FrameJournal(map_path, CAMERA)
    assert list(problems(map_path)) == []


def test_frames_of_two_presets_do_not_mix(map_path):
    with FrameJournal(map_path, preset="draft") as journal:
        journal.append(0, IMAGES[0], 1.0)
    with pytest.raises(FormatError, match="holds frames of preset 'draft', not 'reference'"):
        FrameJournal(map_path, preset="reference")
    with FrameJournal(map_path) as journal:
        assert journal.preset == "draft"
        journal.pack()
    with MapFile(map_path) as file:
        assert file.preset == "draft"
    with pytest.raises(FormatError, match="holds frames of preset 'draft', not 'reference'"):
        FrameJournal(map_path, preset="reference")


def test_discarded_frames_make_room_for_another_camera(map_path, topomap):
    small, smaller = FisheyeCamera().resized(8), FisheyeCamera().resized(4)
    for camera in (small, smaller):
        with FrameJournal(map_path, camera) as journal:
            journal.append(0, np.ones(camera.image_size, np.uint8), 1.0)
            journal.pack()
            journal.append(3, np.ones(camera.image_size, np.uint8), 1.0)
        assert read_map(map_path).camera == camera
        discard_frames(map_path)
        assert files_beside(map_path) == [map_path.name]
        # The map's own camera is back, not the one of the discarded frames.
        assert_same(read_map(map_path), topomap)
    with FrameJournal(map_path) as journal:
        assert journal.done == set()


def test_journal_of_another_map_is_refused(map_path, tmp_path, topomap):
    with FrameJournal(map_path) as journal:
        journal.append(0, IMAGES[0], 1.0)
    other = tmp_path / "other.h5"
    write_map(other, two_rooms().__class__(**(vars(topomap) | {"seed": 99})))
    journal_path(map_path).rename(journal_path(other))
    with pytest.raises(FormatError, match=r"other\.h5\.frames: holds frames of another map"):
        FrameJournal(other)


@pytest.mark.parametrize("content", [b"", b"\n", b"hello\n", b"roomseg-frames 1 00000000 {}\n"])
def test_other_files_are_no_journals(map_path, content):
    journal_path(map_path).write_bytes(content)
    with pytest.raises(FormatError, match="no journal of frames"):
        FrameJournal(map_path)
    assert journal_path(map_path).read_bytes() == content


@pytest.mark.parametrize(
    ("node", "image", "gain", "message"),
    [
        (8, IMAGES[0], 1.0, r"node 8, expected 0\.\.7"),
        (-1, IMAGES[0], 1.0, r"node -1, expected 0\.\.7"),
        (0, IMAGES[0][:15], 1.0, r"an image of uint8 \(15, 16\)"),
        (0, IMAGES[0].astype(float), 1.0, "an image of float64"),
        (0, IMAGES[0], np.nan, "gain nan of node 0, expected a number > 0"),
        (0, IMAGES[0], 0.0, r"gain 0\.0 of node 0, expected a number > 0"),
    ],
)
def test_wrong_frames_are_refused(map_path, node, image, gain, message):
    with FrameJournal(map_path) as journal:
        with pytest.raises(FormatError, match=message):
            journal.append(node, image, gain)
        assert journal.done == set()
