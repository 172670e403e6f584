"""The sheet of a dataset: all values in the charts, all places at one scale."""

from __future__ import annotations

import numpy as np
import pytest
from small_flats import two_rooms

from roomseg.cli.home_plan import home_plan
from roomseg.figures import Chart, SheetPlace, dataset_sheet, figure_bytes
from roomseg.figures.sheet import _bins
from scenes import Apartment

PIXELS = np.full((20, 30), 90, np.uint8)


def place(split: str, images: int = 0, larger: float = 0.0) -> SheetPlace:
    fields = two_rooms()
    fields["rooms"][1]["polygon"][1][0] += larger
    fields["rooms"][1]["polygon"][2][0] += larger
    plan = home_plan(Apartment.model_validate(fields))
    return SheetPlace(f"a place of {split}", split, plan, (PIXELS,) * images)


CHARTS = [
    Chart("rooms", {"train": [1, 2, 2, 5], "validation": [], "test": [3]}),
    Chart("floor", {"train": [10.5, 12.0, 80.25, 33.0], "validation": [], "test": [41.5]}),
    Chart("coverage", {"train": [99.5], "validation": [], "test": []}),
]


def test_charts_count_every_value():
    figure = dataset_sheet("all", [place("train"), place("test")], CHARTS)
    axes = figure.subfigs[0].axes
    assert [ax.get_xlabel() for ax in axes] == ["rooms", "floor", "coverage"]
    # The tops of the highest bars would not do: they are stacked.
    assert [sum(bar.get_height() for bar in ax.patches) for ax in axes] == [5, 5, 1]
    assert [text.get_text() for text in figure.subfigs[0].legends[0].texts] == ["train", "test"]
    assert figure_bytes(figure, ".png", 40)[:4] == b"\x89PNG"


def test_places_have_one_scale_and_their_images():
    places = [place("train", 3), place("train", 1, larger=2.0), place("test"), place("test", 5)]
    figure = dataset_sheet("all", places, CHARTS)
    figure.draw_without_rendering()
    plans = [ax for ax in figure.axes if ax.get_title()]
    assert [ax.get_title() for ax in plans] == [item.title for item in places]
    spans = [(np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())) for ax in plans]
    assert np.allclose(spans, spans[0])
    assert spans[0][0] > 3.44 + 2.0
    scales = [ax.get_window_extent().width / np.ptp(ax.get_xlim()) for ax in plans]
    assert np.allclose(scales, scales[0], rtol=0.03)
    shown = [image for ax in figure.axes for image in ax.images]
    assert len(shown) == 3 + 1 + 3
    assert all(np.array_equal(image.get_array(), PIXELS) for image in shown)
    assert len(figure.findobj(lambda artist: artist.get_gid() == "scale-bar")) == 10


@pytest.mark.parametrize(
    ("values", "count", "ticks"),
    [
        ([1, 2, 2, 5], 5, [1, 2, 3, 4, 5]),
        ([4, 4], 1, [4]),
        ([4.5], 1, [4.5]),
        ([1, 19], 19, [1, 4, 7, 10, 13, 16, 19]),
        ([0, 100], 12, None),
        ([0.5, 1.0], 12, None),
    ],
)
def test_bins_hold_all_and_whole_numbers_have_their_own(values, count, ticks):
    bins, at = _bins(np.array(values, float))
    assert len(bins) == count + 1
    assert bins[0] <= min(values) and max(values) <= bins[-1]
    assert (None if at is None else at.tolist()) == ticks
