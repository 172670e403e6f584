"""Files that are read back, and bad files with what is said about each."""

from __future__ import annotations

import json
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import (
    Apartment,
    SceneError,
    apartment_from_json,
    apartment_to_json,
    load_apartment,
    reference_names,
    save_apartment,
)
from test_scenes.places import framed, two_rooms, two_rooms_data


def refused(source):
    with pytest.raises(SceneError) as error:
        load_apartment(source)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "home.json"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def dumped(**changes):
    return json.dumps(two_rooms_data(**changes))


def test_saved_apartment_is_read_back(tmp_path):
    place = two_rooms(
        passages=framed(),
        furniture=[{"kind": "rug", "position": [2, 1], "materials": {"fabric": "own"}}],
        materials={"own": {"pattern": "carpet", "colour": [0.1, 0.2, 0.3]}},
    )
    path = tmp_path / "home.json"
    save_apartment(place, path)
    assert load_apartment(path) == place
    assert load_apartment(str(path)) == place
    first = path.read_bytes()
    save_apartment(load_apartment(path), path)
    assert path.read_bytes() == first
    assert [item.name for item in tmp_path.iterdir()] == ["home.json"]


def test_every_thing_has_a_line_of_its_own_and_defaults_are_left_out():
    place = two_rooms()
    lines = [line.strip().rstrip(",") for line in apartment_to_json(place).splitlines()]
    assert sum(line.startswith('{"name": ') for line in lines) == len(place.rooms)
    assert any('"polygon": [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]' in x for x in lines)
    assert not any("null" in line or '"closed": false' in line for line in lines)


finite = st.floats(-1000, 1000)
positive = st.floats(1e-3, 1000)


@settings(max_examples=60, deadline=None)
@given(
    polygon=st.lists(st.tuples(finite, finite), min_size=3, max_size=9),
    height=positive,
    colour=st.tuples(*[st.floats(0, 1)] * 3),
    text=st.text(max_size=30),
)
def test_json_keeps_every_number(polygon, height, colour, text):
    data = two_rooms_data(description=text, materials={"own": {"colour": colour}})
    data["rooms"][0].update(polygon=polygon, ceiling_height=height)
    place = Apartment.model_validate(data)
    assert apartment_from_json(apartment_to_json(place), checked=False) == place


@pytest.mark.parametrize("name", reference_names())
def test_reference_places_are_read_by_name(name):
    assert load_apartment(name).name == name


def test_byte_order_mark_is_read(write):
    assert load_apartment(write(b"\xef\xbb\xbf" + dumped().encode())) == two_rooms()


def test_missing_file():
    message = refused("nowhere/home.json")
    assert message.startswith("nowhere/home.json: no such file, nor a reference place (")


def test_folder(tmp_path):
    assert refused(tmp_path).endswith("cannot be read: Is a directory")


@pytest.mark.parametrize(
    "text, expected",
    [
        (b"\xff\xfe{}", "byte 0 is not UTF-8; expected a JSON text file"),
        ("", "line 1, column 1: not JSON: Expecting value"),
        ('{"name": "x",\n "rooms": [}', "line 2, column 12: not JSON: Expecting value"),
        ('{"name": "x", "name": "y"}', "field 'name' is given twice; expected once"),
        ('{"name": NaN}', "NaN is not a JSON number; expected a finite one"),
        ("[" * 100_000, "nested too deeply or a number too long"),
        ("[]", "the file: []; expected an object with fields"),
        (dumped(colour=3), "colour: unknown field; expected one of format, format_version, name"),
        (
            dumped(passages=framed(threshold={"height": 0.02})),
            "passages[0].threshold.height: 0.02; expected at most 0.01",
        ),
        (dumped(wals=[]), "wals: unknown field; did you mean 'walls'?"),
        (dumped(name="two rooms"), "name: 'two rooms'; expected letters, digits, '_', '.', '-'"),
        (dumped(rooms=[]), "rooms: []; expected at least 1, not 0"),
        (
            dumped(blocks=[{"polygon": [[0, 0], [1, 1]]}]),
            "blocks[0].polygon: [[0, 0], [1, 1]]; expected at least 3, not 2",
        ),
        (dumped(walls={"a": 1}), "walls: {'a': 1}; expected a list"),
        (dumped(passages=[{"position": 4}]), "passages[0].position: 4; expected a list"),
        (dumped(description=4), "description: 4; expected a text"),
        (dumped(start={"position": [2000, 0]}), "start.position[0]: 2000; expected at most 1000"),
        (dumped(format_version=2), "format_version: 2; expected 1"),
        (
            dumped(passages=[{"position": [4.05, 1.5], "widht": 1}]),
            "passages[0].widht: unknown field; did you mean 'width'?",
        ),
        (
            dumped(passages=[{"position": [4.05, 1.5], "frame": {"wide": 1}}]),
            "passages[0].frame.wide: unknown field; did you mean 'width'?",
        ),
        (
            dumped(materials={"own": {"color": [0, 0, 0]}}),
            "materials.own.color: unknown field; did you mean 'colour'?",
        ),
        (dumped(passages=[{"width": 1.0}]), "passages[0].position: missing; expected a value"),
        (
            dumped(passages=[{"position": [4.05, 1.5], "width": -1}]),
            "passages[0].width: -1; expected above 0",
        ),
        (
            dumped(passages=[{"position": [4.05, "1.5"]}]),
            "passages[0].position[1]: '1.5'; expected a number",
        ),
        (
            dumped(lamps=[{"kind": "neon", "position": [1, 1]}]),
            "lamps[0].kind: 'neon'; expected 'ceiling', 'pendant', 'floor' or 'table'",
        ),
        (
            dumped(passages=[{"position": [3, 1.5]}]),
            "passages[0].position: (3, 1.5) lies on no wall's centre line;",
        ),
    ],
)
def test_bad_files_are_named(write, text, expected):
    path = write(text)
    assert refused(path).startswith(f"{path}: {expected}")


def test_further_problems_are_counted(write):
    boxes = [{"kind": "box", "position": [k, 9]} for k in range(3)]
    assert refused(write(dumped(furniture=boxes))).endswith("(and 2 more problems)")
    assert refused(write(dumped(a=1, b=2))).endswith("(and 1 more problem)")


def test_what_is_no_file_is_not_replaced_and_a_link_stays(tmp_path):
    pipe, link, file = (tmp_path / f"{name}.json" for name in ("pipe", "link", "file"))
    os.mkfifo(pipe)
    with pytest.raises(SceneError, match=r"pipe\.json: is no regular file"):
        save_apartment(two_rooms(), pipe)
    assert pipe.is_fifo()
    link.symlink_to(file)
    save_apartment(two_rooms(), link)
    assert link.is_symlink()
    assert load_apartment(file) == two_rooms()
    assert len(list(tmp_path.iterdir())) == 3


def test_an_apartments_name_ends_in_json(tmp_path):
    with pytest.raises(SceneError, match=r"home\.txt: .* ends in \.json"):
        save_apartment(two_rooms(), tmp_path / "home.txt")
    assert not list(tmp_path.iterdir())


def test_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "home.json"
    save_apartment(two_rooms(), path)
    before = path.read_bytes()

    def full(_handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(SceneError, match=r"home\.json: cannot be written: No space left"):
        save_apartment(two_rooms(name="other"), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_folder_that_is_not_there(tmp_path):
    with pytest.raises(SceneError, match="cannot be written: No such file"):
        save_apartment(two_rooms(), tmp_path / "no" / "home.json")


def test_schema_is_generated_from_the_model():
    schema = Apartment.model_json_schema()
    assert schema["required"] == ["name", "rooms", "start"]
    assert schema["additionalProperties"] is False
