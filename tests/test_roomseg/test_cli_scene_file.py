"""An apartment's 3D scene goes with it, from command to command."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from dataset import RoomsegError
from dataset.storage import write_map
from render import preset_named, render_map
from roomseg.cli.main import main
from scenes import load_apartment
from simulator import coverage_report, simulate

CONTENT = b"not Blender's"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home whose scene file is beside it; the working folder is another one."""
    room = [[0, 0], [2, 0], [2, 2], [0, 2]]
    outer = [[-0.1, -0.1], [2.1, -0.1], [2.1, 2.1], [-0.1, 2.1]]
    data = {
        "name": "home",
        "rooms": [{"name": "only", "polygon": room}],
        "blocks": [{"polygon": outer, "holes": [room]}],
        "start": {"position": [1, 1]},
        "scene_file": {"file": "home-1.blend", "sha256": hashlib.sha256(CONTENT).hexdigest()},
    }
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "home-1.blend").write_bytes(CONTENT)
    (tmp_path / "home" / "home.json").write_text(json.dumps(data))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "home" / "home.json"


def test_simulate_puts_the_scene_beside_the_maps(home: Path, capsys) -> None:
    assert main(["simulate", str(home), "-o", "maps"]) == 0
    assert Path("maps/home-1.blend").read_bytes() == CONTENT
    assert Path("maps/home-run1.h5").exists()

    Path("maps/home-1.blend").write_bytes(b"other")
    capsys.readouterr()
    assert main(["simulate", str(home), "-o", "maps"]) == 2
    line = capsys.readouterr().err
    assert line.startswith("roomseg: error: maps/home-1.blend: not the 3D scene that 'home'")
    assert line.count("\n") == 1

    home.with_name("home-1.blend").unlink()
    assert main(["simulate", str(home), "-o", "elsewhere"]) == 2
    assert "home-1.blend: the 3D scene of 'home': No such file" in capsys.readouterr().err
    assert not list(Path("elsewhere").iterdir())


def test_render_names_a_scene_that_is_missing_or_nonsense(home: Path) -> None:
    place = load_apartment(home)
    topomap = simulate(place, run="run1", seed=1, created="1970-01-01T00:00:00Z")
    assert coverage_report(topomap, place).nodes > 0
    write_map("home-run1.h5", topomap)
    with pytest.raises(RoomsegError, match=r"home-1.blend: the 3D scene of 'home': No such file"):
        render_map("home-run1.h5", preset=preset_named("quick"), limit=1)
    Path("home-1.blend").write_bytes(CONTENT)
    with pytest.raises(RoomsegError, match=r"home-1.blend: not a file of Blender") as caught:
        render_map("home-run1.h5", preset=preset_named("quick"), limit=1)
    assert "\n" not in str(caught.value)
    assert Path("home-run1.h5").exists()
