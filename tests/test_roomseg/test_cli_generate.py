"""``roomseg generate``: one apartment, a thousand, stopped and called again."""

from __future__ import annotations

from pathlib import Path

import pytest

import scenes.generator
from roomseg.cli.main import main
from scenes import SceneError, load_apartment
from scenes.generator import Wishes, generate

SMALL = ("--rooms", "2", "--clutter", "0")


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(place: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(place.iterdir())}


def test_many_are_the_same_whatever_the_number_of_jobs(folder, capsys):
    assert main(["generate", "--count", "3", "--seed", "5", *SMALL, "-o", "one"]) == 0
    assert (
        main(["generate", "--count", "3", "--seed", "5", *SMALL, "--jobs", "2", "-o", "two"]) == 0
    )
    one = contents(folder / "one")
    assert one == contents(folder / "two")
    assert len(one) == 3
    homes = [load_apartment(path) for path in sorted((folder / "one").iterdir())]
    assert [f"{home.name}.json" for home in homes] == list(one)
    assert homes[0] == generate(5, Wishes(rooms=2, clutter=0.0))
    assert "one: 3 apartments, 0 of them there before" in capsys.readouterr().out


def test_what_is_there_is_left_alone(folder, capsys):
    assert main(["generate", "--count", "2", *SMALL, "-o", "homes"]) == 0
    before = {path: path.stat().st_mtime_ns for path in (folder / "homes").iterdir()}
    assert main(["generate", "--count", "3", *SMALL, "-o", "homes"]) == 0
    assert "3 apartments, 2 of them there before" in capsys.readouterr().out
    assert all(path.stat().st_mtime_ns == then for path, then in before.items())
    # Other wishes give other names, and leave these alone too.
    assert main(["generate", "--count", "1", "--rooms", "2-3", "-o", "homes"]) == 0
    assert len(list((folder / "homes").iterdir())) == 4


def test_stopped_in_the_middle(folder, monkeypatch, capsys):
    real, made = generate, []

    def stopping(seed, wishes):
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append(seed)
        return real(seed, wishes)

    monkeypatch.setattr(scenes.generator, "generate", stopping)
    assert main(["generate", "--count", "4", *SMALL, "-o", "homes"]) == 130
    assert "stopped; call it again" in capsys.readouterr().err
    assert len(list((folder / "homes").iterdir())) == 2
    made.clear()
    monkeypatch.setattr(scenes.generator, "generate", real)
    assert main(["generate", "--count", "4", *SMALL, "-o", "homes"]) == 0
    assert len(list((folder / "homes").iterdir())) == 4


def test_a_seed_without_apartment_stops_no_others(folder, monkeypatch, capsys):
    real = generate

    def failing(seed, wishes):
        if seed == 1:
            raise SceneError("rooms, area: none for seed 1")
        return real(seed, wishes)

    monkeypatch.setattr(scenes.generator, "generate", failing)
    assert main(["generate", "--count", "3", *SMALL, "-o", "homes"]) == 2
    error = capsys.readouterr().err
    assert "rooms, area: none for seed 1" in error
    assert "roomseg: error: homes: 1 of 3 could not be made" in error
    assert len(list((folder / "homes").iterdir())) == 2


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--count", "2", "-o", "home.json"), "home.json is a file name, expected a folder"),
        (("--count", "2", "-o", "there"), "there is a file name, expected a folder"),
        (("--count", "2", "-o", "no/homes"), "no/homes: the folder no does not exist"),
        (("--count", "0", "-o", "homes"), "0 is not in the range"),
        (("--rooms", "few", "-o", "a.json"), "'few' is neither a whole number nor a range"),
        (("--rooms", "2.5", "-o", "a.json"), "'2.5' is neither a whole number nor a range"),
        (("--rooms", "2-13", "-o", "a.json"), "13 is not in the range 1<=x<=12"),
        (
            ("--rooms", "5-2", "-o", "a.json"),
            "'--rooms': 5-2; expected the smaller value first, 2-5",
        ),
        (("--rooms", "-3", "-o", "a.json"), "-3 is not in the range"),
        (("--area", "nan", "-o", "a.json"), "nan is not in the range"),
        (("--area", "20", "--rooms", "8", "-o", "a.json"), "area: 20.0; expected 40 to 240"),
        (("--layout", "corridor", "--rooms", "2", "-o", "a.json"), "expected at least 4 rooms"),
        (("--layout", "maze", "-o", "a.json"), "'maze' is not one of"),
        (("--clutter", "2", "-o", "a.json"), "2.0 is not in the range"),
    ],
)
def test_refused_in_one_line(folder, capsys, arguments, expected):
    Path("there").write_text("something")
    assert main(["generate", *arguments]) == 2
    error = capsys.readouterr().err
    assert expected in error
    assert error.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ["there"]


def test_another_file_of_that_name_is_not_taken_for_it(folder, capsys):
    assert main(["generate", "--seed", "3", *SMALL, "-o", "a.json"]) == 0
    Path("homes").mkdir()
    name = f"{generate(4, Wishes(rooms=2, clutter=0.0)).name}.json"
    Path("homes", name).write_bytes(Path("a.json").read_bytes())
    capsys.readouterr()
    assert main(["generate", "--seed", "4", "--count", "1", *SMALL, "-o", "homes"]) == 2
    assert "choose another folder" in capsys.readouterr().err
    Path("homes", name).write_text("{")
    assert main(["generate", "--seed", "4", "--count", "1", *SMALL, "-o", "homes"]) == 2
    assert "choose another folder" in capsys.readouterr().err
