"""What docs/scenes.md shows and lists is what the code has."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenes import apartment_from_json, reachable_positions
from scenes.materials import BUILT_IN
from scenes.pieces import KINDS

PAGE = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")


def test_example_is_a_good_apartment():
    place = apartment_from_json(PAGE.split("```json")[1].split("```")[0])
    assert len(reachable_positions(place)) > 1000


@pytest.mark.parametrize("name", sorted([*KINDS, *BUILT_IN]))
def test_every_kind_and_material_is_listed(name):
    assert f"`{name}`" in PAGE
