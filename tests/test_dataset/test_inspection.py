from __future__ import annotations

import numpy as np
import pytest

from dataset import FrameJournal, summarise


def test_summary_counts_what_is_there(full_path):
    summary = summarise(full_path)
    assert (summary.node_count, summary.edge_count, summary.visit_count) == (8, 10, 10)
    assert (summary.part_count, summary.lane_count, summary.obstacle_count) == (1, 2, 2)
    assert summary.duration == pytest.approx(9.0)
    assert summary.path_length == pytest.approx(3.0)
    assert summary.median_edge_length == pytest.approx(1.0)
    assert (summary.images_done, summary.journal, summary.preset) == (8, False, "")
    assert (summary.room_count, summary.border_edge_count) == (2, 2)
    assert summary.nodes_labelled
    assert summary.segmented_by == "m"
    assert (summary.robot_radius, summary.sensor) == (0.15, None)
    assert summary.robot == {"radius": 0.15, "lane_spacing": 1.0}
    assert summary.file_size == full_path.stat().st_size


def test_summary_tells_of_a_waiting_journal(map_path):
    with FrameJournal(map_path, preset="draft") as journal:
        journal.append(0, np.zeros((16, 16), np.uint8), 1.0)
    assert summarise(map_path).journal
    assert summarise(map_path).image_size == (16, 16)
    assert summarise(map_path).images_done == 0
    assert summarise(map_path).segmented_by is None
