"""The gallery's page shows what there is, and only what has changed is rendered again."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from scenes import load_apartment

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def gallery(tmp_path, monkeypatch):
    """The command with a quick renderer, writing below a folder of its own."""
    spec = importlib.util.spec_from_file_location("gallery", ROOT / "docs" / "gallery.py")
    module = importlib.util.module_from_spec(spec)
    # The dataclass in it looks its module up.
    monkeypatch.setitem(sys.modules, "gallery", module)
    spec.loader.exec_module(module)
    module.drawn = []

    def draw(apartment, path, *, size, samples):
        module.drawn.append(apartment.name)
        cv2.imwrite(str(path), np.full((size // 2, size, 3), 200, np.uint8))

    monkeypatch.setattr(module, "draw_cutaway", draw)
    monkeypatch.setattr(module, "HERE", tmp_path)
    monkeypatch.setattr(module, "reference_names", lambda: ["demo1", "real3", "sim4"])
    return module


def run(gallery, tmp_path, *arguments: str) -> None:
    fixed = ["--seeds", "2", "--size", "64", "-o", str(tmp_path / "work")]
    result = CliRunner().invoke(gallery.main, [*fixed, *arguments], catch_exceptions=False)
    assert result.exit_code == 0


def test_every_place_and_seed_has_its_picture(gallery, tmp_path):
    run(gallery, tmp_path)
    assert gallery.drawn == ["sim4", "real3", "home-1", "home-2"]
    page = (tmp_path / "gallery.md").read_text()
    shown = sorted(path.name for path in (tmp_path / "gallery").iterdir())
    assert shown == ["homes-1.jpg", "real3.jpg", "sim4.jpg"]
    assert all(f"(gallery/{name})" in page for name in shown)
    assert "sim4: 5 rooms, 46 m²" in page
    assert load_apartment("sim4").description in " ".join(page.split())


def test_only_what_has_changed_is_rendered_again(gallery, tmp_path, monkeypatch):
    run(gallery, tmp_path)
    gallery.drawn.clear()
    run(gallery, tmp_path)
    assert gallery.drawn == []

    def changed(name):
        place = load_apartment(name)
        return place.model_copy(update={"lamps": ()}) if name == "real3" else place

    monkeypatch.setattr(gallery, "load_apartment", changed)
    run(gallery, tmp_path)
    assert gallery.drawn == ["real3"]
    run(gallery, tmp_path, "--samples", "2")
    assert len(gallery.drawn) == 5
