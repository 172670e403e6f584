"""What docs/scenes.md and docs/pieces.md show and list is what the code has."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import pytest

from scenes import Apartment, apartment_from_json, check, reachable_positions
from scenes.apartment import Block, Passage, Room, RoomKind, Threshold
from scenes.materials import BUILT_IN
from scenes.pieces import KINDS
from test_scenes.places import two_rooms
from test_scenes.test_pieces import UNDER

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "scenes.md").read_text(encoding="utf-8")
PIECES = (DOCS / "pieces.md").read_text(encoding="utf-8")
ROWS = {
    row[0]: row[1:]
    for row in re.findall(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \| (\w+) \| (.*) \|$", PIECES, re.M)
}
"""Size, slots, beneath and summary of every kind in the tables."""


def test_example_is_a_good_apartment():
    place = apartment_from_json(PAGE.split("```json")[1].split("```")[0])
    assert len(reachable_positions(place)) > 1000


EXAMPLES = [json.loads(part.split("```")[0]) for part in PAGE.split("```json")[1:]]


@pytest.mark.parametrize("fields", EXAMPLES[1:], ids=lambda fields: next(iter(fields)))
def test_further_fields_go_with_the_example(fields):
    assert list(check(Apartment.model_validate(EXAMPLES[0] | fields))) == []


def test_the_page_says_what_an_apartment_and_a_room_may_have():
    models = (Apartment, Block, Passage, Room, Threshold)
    fields = {name for model in models for name in model.model_fields}
    assert [name for name in sorted(fields) if not re.search(rf"\b{name}\b", PAGE)] == []
    assert all(f"`{kind}`" in PAGE for kind in get_args(RoomKind))


def test_examples_of_pieces_and_materials_are_good():
    piece, materials = (json.loads(part.split("```")[0]) for part in PIECES.split("```json")[1:])
    place = two_rooms(furniture=[piece], **materials)
    assert not list(check(place)) and len(place.materials) == 3


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_every_material_is_listed(name):
    assert f"`{name}`" in PIECES


def test_every_kind_is_listed():
    assert set(ROWS) == set(KINDS)


@pytest.mark.parametrize("name", sorted(KINDS))
def test_what_the_tables_say_of_a_kind(name):
    kind, (size, slots, beneath, summary) = KINDS[name], ROWS[name]
    assert size == " × ".join(f"{length:g}" for length in kind.size)
    assert slots == ", ".join(f"{slot} ({material})" for slot, material in kind.slots.items())
    assert name in UNDER[beneath].split()
    hangs = f" Hangs at {kind.elevation:g} m." if kind.elevation else ""
    assert summary == kind.summary + hangs


def test_the_example_of_a_new_kind_is_a_kind():
    import scenes.parts

    code = PIECES.split("```python")[1].split("```")[0]
    names = {name: getattr(scenes.parts, name) for name in scenes.parts.__all__}
    exec(compile("from __future__ import annotations\n" + code, "pieces.md", "exec"), names)
    parts = list(names["footstool"]())
    assert len(parts) == 5 and max(part.top for part in parts) == pytest.approx(0.4)
