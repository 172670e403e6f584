"""Every benchmark starts: nothing in its folder stands in the way of a package."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"


@pytest.mark.parametrize("script", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_benchmarks_start(script):
    run = subprocess.run(
        [sys.executable, str(script), "--help"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert "Usage:" in run.stdout


def run(script, *arguments):
    """Run a benchmark and return what it printed."""
    command = [sys.executable, str(FOLDER / script), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_small_grids_that_are_no_apartments_are_cleaned_to_the_end(tmp_path):
    run("grids.py", "--size", "0.04", "-o", tmp_path)
    grids = sorted(tmp_path.glob("*.json"))
    assert [path.stem for path in grids] == ["corridor", "hall", "lab"]
    figures = tmp_path / "figures"
    once = run("coverage.py", *grids, "--starts", 1, "-o", tmp_path, "--json", figures)
    for cleaned in json.loads(figures.read_text())["runs"]:
        assert cleaned["failed"] is None and cleaned["connected"]
        assert cleaned["coverage"] >= 0.98 and cleaned["from_home"] <= 0.3
        assert cleaned["collisions"] == 0
        assert cleaned["path_length"] > 0.9 * cleaned["shortest_path"]
    # A line of the journal was cut short when the benchmark was killed: that run is made again.
    journal = tmp_path / "runs.jsonl"
    whole = journal.read_bytes()
    first, second, third = whole.splitlines(keepends=True)
    journal.write_bytes(first + second + third[:20])
    again = run("coverage.py", *grids, "--starts", 1, "-o", tmp_path)
    assert journal.read_bytes().startswith(first + second)
    assert len(journal.read_bytes().splitlines()) == 3
    untimed = ("coverage,", "path", "full turns", "nodes per")
    for line, before in zip(again.splitlines(), once.splitlines(), strict=True):
        assert line == before or not any(word in line for word in untimed)


@pytest.mark.slow
def test_the_price_of_an_image_beside_the_plain_loop(tmp_path):
    figures = tmp_path / "figures.json"
    small = ("--place", "demo1", "--views", 2, "--loop-views", 1, "--disc", 96)
    printed = run("render_price.py", *small, "--json", figures)
    costs = list(json.loads(figures.read_text()).values())
    assert len(costs) == 4 and "plain loop" in printed
    assert costs[3]["cpu"] > costs[2]["cpu"] > 0.0
    assert costs[0]["cpu"] > costs[1]["cpu"] > 0.0
