"""The film of a run: what is in its pictures, and the files."""

from __future__ import annotations

import resource
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image

from dataset import FormatError, read_map, write_map
from roomseg.cli.main import main
from roomseg.figures.replay import BELIEF, COVERED, ROBOT, replay_frames
from scenes.apartment import Apartment, Block, Room, Start
from simulator import simulate


def share(frame, colour):
    return (frame == np.array(colour)).all(axis=-1).mean()


@pytest.fixture(scope="module")
def driven():
    """A run through a room of 3 m by 2 m."""
    corners = ((0, 0), (3, 0), (3, 2), (0, 2))
    shell = Block(polygon=((-0.2, -0.2), (3.2, -0.2), (3.2, 2.2), (-0.2, 2.2)), holes=(corners,))
    room = Room(name="room", polygon=corners)
    place = Apartment(name="room", rooms=(room,), blocks=(shell,), start=Start(position=(1, 1)))
    return simulate(place, seed=1)


@pytest.fixture
def run_file(driven, tmp_path):
    path = tmp_path / "run.h5"
    write_map(path, driven)
    return path


def test_the_covered_floor_fills_in_and_the_robot_is_there(run_file):
    frames = list(replay_frames(read_map(run_file), speed=400.0, rate=5.0, height=200))
    covered = [share(frame[:, : frame.shape[1] // 2], COVERED) for frame in frames]
    assert covered[-1] > 0.2 > covered[0]
    assert all(share(frame, ROBOT) > 0.0 for frame in frames)
    assert len({frame.shape for frame in frames}) == 1


def test_a_map_without_a_driven_path_is_refused(run_file):
    with pytest.raises(FormatError, match="/path: missing"):
        next(replay_frames(replace(read_map(run_file), path=None)))


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_films_have_all_pictures(run_file, suffix, capfd):
    film = run_file.with_suffix(suffix)
    assert (
        main(["replay", str(run_file), "-o", str(film), "--speed", "500", "--height", "160"]) == 0
    )
    reader = cv2.VideoCapture(str(film))
    last = read_map(run_file).path.time[-1]
    assert reader.get(cv2.CAP_PROP_FRAME_COUNT) == pytest.approx(last / 20.0, abs=3)
    assert reader.read()[1].shape[0] == 160


def test_gif_moves(run_file):
    film = run_file.with_suffix(".gif")
    assert (
        main(["replay", str(run_file), "-o", str(film), "--speed", "900", "--height", "160"]) == 0
    )
    assert Image.open(film).n_frames >= 3


def test_another_kind_of_file_is_refused(run_file, capsys):
    assert main(["replay", str(run_file), "-o", str(run_file.with_suffix(".avi"))]) == 2
    assert "expected a name that ends in .mp4 or .webm or .gif" in capsys.readouterr().err


def test_where_the_robot_takes_itself_to_be_is_shown_beside_the_truth(driven):
    path = driven.path
    off = replace(path, estimate=path.estimate + np.array([0.8, 0.0, 0.0]))
    for shown, expected in ((path, 1), (off, 2)):
        frames = replay_frames(replace(driven, path=shown), speed=400.0, rate=5.0, height=300)
        frame = list(frames)[-1]
        ring = (np.abs(frame[:-40, : frame.shape[1] // 2].astype(int) - BELIEF) < 40).all(axis=-1)
        robot = (frame[:-40, : frame.shape[1] // 2] == np.array(ROBOT)).all(axis=-1)
        apart = abs(np.argwhere(ring)[:, 1].mean() - np.argwhere(robot)[:, 1].mean())
        assert (apart > 30.0) == (expected == 2)


@pytest.mark.parametrize("suffix", [".mp4", ".webm", ".gif"])
def test_a_full_disk_is_one_line_and_leaves_the_old_film(run_file, suffix, capsys):
    film = run_file.with_suffix(suffix)
    film.write_bytes(b"old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    # The kernel refuses to let files grow, as on a full disk.
    resource.setrlimit(resource.RLIMIT_FSIZE, (4000, before[1]))
    try:
        code = main(["replay", str(run_file), "-o", str(film), "--speed", "300"])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    told = capsys.readouterr().err
    assert code == 2 and told.count("\n") == 1 and "cannot be written" in told
    assert film.read_bytes() == b"old"
    assert sorted(p.name for p in run_file.parent.iterdir()) == sorted(["run.h5", film.name])
