"""Judge generated apartments: valid, reachable, believable, all different.

Generates apartments of consecutive seeds with nothing else asked for and
judges them from outside: `scenes.checks.check` once more, the floor that
`scenes.passages` finds within reach of a robot of 15 cm radius, and distances
between plans. Distributions stand beside those of the reference places.

    python benchmarks/generator.py                          # 1000 seeds, about 5 minutes
    python benchmarks/generator.py --count 100 --jobs 2 --json generator.json
"""

from __future__ import annotations

import hashlib
import itertools
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

# Some files here have the names of packages, which Python would find first.
sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).resolve().parent]

import click
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from roomseg.cli.output import follow, progress_bar, write_json, write_table
from scenes import (
    Apartment,
    apartment_to_json,
    check,
    floor_area,
    floor_region,
    generate_apartment,
    load_apartment,
    obstacles,
    reachable_positions,
    reference_names,
)
from scenes.passages import ROBOT_RADIUS, free_region

CELL = 0.5
"""Raster on which plans are compared, m."""
SPAN = 26.0
"""Side of the square on which plans are compared, m."""
ALIKE = 3.0
"""Plans that differ by less on the raster are compared exactly, m²."""
SPACING = 0.05
L_SHAPED = 0.93
"""A room that fills less of its bounds than this counts as L-shaped."""
SETTLED = (
    "bathroom",
    "bedroom",
    "corridor",
    "kitchen",
    "living_room",
    "office",
    "storage",
    "other",
)


@dataclass(frozen=True)
class Home:
    """Figures of one apartment; ``plan``: kind of room on the raster, 0 outside."""

    name: str
    seconds: float
    problems: tuple[str, ...]
    unreached: tuple[str, ...]
    rooms: int
    area: float
    aspects: tuple[float, ...]
    bent: int
    doors: int
    wide: int
    windows: int
    pieces: int
    free: float
    pockets: float
    digest: str
    plan: NDArray[np.uint8]
    floors: tuple[tuple[str, Polygon], ...]


def judged(apartment: Apartment, seconds: float = 0.0) -> Home:
    """Figures of an apartment, by other means than the generator's."""
    shapes = [Polygon(room.polygon) for room in apartment.rooms]
    spots = shapely.points(reachable_positions(apartment, ROBOT_RADIUS, SPACING))
    reached = [np.count_nonzero(shapely.covers(shape, spots)) * SPACING**2 for shape in shapes]
    floor = floor_region(apartment)
    free = float(floor.difference(obstacles(apartment)).area)
    centres = float(free_region(apartment, ROBOT_RADIUS).area)
    opened = [passage for passage in apartment.passages if not passage.closed]
    geometry = apartment.model_copy(update={"name": "home"})
    return Home(
        name=apartment.name,
        seconds=seconds,
        problems=tuple(check(apartment)),
        unreached=tuple(
            room.name for room, area in zip(apartment.rooms, reached, strict=True) if area < 0.1
        ),
        rooms=len(shapes),
        area=floor_area(apartment),
        aspects=tuple(_aspect(shape) for shape in shapes),
        bent=sum(shape.area < L_SHAPED * shapely.box(*shape.bounds).area for shape in shapes),
        doors=len(opened),
        wide=sum(p.lintel_height is None for p in opened),
        windows=len(apartment.windows),
        pieces=len(apartment.furniture),
        free=free / float(floor.area),
        pockets=max(0.0, 1.0 - len(spots) * SPACING**2 / centres),
        digest=hashlib.sha256(apartment_to_json(geometry).encode()).hexdigest(),
        plan=_raster(apartment, shapes),
        floors=tuple((r.kind, shape) for r, shape in zip(apartment.rooms, shapes, strict=True)),
    )


def _aspect(shape: Polygon) -> float:
    x0, y0, x1, y1 = shape.bounds
    short, long = sorted((x1 - x0, y1 - y0))
    return float(long / short)


def _raster(apartment: Apartment, shapes: Sequence[Polygon]) -> NDArray[np.uint8]:
    """Kind of the room in every cell from the lower left corner on."""
    low = shapely.bounds(shapely.MultiPolygon(shapes))[:2]
    middles = np.arange(CELL / 2, SPAN, CELL)
    x, y = np.meshgrid(middles + low[0], middles + low[1])
    plan = np.zeros(x.shape, dtype=np.uint8)
    for room, shape in zip(apartment.rooms, shapes, strict=True):
        plan[shapely.contains_xy(shape, x, y)] = 1 + SETTLED.index(room.kind)
    return plan


def made(seed: int) -> Home:
    """Generate and judge one apartment; seconds of processor time for the first."""
    begin = time.process_time()
    apartment = generate_apartment(seed)
    return judged(apartment, time.process_time() - begin)


def all_made(seeds: range, jobs: int) -> Iterator[Home]:
    if jobs == 1:
        yield from map(made, seeds)
        return
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        yield from pool.map(made, seeds, chunksize=8)


# ---- how different plans are --------------------------------------------------------------------


def nearest(homes: Sequence[Home]) -> NDArray[np.float64]:
    """Floor that differs in use from the most similar other plan, in any of 8 positions, m².

    On the raster; where that finds next to nothing, exactly.
    """
    plans = np.stack([home.plan for home in homes])
    own = _one_hot(plans)
    area = own.sum(axis=1)
    best, like = np.full(len(homes), np.inf), np.zeros(len(homes), dtype=int)
    for turns, mirrored in itertools.product(range(4), (False, True)):
        moved = np.stack([_moved(plan, turns, mirrored) for plan in plans])
        other = _one_hot(moved)
        same = own @ other.T
        both = (plans > 0).reshape(len(plans), -1).astype(np.float32) @ (moved > 0).reshape(
            len(plans), -1
        ).T.astype(np.float32)
        differs = area[:, None] + area[None, :] - both - same
        np.fill_diagonal(differs, np.inf)
        like = np.where(differs.min(axis=1) < best, differs.argmin(axis=1), like)
        best = np.minimum(best, differs.min(axis=1))
    best *= CELL**2
    for index in np.flatnonzero(best < ALIKE):
        best[index] = difference(homes[index], homes[like[index]])
    return best


def difference(a: Home, b: Home) -> float:
    """Floor that differs in use between two plans in the best of 8 positions, m²."""
    own = {kind: _use(a.floors, kind) for kind in SETTLED}
    differs = []
    for moved in _positions(b):
        other = {kind: _use(moved, kind) for kind in SETTLED}
        whole = shapely.union_all([*own.values(), *other.values()]).area
        differs.append(whole - sum(own[kind].intersection(other[kind]).area for kind in SETTLED))
    return float(min(differs))


def _use(floors: Sequence[tuple[str, Polygon]], kind: str) -> shapely.Geometry:
    """All floor of one kind of room, the whole home in the lower left corner."""
    low = shapely.bounds(shapely.MultiPolygon([shape for _, shape in floors]))[:2]
    region = shapely.union_all([shape for own, shape in floors if own == kind])
    return shapely.transform(region, lambda xy: xy - low)


def _positions(home: Home) -> Iterator[list[tuple[str, Polygon]]]:
    """A plan turned by quarter turns, as it is and mirrored."""
    for turns, mirror in itertools.product(range(4), (1.0, -1.0)):
        turn = np.linalg.matrix_power(np.array([[0.0, 1.0], [-1.0, 0.0]]), turns)
        rows = np.diag([mirror, 1.0]) @ turn
        yield [
            (kind, shapely.transform(shape, lambda xy, rows=rows: xy @ rows))
            for kind, shape in home.floors
        ]


def _one_hot(plans: NDArray[np.uint8]) -> NDArray[np.float32]:
    kinds = np.arange(1, len(SETTLED) + 1, dtype=np.uint8)
    return (plans[..., None] == kinds).reshape(len(plans), -1).astype(np.float32)


def _moved(plan: NDArray[np.uint8], turns: int, mirrored: bool) -> NDArray[np.uint8]:
    """A plan turned and mirrored, back in the lower left corner."""
    turned = np.rot90(plan[:, ::-1] if mirrored else plan, turns)
    rows, columns = np.nonzero(turned)
    return np.roll(turned, (-rows.min(), -columns.min()), axis=(0, 1))


# ---- tables -------------------------------------------------------------------------------------

FIGURES: dict[str, tuple[Callable[[Home], float | Sequence[float]], str]] = {
    "rooms": (lambda home: home.rooms, ".0f"),
    "floor, m²": (lambda home: home.area, ".1f"),
    "floor per room, m²": (lambda home: home.area / home.rooms, ".1f"),
    "long : short side of a room": (lambda home: home.aspects, ".2f"),
    "L-shaped and other bent rooms, %": (lambda home: 100 * home.bent / home.rooms, ".0f"),
    "passages between rooms": (lambda home: home.doors, ".0f"),
    "of them without lintel, %": (lambda home: 100 * home.wide / max(home.doors, 1), ".0f"),
    "windows": (lambda home: home.windows, ".0f"),
    "pieces": (lambda home: home.pieces, ".0f"),
    "pieces per m²": (lambda home: home.pieces / home.area, ".2f"),
    "free of obstacles to the robot, %": (lambda home: 100 * home.free, ".0f"),
    "free but out of its reach, %": (lambda home: 100 * home.pockets, ".1f"),
}


def summary(homes: Sequence[Home], name: str) -> dict[str, float]:
    """Mean, 5th, 50th and 95th percentile and limits of a figure."""
    values = np.concatenate([np.atleast_1d(FIGURES[name][0](home)) for home in homes])
    low, p5, p50, p95, high = np.percentile(values, [0, 5, 50, 95, 100])
    figures = {"mean": values.mean(), "p5": p5, "p50": p50, "p95": p95, "min": low, "max": high}
    return {key: float(value) for key, value in figures.items()}


def show_distributions(homes: Sequence[Home], places: Sequence[Home]) -> dict[str, Any]:
    rows, figures = [], {}
    for name, (_, spec) in FIGURES.items():
        ours, theirs = summary(homes, name), summary(places, name)
        figures[name] = {"generated": ours, "places": theirs}
        cells = [f"{ours[key]:{spec}}" for key in ("mean", "p5", "p50", "p95")]
        cells += [f"{theirs[key]:{spec}}" for key in ("mean", "min", "p50", "max")]
        rows.append((name, *cells))
    columns = ("", "mean", "5 %", "median", "95 %", "places: mean", "least", "median", "most")
    write_table(f"{len(homes)} apartments beside {len(places)} reference places", columns, rows)
    counts = np.bincount([home.rooms for home in homes], minlength=13)
    shares = ((str(rooms), f"{100 * counts[rooms] / len(homes):.1f}") for rooms in range(1, 13))
    write_table("room count", ("rooms", "%"), list(shares))
    return figures


def show_verdict(homes: Sequence[Home]) -> dict[str, Any]:
    seconds = np.array([home.seconds for home in homes])
    away = nearest(homes)
    figures = {
        "valid": float(np.mean([not home.problems for home in homes])),
        "every_room_reached": float(np.mean([not home.unreached for home in homes])),
        "seconds": {
            key: float(value)
            for key, value in zip(
                ("median", "p95", "max", "sum"),
                (*np.percentile(seconds, [50, 95, 100]), seconds.sum()),
                strict=True,
            )
        },
        "distinct": len({home.digest for home in homes}),
        "with_bent_room": float(np.mean([home.bent > 0 for home in homes])),
        "nearest_plan_m2": {
            "least": float(away.min()),
            "median": float(np.median(away)),
            "least_share": float((away / [home.area for home in homes]).min()),
        },
    }
    apart, spent = figures["nearest_plan_m2"], figures["seconds"]
    rows = [
        ("valid", f"{100 * figures['valid']:.2f} %"),
        ("every room reached by a 15 cm robot", f"{100 * figures['every_room_reached']:.2f} %"),
        ("processor seconds each: median", f"{spent['median']:.2f}"),
        ("95 %", f"{spent['p95']:.2f}"),
        ("most", f"{spent['max']:.2f}"),
        ("all together, minutes", f"{spent['sum'] / 60:.1f}"),
        ("different apartments", f"{figures['distinct']} of {len(homes)}"),
        ("floor that differs from the most similar other plan: least, m²", f"{apart['least']:.2f}"),
        ("median, m²", f"{apart['median']:.1f}"),
        ("least, share of the home", f"{100 * apart['least_share']:.1f} %"),
        ("with a room that is no rectangle", f"{100 * figures['with_bent_room']:.0f} %"),
    ]
    write_table("generated apartments", ("", ""), rows)
    for home in homes:
        for problem in (*home.problems, *(f"{room} is not reached" for room in home.unreached)):
            click.echo(f"{home.name}: {problem}")
    return figures


@click.command()
@click.option("--count", default=1000, show_default=True, help="How many seeds.")
@click.option("--seed", default=0, show_default=True, help="The first.")
@click.option("--jobs", default=1, show_default=True, help="Processes at the same time.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Figures for machines.")
def main(count: int, seed: int, jobs: int, json_file: Path | None) -> None:
    homes = []
    with progress_bar("homes") as bar:
        show = follow(bar, "generated")
        show(0, count)
        for home in all_made(range(seed, seed + count), jobs):
            homes.append(home)
            show(len(homes), count)
    places = [judged(load_apartment(name, checked=False)) for name in _places()]
    figures = show_verdict(homes) | {"distributions": show_distributions(homes, places)}
    write_json(json_file, figures)


def _places() -> list[str]:
    """Reference places without the made-up ones of the demo."""
    return [name for name in reference_names() if not name.startswith("demo")]


if __name__ == "__main__":
    main()
