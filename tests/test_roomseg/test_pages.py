"""The self-contained pages of `roomseg view`."""

from __future__ import annotations

import json
import shutil
import webbrowser
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import TO_PAGE, chromium, needs_chromium
from cleaned_flat import cleaned_flat, fisheye_image
from small_flats import two_rooms

from dataset import write_map, write_rooms
from roomseg.classifier import ClassifierParameters, load_model, save_model
from roomseg.cli.main import main
from roomseg.evaluation import train_on
from roomseg.features import edge_features
from roomseg.labelled_map import LabelledMap

NAME = "</script><b>flat"
FLAT = replace(cleaned_flat(NAME), camera=cleaned_flat().camera.resized(32))

MODEL = "(name) => Bokeh.documents[0].get_model_by_name(name)"


class Tags(HTMLParser):
    """The tags of a page, and what they load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.loaded: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append(tag)
        self.loaded += [value or "" for name, value in attrs if name in ("src", "href")]


class Page:
    """A page in a browser, which must ask for nothing and make no error."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.asked: list[str] = []
        self.errors: list[str] = []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    def open(self, path: Path) -> None:
        self.page.goto(path.as_uri())
        self.page.wait_for_function(
            "() => globalThis.Bokeh?.documents?.[0]?.is_idle", timeout=60_000
        )

    def of(self, name: str, what: str) -> Any:
        """Something of the model of that name."""
        return self.page.evaluate(f"() => ({MODEL})('{name}').{what}")

    def choose(self, name: str, value: str) -> None:
        self.page.evaluate(f"() => {{ ({MODEL})('{name}').value = '{value}' }}")

    def at(self, point: Any) -> tuple[float, float]:
        x, y = self.page.evaluate(TO_PAGE, [float(point[0]), float(point[1])])
        return x, y

    def until(self, condition: str) -> None:
        self.page.wait_for_function(f"() => {condition}", timeout=30_000)

    def cell(self, text: str) -> Any:
        """A cell of a table."""
        return self.page.locator(".slick-cell").get_by_text(text, exact=True)

    def visible(self, kind: str) -> list[bool]:
        """Of all renderers of a kind of glyph."""
        return self.page.evaluate(
            "(kind) => [...Bokeh.documents[0]._all_models.values()]"
            ".filter((m) => m.type == 'GlyphRenderer' && m.glyph.type == kind)"
            ".map((m) => m.visible)",
            kind,
        )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    image = fisheye_image(FLAT.camera)
    images = [image if n % 2 else None for n in range(len(FLAT.nodes))]
    room = FLAT.ground_truth.room
    write_map(folder / "flat.h5", FLAT, images)
    write_rooms(folder / "flat.h5", np.where(room == 2, 1, room), model="<i>mine</i>", rooms=2)
    write_map(folder / "real.h5", replace(cleaned_flat(real=True), ground_truth=None))
    truth = replace(FLAT.ground_truth, room=2 - room, room_names=("x", "y", "z"))
    write_map(folder / "copy.h5", replace(FLAT, ground_truth=truth))
    shutil.copy(folder / "flat.h5", folder / "same.h5")
    moved = replace(FLAT.nodes, position=FLAT.nodes.position + 1.0)
    write_map(folder / "moved.h5", replace(FLAT, nodes=moved))
    _write_model(folder / "model.skops")
    home = two_rooms("home", description="<b>a home</b>")
    home["furniture"] = [{"kind": "chair", "position": [2.5, 1.2]}]
    (folder / "home.json").write_text(json.dumps(home))
    write_map(folder / "placed.h5", replace(FLAT, scene=json.dumps(home)))
    return folder


def _write_model(path: Path) -> None:
    class NoImages:
        topomap = FLAT
        done = np.zeros(len(FLAT.nodes), bool)

    features = edge_features(NoImages(), ("length", "passageway_width"))
    item = LabelledMap.of(FLAT, features)
    runs = [replace(item, run=f"run{number}") for number in range(2)]
    save_model(train_on(runs, ClassifierParameters()), path)


@pytest.fixture(scope="module")
def files(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a map, a home, a model, and what is none of them."""
    files = tmp_path_factory.mktemp("files")
    (files / "homes").mkdir()
    (files / ".hidden").mkdir()
    shutil.copy(folder / "home.json", files / "homes")
    shutil.copy(folder / "home.json", files / ".hidden")
    shutil.copy(folder / "flat.h5", files)
    shutil.copy(folder / "model.skops", files)
    (files / "figures.json").write_text("{}")
    (files / "<b>broken.h5").write_text("no map")
    return files


def page_of(folder: Path, *arguments: object) -> Path:
    page = folder / "page.html"
    assert main(["view", *map(str, arguments), "-o", str(page)]) == 0
    return page


@pytest.mark.parametrize("name", ["flat.h5", "real.h5", "home.json", "model.skops", "files"])
def test_the_page_loads_nothing(folder: Path, files: Path, tmp_path: Path, name: str) -> None:
    source = files if name == "files" else folder / name
    tags = Tags()
    tags.feed(page_of(tmp_path, source).read_text(encoding="utf-8"))
    assert {"html", "script", "style"} <= set(tags.found)
    assert tags.loaded == []
    assert "b" not in tags.found, "names are no HTML"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["flat.h5", "--show", "run", "-o", "x.html"], "a page has all layers"),
        (["flat.h5", "--show", "run"], "a page has all layers"),
        (["home.json", "--show", "run", "-o", "x.png"], "says what to draw of a map"),
        (["flat.h5", "--browser", "-o", "x.png"], "expected -o FILE.html"),
        (["none.h5", "-o", "x.html"], "none.h5"),
        (["none.skops", "-o", "x.html"], "none.skops: no such file"),
        (["model.skops", "-o", "x.png"], "a model has a page, expected -o FILE.html"),
        ([".", "-o", "x.png"], "a folder has a page"),
        (["empty", "-o", "x.html"], "empty: no apartment (.json), map (.h5) or model (.skops)"),
        (["sim4", "--cutaway"], "give its name with -o"),
        (["flat.h5", "--compare", "copy.h5", "-o", "x.png"], "only a map's page shows it"),
        (["model.skops", "--compare", "copy.h5", "-o", "x.html"], "only a map's page shows it"),
        (["flat.h5", "--compare", "home.json", "-o", "x.html"], "expected a model (.skops) or a"),
        (["flat.h5", "--compare", "same.h5", "-o", "x.html"], "no rooms but those of flat.h5"),
        (["flat.h5", "--compare", "moved.h5", "-o", "x.html"], "expected a copy of flat.h5"),
        (["flat.h5", "--compare", "none.h5", "-o", "x.html"], "none.h5"),
        (["flat.h5", "--rooms", "3", "-o", "x.html"], "for a model of --compare"),
    ],
)
def test_what_no_page_can_show_is_one_line(
    folder: Path,
    arguments: list[str],
    expected: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(folder)
    (folder / "empty").mkdir(exist_ok=True)
    monkeypatch.setattr(webbrowser, "open", lambda url: pytest.fail("nothing to show"))
    assert main(["view", *arguments]) == 2
    error = capsys.readouterr().err
    error = error[error.index("roomseg: error:") :]
    assert error.count("\n") == 1 and expected in error
    assert not list(folder.glob("x.*"))


def test_without_a_name_the_page_is_opened(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.chdir(folder)
    assert main(["view", "home.json"]) == 0
    (page,) = tmp_path.rglob("*.html")
    assert opened == [page.as_uri()] and page.name == "home.html"
    assert page.parent.stat().st_mode & 0o077 == 0, "nobody else reads it"


def test_a_model_for_real_maps_needs_the_room_count(folder: Path, tmp_path: Path) -> None:
    model = folder / "model.skops"
    page = page_of(tmp_path, folder / "real.h5", "--compare", model, "--rooms", 2)
    assert "rooms by model.skops: 2 rooms" in page.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def tab(browser: Any) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    shown = Page(page)
    yield shown
    page.close()
    own = ("file:", "data:", "blob:")
    assert [url for url in shown.asked if not url.startswith(own)] == []
    assert shown.errors == []


@needs_chromium
def test_a_run_is_replayed_in_the_page(folder: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, folder / "placed.h5"))
    points = tab.of("obstacle points", "data.x.length")
    assert points == len(FLAT.obstacles.time)
    assert tab.of("robot, true path", "data.x.length") == 0, "the run is over"
    tab.page.locator(".noUi-handle").first.press("Home")
    assert tab.of("true path", "data.x.length") == 1, "at its beginning one pose is driven"
    assert tab.of("true path", "data.x[0]") == FLAT.path.true_pose[0, 0]
    assert tab.of("robot, true path", "data.x.length") == 1
    seen = int(np.sum(FLAT.obstacles.time <= 0.0))
    assert tab.of("obstacle points", "data.x.length") == seen < points
    switched = tab.of(
        "layers", "active.map((i) => Bokeh.documents[0].get_model_by_name('layers').labels[i])"
    )
    assert "true path" in switched
    tab.page.get_by_role("button", name="Play").click()
    tab.until(f"({MODEL})('true path').data.x.length > 3")
    tab.page.get_by_role("button", name="Pause").click()
    tab.page.locator(".noUi-handle").first.press("End")
    assert tab.of("obstacle points", "data.x.length") == points


@needs_chromium
def test_two_segmentations_are_compared(folder: Path, tmp_path: Path, tab: Page) -> None:
    compared = ("--compare", folder / "copy.h5", "--compare", folder / "model.skops")
    tab.open(page_of(tmp_path, folder / "flat.h5", *compared))
    names = ["true rooms", "rooms by <i>mine</i>", "true rooms of copy.h5", "rooms by model.skops"]
    assert tab.of("rooms0", "options.map((option) => option[1])") == names
    lost = int(np.sum(FLAT.ground_truth.room == 2))
    # The smaller of the two rooms that were joined differs.
    lost = min(lost, int(np.sum(FLAT.ground_truth.room == 1)))
    assert sum(tab.of("nodes", "data.differs")) == lost
    assert f"{lost} of {len(FLAT.nodes)} nodes differ" in tab.of("about1", "text")
    tab.choose("rooms1", "2")
    assert sum(tab.of("nodes", "data.differs")) == 0, "the same rooms by other names"
    assert sorted(tab.of("names1", "data.name")) == ["x", "y", "z"]
    assert tab.of("names0", "data.name") == ["1", "2", "3"]
    tab.choose("rooms0", "3")
    assert "impurity" not in tab.of("about1", "text")
    ranges = tab.page.evaluate(
        "() => [...Bokeh.documents[0]._all_models.values()]"
        ".filter((m) => m.type == 'Figure').map((m) => m.x_range.id)"
    )
    assert len(ranges) == 2 and len(set(ranges)) == 1, "zoomed together"


@needs_chromium
def test_layers_features_and_images(folder: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, folder / "copy.h5"))
    tab.page.locator("select").select_option("passageway_width")
    assert tab.visible("Segment") == [True]
    widths = tab.of("edge values", "data.value")
    graph_edges = len(tab.of("edge values", "data.x0"))
    assert len(widths) == graph_edges and max(widths) > min(widths) > 0
    assert tab.visible("Text") == [True]
    tab.page.get_by_text("room names").click()
    assert tab.visible("Text") == [False]
    tab.page.mouse.move(*tab.at(FLAT.nodes.position[31]))
    tab.until(f"({MODEL})('node').text.includes('no image')")


@needs_chromium
def test_pointing_at_a_node_shows_its_images(folder: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, folder / "flat.h5"))
    tab.page.mouse.move(*tab.at(FLAT.nodes.position[31]))
    tab.until(f"({MODEL})('node').text.startsWith('<b>Node 31</b>')")
    assert tab.of("node", "text").count('<img src="data:image/jpeg;base64,') == 2


@needs_chromium
def test_rooms_of_an_apartment_are_chosen(folder: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, folder / "home.json"))
    assert tab.of("furniture", "data.name[0]") == "chair"
    assert tab.of("rooms", "data.name") == ["a", "b"]
    tab.page.mouse.click(*tab.at((0.8, 1.4)))
    tab.until(f"({MODEL})('room').text.includes('<dd>a</dd>')")
    assert tab.of("rooms", "selected.indices") == [0]
    assert "<dt>leads to</dt><dd>b</dd>" in tab.of("room", "text")
    tab.cell("b").click()
    tab.until(f"({MODEL})('room').text.includes('<dd>b</dd>')")


@needs_chromium
def test_a_model_tells_what_it_is_made_of(folder: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, folder / "model.skops"))
    assert tab.of("features", "data.feature") == ["edge length, m", "passageway width, m"]
    assert tab.of("maps", "data.run") == ["run0", "run1"]
    assert tab.of("maps", "data.environment[0]") == NAME
    assert tab.of("maps", "data.nodes[0]") == len(FLAT.nodes)
    model = load_model(folder / "model.skops")
    is_border = model.decision_function(model.mean + model.spread * model.points) > 0.0
    kinds = np.where(is_border, "a border edge", "another edge").tolist()
    assert tab.of("points", "data.kind") == kinds


def test_files_are_in_the_order_of_their_numbers(folder: Path, tmp_path: Path) -> None:
    for number in (10, 2):
        shutil.copy(folder / "home.json", tmp_path / f"home-{number}.json")
    page = page_of(folder, tmp_path).read_text(encoding="utf-8")
    assert page.index('"home-2.json"') < page.index('"home-10.json"')


@needs_chromium
def test_a_folder_shows_its_files(files: Path, tmp_path: Path, tab: Page) -> None:
    tab.open(page_of(tmp_path, files))
    names = ["flat.h5", "model.skops", "homes/home.json"]
    assert tab.of("files", "data.name") == names
    assert tab.of("files", "data.kind") == ["map", "model", "apartment"]
    for name in names:
        assert tab.page.get_by_role("heading", name=name).is_visible()
    assert tab.page.get_by_text("<b>broken.h5").count() == 1
    tab.cell("homes/home.json").click()
    tab.page.get_by_role("heading", name="flat.h5").wait_for(state="hidden")
    assert tab.page.get_by_role("heading", name="homes/home.json").is_visible()
