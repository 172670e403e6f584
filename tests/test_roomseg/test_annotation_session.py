"""An annotation of a file: journal, save, what a crash leaves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cleaned_flat import cleaned_flat
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_ground_truth import rows_map

from dataset import GroundTruth, RoomsegError, TopoMap, problems, read_map, write_map, write_rooms
from roomseg.annotation.journal import journal_path
from roomseg.annotation.session import Annotation

ACROSS = {x: (x, -0.2, x, 1.1) for x in (0.95, 1.95, 2.95)}


def corridor() -> TopoMap:
    """Without a ground truth, its edges in order as a file has them."""
    topomap = rows_map((), 1)
    edges = topomap.edges[np.lexsort(topomap.edges.T[::-1])]
    return replace(topomap, edges=edges, ground_truth=None)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "corridor.h5"
    write_map(file, corridor())
    return file


def confirm(annotation: Annotation) -> Annotation:
    annotation.settle(annotation.pending()())
    return annotation


def test_what_is_saved_is_what_was_drawn(path: Path) -> None:
    write_rooms(path, np.zeros(160), model="other", rooms=1)
    with Annotation(path) as annotation:
        annotation.draw(ACROSS[0.95])
        annotation.draw(ACROSS[2.95])
        annotation.rename(1, "hall")  # the larger part stays room 1 each time
        assert annotation.unsaved
        assert "2 borders and 3 rooms" in annotation.save()
        assert not annotation.unsaved
    assert list(problems(path)) == []
    topomap = read_map(path)
    truth, x = topomap.ground_truth, topomap.nodes.position[:, 0]
    assert (truth.room == (x > 0.95).astype(int) + (x > 2.95)).all()
    assert truth.room_names == ("", "hall", "")
    assert truth.frame == "map"
    assert not journal_path(path).exists()
    with Annotation(path) as again:
        assert [(r.title, r.size) for r in again.drawing.active_rooms] == [
            ("room 1", 40),
            ("hall", 80),
            ("room 3", 40),
        ]
        assert not again.unsaved and not again.notice


def test_everything_is_kept_at_once(path: Path) -> None:
    """No close, no save: as if the process were killed after any edit."""
    annotation = Annotation(path)
    annotation.draw(ACROSS[0.95])
    annotation.draw(ACROSS[1.95])
    annotation.undo()
    annotation.draw(ACROSS[2.95])
    annotation.rename(1, "bath")
    drawing, history = annotation.drawing, annotation.history
    annotation._journal._stack.close()  # the kernel drops the lock of a killed process
    with Annotation(path) as again:
        assert again.drawing == drawing
        assert again.history == history
        assert again.unsaved and again.notice.startswith("Found again: 3 edits")
        again.undo()
        assert [room.name for room in again.drawing.active_rooms if room.name] == []


def edit(annotation: Annotation, step: str, number: int) -> None:
    """One of the edits; the number makes it another one each time."""
    x, borders = 0.55 + 0.3 * number, annotation.drawing.borders
    edits = {
        "draw": lambda: annotation.draw((x, -0.2, x, 1.1)),
        "move": lambda: borders and annotation.move(borders[-1].id, (x, -0.3, x, 1.1)),
        "delete": lambda: borders and annotation.delete([borders[0].id]),
        "count": lambda: annotation.give_count(number % 3 or None),
        "name": lambda: annotation.rename(annotation.drawing.active_rooms[0].id, f"no {number}"),
        "strike": lambda: annotation.strike(0),
        "undo": annotation.undo,
        "redo": annotation.redo,
    }
    edits[step]()


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    steps=st.lists(
        st.sampled_from(["draw", "move", "delete", "undo", "redo", "count", "name", "strike"]),
        max_size=12,
    ),
    torn=st.integers(0, 40),
)
def test_any_edits_are_found_again_but_for_a_torn_last_one(
    tmp_path_factory: pytest.TempPathFactory, steps: list[str], torn: int
) -> None:
    path = tmp_path_factory.mktemp("edits") / "corridor.h5"
    write_map(path, corridor())
    suggestions = np.array([[[3.55, -0.2], [3.55, 1.1]]])
    annotation = Annotation(path, suggestions)
    states = [annotation.history]
    for number, step in enumerate(steps):
        edit(annotation, step, number)
        if annotation.history != states[-1]:
            states.append(annotation.history)
    annotation.close()
    journal = journal_path(path)
    if journal.exists() and torn:
        content = journal.read_bytes()
        last = len(content.splitlines(keepends=True)[-1])
        journal.write_bytes(content[: len(content) - min(torn, last)])
        states.pop() if len(states) > 1 else None
    with Annotation(path, suggestions) as again:
        assert again.history == states[-1]
        again.draw((3.75, -0.2, 3.75, 1.1))
        after = again.history
    with Annotation(path, suggestions) as again:
        assert again.history == after


def test_borders_that_do_not_give_the_rooms_are_saved_without_rooms(path: Path) -> None:
    with Annotation(path) as annotation:
        annotation.draw(ACROSS[0.95])
        annotation.give_count(4)
        confirm(annotation)
        assert "cut the map into 2 pieces" in annotation.confirmation.problem
        assert len(annotation.drawing.active_rooms) == 4, "as the clustering has them"
        assert "no rooms yet" in annotation.save()
        assert annotation.unsaved
    truth = read_map(path).ground_truth
    assert truth.room is None and truth.room_count == 4 and len(truth.borders) == 1
    assert list(problems(path)) == []
    assert journal_path(path).exists()


def test_only_one_annotates_a_map(path: Path) -> None:
    with (
        Annotation(path),
        pytest.raises(RoomsegError, match="open in another `roomseg annotate`; end that first"),
    ):
        Annotation(path)


@pytest.mark.parametrize("what", ["other map", "garbage", "damaged"])
def test_a_journal_that_does_not_fit_is_refused_and_kept(path: Path, what: str) -> None:
    with Annotation(path) as annotation:
        annotation.draw(ACROSS[0.95])
        annotation.draw(ACROSS[1.95])
    journal = journal_path(path)
    if what == "other map":
        write_map(path, replace(rows_map((), 1, columns=41), ground_truth=None))
    elif what == "garbage":
        journal.write_bytes(b"[1]\n")
    else:
        head, first, second = journal.read_bytes().splitlines(keepends=True)
        journal.write_bytes(head + first[:-9] + b"\n" + second)
    content = journal.read_bytes()
    with pytest.raises(RoomsegError, match=str(journal)) as caught:
        Annotation(path)
    assert "\n" not in str(caught.value)
    assert journal.read_bytes() == content


def test_a_map_that_was_exchanged_is_not_written(path: Path) -> None:
    with Annotation(path) as annotation:
        annotation.draw(ACROSS[0.95])
        other = rows_map((), 1)
        nodes = replace(other.nodes, position=other.nodes.position + 1.0)
        write_map(path, replace(other, nodes=nodes, ground_truth=None))
        with pytest.raises(RoomsegError, match="another map now"):
            annotation.save()
    assert read_map(path).ground_truth is None
    assert journal_path(path).exists()


def test_borders_of_the_plan_are_carried_over(tmp_path: Path) -> None:
    path = tmp_path / "flat.h5"
    topomap = cleaned_flat()
    write_map(path, topomap)
    with Annotation(path) as annotation:
        assert "carried over" in annotation.notice
        assert annotation.count == 3 and not annotation.cut.leaks
        confirm(annotation)
        rooms = annotation.room_of_node
        assert (
            sum(
                np.bincount(topomap.ground_truth.room[rooms == r.id]).max()
                for r in annotation.drawing.active_rooms
            )
            / len(rooms)
            > 0.97
        )
    with Annotation(path, afresh=True) as annotation:
        assert annotation.count == 1 and not annotation.drawing.borders


def test_the_borders_of_a_real_robots_map_are_edited(tmp_path: Path) -> None:
    path = tmp_path / "real.h5"
    write_map(path, cleaned_flat(real=True))
    with Annotation(path) as annotation:
        assert len(annotation.drawing.borders) == 6 and not annotation.notice
        annotation.delete([1])
        annotation.save()
    assert len(read_map(path).ground_truth.borders) == 5


def test_borders_as_short_as_a_grids_steps_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "imported.h5"
    topomap = rows_map((1.95,), 2)
    truth = topomap.ground_truth
    steps = np.concatenate([truth.borders, [[[1.95, 1.1], [1.96, 1.1]]]])
    write_map(file, replace(topomap, ground_truth=replace(truth, borders=steps)))
    with Annotation(file) as annotation:
        assert [border.length for border in annotation.drawing.borders] == [
            pytest.approx(1.3),
            pytest.approx(0.01),
        ]
        with pytest.raises(RoomsegError, match=r"at least 0\.03 m"):
            annotation.draw((0.5, 0.0, 0.51, 0.0))


def test_suggestions_go_when_they_are_drawn_or_struck_out(path: Path) -> None:
    suggestions = np.array([np.reshape(line, (2, 2)) for line in ACROSS.values()])
    with Annotation(path, suggestions) as annotation:
        annotation.strike(2)
        assert annotation.open_suggestions().tolist() == [0, 1]
        annotation.accept([1])
        assert annotation.open_suggestions().tolist() == [0]
        annotation.draw((0.85, -0.2, 0.85, 1.1))
        assert annotation.open_suggestions().tolist() == []
        annotation.undo(), annotation.undo(), annotation.undo()
        assert annotation.open_suggestions().tolist() == [0, 1, 2]


def test_clustering_of_something_else_by_now_is_not_taken(path: Path) -> None:
    with Annotation(path) as annotation:
        work = annotation.pending()
        annotation.draw(ACROSS[1.95])
        annotation.settle(work())
        assert annotation.confirmation is None
        assert len(confirm(annotation).drawing.active_rooms) == 2


def test_names_must_be_those_of_the_rooms() -> None:
    with pytest.raises(RoomsegError, match="room_names: 1 names, expected 2"):
        GroundTruth(np.zeros((0, 2, 2)), "map", np.zeros(0, bool), 2, room_names=("hall",))
