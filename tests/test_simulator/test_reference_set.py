"""The reference set as data: Table 8's numbers of maps, and starts that a robot can begin at."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import pairwise

import pytest
import shapely

from dataset import REAL_CAMERA, SIMULATED_CAMERA, CameraFlaws
from scenes import load_apartment
from scenes.passages import free_region
from simulator import NEW_RUNS, NOVEL_RUNS, REFERENCE_RUNS

ALL = (*REFERENCE_RUNS, *NEW_RUNS, *NOVEL_RUNS)


def test_as_many_maps_as_table_8_has():
    simulated = {f"sim{number}": 3 for number in range(1, 6)}
    assert Counter(run.place for run in REFERENCE_RUNS) == simulated | {
        "real1": 5,
        "real2": 8,
        "real3": 3,
    }
    assert [run.place for run in NEW_RUNS] == list(simulated)
    assert [run.place for run in NOVEL_RUNS] == ["novel"] * 5


def test_files_and_seeds_are_all_different():
    assert len({run.file_name for run in ALL}) == len(ALL)
    seeds = sorted(run.seed for run in ALL)
    assert min(b - a for a, b in pairwise(seeds)) > 5000


@pytest.mark.parametrize("place", sorted({run.place for run in ALL}))
def test_runs_begin_apart_or_look_elsewhere_on_free_floor(place):
    starts = [run.start for run in ALL if run.place == place]
    home = load_apartment(place)
    # The robot and 2 cm around it; all in the one piece of floor that it can clean.
    floor = free_region(home, 0.17)
    pieces = shapely.get_parts(floor)
    own = next(p for p in pieces if p.intersects(shapely.Point(home.start.position)))
    for x, y, _ in starts:
        assert own.covers(shapely.Point(x, y))
    for i, (x, y, heading) in enumerate(starts):
        for u, v, other in starts[:i]:
            turned = abs((heading - other + 180.0) % 360.0 - 180.0)
            assert abs(x - u) + abs(y - v) > 0.5 or turned > 45.0


def test_the_stand_ins_have_the_real_camera_and_drift_more():
    for run in ALL:
        real = run.place.startswith("real")
        lens = replace(run.camera, flaws=CameraFlaws())
        assert lens == (REAL_CAMERA if real else SIMULATED_CAMERA)
        assert (run.camera.flaws.full_well > 0.0) == real
    drifting, plain = (
        next(run.robot for run in ALL if run.place == name) for name in ("real1", "sim1")
    )
    assert drifting.slip_noise > plain.slip_noise
    assert drifting.correction_heading_noise > plain.correction_heading_noise
