"""The self-contained page of a map."""

from __future__ import annotations

import shutil
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from cleaned_flat import cleaned_flat, fisheye_image

from dataset import write_map, write_rooms
from roomseg.cli.main import main

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

DRIVEN = """() => {
  const paths = [...Bokeh.documents[0]._all_models.values()].filter((m) => m.name == "path")
  return [paths[0].data_source.data.x.length, paths[0].visible]
}"""
"""How many poses of the path are shown, and whether they are."""


class Tags(HTMLParser):
    """The tags of a page, and what they load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.loaded: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append(tag)
        self.loaded += [value or "" for name, value in attrs if name in ("src", "href")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    flat = replace(cleaned_flat("</script><b>flat"), camera=cleaned_flat().camera.resized(32))
    image = fisheye_image(flat.camera)
    write_map(folder / "flat.h5", flat, [image if n % 2 else None for n in range(len(flat.nodes))])
    write_rooms(folder / "flat.h5", flat.ground_truth.room, model="<i>mine</i>", rooms=3)
    write_map(folder / "real.h5", replace(cleaned_flat(real=True), ground_truth=None))
    return folder


@pytest.mark.parametrize("name", ["flat", "real"])
def test_the_page_loads_nothing(folder: Path, name: str) -> None:
    page = folder / f"{name}.html"
    assert main(["view", str(folder / f"{name}.h5"), "-o", str(page)]) == 0
    tags = Tags()
    tags.feed(page.read_text(encoding="utf-8"))
    assert {"html", "script", "style"} <= set(tags.found)
    assert tags.loaded == []
    assert "b" not in tags.found, "names are no HTML"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["flat.h5", "--show", "run", "-o", "x.html"], "has all layers"),
        (["sim4", "-o", "x.html"], "a page is of a map"),
        (["flat.h5", "--browser", "-o", "x.png"], "expected -o FILE.html"),
        (["none.h5", "-o", "x.html"], "none.h5"),
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
    assert main(["view", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and expected in error
    assert not (folder / "x.html").exists()


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium; setup.sh installs it where it can")
def test_the_page_in_a_browser(folder: Path) -> None:
    from playwright.sync_api import sync_playwright

    page_file = folder / "shown.html"
    assert main(["view", str(folder / "flat.h5"), "-o", str(page_file)]) == 0
    asked: list[str] = []
    errors: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(page_file.as_uri())
        page.wait_for_function("() => globalThis.Bokeh?.documents?.[0]?.is_idle", timeout=60_000)
        page.locator("select").select_option("passageway_width")
        page.locator(".noUi-handle").first.press("Home")
        driven = page.evaluate(DRIVEN)
        browser.close()
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert errors == []
    assert driven == [1, True], "at its beginning one pose is driven"
