"""Do the reference places resemble the paper's? Table 8 beside ours.

Cleans every place as the reference set does, ``--runs`` of its runs at most, and counts.
Area: within 2 %; rooms, passageway contrast and light: the same; map nodes per m² of floor:
within 25 % for Sim1 to Sim5; map nodes: within 15 % for the stand-ins, of which the paper
gives no area. Of the novel environment it gives no figures.

    python benchmarks/places.py --jobs 2
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from math import radians
from multiprocessing import get_context
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np

from roomseg.cli.output import follow, progress_bar, write_json, write_table
from simulator import NOVEL_RUNS, REFERENCE_RUNS, ReferenceRun

AREA_BAND = 0.02
DENSITY_BAND = 0.25
NODES_BAND = 0.15


@dataclass(frozen=True)
class Row:
    """What Table 8 says of an environment; area in m², None where it says nothing."""

    area: float | None
    nodes: int | None
    rooms: int | None
    contrast: str | None
    lighting: str | None

    @property
    def density(self) -> float | None:
        """Map nodes per m² of floor."""
        return None if self.area is None or self.nodes is None else self.nodes / self.area


TABLE_8 = {
    "sim1": Row(125.0, 2806, 9, "high", "interior"),
    "sim2": Row(101.0, 1988, 9, "low", "mixed"),
    "sim3": Row(51.0, 787, 5, "low", "exterior"),
    "sim4": Row(46.0, 783, 5, "medium", "exterior"),
    "sim5": Row(79.0, 1688, 7, "high", "interior"),
    "real1": Row(None, 656, 3, "low", "exterior"),
    "real2": Row(None, 760, 4, "low", "exterior"),
    "real3": Row(None, 649, 2, "high", "exterior"),
    "novel": Row(None, None, None, None, None),
}


def one_run(run: ReferenceRun) -> dict[str, Any]:
    """Clean a place once; figures of the run."""
    from scenes import load_apartment
    from simulator import coverage_report, simulate

    apartment = load_apartment(run.place)
    start = (*run.start[:2], radians(run.start[2]))
    topomap = simulate(
        apartment, run=run.name, seed=run.seed, start=start, robot=run.robot, sensor=run.sensor
    )
    return {"place": run.place, "run": run.name} | asdict(coverage_report(topomap, apartment))


def judged(name: str, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """A place and its runs beside the paper, and what is outside the bands."""
    from scenes import floor_area, load_apartment

    place, paper = load_apartment(name), TABLE_8[name]
    ours: dict[str, Any] = {
        "area": floor_area(place),
        "rooms": len(place.rooms),
        "contrast": place.passageway_contrast,
        "lighting": place.lighting.source,
        "nodes": float(np.mean([run["nodes"] for run in runs])),
        "density": float(np.mean([run["nodes_per_m2"] for run in runs])),
    }
    bands = {"area": AREA_BAND, "density": DENSITY_BAND}
    if paper.area is None:
        bands["nodes"] = NODES_BAND
    outside = [key for key, band in bands.items() if _off(ours[key], getattr(paper, key), band)]
    for key in ("rooms", "contrast", "lighting"):
        if getattr(paper, key) not in (None, ours[key]):
            outside.append(key)
    least = min(run["coverage"] for run in runs)
    figures = {"coverage": least, "outside": outside}
    return {"place": name} | ours | figures | {"paper": asdict(paper), "runs": runs}


def _off(value: float, paper: float | None, band: float) -> bool:
    return paper is not None and abs(value - paper) > band * paper


def line(place: dict[str, Any]) -> tuple[str, ...]:
    """The row of the table: ours, and the paper's in brackets."""
    paper = TABLE_8[place["place"]]
    return (
        place["place"],
        f"{place['area']:.1f}{_beside(paper.area, 0)}",
        f"{place['rooms']}{_beside(paper.rooms, 0)}",
        f"{place['contrast']}, {place['lighting']}",
        f"{place['nodes']:.0f}{_beside(paper.nodes, 0)}",
        f"{place['density']:.1f}{_beside(paper.density, 1)}",
        f"{100 * place['coverage']:.1f}",
        ", ".join(place["outside"]) or "–",
    )


def _beside(value: float | None, digits: int) -> str:
    return "" if value is None else f" ({value:.{digits}f})"


@click.command()
@click.argument("places", nargs=-1, type=click.Choice(list(TABLE_8)), metavar="[PLACE]...")
@click.option("--runs", type=click.IntRange(1), default=8, show_default=True, help="Of each.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True)
@click.option("--json", "json_file", type=click.Path(path_type=Path))
def main(places: tuple[str, ...], runs: int, jobs: int, json_file: Path | None) -> None:
    """Table 8 for PLACE... (all nine without)."""
    names = places or tuple(TABLE_8)
    every = (*REFERENCE_RUNS, *NOVEL_RUNS)
    wanted = [run for name in names for run in [r for r in every if r.place == name][:runs]]
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool, progress_bar("runs") as bar:
        show = follow(bar, "cleaning")
        tasks = [pool.submit(one_run, run) for run in wanted]
        for done, _ in enumerate(as_completed(tasks), 1):
            show(done, len(wanted))
    figures = [task.result() for task in tasks]
    table = [judged(name, [run for run in figures if run["place"] == name]) for name in names]
    write_json(json_file, {"places": table})
    columns = (
        *("", "area m²", "rooms", "contrast, light", "map nodes", "nodes/m²"),
        *("least coverage %", "outside"),
    )
    write_table(
        f"Table 8: ours (the paper's), {len(wanted)} runs", columns, [line(p) for p in table]
    )


if __name__ == "__main__":
    main()
