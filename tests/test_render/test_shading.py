"""Materials as Blender holds them."""

from __future__ import annotations

from typing import Any

import pytest


def test_tiles_have_their_size_in_metres(probed: dict[str, Any]) -> None:
    assert probed["tile"] == pytest.approx([0.3, 0.3])


def test_every_pattern_makes_a_surface(probed: dict[str, Any]) -> None:
    assert probed["patterns_linked"].all()
    assert len(probed["patterns_linked"]) == 11
