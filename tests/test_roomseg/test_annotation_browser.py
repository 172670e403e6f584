"""The page of `roomseg annotate`, driven by a browser as a person does it."""

from __future__ import annotations

import http.client
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import FIND_FIGURE, TO_PAGE, chromium, needs_chromium
from cleaned_flat import cleaned_flat, fisheye_image

from dataset import problems, read_map, write_map
from roomseg.annotation.carrying import carried_to_map
from roomseg.annotation.journal import journal_path
from roomseg.cli.main import main

pytestmark = needs_chromium
FLAT = cleaned_flat("flat")
DOORS = carried_to_map(FLAT.nodes, FLAT.ground_truth.borders)[[1, 4]]
"""The middle line of either doorway."""
IMAGE_SIZES = """() => {
  const all = (root) => [...root.querySelectorAll("*")].flatMap((e) =>
    [...(e.tagName == "IMG" ? [e] : []), ...(e.shadowRoot ? all(e.shadowRoot) : [])])
  const sizes = all(document).map((image) => [image.naturalWidth, image.naturalHeight])
  return JSON.stringify(sizes) == "[[48,48],[288,48]]"
}"""


class Tab:
    """A browser tab with the page, and a hand on the mouse."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on(
            "console",
            lambda message: self.errors.append(message.text) if message.type == "error" else None,
        )

    def open(self, url: str) -> None:
        self.page.goto(url)
        self.page.wait_for_function(
            f"() => globalThis.Bokeh?.documents?.[0]?.is_idle && ({FIND_FIGURE})() != null",
            timeout=60_000,
        )
        self.until("status.text.includes('border')")

    def until(self, condition: str) -> None:
        """Wait until something holds of the document's models, by their names."""
        names = sorted(
            set(re.findall(r"\b(status|message|nodes|borders|rooms|leaks|node)\b\.", condition))
        )
        models = ", ".join(f"{n} = Bokeh.documents[0].get_model_by_name('{n}')" for n in names)
        self.page.wait_for_function(
            f"() => {{ const {models}; return {condition} }}", timeout=30_000
        )

    def at(self, point: Any) -> tuple[float, float]:
        x, y = self.page.evaluate(TO_PAGE, [float(point[0]), float(point[1])])
        return x, y

    def drag(self, start: Any, end: Any, *, release: bool = True) -> None:
        self.page.mouse.move(*self.at(start))
        self.page.mouse.down()
        for share in (0.3, 0.7, 1.0):
            self.page.mouse.move(*self.at((1 - share) * np.array(start) + share * np.array(end)))
        if release:
            self.page.mouse.up()

    def click(self, point: Any) -> None:
        self.page.mouse.click(*self.at(point))

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()

    def colours(self) -> list[int]:
        script = "() => [...Bokeh.documents[0].get_model_by_name('nodes').data.colour]"
        return self.page.evaluate(script)


@contextmanager
def serving(*arguments: str | Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "roomseg.cli", "annotate", "--no-open", *map(str, arguments)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"},
    )
    try:
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found is not None, "the server says where it is"
        yield process, found[0]
    finally:
        process.send_signal(signal.SIGINT)
        with suppress(subprocess.TimeoutExpired):
            process.wait(20)
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as browser:
        yield browser


@pytest.fixture
def tab(browser: Any) -> Iterator[Tab]:
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    yield Tab(page)
    page.close()


@pytest.fixture(scope="module")
def maps(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """Two without images and ground truth, one with both."""
    folder = tmp_path_factory.mktemp("maps")
    paths = folder / "drawn.h5", folder / "named.h5", folder / "seen.h5"
    for path in paths[:2]:
        write_map(path, replace(FLAT, ground_truth=None))
    camera = FLAT.camera.resized(48)
    image = fisheye_image(camera)
    images = [image if node % 2 else None for node in range(len(FLAT.nodes))]
    write_map(paths[2], replace(FLAT, camera=camera), images)
    return paths


@pytest.fixture(scope="module")
def url(maps: tuple[Path, Path, Path]) -> Iterator[str]:
    with serving(*maps) as (_, address):
        yield address.rstrip("/")


def test_draw_undo_move_save_and_reload(maps: tuple[Path, Path, Path], url: str, tab: Tab) -> None:
    path = maps[0]
    tab.open(f"{url}/map0")
    assert set(tab.colours()) == {0}
    tab.drag(*DOORS[0], release=False)
    tab.until("borders.data.x0.length == 0")
    tab.page.mouse.up()
    tab.until("status.text.includes('<b>1 border, 2 rooms') && rooms.data.name.length == 2")
    assert len(set(tab.colours())) == 2
    tab.drag(*DOORS[1])
    tab.until("status.text.includes('<b>2 borders, 3 rooms')")
    assert len(set(tab.colours())) == 3
    tab.press("Undo")
    tab.until("status.text.includes('<b>1 border, 2 rooms')")
    assert len(set(tab.colours())) == 2
    tab.page.keyboard.press("Control+y")
    tab.until("status.text.includes('<b>2 borders, 3 rooms')")

    # An end is taken into the room: the border leaks, and the way round it is shown.
    first, second = DOORS[1]
    tab.drag(second, (first + second) / 2)
    tab.until("status.text.includes('leaks: a way round') && leaks.data.xs.length == 1")
    tab.page.keyboard.press("Control+z")
    tab.until("status.text.includes('every border separates')")

    tab.press("Save")
    tab.until("message.text.includes('Saved 2 borders and 3 rooms')")
    assert list(problems(path)) == []
    colours = tab.colours()
    tab.page.reload()
    tab.open(f"{url}/map0")
    tab.until("borders.data.x0.length == 2")
    assert tab.colours() == colours
    truth, own = read_map(path).ground_truth, FLAT.ground_truth.room
    assert truth.room_count == 3
    agreeing = sum(np.bincount(own[truth.room == room]).max() for room in range(3))
    assert agreeing / len(own) > 0.97
    assert tab.errors == []


def test_a_killed_server_loses_nothing(tmp_path: Path, tab: Tab) -> None:
    path = tmp_path / "flat.h5"
    write_map(path, replace(FLAT, ground_truth=None))
    with serving(path) as (process, url):
        tab.open(url)
        tab.drag(*DOORS[0])
        tab.until("status.text.includes('<b>1 border, 2 rooms')")
        tab.drag(*DOORS[1], release=False)
        process.kill()
        process.wait()
    assert journal_path(path).exists()
    assert read_map(path).ground_truth is None
    with serving(path) as (_, url):
        tab.open(url)
        tab.until("message.text.includes('Found again: 1 edits') && borders.data.x0.length == 1")
        assert len(set(tab.colours())) == 2
        tab.press("Undo")
        tab.until("borders.data.x0.length == 0")


def test_rooms_are_named_split_and_merged(
    maps: tuple[Path, Path, Path], url: str, tab: Tab
) -> None:
    inside = FLAT.nodes.position[3]
    tab.open(f"{url}/map1")
    tab.drag(*DOORS[0])
    tab.until("rooms.data.name.length == 2")
    assert tab.page.get_by_role("button", name="Split room").is_disabled()
    tab.click(inside)
    tab.until("rooms.selected.indices.length == 1")
    field = tab.page.get_by_placeholder("name of the selected room")
    field.fill("<i>Küche</i>")
    field.press("Enter")
    tab.until("rooms.data.name.includes('<i>Küche</i>')")
    tab.page.get_by_text("<i>Küche</i>").wait_for()  # in the table, as it was typed
    tab.press("Split room")
    tab.until("rooms.data.name.length == 3")
    tab.press("Undo")
    tab.until("rooms.data.name.length == 2")
    tab.page.keyboard.down("Shift")
    tab.click(FLAT.nodes.position[FLAT.ground_truth.room == 2][0])
    tab.page.keyboard.up("Shift")
    tab.until("rooms.selected.indices.length == 2")
    tab.press("Merge rooms")
    tab.until("rooms.data.name.length == 1 && rooms.data.name[0] == '<i>Küche</i>'")
    field.fill("attic")
    field.press("Control+s")
    tab.until("message.text.includes('Saved 0 borders and 1 room ')")
    assert read_map(maps[1]).ground_truth.room_names == ("attic",)
    assert tab.errors == []


def test_pointing_at_a_node_shows_its_images(url: str, tab: Tab) -> None:
    tab.open(f"{url}/map2")
    tab.until("message.text.includes('carried over')")
    tab.page.mouse.move(*tab.at(FLAT.nodes.position[31]))
    tab.until("node.text.includes('Node 31')")
    tab.page.wait_for_function(IMAGE_SIZES, timeout=30_000)
    tab.page.mouse.move(*tab.at(FLAT.nodes.position[32]))
    tab.until("node.text.includes('no image')")
    assert tab.errors == []


def answer(url: str, path: str, **headers: str) -> int:
    host = url.split("/")[2]
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.putrequest("GET", path, skip_host=True)
    for name, value in ({"Host": host} | headers).items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    return connection.getresponse().status


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def test_other_pages_and_other_names_are_refused(
    maps: tuple[Path, Path, Path], url: str, tab: Tab, tmp_path: Path
) -> None:
    path = maps[0]
    port = url.rsplit(":", 1)[1]
    places = (
        "/",
        "/map0",
        "/map0/autoload.js",
        "/static/js/bokeh.min.js",
        "/favicon.ico",
        "/image/0/0/fisheye.png",
        "/map0/metadata",
    )
    for place in places:
        assert answer(url, place, Host=f"evil.example:{port}") == 403
        assert answer(url, place, Host="127.0.0.1") == 403
        assert answer(url, place, Origin="http://evil.example") == 403
        assert answer(url, place, Origin=f"http://127.0.0.1:{int(port) + 1}") == 403
        assert answer(url, place, Sec_Fetch_Site="cross-site") == 403
    assert answer(url, "/map0", Host=f"localhost:{port}") == 200
    assert answer(url, "/static/js/bokeh.min.js", Origin=url) == 200
    assert answer(url, "/map0/ws", Origin="http://evil.example", **UPGRADE) == 403
    assert answer(url, "/map0/ws", Origin="null", **UPGRADE) == 403
    for place in (
        "/image/0/0/fisheye.png",
        "/image/0/99999/fisheye.png",
        "/image/7/0/fisheye.png",
        "/image/0/../0/fisheye.png",
        "/image/0/%2e%2e/fisheye.png",
        "/static/../../../../etc/passwd",
        "/static/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        f"{path}",
        "/map9",
    ):
        assert answer(url, place) in (403, 404)
    # A page of another origin, in a real browser: neither embedded nor called.
    other = tmp_path / "other.html"
    other.write_text(
        f"<iframe src='{url}/map0'></iframe><script>globalThis.told = null;"
        f"new WebSocket('ws://127.0.0.1:{port}/map0/ws', ['bokeh', 'x'])"
        ".addEventListener('error', () => { told = 'refused' })</script>"
    )
    tab.page.goto(other.as_uri())
    tab.page.wait_for_function("() => told == 'refused'", timeout=30_000)
    assert "refused" in tab.page.frames[1].content()


def test_what_cannot_be_annotated_is_one_line(
    maps: tuple[Path, Path, Path], url: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = url.rsplit(":", 1)[1]
    other = tmp_path / "other.h5"
    write_map(other, replace(FLAT, ground_truth=None))
    for arguments, expected in (
        (["--port", port, other], f"--port {port}: cannot be used"),
        ([maps[0]], "is open in another `roomseg annotate`; end that first"),
        ([tmp_path / "none.h5"], "no such file"),
        ([other, "--model", tmp_path / "none.skops"], "no such file"),
    ):
        assert main(["annotate", "--no-open", *map(str, arguments)]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1 and expected in error
