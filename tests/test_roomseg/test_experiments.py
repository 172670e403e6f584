"""Search spaces, tables and parts of the experiments; and all of them on made-up features."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest
from cleaned_flat import floor, obstacles
from made_up_features import map_features

from dataset import FormatError
from roomseg.classifier import ClassifierParameters
from roomseg.evaluation import leave_one_environment_out
from roomseg.experiments import QUICK_SETTINGS, Cache, FloorPlan, Settings, paper, reproduce
from roomseg.experiments.grids import (
    BASIC,
    EXTRAFINE,
    FINE,
    FULL,
    NO_CAMERA,
    NO_CEILING,
    Grid,
)
from roomseg.experiments.maps import Maps, judged
from roomseg.experiments.searches import Search, search
from roomseg.experiments.tables import Cell, Row, Table
from roomseg.feature_set import MapFeatures
from roomseg.report.reproduction_page import write_reproduction

TINY = Grid((-3.0,), (-5.0, -3.0), (40.0,), (20.0, 60.0))
TINIEST = {"tiniest": Grid((-3.0,), (-3.0,), (40.0,), (60.0,))}
SETTINGS = Settings({"tiny": TINY}, dict.fromkeys(QUICK_SETTINGS.variants, TINIEST))


def test_spaces_have_the_sizes_of_tables_4_and_9():
    sizes = [len(set(grid.combinations())) for grid in (FULL, FINE, EXTRAFINE, BASIC)]
    assert sizes == [1440, 600, 495, 480]
    basic = set(BASIC.combinations())
    assert len(set(NO_CAMERA.combinations()) - basic) == 316
    assert len(set(NO_CEILING.combinations()) - basic) == 300
    assert basic < set(NO_CEILING.combinations())
    assert basic < set(FULL.combinations())


def test_the_papers_choice_lies_in_its_spaces():
    for grid in (FULL, FINE, EXTRAFINE, BASIC):
        assert ClassifierParameters() in grid.combinations()
    for name, grid in (("no-camera", NO_CAMERA), ("no-pano", BASIC), ("no-ceiling", NO_CEILING)):
        c, gamma, weight, rho = paper.VARIANTS[name][:4]
        assert ClassifierParameters(2.0**c, 2.0**gamma, weight, rho) in grid.combinations()


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        (Cell(0.69, 0.71, (0.65, 0.77)), "0.69 here, 0.71 in the paper (0.02 lower); within"),
        (Cell(4.0, 1.04), "4.00 here, 1.04 in the paper (2.96 higher)"),
        (Cell(3.2, 3.13, (-np.inf, 3.13)), "outside what we accept, at most 3.13"),
        (Cell(0.4, 0.42, (0.42, np.inf)), "outside what we accept, at least 0.42"),
        (Cell(0.943, 0.87, (0.80, 0.94)), "0.94 here, 0.87 in the paper (0.07 higher) (exactly"),
    ],
)
def test_a_sentence_says_what_differs(cell, said):
    (sentence,) = Table("t", "T", ("", "value"), (Row("length", (cell,)),)).sentences
    assert sentence.startswith("length: ")
    assert said in sentence


def test_no_sentence_where_nothing_differs_as_written():
    cells = (Cell(0.714, 0.71, (0.6, 0.8)), Cell(None, 0.3), Cell(0.3), Cell(float("nan")))
    table = Table("t", "T", ("", *"abcd"), (Row("x", cells),))
    assert table.sentences == ()
    assert [cell.written for cell in cells] == ["0.71", "–", "0.30", "–"]


def test_what_is_outside_is_told_even_where_differences_are_not():
    cells = (Cell(4.0, 3.13, (-np.inf, 3.13)), Cell(1.0, 2.0), Cell(1.0, 2.0, expected=True))
    table = Table("t", "T", ("", *"abc"), (Row("x", cells),), said=False)
    assert table.sentences == ()
    assert len(table.misses) == 1
    assert table.misses[0].startswith("x, a: 4.00 here, 3.13 in the paper (0.87 higher); outside")
    told = replace(table, said=True).sentences
    assert [sentence[:4] for sentence in told] == ["x, a", "x, b"]


def test_a_table_as_csv():
    rows = (Row("a, b", (Cell(1 / 3, 0.3, (0.2, 0.4)),)), Row("c", (Cell(None, 2.0),)))
    table = Table("t", "T", ("name", "value"), rows)
    assert list(csv.reader(io.StringIO(table.csv()))) == [
        ["name", "value", "value (paper)", "value (accepted)"],
        ["a, b", "0.3333333333", "0.3", "within 0.20 to 0.40"],
        ["c", "", "2", ""],
    ]
    with pytest.raises(ValueError, match="t: c: 1 cells, expected 2"):
        Table("t", "T", ("name", "x", "y"), rows[1:])


def test_the_cache_keeps_by_content(tmp_path):
    made = []

    def make():
        made.append(1)
        return {"x": np.arange(3)}

    cache = Cache(tmp_path / "cache")
    for depends in ((1, "a"), (1, "a"), (1, "b")):
        np.testing.assert_array_equal(cache.get("some", depends, make)["x"], [0, 1, 2])
    assert len(made) == 2
    for path in (tmp_path / "cache").iterdir():
        path.write_bytes(path.read_bytes()[:40])
    np.testing.assert_array_equal(cache.get("some", (1, "a"), make)["x"], [0, 1, 2])
    assert len(made) == 3
    Cache().get("some", (1, "a"), make)
    assert len(made) == 4


@pytest.fixture(scope="module")
def features() -> list[MapFeatures]:
    return [
        map_features("a", 1),
        map_features("a", 2, "run2"),
        map_features("b", 3),
        map_features("c", 4),
        map_features("a", 5, "new1"),
        map_features("novel", 6),
    ]


@pytest.fixture(scope="module")
def maps(features) -> Maps:
    return Maps.of(features, 41)


def test_maps_play_their_parts(maps, features):
    assert [item.name for item in maps.reference] == ["a/run1", "a/run2", "b/run1", "c/run1"]
    assert [item.name for item in maps.new] == ["a/new1"]
    assert [item.name for item in maps.novel] == ["novel/run1"]
    np.testing.assert_array_equal(
        maps.reference[2].features.column("passageway"), features[2].passageway[41]
    )
    assert maps.identity != Maps.of(features, 40).identity
    other = replace(features[0], key="f" * 32)
    assert maps.identity != Maps.of([other, *features[1:]], 41).identity
    plain = maps.with_features("no-camera")
    assert plain.reference[0].features.names == ("length", "passageway_width")
    assert plain.identity != maps.identity
    with pytest.raises(FormatError, match="1 environments, expected at least 2"):
        Maps.of([features[0], features[5]], 41)


def test_judging_is_leave_one_environment_out_and_is_kept(maps, tmp_path):
    parameters, cache = ClassifierParameters(C=1.0), Cache(tmp_path)
    found = judged(maps, maps.reference, parameters, cache)
    alone = leave_one_environment_out(maps.reference, parameters)
    again = judged(maps, maps.reference, parameters, cache)
    assert len(list(tmp_path.iterdir())) == 1
    for one, other, third in zip(found, alone.results, again, strict=True):
        for name in ("labels", "predicted", "uniform_labels"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
            np.testing.assert_array_equal(getattr(third, name), getattr(other, name))
        assert one.quality == other.quality == third.quality


def test_a_search_is_leave_one_environment_out_and_goes_on(maps, tmp_path):
    steps = []

    def stop(done, total):
        steps.append(done)
        if done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search(maps, TINY, "tiny", Cache(tmp_path), progress=stop)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert len(kept) == 2
    found = search(maps, TINY, "tiny", Cache(tmp_path))
    assert found.impurity.shape == (4, 4)
    assert all(path.stat().st_mtime_ns == time for path, time in kept.items())
    for index in (0, 3):
        alone = leave_one_environment_out(maps.reference, found.combinations[index])
        np.testing.assert_array_equal(found.impurity[index], alone.impurity)
    assert found.lowest == found.impurity.mean(axis=1).min()
    assert found.best == found.combinations[int(found.impurity.mean(axis=1).argmin())]


def test_searches_are_joined_without_repeating():
    some = [ClassifierParameters(rho=rho) for rho in (10.0, 20.0, 30.0)]
    first = Search(tuple(some[:2]), np.array([[0.2, 0.4], [0.1, 0.1]]))
    second = Search(tuple(some[1:]), np.array([[0.9, 0.9], [0.0, 0.1]]))
    both = first.joined(second)
    assert both.combinations == tuple(some)
    assert both.best == some[2]
    np.testing.assert_allclose(both.mean, [0.3, 0.1, 0.05])
    np.testing.assert_array_equal(both.order, [2, 1, 0])


@pytest.fixture(scope="module")
def reproduction(features, tmp_path_factory):
    plan = FloorPlan(obstacles(), floor())
    folder = tmp_path_factory.mktemp("cache")
    told = Counter()

    def tell(what, done, total):
        told[what] = max(told[what], done)

    plans = {"a": plan, "b": plan, "novel": plan}
    found = reproduce(features, plans, SETTINGS, Cache(folder), tell=tell)
    assert told["search tiny"] == 6  # two γ, three places
    assert told["search no-obst, tiniest"] == 3
    before = {path.name for path in folder.iterdir()}
    again = reproduce(features, plans, SETTINGS, Cache(folder))
    assert {path.name for path in folder.iterdir()} == before
    tables = [[t for s in r.sections for t in s.tables] for r in (found, again)]
    assert [t.csv() for t in tables[0]] == [t.csv() for t in tables[1]]
    return found


def table_of(reproduction, name: str) -> Table:
    (found,) = (t for s in reproduction.sections for t in s.tables if t.name == name)
    return found


def test_the_best_passageway_parameters_are_found(reproduction):
    # Of made-up values the later combinations are the better ones.
    assert reproduction.passageway >= 38
    assert "I_min = 400" in table_of(reproduction, "table2").note


def test_every_table_of_the_paper_is_there(reproduction):
    names = {t.name for s in reproduction.sections for t in s.tables}
    assert {f"table{n}" for n in (1, 2, 3, 4, 5, 7, 8, 9, 10)} <= names
    assert {"segmentation", "environments", "maps", "new-runs", "novel"} <= names
    rows = {row.label: row for row in table_of(reproduction, "table10").rows}
    assert list(rows) == list(paper.VARIANTS)
    best = reproduction.segmentations
    mean = np.mean([judged.impurity for judged in best.maps])
    assert rows["default"].cells[4].ours == pytest.approx(mean)
    assert rows["default"].cells[4].paper == 3.13
    uniform = np.mean([judged.uniform_impurity for judged in best.maps])
    assert rows["uniform"].cells[4].ours == pytest.approx(uniform)


def test_the_report_has_every_table_figure_and_sentence(reproduction, tmp_path):
    page = write_reproduction(reproduction, tmp_path, software="roomseg <1>")
    html = page.read_text(encoding="utf-8")
    assert "roomseg &lt;1&gt;" in html
    assert not re.search(r"https?:|@import|url\(", html)
    assert_nested(html)
    for section in reproduction.sections:
        for table in section.tables:
            assert (tmp_path / "tables" / f"{table.name}.csv").read_text() == table.csv()
            assert f'href="tables/{table.name}.csv"' in html
        for drawing in section.drawings:
            assert f'src="figures/{drawing.name}.png"' in html
            picture = cv2.imread(str(tmp_path / "figures" / f"{drawing.name}.png"))
            assert min(picture.shape[:2]) > 300
            assert np.ptp(picture) > 150
            assert (tmp_path / "figures" / f"{drawing.name}.pdf").read_bytes()[:5] == b"%PDF-"
    assert {"fig11", "fig13", "fig15", "fig22", "fig26", "fig27", "fig28", "fig29"} <= {
        drawing.name for section in reproduction.sections for drawing in section.drawings
    }
    assert "Edge length, area under curve: " in html


def assert_nested(html: str) -> None:
    """Every tag that opens is closed in turn."""
    opened = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, _):
            opened.extend([tag] * (tag not in ("meta", "img", "br")))

        def handle_endtag(self, tag):
            assert opened.pop() == tag

    Reader().feed(html)
    assert opened == []


def test_an_earlier_reports_files_go(reproduction, tmp_path):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "fig99.png").write_text("old")
    (tmp_path / "figures" / "my notes.txt").write_text("mine")
    write_reproduction(reproduction, tmp_path, software="")
    left = {path.name for path in (tmp_path / "figures").iterdir()}
    assert "fig99.png" not in left
    assert "my notes.txt" in left
