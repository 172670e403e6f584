"""Looks that take in what has changed, against looks at the whole grid by other libraries."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import cKDTree

from simulator import gridcells
from simulator.gridcells import CELL, Covered
from simulator.gridmap import GridMap
from simulator.outlook import Outlook

CLEARANCE, RADIUS, NEAR, TRIED = 0.135, 0.2, 0.375, 0.1


def expected(grid, nodes, tried):
    """Cells, components and nearest nodes, looking at everything."""
    away = ndimage.distance_transform_edt(~grid.blocked()) * CELL
    mask = grid.seen & (away >= CLEARANCE)
    cells = np.argwhere(mask)
    points = grid.centres(cells)
    for places, radius in ((nodes, RADIUS), (tried, TRIED)):
        if len(places):
            covered = cKDTree(places).query(points)[0] <= radius
            mask[tuple(cells[covered].T)] = False
    labels, _ = ndimage.label(mask)
    cells = np.argwhere(mask)
    gap, node = cKDTree(nodes).query(grid.centres(cells))
    return cells, labels[tuple(cells.T)] - 1, np.where(gap < NEAR, node, -1)


def wander(grid, pose, rng):
    """Drive a little, with beams, spots and a contact now and then."""
    for _ in range(30):
        pose += [0.05 * np.cos(pose[2]), 0.05 * np.sin(pose[2]), rng.normal(0.0, 0.2)]
        grid.hold(pose, 1.5)
        gridcells.stand(grid.table, pose, 0.15)
        angles = pose[2] + np.arange(8) * np.pi / 4
        ranges = np.where(rng.random(8) < 0.5, rng.uniform(0.4, 1.0, 8), np.nan)
        gridcells.pass_beams(grid.table, pose, angles, ranges, 0.6)
        gridcells.hit(grid.table, pose, angles, ranges)
        if rng.random() < 0.1:
            gridcells.feel(grid.table, pose, rng.uniform(-1.0, 1.0), 0.15)


@pytest.mark.parametrize("seed", range(4))
def test_every_look_agrees_with_one_at_the_whole_grid(seed):
    rng = np.random.default_rng(seed)
    grid, pose, view = GridMap(np.zeros(2)), np.zeros(3), Outlook(CLEARANCE, RADIUS, NEAR)
    nodes, tried, shapes = [], [], set()
    for turn in range(25):
        wander(grid, pose, rng)
        if turn % 8 == 5:
            # A forgotten lane, and one that takes its place.
            del nodes[-6:]
            grid.forget_contacts(pose[:2], 0.4)
        nodes.extend(pose[:2] + rng.normal(0.0, 0.3, (6, 2)))
        if turn == 15:
            grid.bridge_seen(0.1)
        places = np.array(nodes)
        tried.append(places[-1] + 0.3)
        seen = view.look(grid, places, Covered(np.array(tried[-5:]), TRIED))
        for found, right in zip(seen, expected(grid, places, np.array(tried[-5:])), strict=True):
            np.testing.assert_array_equal(found, right)
        shapes.add(grid.seen.shape)
    assert len(shapes) > 1 and len(np.unique(seen.component)) > 3


def test_nothing_is_left_of_a_covered_floor():
    grid = GridMap(np.zeros(2))
    gridcells.stand(grid.table, np.zeros(3), 0.15)
    view = Outlook(CLEARANCE, RADIUS, NEAR)
    nothing = Covered(np.zeros((0, 2)), TRIED)
    assert len(view.look(grid, np.array([[9.0, 9.0]]), nothing).cells) > 40
    seen = view.look(grid, np.zeros((1, 2)), nothing)
    assert [len(rows) for rows in seen] == [0, 0, 0]


def test_components_hang_together_by_their_sides():
    """A U, whose arms meet late, a corner that only touches, and no way around the rim."""
    picture = np.array(
        [
            [1, 0, 1, 0, 0, 1],
            [1, 0, 1, 0, 1, 0],
            [1, 1, 1, 0, 0, 0],
            [0, 0, 0, 0, 0, 1],
            [1, 0, 0, 0, 0, 0],
        ]
    )
    found = gridcells.components(np.flatnonzero(picture), 6)
    assert found.tolist() == [0, 0, 1, 0, 0, 2, 0, 0, 0, 3, 4]
