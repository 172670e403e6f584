"""The report names every map and number, escapes what it is told, and appears at once."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest
from cleaned_flat import cleaned_flat, fisheye_image, floor, kept_edges, obstacles

import roomseg.report.page as page_module
from dataset.camera import FisheyeCamera
from roomseg.figures import RocCurve
from roomseg.report import (
    Comparison,
    Fact,
    MapResult,
    Measure,
    Place,
    Report,
    Spread,
    search_lintel,
    take_snapshot,
    write_report,
)

HOSTILE = "<script>alert('x')</script>\"><img src=x onerror=alert(1)>&amp;"
VOID = {"meta", "img", "br", "link", "input"}


class Page(HTMLParser):
    """Tags, attributes and text of a page; refuses tags that do not nest."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tags, self.words, self.open = [], [], []
        self.feed(path.read_text(encoding="utf-8"))
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.words.append(" ".join(data.split()))

    @property
    def text(self):
        return " ".join(word for word in self.words if word)

    def all(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.fixture(scope="module")
def result():
    topomap = cleaned_flat("flat")
    kept = kept_edges(topomap)
    truth = topomap.ground_truth.room
    return MapResult(
        topomap,
        topomap.edges[kept],
        topomap.ground_truth.edge_is_border[kept],
        (truth + 1) % 3,
        np.arange(len(truth)) % 3,
        0.0123,
        0.4567,
        (Fact("coverage", "97.6 %"),),
    )


@pytest.fixture(scope="module")
def report(result):
    camera = FisheyeCamera()
    image = fisheye_image(camera)
    rate = np.linspace(0.0, 1.0, 9)
    real = cleaned_flat("stand-in", real=True)
    first = Place(
        "Flat",
        (result,),
        "A flat with a corridor",
        obstacles(),
        floor(),
        snapshots=(take_snapshot(4, image, camera), take_snapshot(99, image, camera)),
        lintel=search_lintel(4, image, camera),
        facts=(Fact("floor", "31.4 m²"),),
    )
    second = Place("Stand-in", (MapResult(real, impurity=0.0877),))
    table = Comparison(
        "Table 1: edges",
        (
            Measure("P(short)", 0.5017, 0.498, (0.45, 0.55)),
            Measure("P(border)", 0.0713, 0.026, (0.020, 0.033)),
            Measure("no target", 4.25, digits=1),
        ),
        "After preprocessing.",
    )
    return Report(
        "Three rooms",
        "2026-01-02",
        "roomseg 0.1.0",
        (first, second),
        comparisons=(table,),
        roc_without_images=(RocCurve("edge length", rate, rate**0.5, 0.67),),
        roc_with_images=(RocCurve("passageway", rate, rate**0.2, 0.83),),
        impurity_by_variant=(("default", 0.03, 0.0313), ("own", 0.05, None)),
    )


@pytest.fixture(scope="module")
def written(report, tmp_path_factory):
    return write_report(report, tmp_path_factory.mktemp("report") / "new")


def test_every_map_and_number_is_on_the_page(written):
    text = Page(written).text
    for words in (
        "Three rooms",
        "flat · run1",
        "stand-in · run1",
        "1.23",
        "45.67",
        "8.77",
        "5.00",  # mean of 1.23 and 8.77
        "97.6 %",
        "31.4 m²",
        "760",
        "1,520",  # nodes of both maps
        "P(short)",
        "0.502",
        "0.498",
        "0.071",
        "0.020 – 0.033, outside",
        "4.2",
        "After preprocessing.",
        "3.13",
        "1.04",
        "12.91",
        "15.46",
    ):
        assert words in text, words


def test_pictures_are_there_and_described(written, result):
    page = Page(written)
    images = [image for image in page.all("img") if "src" in image]
    assert len(images) == 3 + 6 + 1 + 2 * 2 + 1 + 4 + 3  # rooms, run, lintel, shots, 2nd, charts
    for image in images:
        assert len(image["alt"]) > 15
        pixels = cv2.imread(str(written.parent / image["src"]), cv2.IMREAD_COLOR)
        assert pixels.shape[:2] == (int(image["height"]), int(image["width"]))
    captions = page.text
    assert f"All {len(result.topomap.edges):,} edges" in captions
    assert f"The {len(result.kept):,} edges kept" in captions
    assert "no node wrong" in captions
    stored = {path.name for path in (written.parent / "images").iterdir()}
    assert stored == {Path(image["src"]).name for image in images}


def test_each_picture_opens_large_without_the_script(written):
    links = [a["href"] for a in Page(written).all("a")]
    assert {h for h in links if h.startswith("images/")} == {
        image["src"] for image in Page(written).all("img") if "src" in image
    }
    anchors = {s["id"] for s in Page(written).all("section")}
    assert {h[1:] for h in links if h.startswith("#")} == anchors


def test_nothing_comes_from_elsewhere(written):
    html = written.read_text(encoding="utf-8")
    assert not re.search(r"https?:|@import|url\(", html)
    assert "src" not in Page(written).all("script")[0]
    assert not Page(written).all("link")


def test_hostile_names_are_text(report, result, tmp_path):
    topomap = replace(result.topomap, environment=HOSTILE, run=HOSTILE)
    place = Place(
        HOSTILE, (replace(result, topomap=topomap),), HOSTILE, facts=(Fact(HOSTILE, HOSTILE),)
    )
    table = Comparison(HOSTILE, (Measure(HOSTILE, 1.0),), HOSTILE)
    hostile = Report(HOSTILE, HOSTILE, HOSTILE, (place,), HOSTILE, (), (table,))
    page = Page(write_report(hostile, tmp_path))
    assert len(page.all("script")) == 1
    assert not [tag for tag, attributes in page.tags if "onerror" in attributes]
    assert page.text.count("alert(1)") >= 10
    for path in (tmp_path / "images").iterdir():
        assert re.fullmatch(r"[a-z0-9-]+\.png", path.name)


def test_a_report_without_results_has_no_results(tmp_path):
    place = Place("Bare", (MapResult(replace(cleaned_flat(), ground_truth=None, path=None)),))
    page = Page(
        write_report(Report("Bare", "now", "roomseg", (place, Place("None yet", ()))), tmp_path)
    )
    assert [section["id"] for section in page.all("section")] == ["place-1", "place-2"]
    assert "impurity" not in page.text


def test_the_old_report_survives_a_failure(report, tmp_path, monkeypatch):
    report = replace(report, places=())
    old = write_report(replace(report, roc_with_images=()), tmp_path)
    html, images = old.read_text(), sorted((tmp_path / "images").iterdir())

    def fail(*_):
        raise OSError("disk full")

    with monkeypatch.context() as patch:
        patch.setattr(page_module, "write_text", fail)
        with pytest.raises(OSError, match="disk full"):
            write_report(report, tmp_path)
    assert old.read_text() == html
    assert set(images) <= set((tmp_path / "images").iterdir())


def test_writing_again_changes_nothing_and_drops_old_pictures_only(report, tmp_path):
    report = replace(report, places=())
    small = replace(report, roc_with_images=())
    write_report(report, tmp_path)
    assert list((tmp_path / "images").glob("roc-with-images-*"))
    (tmp_path / "images" / "mine.png").write_bytes(b"keep")
    first = write_report(small, tmp_path).read_bytes()
    pictures = {p.name: p.read_bytes() for p in (tmp_path / "images").iterdir()}
    assert write_report(small, tmp_path).read_bytes() == first
    assert {p.name: p.read_bytes() for p in (tmp_path / "images").iterdir()} == pictures
    assert "mine.png" in pictures
    assert not [name for name in pictures if name.startswith("roc-with-images")]
    assert not list(tmp_path.glob(".*"))


def test_spread_is_mean_and_median():
    assert Spread.of([0.0, 0.1, 0.5]) == Spread(pytest.approx(0.2), 0.1)
    assert Spread.of([]) is None


@pytest.mark.parametrize(("value", "agrees"), [(0.45, True), (0.55, True), (0.56, False)])
def test_measures_agree_within_the_accepted_range(value, agrees):
    assert Measure("x", value, 0.5, (0.45, 0.55)).agrees is agrees
    assert Measure("x", value).agrees is None
