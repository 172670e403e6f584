"""Links lead somewhere, in the repository as on the site; the code of extending.md runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").glob("*.md")),
    ROOT / "benchmarks" / "README.md",
    ROOT / "examples" / "README.md",
]
CODE = re.compile(r"^( *)```.*?^\1```$|`[^`\n]+`", re.M | re.S)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def anchors(page: Path) -> set[str]:
    """What headings are called on the page, by the rule of both GitHub and the site."""
    heads = re.findall(r"^#+ (.*)$", CODE.sub(lambda m: m[0].strip("`"), page.read_text()), re.M)
    texts = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head).lower() for head in heads]
    return {re.sub(r"[^\w\- ]", "", text).strip().replace(" ", "-") for text in texts}


def links(page: Path) -> list[str]:
    return LINK.findall(CODE.sub("", page.read_text(encoding="utf-8")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page):
    lost = []
    for link in links(page):
        if link.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            lost.append(link)
    assert lost == []


def figures(text: str) -> set[str]:
    """Numbers, thousands without a mark."""
    whole = re.sub(r"(?<=\d)[,\u00a0\u202f ](?=\d{3}\b)", "", text)
    return set(re.findall(r"\d+(?:\.\d+)?", whole))


def test_results_are_those_of_the_pages_that_they_lead_to():
    page, seen, lost = "", 0, []
    for line in (ROOT / "docs" / "results.md").read_text(encoding="utf-8").splitlines():
        if not line.startswith("| ") or line.startswith(("| what", "|---")):
            continue
        if found := re.search(r"\]\(([^)#]+)[^)]*\) \|$", line):
            page = (ROOT / "docs" / found[1]).read_text(encoding="utf-8")
        ours = figures(line.split("|")[2])
        lost += [(line, figure) for figure in ours - figures(page)]
        seen += len(ours)
    assert lost == [] and seen > 30


def test_pictures_are_small():
    large = [p for p in (ROOT / "docs").rglob("*") if p.suffix in {".png", ".jpg", ".gif"}]
    assert [p.name for p in large if p.stat().st_size > 350_000] == []


def test_the_citation_is_of_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{citation["version"]}"' in project
    assert {"cff-version", "message", "title", "authors"} <= set(citation)


EXTENDING = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
BLOCKS = [
    re.sub(f"^{block[1]}", "", block[2], flags=re.M)
    for block in re.finditer(r"^( *)```python\n(.*?)^\1```$", EXTENDING, re.M | re.S)
]


def module(beginning: str) -> dict[str, object]:
    """What a block of code of the page defines."""
    (block,) = [block for block in BLOCKS if block.startswith(f'"""{beginning}')]
    names: dict[str, object] = {"__name__": "extending"}
    exec(compile(block, "extending.md", "exec"), names)
    return names


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    from dataset import write_map
    from roomseg.ground_truth import label_rooms
    from scenes import load_apartment
    from simulator import simulate

    folder = tmp_path_factory.mktemp("maps")
    for name in ("demo1", "demo2"):
        write_map(folder / f"{name}.h5", label_rooms(simulate(load_apartment(name), seed=1)))
    return sorted(folder.glob("*.h5"))


def test_the_feature(maps):
    from dataset import read_map
    from roomseg.preprocessing import preprocess

    topomap = read_map(maps[0])
    edges = preprocess(topomap).edges
    counts = module("How many obstacle points")["obstacle_counts"](topomap, edges)
    middle = topomap.nodes.position[edges[7]].mean(axis=0)
    near = np.linalg.norm(topomap.obstacles.position - middle, axis=1) <= 0.5
    assert counts.shape == (len(edges),) and counts[7] == near.sum()


def test_the_baseline(maps, tmp_path):
    (block,) = [block for block in BLOCKS if block.startswith('"""A baseline')]
    script = tmp_path / "baseline.py"
    script.write_text(block, encoding="utf-8")
    run = subprocess.run(
        [sys.executable, str(script), *map(str, maps)],
        env={"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert [line.split(":")[0] for line in lines] == [
        f"{place}, {answer}" for place in ("demo1", "demo2") for answer in ("method", "positions")
    ]


def test_the_importer_of_floor_plans(tmp_path):
    from scenes import SceneError, check, reachable_positions

    read = module("Floor plans as a list of boxes")["read_boxes"]
    plan = tmp_path / "flat.boxes"
    plan.write_text(EXTENDING.split("```text\nroom")[1].split("```")[0].join(["room", ""]))
    apartment = read(plan).apartment
    assert [room.kind for room in apartment.rooms] == ["living_room", "bathroom"]
    assert list(check(apartment)) == [] and len(reachable_positions(apartment)) > 1000
    plan.write_text("room a b 0 0 1\n")
    with pytest.raises(SceneError, match=r"flat\.boxes: line 1: 'room a b 0 0 1'"):
        read(plan)


def test_the_importer_of_runs(tmp_path):
    from dataset import FormatError

    read = module("Runs as CSV")["read_csv_log"]
    log = tmp_path / "monday.csv"
    x = np.arange(0.0, 2.0, 0.05)
    lanes = [np.column_stack([x[:: 1 - 2 * k], np.full(len(x), 0.3 * k)]) for k in (0, 1)]
    way = np.concatenate(lanes)
    table = np.column_stack([np.arange(len(way)) / 4, way, np.zeros(len(way))])
    np.savetxt(log, table, delimiter=",")
    topomap = read(log, name="lab").topomap
    assert topomap.environment == "lab" and 35 <= len(topomap.nodes) <= 45
    log.write_text("1,2\n")
    with pytest.raises(FormatError, match="2 columns"):
        read(log)
